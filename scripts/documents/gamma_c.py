"""Gamma of two-sided collision against the frequency, from eight packings, and the motion there; writes docs/gamma_c.*.

    python scripts/documents/gamma_c.py                        # the document, from docs/gamma_c.nc
    python scripts/documents/gamma_c.py simulate [--workers N] # the runs anew: about twenty minutes on one core

The paper's damper, compacted, at each of ten frequencies, and at amplitudes round that at which a plastic block
collides with floor and lid best.  The motion of four packings near an optimum is recorded: where the bed is, how thick,
and when floor and lid push.  May be stopped and started again: results/gamma_c keeps what is done.
"""

from __future__ import annotations

import argparse

import numpy as np
import xarray as xr
from shared import DOCS, ROOT, progress

from warpdamp import Batch, Case, Drive, Grains, Request, load, prepare, run
from warpdamp.analysis.optimum import collision_optimum
from warpdamp.analysis.results import write
from warpdamp.config.study import Config
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene.paper import COUNT, RADIUS, damper
from warpdamp.scene.scene import STANDARD_GRAVITY

RUNS, MOTION = DOCS / "gamma_c.nc", DOCS / "gamma_c_motion.nc"
FREQUENCIES = (28, 32, 36, 40, 44, 48, 52, 56, 60, 64)
"""[Hz]; below, the optima of fluidisation and collision are one."""

RATIOS = np.arange(6, 15) / 10
"""Gamma over that of the plastic block."""

SEEDS, CYCLES, STEPS = list(range(1, 9)), 48, 12
BLOCK_CLEARANCE = 2.2e-3
"""Eq. 2's clearance [m], round whose optimum amplitudes are taken."""

KEPT = (
    "effectiveness", "effectiveness_standard_error", "clearance", "clearance_after", "status", "cycles",
    "floor_impulse", "lid_impulse", "ledger_residual", "cpu_time",
)  # fmt: skip

MOTION_SEEDS, MOTION_FREQUENCY, MOTION_GAMMA = (1, 2, 3, 4), 40.0, 6.0
MOTION_CYCLES, RECORDED, SAMPLES = 40, 20, 48
"""Cycles, those at the end that are recorded, and records of a cycle."""


def job(frequency: float) -> Config:
    """One frequency."""
    values = load(ROOT / "configs" / "frequency_map.yaml").model_dump()
    block = float(collision_optimum(frequency, BLOCK_CLEARANCE))
    values["excitation"] |= {"frequency": [frequency], "gamma": [round(float(r * block), 3) for r in RATIOS]}
    changes = {
        "steady_state": {"fewest_cycles": CYCLES, "most_cycles": CYCLES},
        "numerics": {"steps_per_contact": STEPS},
        "seeds": SEEDS,
    }
    return Config.model_validate(values | changes)


def simulate(workers: int | None) -> None:
    """All frequencies, from the same beds."""
    parts = []
    for frequency in FREQUENCIES:
        store = ROOT / "results" / "gamma_c" / f"{frequency:g}"
        results = run(job(frequency), store=store, workers=workers, report=progress(f"{frequency:g} Hz"))
        part = results[list(KEPT)].rename(gamma="ratio").reset_coords("ratio")
        parts.append(part.rename(ratio="gamma").assign_coords(ratio=RATIOS))
        together = xr.concat(parts, "frequency", combine_attrs="override")
        together.attrs = {"title": "The paper's damper round the optimum of two-sided collision, eight packings"}
        write(together, RUNS)
        print(f"{frequency:g} Hz done", flush=True)
    if not MOTION.exists():
        write(xr.concat([motion(seed) for seed in MOTION_SEEDS], "seed", combine_attrs="override"), MOTION)


def motion(seed: int) -> xr.Dataset:
    """One packing near the optimum of mode 1's frequency, at parts of its cycles, seen from the enclosure."""
    rest = damper(gamma=0)
    bed = prepare(Request(rest, Grains.alike(RADIUS, COUNT), seed))
    scene = rest.driven(Drive(MOTION_FREQUENCY, MOTION_GAMMA * STANDARD_GRAVITY))
    n = steps_per_cycle(scene, bed.state, steps_per_contact=STEPS)
    batch = Batch([Case(scene, bed.state, 1 / (MOTION_FREQUENCY * n))], max_rows=MOTION_CYCLES + 1)
    first = (MOTION_CYCLES - RECORDED) * SAMPLES
    rows = []
    for sample in range(first, MOTION_CYCLES * SAMPLES + 1):
        batch.advance(round(sample * n / SAMPLES))
        ((state, ledger),) = batch.read()
        rows.append(_at(state, ledger))
    columns = {name: ("time", np.array([row[name] for row in rows])) for name in rows[0]}
    time = np.arange(first, MOTION_CYCLES * SAMPLES + 1) / SAMPLES
    attributes = {"frequency": MOTION_FREQUENCY, "gamma": MOTION_GAMMA, "samples": SAMPLES}
    result = xr.Dataset(columns, {"time": time}, attributes).assign(clearance=bed.clearance, at_rest=_thick(bed.state))
    return result.expand_dims(seed=[seed])


def _at(state, ledger) -> dict[str, float]:
    """Mean height, how thick the bed is, and running totals of what floor and lid gave and of the dissipation."""
    totals = {name: float(ledger[name][-1]) for name in ("floor_impulse", "lid_impulse")}
    return {"height": float(state.position[:, 2].mean()), "thickness": _thick(state), **totals}


def _thick(state) -> float:
    """Distance of the upper and the lower quarter's mean heights, over their share of a uniform bed's [m]."""
    heights = np.sort(state.position[:, 2])
    quarter = len(heights) // 4
    return float(heights[-quarter:].mean() - heights[:quarter].mean()) / 0.75 + 2 * RADIUS


def main() -> None:
    """Simulate if asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("simulate", nargs="?", choices=["simulate"])
    parser.add_argument("--workers", type=int)
    options = parser.parse_args()
    if options.simulate:
        simulate(options.workers)


if __name__ == "__main__":
    main()
