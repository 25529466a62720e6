"""What accuracy costs, for the paper's scene at six points; writes docs/accuracy.md from docs/accuracy.nc.

python scripts/accuracy.py            # the document, from the committed series
python scripts/accuracy.py simulate   # the series anew: half an hour on two cores
"""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from warpdamp import load
from warpdamp.accuracy import points_of, study
from warpdamp.results import write

ROOT = Path(__file__).parents[1]
SERIES = ROOT / "docs" / "accuracy.nc"
SEEDS = [1, 2, 3, 4]


def cycles(spec) -> int:
    """More where a cycle is cheap."""
    frequency = spec.scene.drive.frequency
    return 160 if frequency < 100 else 400 if frequency < 500 else 600


def simulate() -> None:
    """Run every variation and keep the series."""
    config = load(ROOT / "configs" / "beam.yaml").model_copy(update={"seeds": SEEDS})
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as executor:
        runs = study(points_of(config), cycles, executor, report=lambda done: print(f"{100 * done:.0f} %", flush=True))
    runs = runs.assign_attrs(title="Energies of cycles of the paper's damper, by numerical choice")
    write(runs, SERIES)


if __name__ == "__main__":
    simulate()
