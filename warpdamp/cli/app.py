"""The command line: parse, call, print."""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import UsageError
from ..version import PHYSICS_VERSION, __version__
from . import design as cli_design
from . import look as cli_look
from . import structure as cli_structure
from .common import ConfigArgument, importing_meanwhile, one_line_errors, picture_file, progress, stoppable, writable

if TYPE_CHECKING:
    from ..config.study import Config

EXECUTORS = ("processes", "in-process", "dask")

app = typer.Typer(
    help="How much vibration a granular damper takes out of a structure.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


def _say_version(wanted: bool) -> None:
    if wanted:
        print(f"warpdamp {__version__}, physics version {PHYSICS_VERSION}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_say_version, is_eager=True, help="Show the versions and exit.")
    ] = False,
) -> None:
    pass


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
    limit: Annotated[float | None, typer.Option(min=1, help="Seconds after which a batch counts as hanging.")] = None,
) -> None:
    """Run a study, or what is left of it: one netCDF file, a picture, and a table of the optima.

    Every batch of cases is stored in OUTPUT/CONFIG as soon as it is done; the same command continues from there.
    """
    from rich.console import Console

    with one_line_errors():
        from ..analysis.results import write
        from ..report.curves import draw
        from ..report.figures import save
        from ..report.tables import summary, verdicts
        from ..study import run as study
        from ..sweep.load import load

        if executor not in EXECUTORS and "://" not in executor:
            raise typer.BadParameter(f"'{executor}' is not one of {', '.join(EXECUTORS)}", param_hint="--executor")
        checked, share = load(config), _part(part)
        store = output / f"{config.stem}{'-quick' if quick else ''}"
        path = store.with_name(f"{store.name}.nc")
        writable(output)
        started = time.perf_counter()
        options = {"quick": quick, "workers": workers, "executor": executor, "limit": limit}
        with stoppable(store), progress() as report:
            if share:
                study.carry_out(checked, store, part=share, report=report, **options)
                print(f"part {part} is done; warpdamp collect {store} puts all parts together")
                return
            dataset = study.run(checked, store=store, report=importing_meanwhile(report), **options)
        write(dataset, path)
        save(draw(dataset), path.with_suffix(".png"))
    console = Console()
    console.print(summary(dataset))
    for line in verdicts(dataset, quick=quick):
        console.print(line, highlight=False)
    if quick:
        console.print(
            "quick look: loose beds, one seed, 12 cycles a case, a few amplitudes, whatever the configuration says of "
            "these; run without --quick for the study itself",
            highlight=False,
        )
    spent = time.perf_counter() - started
    console.print(f"{path} and {path.stem}.png, in {spent:.0f} s", highlight=False)


def _part(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    k, _, n = text.partition("/")
    if not (k.isdigit() and n.isdigit() and 1 <= int(k) <= int(n)):
        raise typer.BadParameter(f"'{text}' is not a part: write as 17/200", param_hint="--part")
    return int(k), int(n)


FolderArgument = Annotated[Path, typer.Argument(help="Folder of a run.", metavar="DIR")]


@app.command()
def status(folder: FolderArgument) -> None:
    """Show the progress of a run: done, in progress, failed, and the time left."""
    with one_line_errors():
        from ..execution.progress import status as progress_lines

        for line in progress_lines(folder):
            print(line)


@app.command()
def collect(
    folder: FolderArgument,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="netCDF file to write (default: beside DIR).")
    ] = None,
) -> None:
    """Collect all that is done so far in one netCDF file, at any moment."""
    from rich.console import Console

    with one_line_errors():
        from ..analysis.results import write
        from ..execution.store import Store
        from ..report.tables import verdicts
        from ..study.run import collect as collected

        store = Store.existing(folder).folder
        target = output or store.with_name(f"{store.name}.nc")
        writable(target.parent)
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
    """Explain what a study will simulate, why, and its cost, without running it."""
    with one_line_errors():
        from ..study.explain import explain as explained
        from ..sweep.load import load

        checked = load(config)
        designed = _designed(checked) if checked.design else ""
        if measure:
            from ..study.cost import measure_study

            measure_study(checked)
        print(explained(checked) + designed)


def _designed(checked: Config) -> str:
    """What `warpdamp design` will choose, once its problem has been read."""
    from ..design.problem import Problem

    budget = checked.design.budget
    ends = [f"{number:g} {what}" for what, number in (("cases", budget.cases), ("minutes", budget.minutes)) if number]
    return "\n".join(
        [
            "\n",
            "Design (warpdamp design)",
            f"  chooses {', '.join(variable.name for variable in Problem(checked).variables)}; the search ends after "
            + " or ".join(ends),
        ]
    )


@app.command()
def accuracy(
    config: ConfigArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the results.")] = Path("results"),
    cycles: Annotated[int, typer.Option(min=30, help="Cycles of every run.")] = 120,
    points: Annotated[int, typer.Option(min=2, help="Points of the study to take, at most.")] = 6,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes (default: all cores).")] = None,
) -> None:
    """Study what accuracy costs: each numerical choice varied at a few points of a study."""
    with one_line_errors():
        from ..analysis.results import write
        from ..execution.executors import worker_pool
        from ..report.accuracy import budget, work_precision
        from ..report.figures import save
        from ..report.tables import accuracy_table
        from ..study.accuracy import points_of
        from ..study.accuracy import study as vary
        from ..sweep.load import load

        checked = load(config)
        writable(output)
        specs = points_of(checked, points)
        with progress() as report, worker_pool("processes", workers) as processes:
            runs = vary(specs, lambda _: cycles, processes.executor, report=lambda done: report("runs", done))
        path = output / f"{config.stem}-accuracy.nc"
        write(runs, path)
        save(work_precision(runs), path.with_suffix(".png"))
        save(budget(runs), path.with_name(f"{path.stem}-budget.png"))
    from rich.console import Console

    Console().print(accuracy_table(runs))
    print(path)


@app.command()
def plot(
    file: Annotated[Path, typer.Argument(help="Results of a run.", metavar="FILE.nc")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Picture to write, .png, .pdf or .svg (default: beside FILE).")
    ] = None,
) -> None:
    """Draw a results file: curves, maps, or scattered cases, as its dimensions ask; or that of coupled runs."""
    with one_line_errors():
        from ..analysis.results import is_coupled, read
        from ..report.coupled import answers
        from ..report.curves import draw
        from ..report.figures import save

        target = picture_file(output or file.with_suffix(".png"))
        dataset = read(file, coupled=True)
        try:
            figure = (answers if is_coupled(dataset) else draw)(dataset)
        except ValueError as error:
            raise UsageError(f"{file}: {error}") from None
        save(figure, target)
    print(target)


@app.command()
def schema() -> None:
    """Print the JSON schema of the configuration, for editors."""
    from ..config.schema import json_schema

    print(json.dumps(json_schema(), indent=2))


@app.command()
def info() -> None:
    """Show what is installed: versions, devices, caches, extras."""
    from ..report.installation import caches, devices, extras, versions

    with one_line_errors():
        parts = {"versions": versions(), "devices": devices(), "caches": caches(), "extras": extras()}
    for title, lines in parts.items():
        print(title)
        for name, text in lines.items():
            print(f"  {name:<12} {text}")


for part in (cli_look, cli_structure, cli_design):
    app.registered_commands += part.app.registered_commands


def main() -> None:
    """Run the command line; end quietly when nobody reads its output on, as behind ``| head``."""
    try:
        try:
            app(prog_name="warpdamp")
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left in the buffer goes there at exit
        sys.exit(1)
