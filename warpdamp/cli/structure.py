"""Commands about structures: modes, FRFs, fits, coupled runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import UsageError
from .common import ConfigArgument, one_line_errors, picture_file, progress, save_as_asked, writable

if TYPE_CHECKING:
    import xarray as xr

    from ..config.study import Config
    from ..modal.frf import ModalModel
    from ..modes import Modes

MOST_REFUSED = 12
"""Fits that a command says why it left out."""


AtOption = Annotated[list[str] | None, typer.Option(help="Value of a swept scalar, as friction=0.5.")]

app = typer.Typer()


@app.command()
def modes(
    config: ConfigArgument,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Write those with the particles: .png, .pdf or .svg, or .csv or .uff."),
    ] = None,
) -> None:
    """Show the structure's modes, without and with the particles' mass."""
    from rich.console import Console

    with one_line_errors():
        from ..config.build import particle_mass
        from ..modal.from_config import modes as structure_modes
        from ..report.tables import modes_table
        from ..study.several import modes_of_all
        from ..sweep.cases import Cases
        from ..sweep.dampers import every_damper
        from ..sweep.load import load

        checked = load(config)
        if checked.structure is None:
            raise checked.error("structure", "missing: there are no modes without a structure")
        if checked.dampers:
            alone = every_damper(checked)
            seen = modes_of_all(checked, alone)
            _show_dampers(alone, seen)
            if output:
                _write_modes(seen[0], output, checked.title)
            return
        configs = [point.config for point in Cases(checked).points() if point.config]
        masses = {particle_mass(single) for single in configs}
        if not checked.structure.particles_included:
            masses.add(0.0)
        modes_by_mass = {m: structure_modes(configs[0], particles=m) for m in sorted(masses)}
        if output:
            _write_modes(modes_by_mass[max(masses)], output, checked.title)
    console = Console()
    for particles, loaded in modes_by_mass.items():
        console.print(f"with {1e3 * particles:.2f} g of particles", highlight=False)
        console.print(modes_table(loaded))


def _show_dampers(alone: list[Config], seen: list[Modes]) -> None:
    """The modes with the particles of several dampers, as each of these sees them."""
    from rich.console import Console

    from ..config.build import particle_mass
    from ..report.tables import modes_table

    masses = [particle_mass(config) for config in alone]
    console = Console()
    for k, modes in enumerate(seen, 1):
        own, total = 1e3 * masses[k - 1], 1e3 * sum(masses)
        console.print(f"at damper {k}, which holds {own:.2f} g of {total:.2f} g of particles", highlight=False)
        console.print(modes_table(modes))


def _write_modes(modes: Modes, path: Path, title: str) -> None:
    """Write modes as a picture, a table or a universal file, as the suffix says."""
    from ..formats.export import WRITTEN, export
    from ..report.figures import save
    from ..report.mode_shapes import shapes

    writable(path.parent)
    if path.suffix.lower() in WRITTEN:
        export(modes, path)
    else:
        save(shapes(modes, title), picture_file(path, *WRITTEN))


@app.command()
def coupled(
    config: ConfigArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the results.")] = Path("results"),
    workers: Annotated[int | None, typer.Option(min=1, help="Processes (default: all cores).")] = None,
    card: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="CARD",
            help="Card of each damper in their order, or one for all: what they predict beside what is read.",
        ),
    ] = None,
) -> None:
    """Let the structure answer: a force on it, its base's motion or its release, with the particles in the loop."""
    with one_line_errors():
        from ..analysis.results import write
        from ..coupled.prediction import differences, mode_with_dampers, with_prediction
        from ..coupled.run import simulate
        from ..execution.executors import worker_pool
        from ..modal.card import read_card
        from ..report.coupled import answers
        from ..report.coupled_verdicts import coupled_verdicts
        from ..report.figures import save
        from ..sweep.load import load

        checked = load(config)
        parts = [read_card(file) for file in card or []]
        mode = mode_with_dampers(checked, parts) if parts else None
        writable(output)
        with progress() as report, worker_pool("processes", workers) as processes:
            runs = simulate(checked, processes.executor, lambda done: report("runs", done))
        runs = with_prediction(runs, mode) if mode else runs
        path = output / f"{config.stem}-coupled.nc"
        write(runs, path)
        save(answers(runs), path.with_suffix(".png"))
    for line in [*coupled_verdicts(runs), *differences(checked, parts)]:
        print(line)
    print(path)


def _newtons(text: str) -> float:
    from ..config.quantities import to_si

    try:
        return to_si(text, "N")
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None


