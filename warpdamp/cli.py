"""The command line: parse, call, print."""

from __future__ import annotations

import json
import os
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    help="How much vibration a granular damper takes out of a structure.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)

ConfigArgument = Annotated[Path, typer.Argument(help="YAML file of the study.", metavar="CONFIG")]


@app.command()
def run(
    config: ConfigArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the results.")] = Path("results"),
    quick: Annotated[
        bool, typer.Option("--quick", help="A first look in a minute: few amplitudes, one seed, loose bed, 12 cycles.")
    ] = False,
    workers: Annotated[int | None, typer.Option(min=1, help="Workers (default: all cores).")] = None,
    executor: Annotated[
        str, typer.Option(help="processes, in-process, dask, or the address of a Dask scheduler.")
    ] = "processes",
    part: Annotated[
        str | None, typer.Option(metavar="K/N", help="Run the K-th of N parts only, as an array job does.")
    ] = None,
    limit: Annotated[
        float | None, typer.Option(min=1, help="Seconds after which a batch is taken for hanging.")
    ] = None,
) -> None:
    """Run a study, or what is left of it: one netCDF file, a picture, and a table of the peaks.

    Every batch of cases is kept in OUTPUT/CONFIG as soon as it is done; the same command goes on from there.
    """
    from rich.console import Console

    with _one_line_errors():
        from . import study
        from .config import load
        from .plot import draw, save
        from .report import summary, verdicts
        from .results import write

        checked, own = load(config), _part(part)
        store = output / f"{config.stem}{'-quick' if quick else ''}"
        path = store.with_name(f"{store.name}.nc")
        _writable(output)
        started = time.perf_counter()
        options = {"quick": quick, "workers": workers, "executor": executor, "limit": limit}
        with _stoppable(store), _progress() as report:
            if own:
                study.carry_out(checked, store, part=own, report=report, **options)
                print(f"part {part} is done; warpdamp collect {store} puts all parts together")
                return
            dataset = study.run(checked, store=store, report=report, **options)
        write(dataset, path)
        save(draw(dataset), path.with_suffix(".png"))
    console = Console()
    console.print(summary(dataset))
    for line in verdicts(dataset):
        console.print(line, highlight=False)
    spent = time.perf_counter() - started
    console.print(f"{path} and {path.stem}.png, in {spent:.0f} s", highlight=False)


def _part(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    k, _, n = text.partition("/")
    if not (k.isdigit() and n.isdigit() and 1 <= int(k) <= int(n)):
        raise typer.BadParameter(f"'{text}' is no part: write as 17/200", param_hint="--part")
    return int(k), int(n)


@contextmanager
def _stoppable(store: Path):
    """Ctrl-C, or a scheduler's polite end, stops a run and says how to go on."""
    import signal

    def stop(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    except KeyboardInterrupt:
        print(
            f"\nwarpdamp: stopped; every finished batch is kept in {store}: the same command goes on from there, "
            f"warpdamp status {store} says how far it is",
            file=sys.stderr,
        )
        raise typer.Exit(130) from None
    finally:
        signal.signal(signal.SIGTERM, before)


FolderArgument = Annotated[Path, typer.Argument(help="Folder of a run.", metavar="DIR")]


@app.command()
def status(folder: FolderArgument) -> None:
    """Say how far a run is: done, at work, failed, and the time left."""
    with _one_line_errors():
        from .status import status as told

        for line in told(folder):
            print(line)


@app.command()
def collect(
    folder: FolderArgument,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="netCDF file to write (default: beside DIR).")
    ] = None,
) -> None:
    """Put all that is done so far into one netCDF file, at any moment."""
    from rich.console import Console

    with _one_line_errors():
        from .report import verdicts
        from .results import write
        from .store import Store
        from .study import collect as collected

        store = Store.existing(folder).folder
        target = output or store.with_name(f"{store.name}.nc")
        _writable(target.parent)
        dataset = collected(store)
        write(dataset, target)
    for line in verdicts(dataset):
        Console().print(line, highlight=False)
    print(target)


