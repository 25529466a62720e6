"""How beds are compacted, what they reach, and whether shaking with friction leaves them there; writes docs/beds.nc.

    python scripts/documents/beds.py            # what was measured, as tables
    python scripts/documents/beds.py simulate   # what is not in docs/beds.nc yet: about ten minutes on one core

Sixteen packings of the paper's damper, of which four are shaken on for 300 cycles at 46 Hz and Gamma 6 (with half the
usual steps to a contact), and two of each other cavity.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import xarray as xr
from shared import DOCS

from warpdamp import Batch, Case, Cylinder, Scene, State
from warpdamp.analysis.results import write
from warpdamp.damper.case import MOST_BLOCKS
from warpdamp.damper.compaction import compact, measured_clearance
from warpdamp.damper.placement import fill, separate
from warpdamp.damper.settling import settle
from warpdamp.numerics.timestep import Numerics, steps_per_cycle
from warpdamp.scene.paper import COUNT, FREQUENCY, RADIUS, damper

RUNS = DOCS / "beds.nc"
STAGES = (0, 100, 200, 300)
"""Cycles of shaking with friction after which the clearance is measured."""

USUAL, HALF = Numerics(), Numerics(steps_per_contact=12.0)


@dataclass(frozen=True)
class Bed:
    """A cavity and what is in it."""

    name: str
    diameter: float
    height: float
    radius: tuple[float, ...]
    packings: int = 2
    lid: bool = True
    shaken_on: int = 0

    @property
    def scene(self) -> Scene:
        """The paper's materials, in this cavity."""
        return damper(cavity=Cylinder(self.diameter, self.height, lid=self.lid))

    @property
    def label(self) -> str:
        """Name, spheres across and fill."""
        across = self.diameter / (2 * np.mean(self.radius))
        return f"{self.name}, D/d {across:.1f}, fill {fill(self.radius, self.scene.enclosure):.3f}"


def alike(diameter: float, height: float, radius: float, part: float) -> tuple[float, ...]:
    """Equal spheres that fill ``part`` of a cavity."""
    return (radius,) * round(part * 0.75 * diameter**2 * height / (4 * radius**3))


MIXTURE = tuple(np.linspace(2.5e-3, 5e-3, 120))
BEDS = [
    Bed("paper", 0.04, 0.04, (RADIUS,) * COUNT, packings=16, shaken_on=4),
    Bed("narrow", 0.036, 0.05, alike(0.036, 0.05, 5e-3, 0.42)),
    Bed("wide", 0.048, 0.02, alike(0.048, 0.02, 3e-3, 0.5)),
    Bed("sizes", 0.042, 0.04, MIXTURE),
    Bed("open", 0.04, 0.04, alike(0.04, 0.04, RADIUS, 0.5), lid=False),
]


def compacted(bed: Bed, seed: int) -> xr.Dataset:
    """One packing: clearance after every block, at the end, and while it is shaken on with friction."""
    scene, started = bed.scene, time.process_time()
    state = State.at_rest(separate(bed.radius, scene.enclosure, seed), bed.radius)
    state, clearances, settled = compact(scene, state, USUAL)
    state = settle(scene, state)
    reached = [measured_clearance(scene, state)]
    spent = time.process_time() - started
    loose = settle(scene, State.at_rest(separate(bed.radius, scene.enclosure, seed), bed.radius))
    if seed <= bed.shaken_on:
        for before, after in pairwise(STAGES):
            state = shaken(scene, state, after - before)
            reached.append(measured_clearance(scene, settle(scene, state)))
    return xr.Dataset(
        {
            "series": ("block", _padded(clearances, MOST_BLOCKS)),
            "clearance": ("stage", _padded(reached, len(STAGES))),
            "loose": measured_clearance(scene, loose),
            "blocks": float(len(clearances)),
            "settled": float(settled),
            "cpu_time": spent,
        },
        {"stage": list(STAGES)},
    )


def shaken(scene: Scene, state: State, cycles: int) -> State:
    """A bed after some cycles of the paper's shaking, with friction."""
    n = steps_per_cycle(scene, state, steps_per_contact=HALF.steps_per_contact)
    batch = Batch([Case(scene, state, 1 / FREQUENCY / n)], max_rows=cycles + 1)
    batch.advance(cycles * n)
    return batch.read()[0][0]


def _padded(values, length: int) -> np.ndarray:
    return np.pad(np.array(values, float), (0, length - len(values)), constant_values=np.nan)


def simulate() -> None:
    """Every packing that is not there yet."""
    for bed in BEDS:
        for seed in range(bed.packings, 0, -1):  # those that are shaken on, the dearest, last
            kept = stored()
            if bed.label in kept and seed in kept[bed.label].seed:
                continue
            packing = compacted(bed, seed).expand_dims(seed=[seed])
            others = [kept[bed.label]] if bed.label in kept else []
            kept[bed.label] = xr.concat([*others, packing], "seed")
            packings = [part.expand_dims(bed=[label]) for label, part in kept.items()]
            write(xr.concat(packings, "bed", join="outer"), RUNS)
            print(row(bed.label, packing.isel(seed=0)), flush=True)


def stored() -> dict[str, xr.Dataset]:
    """What was measured, by bed."""
    if not RUNS.exists():
        return {}
    with xr.open_dataset(RUNS) as runs:
        runs.load()
    return {str(label): runs.sel(bed=label, drop=True).dropna("seed", subset=["cpu_time"]) for label in runs.bed.values}


def row(label: str, packing: xr.Dataset) -> str:
    """One packing in a line, clearances in mm."""
    series = " ".join(f"{1e3 * h:.2f}" for h in packing["series"].values if np.isfinite(h))
    stages = " ".join(f"{1e3 * h:.2f}" for h in packing["clearance"].values if np.isfinite(h))
    return (
        f"{label}, seed {int(packing.seed)}: loose {1e3 * float(packing['loose']):.2f}, blocks {series}; reached "
        f"{stages} in {float(packing['cpu_time']):.1f} s" + ("" if packing["settled"] else ", still compacting")
    )


def tables() -> None:
    """All packings, and the mean and spread of each bed."""
    for label, packings in stored().items():
        for seed in packings.seed:
            print(row(label, packings.sel(seed=seed)))
        first = 1e3 * packings["clearance"].sel(stage=0)
        print(
            f"{label}: {float(first.mean()):.2f} mm, standard deviation {float(first.std(ddof=1)):.2f} mm between "
            f"{len(first)} packings; {float(packings['cpu_time'].mean()):.1f} core-seconds a bed\n"
        )


if __name__ == "__main__":
    if "simulate" in sys.argv[1:]:
        simulate()
    tables()