@app.command(context_settings={"allow_extra_args": True})
def frf(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(help="Results of a run with a structure, or a card.", metavar="RESULTS.nc")],
    structure: Annotated[
        Path | None,
        typer.Option(help="Study whose structure carries the damper; what it says of dampers does not count."),
    ] = None,
    constant_force: Annotated[
        list[float] | None,
        typer.Option(
            parser=_newtons,
            metavar="FORCE",
            help="Amplitude of the force, as '50 mN'; may be repeated (default: controlled Gamma).",
        ),
    ] = None,
    band: Annotated[
        tuple[str, str] | None, typer.Option(metavar="LOW HIGH", help="Lowest and highest frequency [Hz], as 30 50.")
    ] = None,
    at: AtOption = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help=".nc for the data, .png for a picture (default: beside FILE).")
    ] = None,
) -> None:
    """Accelerance of the structure with its damper: at controlled Gamma, or every branch at constant force."""
    with one_line_errors():
        from ..modal import frf as response
        from ..report.frf import families, force_curves

        target, limits = output or file.with_name(f"{file.stem}-frf.png"), _limits(band, context.args)
        dataset = response.chosen(_results_or_card(file), at or [])
        dataset, own = _with_structure(dataset, structure, file)
        if constant_force:
            result, draw = response.constant_force(dataset, constant_force, limits, structure=own), force_curves
        else:
            result, draw = response.accelerance(dataset, band=limits, structure=own), families
        save_as_asked(result, draw, target)
    print(target)


def _limits(band: tuple[str, str] | None, left: list[str]) -> tuple[float, float] | None:
    """Two frequencies [Hz] as numbers; ``left``: arguments that nothing took, since a band of one text took two."""
    if band is None:
        if left:
            raise typer.BadParameter(f"unexpected argument {left[0]}")
        return None
    for text in band:
        try:
            float(text)
        except ValueError:
            said = f"'{text}' is no frequency: give two numbers in Hz with a blank between, as --band 30 50"
            raise typer.BadParameter(said, param_hint="--band") from None
    if left:
        raise typer.BadParameter(f"unexpected argument {left[0]}")
    return float(band[0]), float(band[1])


def _results_or_card(file: Path) -> xr.Dataset:
    """Results as they are in the file, or a card."""
    from ..analysis.results import read
    from ..modal.card import is_card, read_card

    if file.suffix.lower() == ".csv":
        return read_card(file)
    found = read(file)
    return read_card(file) if is_card(found) else found


def _with_structure(dataset: xr.Dataset, structure: Path | None, file: Path) -> tuple[xr.Dataset, ModalModel | None]:
    """The card of the damper in results, and the structure of a study; without one the results alone."""
    from ..modal.card import card as card_of
    from ..modal.card import is_card
    from ..modal.card_damper import difference
    from ..modal.frf import ModalModel
    from ..study.several import modes_with

    if structure is None:
        if is_card(dataset):
            raise UsageError(f"{file}: is a card, a damper without a structure: name one by --structure CONFIG")
        return dataset, None
    part = card_of(dataset)
    mass = float(part["particle_mass"])
    checked = _structural(structure)
    (modes,) = modes_with(checked, [mass])
    if said := difference(part, checked, 1):
        print(said)
    return part, ModalModel.of_modes(modes, modes.inherent_damping, mass)


def _structural(file: Path) -> Config:
    """Study with a structure."""
    from ..sweep.load import load

    checked = load(file)
    if checked.structure is None:
        raise checked.error("structure", "missing: a damper needs a structure that carries it")
    return checked


@app.command()
def card(
    file: Annotated[Path, typer.Argument(help="Results of a run of one damper, or its card.", metavar="RESULTS.nc")],
    at: AtOption = None,
    gamma: Annotated[float | None, typer.Option(help="Amplitude that a file for Nastran holds at.")] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help=".nc, .csv, or .bdf or .dat for Nastran (default: FILE.card.nc)."),
    ] = None,
) -> None:
    """Write the damper as a part: its complex mass over frequency and Gamma, with intervals, range and provenance."""
    with one_line_errors():
        from ..modal.card import card as card_of
        from ..modal.card import write_card
        from ..modal.card_nastran import SUFFIXES, write_nastran
        from ..modal.frf import chosen
        from ..report.tables import card_verdicts

        target = output or file.with_name(f"{file.stem}.card.nc")
        part = card_of(chosen(_results_or_card(file), at or []))
        writable(target.parent)
        nastran = target.suffix.lower() in SUFFIXES
        if nastran and gamma is None:
            raise UsageError(f"{target}: Nastran's tables hold at one amplitude: give it by --gamma")
        if not nastran and gamma is not None:
            raise UsageError(f"{target}: --gamma is for Nastran's tables (.bdf, .dat): a card holds all: leave it out")
        if nastran:
            write_nastran(part, target, gamma)
        else:
            write_card(part, target)
    print(target)
    for line in card_verdicts(part):
        print(line)


