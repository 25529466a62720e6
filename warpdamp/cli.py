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
def modes(config: ConfigArgument) -> None:
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
        masses = sorted({0.0, *(particle_mass(single) for single in every)})
        tables = [(m, modes_table(own_modes(every[0], particles=m))) for m in masses]
    console = Console()
    for particles, table in tables:
        console.print(f"with {1e3 * particles:.2f} g of particles", highlight=False)
        console.print(table)


@app.command()
def plot(
    file: Annotated[Path, typer.Argument(help="Results of a run.", metavar="FILE.nc")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="PNG to write (default: beside FILE).")] = None,
) -> None:
    """Draw a results file: curves, maps of frequency and Gamma, or scattered cases, as its dimensions ask."""
    with _one_line_errors():
        import xarray as xr

        from .plot import draw, save

        target = output or file.with_suffix(".png")
        if target.suffix not in (".png", ".pdf", ".svg"):
            raise OSError(f"{target}: name a file that ends in .png, .pdf or .svg")
        _writable(target.parent)
        try:
            dataset = xr.open_dataset(file)
        except ValueError:
            raise OSError(f"{file}: is no netCDF file") from None
        with dataset:
            if "effectiveness" not in dataset:
                raise OSError(f"{file}: is no results file of warpdamp (it has no effectiveness)")
            save(draw(dataset), target)
    print(target)


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

    try:
        yield
    except (ConfigError, SimulationError, OSError) as error:
        print(error if isinstance(error, ConfigError) else f"warpdamp: {error}", file=sys.stderr)
        raise typer.Exit(2) from None


def _writable(folder: Path) -> None:
    """Make the folder, or say why not, before anything long starts."""
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK):
        raise PermissionError(f"{folder}: cannot be written")


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
