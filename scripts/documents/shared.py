"""What the scripts of this folder share: where documents lie, their parts in Markdown, figures, worker processes."""

import argparse
import importlib.metadata
import json
import os
import platform
import shlex
import sys
import time
from collections.abc import Collection, Iterable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import warpdamp
from warpdamp.files import whole_file

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
sys.path.insert(0, str(ROOT / "tests"))  # closed forms and cases that documents share with the tests


def head(title: str, script: str) -> str:
    """The first lines of a document: its title, and the script (``__file__``) that wrote it, without a full stop."""
    return f"# {title}\n\nWritten by `python {Path(script).resolve().relative_to(ROOT)}`"


def table(heading: Collection[str], rows: Iterable[Iterable]) -> str:
    """A Markdown table; cells are text or what ``str`` makes of them."""
    first, *lines = (f"| {' | '.join(map(str, row))} |" for row in (heading, *rows))
    return "\n".join([first, "|" + "---|" * len(heading), *lines])


def write_document(name: str, *blocks: str, folder: Path = DOCS) -> None:
    """Write ``folder/name``, an empty line between any two blocks, and print it."""
    text = "\n\n".join(blocks).rstrip() + "\n"
    folder.mkdir(parents=True, exist_ok=True)
    with whole_file(folder / name) as part:
        part.write_text(text, encoding="utf-8")
    if folder == DOCS:
        note(Path(name).stem)
    print(text)


def note(name: str) -> None:
    """Note date, command, cost and physics version of a document, for the table of evidence in the site.

    What was simulated for it keeps its own note, until it is simulated again; so does ``data``, the version of the
    physics that was written down by hand, which goes when all is made anew.
    """
    path = DOCS / "evidence" / f"{name}.json"
    notes = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    script = Path(sys.argv[0]).resolve()
    simulated = "simulate" in sys.argv[1:]
    if simulated or not hasattr(sys.modules["__main__"], "simulate"):
        notes.pop("data", None)
    notes["simulated" if simulated else "written"] = entry = {
        "date": time.strftime("%Y-%m-%d"),
        "command": shlex.join(["python", str(script.relative_to(ROOT)), *sys.argv[1:]]),
        "processor_time": round(sum(os.times()[:4]), 1),
        "physics_version": warpdamp.PHYSICS_VERSION,
    }
    notes.setdefault("written", entry)
    path.parent.mkdir(exist_ok=True)
    with whole_file(path) as part:
        part.write_text(json.dumps(notes, indent=2) + "\n", encoding="utf-8")


def machine() -> str:
    """The processor, how many cores, the system, the date, and the versions of what computes."""
    model = platform.processor() or platform.machine()
    if (info := Path("/proc/cpuinfo")).exists():
        named = [line.partition(":")[2].strip() for line in info.read_text().splitlines() if "model name" in line]
        model = named[0] if named else model
    versions = [f"{name} {importlib.metadata.version(name)}" for name in ("warp-lang", "numpy")]
    return (
        f"{model}, {os.cpu_count()} cores, {platform.system()}, {time.strftime('%Y-%m-%d')}, "
        f"warpdamp {warpdamp.__version__}, {', '.join(versions)}, Python {platform.python_version()}"
    )


def panels(count: int, size: tuple[float, float], **options):
    """A figure of ``count`` panels side by side, its size in inches, and their axes, each with a grid."""
    figure = Figure(figsize=size, layout="constrained", dpi=110)
    axes = figure.subplots(1, count, squeeze=False, **options)[0]
    for ax in axes:
        ax.grid(alpha=0.3)
    return figure, axes


def processes(workers: int | None = None) -> ProcessPoolExecutor:
    """Fresh processes, one for each core by default: Warp does not promise that its runtime survives a fork."""
    return ProcessPoolExecutor(workers or os.cpu_count(), mp_context=get_context("spawn"))


def mean_and_error(values) -> tuple[float, float]:
    """Mean of what is finite, and its standard error."""
    known = np.asarray(values, float).ravel()
    known = known[np.isfinite(known)]
    error = np.std(known, ddof=1) / np.sqrt(len(known)) if len(known) > 1 else np.nan
    return float(np.mean(known)), float(error)


def progress(*words: str):
    """A ``report`` for ``warpdamp.run`` that prints, after some words, the stage and how much of it is done."""
    return lambda stage, done: print(*words, stage, f"{done:.0%}", flush=True)


def run_script(description: str, simulate, document) -> None:
    """Write a document and, if ``simulate`` stands on the command line, run its simulations before."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("simulate", nargs="?", choices=["simulate"])
    parser.add_argument("--workers", type=int)
    options = parser.parse_args()
    if options.simulate:
        simulate(options.workers)
    document()