@app.command()
def damping(
    files: Annotated[list[Path], typer.Argument(help="A card for each damper, or one for all.", metavar="CARD...")],
    structure: Annotated[
        Path, typer.Option(help="Study whose structure carries the dampers, at their places in it.", metavar="CONFIG")
    ],
    output: Annotated[Path | None, typer.Option("-o", "--output", help=".nc for the data.")] = None,
) -> None:
    """Damping of a structure's modes with one damper or several, known by their cards: no simulation."""
    from rich.console import Console

    with one_line_errors():
        from ..analysis.results import write
        from ..modal import card as cards
        from ..modal.card_damper import difference
        from ..report.tables import card_verdicts, dampers_table
        from ..study.several import modes_with

        checked = _structural(structure)
        parts = [cards.read_card(file) for file in files]
        said = list(dict.fromkeys(line for part in parts for line in card_verdicts(part)))
        if len(parts) == 1:
            parts *= 1 + len(checked.dampers)
        modes = modes_with(checked, [float(part["particle_mass"]) for part in parts])
        said += filter(None, (difference(part, checked, k) for k, part in enumerate(parts, 1)))
        found = cards.damping(parts, modes)
        if output:
            if output.suffix != ".nc":
                raise UsageError(f"{output}: name a file that ends in .nc")
            writable(output.parent)
            write(found, output)
    Console().print(dampers_table(found))
    for line in said:
        print(line)


@app.command()
def fit(
    file: Annotated[
        Path, typer.Argument(help="FRF: .nc of `warpdamp frf`, table (.csv, .txt), universal file.", metavar="FRF")
    ],
    near: Annotated[
        list[float] | None,
        typer.Option(help="Frequency near a mode's peak [Hz]; may be repeated (default: every peak)."),
    ] = None,
    damping: Annotated[str, typer.Option(help="Of the modes that are fitted: structural or viscous.")] = "structural",
    at: Annotated[list[str] | None, typer.Option(help="Which of several FRFs, as level=2.")] = None,
    response: Annotated[
        str | None, typer.Option(help="Node and direction of the response, in a universal file of several, as 2z.")
    ] = None,
    reference: Annotated[str | None, typer.Option(help="Node and direction of the force, as 1z.")] = None,
    number: Annotated[int | None, typer.Option(help="Place of the function in the universal file, from 1.")] = None,
    every: Annotated[bool, typer.Option("--all", help="Every FRF of the universal file.")] = False,
    ordinate: Annotated[
        str | None, typer.Option(help="accelerance, mobility or receptance, where the file does not say.")
    ] = None,
    units: Annotated[
        str | None, typer.Option(help="Of response over force, as 'g/lbf', where the file does not say.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help=".nc for the data, .png for a picture over Gamma.")
    ] = None,
) -> None:
    """Frequency and damping of an FRF's modes: line fit, Dobson, circle fit, least squares."""
    from rich.console import Console

    with one_line_errors():
        from ..formats.frf_file import read_frf
        from ..modal.frf import chosen
        from ..modal.identify import fits
        from ..report.frf import fitted_curves
        from ..report.tables import fits_table

        choice = {"response": response, "reference": reference, "number": number, "every": every}
        frf = chosen(read_frf(file, **choice, ordinate=ordinate, units=units), at or [])
        found = fits(frf, near, damping=damping)
        if output:
            if output.suffix != ".nc" and "gamma" not in found.dims:
                raise UsageError(f"{output}: there is nothing to draw over Gamma: name a file that ends in .nc")
            save_as_asked(found, fitted_curves, output)
    console = Console()
    if "read_as" in found.attrs:
        console.print(f"{file}: {found.attrs['read_as']}", highlight=False, markup=False)
    console.print(fits_table(found))
    for line in found.attrs["refused"][:MOST_REFUSED]:
        console.print(f"not fitted: {line}", highlight=False, markup=False)
    if (more := len(found.attrs["refused"]) - MOST_REFUSED) > 0:
        console.print(f"and {more} others", highlight=False)
