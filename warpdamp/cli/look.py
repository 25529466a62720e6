"""Commands that show: films of a case, the report of a study."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import UsageError, WarpdampError
from .common import one_line_errors, progress, writable
from .structure import AtOption

if TYPE_CHECKING:
    import xarray as xr

    from ..modes import Modes
    from ..report.film import Film
    from ..study.again import Again

app = typer.Typer()


@app.command()
def film(
    source: Annotated[Path, typer.Argument(help="Results of a run, or its YAML file.", metavar="RESULTS.nc|CONFIG")],
    gamma: Annotated[float | None, typer.Option(help="Amplitude of the case.")] = None,
    mode: Annotated[int | None, typer.Option(help="Number of the mode that is shaken.")] = None,
    frequency: Annotated[float | None, typer.Option(help="Frequency of the case [Hz].")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the packing (default: the first, or the best).")] = None,
    at: AtOption = None,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o",
            "--output",
            help=".html (a page with a player), .gif, .mp4, .xyz for OVITO, .vtkhdf for ParaView; may be repeated "
            "(default: FILE-film.html).",
        ),
    ] = None,
    frames: Annotated[int, typer.Option(min=2, max=2000, help="Frames.")] = 60,
    cycles: Annotated[int, typer.Option(min=1, help="Cycles of the drive that they show, the last of the case.")] = 3,
    colour: Annotated[str, typer.Option(help="speed, spin or energy: what colours the particles.")] = "speed",
    forces: Annotated[bool, typer.Option("--forces", help="Draw contact forces.")] = False,
    anyway: Annotated[
        bool, typer.Option("--anyway", help="Film results of another version or machine as the case runs here.")
    ] = False,
) -> None:
    """Film a case: it is run again to the same bits, and its last cycles are recorded.

    Several dampers on one structure stand beside each other, in one phase of the drive.
    Of results the most effective case is taken among those that the options leave.
    """
    with one_line_errors():
        targets = output or [Path(f"{source.stem}-film.html")]
        colour_of = _colour(colour)
        for target in targets:
            _check_target(target)
        from ..study.again_beside import again_all
        from ..sweep.choice import Choice

        choice = Choice.of(at or [], gamma=gamma, mode=mode, frequency=frequency, seed=seed)
        with progress() as report:
            taken = again_all(
                source, choice, frames=frames, shown=cycles, anyway=anyway, report=lambda done: report("frames", done)
            )
        shown = _film(taken, colour_of, forces)
        written = [path for target in targets for path in _write(shown, target)]
    for each in taken:
        print(f"{each.label}: {each.remark}")
    for path in written:
        print(path)


def _write(film: Film, target: Path) -> list[Path]:
    """Write a film in the format of a suffix; other programs get a file of each damper."""
    suffix = target.suffix.lower()
    if suffix not in APART or not film.beside:
        WRITERS[suffix](film, target)
        return [target]
    paths = [target.with_stem(f"{target.stem}-damper{k}") for k in range(1, len(film.every) + 1)]
    for one, path in zip(film.every, paths, strict=True):
        WRITERS[suffix](one, path)
    return paths


def _page(film: Film, path: Path) -> None:
    from ..report.film_page import write_film_page

    write_film_page(film, path)


def _gif(film: Film, path: Path) -> None:
    from ..report.film_pictures import write_gif

    write_gif(film, path)


def _mp4(film: Film, path: Path) -> None:
    from ..report.film_pictures import write_mp4

    write_mp4(film, path)


def _extxyz(film: Film, path: Path) -> None:
    from ..report.film_files import write_extxyz

    write_extxyz(film, path)


def _vtkhdf(film: Film, path: Path) -> None:
    from ..report.film_files import write_vtkhdf

    write_vtkhdf(film, path)


WRITERS = {".html": _page, ".gif": _gif, ".mp4": _mp4, ".xyz": _extxyz, ".vtkhdf": _vtkhdf}
"""What writes a film, by the suffix of its file."""

APART = (".xyz", ".vtkhdf")
"""Formats of one cavity."""

NEEDS = {
    ".html": ("jinja2", "pages"),
    ".mp4": ("imageio_ffmpeg", "films as mp4"),
    ".vtkhdf": ("h5py", "films for ParaView"),
}
"""Module of the extra ``film`` that a suffix needs, and for what."""


def _check_target(target: Path) -> None:
    """Refuse a file that cannot be written, before anything is run."""
    from ..formats.optional import needs

    suffix = target.suffix.lower()
    if suffix not in WRITERS:
        raise UsageError(f"{target}: name a file that ends in {', '.join(WRITERS)}")
    if suffix in NEEDS:
        needs(*NEEDS[suffix], "film")
    writable(target.parent)


def _colour(word: str):
    from ..report.film import Colour

    if word not in {colour.value for colour in Colour}:
        raise typer.BadParameter(f"'{word}' is not one of {', '.join(c.value for c in Colour)}", param_hint="--colour")
    return Colour(word)


def _film(taken: list[Again], colour, forces: bool) -> Film:
    """Film of a case, with those of the structure's other dampers beside it."""
    from ..report.film import Film

    films = [
        Film(
            one.trajectory,
            one.title,
            one.label,
            one.remark,
            one.source,
            int(one.values["cycles_discarded"]),
            colour,
            forces,
        )
        for one in taken
    ]
    return replace(films[0], beside=tuple(films[1:]))