@app.command()
def explain(
    config: ConfigArgument,
    measure: Annotated[bool, typer.Option("--measure", help="Measure first what each effect costs here.")] = False,
) -> None:
    """Say what a study will simulate, why, and what it will take, without running it."""
    with _one_line_errors():
        from .config import load
        from .explain import explain as explained

        checked = load(config)
        if measure:
            from .speed import measure_study

            measure_study(checked)
        print(explained(checked))


@app.command()
def accuracy(
    config: ConfigArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the results.")] = Path("results"),
    cycles: Annotated[int, typer.Option(min=30, help="Cycles of every run.")] = 120,
    points: Annotated[int, typer.Option(min=2, help="Points of the study to take, at most.")] = 6,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes (default: all cores).")] = None,
) -> None:
    """Study what accuracy costs: each numerical choice varied at a few points of a study."""
    with _one_line_errors():
        from .accuracy import points_of
        from .accuracy import study as vary
        from .config import load
        from .executors import crew
        from .plot import save
        from .plot_accuracy import budget, work_precision
        from .report import accuracy_table
        from .results import write

        checked = load(config)
        _writable(output)
        own = points_of(checked, points)
        with _progress() as report, crew("processes", workers) as processes:
            runs = vary(own, lambda _: cycles, processes.executor, report=lambda done: report("runs", done))
        path = output / f"{config.stem}-accuracy.nc"
        write(runs, path)
        save(work_precision(runs), path.with_suffix(".png"))
        save(budget(runs), path.with_name(f"{path.stem}-budget.png"))
    from rich.console import Console

    Console().print(accuracy_table(runs))
    print(path)


@app.command()
def modes(
    config: ConfigArgument,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", help="Write those with the particles: a picture (.png), or a .csv or .uff file."
        ),
    ] = None,
) -> None:
    """Show the structure's modes, without and with the particles' mass."""
    from rich.console import Console

    with _one_line_errors():
        from .cases import Cases
        from .config import load
        from .report import modes_table
        from .sources import modes as own_modes
        from .sweep import particle_mass

        checked = load(config)
        if checked.structure is None:
            raise checked.error("structure", "missing: there are no modes without a structure")
        every = [point.config for point in Cases(checked).points() if point.config]
        masses = {particle_mass(single) for single in every}
        if not checked.structure.particles_included:
            masses.add(0.0)
        found = {m: own_modes(every[0], particles=m) for m in sorted(masses)}
        if output:
            from .modal.export import export

            export(found[max(masses)], output, title=checked.title)
    console = Console()
    for particles, own in found.items():
        console.print(f"with {1e3 * particles:.2f} g of particles", highlight=False)
        console.print(modes_table(own))


@app.command()
def plot(
    file: Annotated[Path, typer.Argument(help="Results of a run.", metavar="FILE.nc")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="PNG to write (default: beside FILE).")] = None,
) -> None:
    """Draw a results file: curves, maps of frequency and Gamma, or scattered cases, as its dimensions ask."""
    with _one_line_errors():
        from .plot import draw, save
        from .results import read

        target = _picture(output or file.with_suffix(".png"))
        save(draw(read(file)), target)
    print(target)


def _newtons(text: str) -> float:
    from .units import to_si

    try:
        return to_si(text, "N")
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None


