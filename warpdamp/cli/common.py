"""Common parts of the commands: errors as one line, writable files, progress."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from ..errors import UsageError

AFTER_A_RUN = (
    *("xarray", "dask.array", "distributed", "netCDF4"),  # of which xarray takes what is installed
    *("scipy.signal", "matplotlib.figure", "matplotlib.backends.backend_agg"),
)
"""Libraries that results are collected, drawn and summed up with; a second to import."""

ConfigArgument = Annotated[Path, typer.Argument(help="YAML file of the study.", metavar="CONFIG")]


@contextmanager
def one_line_errors():
    """Context that prints a user's error as one line with exit status 2; a bug keeps its traceback."""
    from ..errors import ConfigError, WarpdampError

    try:
        yield
    except BrokenPipeError:  # nobody reads on, as behind `| head`: nothing to say
        raise
    except (WarpdampError, OSError) as error:
        print(error if isinstance(error, ConfigError) else f"warpdamp: {error}", file=sys.stderr)
        raise typer.Exit(2) from None


def writable(folder: Path) -> None:
    """Make the folder, or say why not, before anything long starts."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"{folder}: cannot be made ({error.strerror}): name another folder") from None
    if not os.access(folder, os.W_OK):
        raise UsageError(f"{folder}: cannot be written")


def picture_file(target: Path, *others: str) -> Path:
    """Path that a picture can be written to; ``others``: suffixes that stand for something else than a picture."""
    from ..report.figures import PICTURES

    if target.suffix not in PICTURES:
        *most, last = *others, *PICTURES
        raise UsageError(f"{target}: name a file that ends in {', '.join(most)} or {last}")
    writable(target.parent)
    return target


def save_as_asked(dataset, draw, target: Path) -> None:
    """Write the data or their picture, as the file's suffix says."""
    from ..analysis.results import write
    from ..report.figures import save

    if target.suffix == ".nc":
        writable(target.parent)
        write(dataset, target)
    else:
        save(draw(dataset), picture_file(target, ".nc"))


@contextmanager
def progress():
    """Progress bar with the time left on a terminal; plain lines elsewhere."""
    if not sys.stderr.isatty():
        yield _plain_progress()
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

    columns = (TextColumn("{task.description:8}"), BarColumn(), TaskProgressColumn(), _time_left_column())
    with Progress(*columns, console=Console(stderr=True)) as progress:
        tasks = {}

        def report(stage, done):
            if stage not in tasks:
                tasks[stage] = progress.add_task(stage, total=1.0)
            progress.update(tasks[stage], completed=done)

        yield report


def _time_left_column():
    """Column with the time left, from the mean rate since the stage began: stages advance in steps of many seconds."""
    from rich.progress import ProgressColumn, Task
    from rich.text import Text

    class TimeLeft(ProgressColumn):
        at: dict[int, tuple[float, float]] = {}  # noqa: RUF012 - of one progress display

        def render(self, task: Task) -> Text:
            done, elapsed = task.percentage / 100, task.finished_time or task.elapsed or 0.0
            before, since = self.at.get(task.id, (0.0, 0.0))
            if done != before:
                before, since = self.at[task.id] = done, elapsed
            left = since * (1 - before) / before - (elapsed - since) if before else 0.0
            return Text(f"{max(0, left) / 60:.1f} min left" if before and done < 1 else "")

    return TimeLeft()


def importing_meanwhile(report: Callable[[str, float], None]) -> Callable[[str, float], None]:
    """The report of a run that, once workers have something to do, imports ``AFTER_A_RUN`` beside them."""
    installed = [name for name in AFTER_A_RUN if find_spec(name.partition(".")[0])]
    thread = threading.Thread(target=lambda: [import_module(name) for name in installed])

    def first_report(stage: str, done: float) -> None:
        report(stage, done)
        if stage == "kernels" and thread.ident is None:
            thread.start()

    return first_report


def _plain_progress():
    last = {}

    def report(stage, done):
        tenth = int(10 * done)
        if last.get(stage) != tenth:
            last[stage] = tenth
            print(f"{stage} {100 * done:.0f} %", file=sys.stderr, flush=True)

    return report


@contextmanager
def stoppable(store: Path):
    """Context in which Ctrl-C or SIGTERM stops a run and says how to continue it."""
    import signal

    def stop(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    except KeyboardInterrupt:
        print(
            f"\nwarpdamp: stopped; every finished batch is stored in {store}: the same command continues from there, "
            f"warpdamp status {store} says how far it is",
            file=sys.stderr,
        )
        raise typer.Exit(130) from None
    finally:
        signal.signal(signal.SIGTERM, before)
