"""Films and reports: how long they take and how large they are; writes docs/films-and-reports.md and its pictures.

    python scripts/documents/films_and_reports.py

The paper's damper at its first mode and Gamma 6, and the report of docs/beam.nc.  Pictures of the pages are taken in a
headless Chromium (apt-get install chromium chromium-driver; pip install selenium).  About two minutes.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from shared import DOCS, ROOT, head, machine, table, write_document

from browser import MISSING, browser, complaints, open_page, resize
from warpdamp.cli.look import WRITERS
from warpdamp.damper.shake import shake
from warpdamp.damper.trajectory import CYCLES, FRAMES, record
from warpdamp.engine.compiling import compile_kernels
from warpdamp.kernels.groups import kernels_for
from warpdamp.report.film import Film
from warpdamp.study.again import again, chain_of
from warpdamp.sweep.cases import Cases
from warpdamp.sweep.choice import Choice, candidates, only
from warpdamp.sweep.load import load

CONFIG, RESULTS = ROOT / "configs" / "beam.yaml", DOCS / "beam.nc"
CHOICE = Choice(gamma=6, mode=1, seed=1)
WIDE, NARROW = 1100, 390
TOP = 1500
"""Height of the part of a page that a picture shows."""

COLOURS = 256


class Clock:
    """Wall and processor time spent in a context, that of processes started in it included [s]."""

    @staticmethod
    def now() -> tuple[float, float]:
        """Both since some moment."""
        spent = os.times()
        return time.perf_counter(), spent.user + spent.system + spent.children_user + spent.children_system

    def __enter__(self):
        self.start = self.now()
        return self

    def __exit__(self, *_):
        self.wall, self.cpu = (now - start for now, start in zip(self.now(), self.start, strict=True))

    @property
    def cells(self) -> tuple[str, str]:
        """Both as text."""
        return f"{self.wall:.1f}", f"{self.cpu:.1f}"


def main() -> None:
    """Film, report, pictures, document."""
    if MISSING:
        sys.exit(MISSING)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        rows, closure = film_rows(folder)
        report(folder)  # makes the bed of its film, if it is not there yet
        clock, report_size = report(folder)
        errors = take_pictures(folder)
    write_document(
        "films-and-reports.md",
        head("Films and reports", __file__) + f": {machine()}; {os.getloadavg()[0]:.1f} processes at work on it.",
        f"## {FRAMES} frames of the paper's damper\n\n"
        f"`warpdamp film configs/beam.yaml --gamma 6 --mode 1 --seed 1`: the last {CYCLES} cycles; kernels and bed "
        "were there before.  Recording stops the run at every frame and looks at the losses of each particle in "
        f"between; what it sees adds up to {100 * closure:.1f} % of the ledger's dissipation over the same cycles.",
        table(("", "wall time [s]", "processor time [s]", "size [MB]"), rows),
        "![A frame of the page of a film](film.png)",
        f"## Report\n\n`warpdamp report docs/beam.nc`, from the shell: {clock.cells[0]} s of wall time, "
        f"{clock.cells[1]} s of processor time, {report_size / 1e6:.2f} MB, with a film of the most effective case.  "
        "Chromium wrote to its console, of the report and the film, wide and narrow: "
        f"{errors or 'nothing'}.",
        "![The upper part of a report](report.png)",
        "![The same in a narrow window](report-narrow.png)",
    )


def film_rows(folder: Path):
    """Rows of the table of a film: the case, its recording, its files; and the part of the losses that was seen."""
    cases = Cases(load(CONFIG))
    chain, criteria = chain_of(cases, only(cases, candidates(cases, CHOICE)))
    specs = [spec for _, spec in chain]
    for kernels in kernels_for(specs[-1].effects):
        compile_kernels(kernels)
    again(CONFIG, CHOICE, frames=2, shown=1)  # compiles and prepares what is not there yet
    with Clock() as case:
        ((_, values),) = shake([specs], criteria)
    with Clock() as recording:
        trajectory = record(specs, [values["cycles"]])
    rows = [("the case by itself", *case.cells, ""), ("the case, recorded", *recording.cells, "")]
    film = Film(trajectory, "Granular damper on a clamped beam", "mode 1, Γ 6", discarded=values["cycles_discarded"])
    for suffix, write in WRITERS.items():
        path = folder / f"film{suffix}"
        with Clock() as clock:
            write(film, path)
        rows.append((suffix[1:], *clock.cells, f"{path.stat().st_size / 1e6:.2f}"))
    seen = FRAMES / (FRAMES - 1) * trajectory.frames[-1].lost.sum()  # the last frame is one short of the end
    return rows, seen / trajectory.ledger.per_cycle()[-CYCLES:].sum()


def report(folder: Path) -> tuple[Clock, int]:
    """Write the report by the command; its time and size [bytes]."""
    target = folder / "report.html"
    with Clock() as clock:
        subprocess.run([sys.executable, "-m", "warpdamp", "report", RESULTS, "-o", target], check=True, cwd=ROOT)
    return clock, target.stat().st_size


def take_pictures(folder: Path) -> str:
    """Pictures of the pages in docs/; returns what the browser complained of."""
    found = []
    with browser() as driver:
        for page, width, height, name in (
            ("report", WIDE, TOP, "report"),
            ("report", NARROW, TOP, "report-narrow"),
            ("film", WIDE, 1000, "film"),
        ):
            open_page(driver, folder / f"{page}.html", width)
            resize(driver, width, height)
            time.sleep(1)  # charts follow the width of the window
            driver.save_screenshot(str(folder / f"{name}.png"))
            found += complaints(driver)
            shrink(folder / f"{name}.png", DOCS / f"{name}.png")
    return "; ".join(found)


def shrink(picture: Path, target: Path) -> None:
    """Save a picture with few colours."""
    from PIL import Image

    with Image.open(picture) as image:
        image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(target, optimize=True)


if __name__ == "__main__":
    main()