LONGEST_CASE = 2e8
"""Particle-steps above which a report leaves the film out: more than half a minute, mostly."""


@app.command()
def report(
    file: Annotated[Path, typer.Argument(help="Results of a run, or the answer of a design.", metavar="RESULTS.nc")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Page to write (default: beside FILE).")] = None,
    film: Annotated[bool, typer.Option(help="With a film of the most effective case.")] = True,
) -> None:
    """Write a report: one HTML file with curves, calculator, energies, modes and a film, which opens offline.

    Of a design: the damper chosen with its probability, its curve, the front, tolerances and runners-up.
    """
    with one_line_errors():
        from ..analysis.results import is_design, read
        from ..formats.optional import needs
        from ..report.design_page import write_design_report
        from ..report.report_page import write_report

        target = output or file.with_suffix(".html")
        if target.suffix.lower() != ".html":
            raise UsageError(f"{target}: name a file that ends in .html")
        needs("jinja2", "reports", "report")
        writable(target.parent)
        dataset = read(file, design=True)
        if is_design(dataset):
            write_design_report(dataset, target)
            print(target)
            return
        try:
            modes = _modes(dataset, file)
            shown = _film_of_report(dataset, file) if film else "This report was made without a film."
            write_report(dataset, target, modes=modes, film=shown)
        except UsageError as error:
            raise UsageError(f"{file}: {error}" if str(file) not in str(error) else str(error)) from None
    print(target)


def _modes(dataset: xr.Dataset, file: Path) -> Modes | str:
    """Modes of the structure of a study, with its particles; or why there are none."""
    from ..study.again import stored_config
    from ..sweep.cases import Cases

    try:
        config = stored_config(dataset, file)
        if config.structure is None:
            return "The study is of a damper without a structure."
        if config.dampers:
            from ..study.several import every_damper, modes_of_all

            return modes_of_all(config, every_damper(config))[0]
        found = next((point.modes for point in Cases(config).points() if point.modes is not None), None)
    except WarpdampError as error:
        return f"The modes cannot be drawn: {error}"
    return found or "The frequencies were given, so that no modes were computed."


def _film_of_report(dataset: xr.Dataset, file: Path) -> Film | str:
    """Film of the most effective case; or why there is none."""
    from ..report.film import Colour
    from ..study.again_beside import again_all
    from ..sweep.choice import Choice

    try:
        taken = again_all(file, Choice(), anyway=True, most=LONGEST_CASE)
    except WarpdampError as error:
        return f"There is no film: {error}"
    return _film(taken, Colour.SPEED, forces=False)