@app.command()
def frf(
    file: Annotated[Path, typer.Argument(help="Results of a run with a structure.", metavar="RESULTS.nc")],
    constant_force: Annotated[
        list[float] | None,
        typer.Option(
            parser=_newtons,
            metavar="FORCE",
            help="Amplitude of the force, as '50 mN'; may be repeated (default: controlled Gamma).",
        ),
    ] = None,
    band: Annotated[tuple[float, float] | None, typer.Option(help="Lowest and highest frequency [Hz].")] = None,
    at: Annotated[list[str] | None, typer.Option(help="Value of a swept scalar, as friction=0.5.")] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help=".nc for the data, .png for a picture (default: beside FILE).")
    ] = None,
) -> None:
    """Accelerance of the structure with its damper: at controlled Gamma, or every branch at constant force."""
    with _one_line_errors():
        from .modal import frf as response
        from .plot_frf import families, force_curves
        from .results import read

        target = output or file.with_name(f"{file.stem}-frf.png")
        dataset = response.chosen(read(file), at or [])
        if constant_force:
            found, draw = response.constant_force(dataset, constant_force, band), force_curves
        else:
            found, draw = response.accelerance(dataset, band=band), families
        _save(found, draw, target)
    print(target)


@app.command()
def fit(
    file: Annotated[Path, typer.Argument(help="FRF: .nc of `warpdamp frf`, .csv, .uff.", metavar="FRF")],
    near: Annotated[
        list[float] | None,
        typer.Option(help="Frequency near a mode's peak [Hz]; may be repeated (default: every peak)."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help=".nc for the data, .png for a picture over Gamma.")
    ] = None,
) -> None:
    """Frequency and damping of an FRF's modes: line fit, Dobson, circle fit, least squares."""
    from rich.console import Console

    with _one_line_errors():
        from .modal.measured import fits, read_frf
        from .plot_frf import fitted_curves
        from .report import fits_table

        found = fits(read_frf(file), near)
        if output:
            if output.suffix != ".nc" and "gamma" not in found.dims:
                raise OSError(f"{output}: one FRF has nothing to draw over Gamma: name a file that ends in .nc")
            _save(found, fitted_curves, output)
    console = Console()
    console.print(fits_table(found))
    for line in found.attrs["refused"]:
        console.print(line, highlight=False)


@app.command()
def schema() -> None:
    """Print the JSON schema of the configuration, for editors."""
    from .config import Config

    print(json.dumps(Config.model_json_schema(), indent=2))


@contextmanager
def _one_line_errors():
    """What a user can mend comes as one line and exit status 2; anything else is a bug and keeps its traceback."""
    from .config import ConfigError
    from .guards import SimulationError
    from .modal import ModalError
    from .modal.extra import MissingLibrary

    try:
        yield
    except (ConfigError, SimulationError, ModalError, MissingLibrary, OSError) as error:
        print(error if isinstance(error, ConfigError) else f"warpdamp: {error}", file=sys.stderr)
        raise typer.Exit(2) from None


def _writable(folder: Path) -> None:
    """Make the folder, or say why not, before anything long starts."""
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK):
        raise PermissionError(f"{folder}: cannot be written")


def _picture(target: Path) -> Path:
    """A file that a picture can be written to."""
    if target.suffix not in (".png", ".pdf", ".svg"):
        raise OSError(f"{target}: name a file that ends in .png, .pdf or .svg")
    _writable(target.parent)
    return target


def _save(dataset, draw, target: Path) -> None:
    """The data or their picture, as the file's suffix says."""
    from .plot import save
    from .results import write

    if target.suffix == ".nc":
        _writable(target.parent)
        write(dataset, target)
    else:
        save(draw(dataset), _picture(target))


@contextmanager
def _progress():
    """A bar with the time left on a terminal; plain lines elsewhere."""
    if not sys.stderr.isatty():
        yield _plain_progress()
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description:8}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True)) as progress:
        tasks = {}

        def report(stage, done):
            if stage not in tasks:
                tasks[stage] = progress.add_task(stage, total=1.0)
            progress.update(tasks[stage], completed=done)

        yield report


def _plain_progress():
    last = {}

    def report(stage, done):
        tenth = int(10 * done)
        if last.get(stage) != tenth:
            last[stage] = tenth
            print(f"{stage} {100 * done:.0f} %", file=sys.stderr, flush=True)

    return report
