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
    workers: Annotated[int | None, typer.Option(min=1, help="Processes (default: all cores).")] = None,
) -> None:
    """Run a study: one netCDF file, a picture, and a table of the peaks."""
    from rich.console import Console

    with _one_line_errors():
        from . import study
        from .config import load
        from .plot import curves, save
        from .report import summary, verdicts
        from .results import write

        checked = load(config)
        path = output / f"{config.stem}{'-quick' if quick else ''}.nc"
        _writable(output)
        started = time.perf_counter()
        with _progress() as report:
            dataset = study.run(checked, quick=quick, workers=workers, report=report)
        write(dataset, path)
        save(curves(dataset), path.with_suffix(".png"))
    console = Console()
    console.print(summary(dataset))
    for line in verdicts(dataset):
        console.print(line, highlight=False)
    spent = time.perf_counter() - started
    console.print(f"{path} and {path.with_suffix('.png').name}, in {spent:.0f} s", highlight=False)


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
        from . import study
        from .config import load
        from .report import modes_table
        from .sweep import particle_mass, points

        checked = load(config)
        if checked.structure is None:
            raise checked.error("structure", "missing: there are no modes without a structure")
        _, single = next(points(checked))
        single._source = checked._source
        masses = {particle_mass(point) for _, point in points(checked)}
        if not checked.structure.particles_included:
            masses.add(0.0)
        found = {m: study.modes(single, particles=m) for m in sorted(masses)}
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
    """Draw the curves of a results file."""
    with _one_line_errors():
        import xarray as xr

        from .plot import curves, save

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
            save(curves(dataset), target)
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
    from .modal.extra import MissingLibrary

    try:
        yield
    except (ConfigError, SimulationError, MissingLibrary, OSError) as error:
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
