"""Whether the claimed intervals hold: 108 cases against what the same case does much longer; writes docs/coverage.nc.

    python scripts/documents/coverage.py

Beds of 30 to 120 spheres, three packings each, frequencies 60-380 Hz and Gamma 1.5-12 drawn at
random.  A case runs as a study with a tolerance would run it; the reference is the mean over eight times as many cycles
after those, at least 300.  About three minutes on two cores.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from shared import DOCS, processes

from warpdamp import Batch, Case, Cylinder, Drive, Grains
from warpdamp.analysis.results import write
from warpdamp.damper.case import Criteria, Request, Spec
from warpdamp.damper.preparation import prepare
from warpdamp.damper.shake import shake
from warpdamp.engine.ledger import maximum_energy
from warpdamp.numerics.steady import standard_error
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.numerics.tolerance import settings_for, student
from warpdamp.scene.paper import CAVITY, COUNT, RADIUS, damper
from warpdamp.scene.scene import STANDARD_GRAVITY

TOLERANCE = 0.05
FILLS, SEEDS, DRAWS = {30: 0.42, 60: 0.46, 90: 0.48, 120: 0.519}, (1, 2, 3), 9
"""Spheres, and the part of the cavity that they fill: near walls fewer fit."""
LONGER, FEWEST_LONGER, FEWEST, MOST = 8, 300, 30, 400


def bed(count: int, seed: int) -> Request:
    """A compacted bed."""
    size = CAVITY.diameter * (count / COUNT * FILLS[COUNT] / FILLS[count]) ** (1 / 3)
    return Request(damper(gamma=0, cavity=Cylinder(size, size)), Grains.alike(RADIUS, count), seed)


def _plan():
    return settings_for(TOLERANCE)


def drawn() -> list[Spec]:
    """The cases."""
    rng = np.random.default_rng(4)
    specs = []
    for count in FILLS:
        for seed in SEEDS:
            request = bed(count, seed)
            for _ in range(DRAWS):
                frequency, gamma = 60 * 10 ** rng.uniform(0, 0.8), rng.uniform(1.5, 12)
                scene = request.scene.driven(Drive(frequency, STANDARD_GRAVITY * gamma))
                n = steps_per_cycle(scene, request.grains, steps_per_contact=_plan().steps_per_contact)
                specs.append(Spec((len(specs),), scene, n, request))
    return specs


def compare(spec: Spec) -> dict:
    """What a case claims, and what it does afterwards."""
    chosen = _plan()
    ((_, claim),) = shake([[spec]], Criteria(chosen.standard_error, FEWEST, MOST, slack=chosen.slack))
    cycles = claim["cycles"]
    total = cycles + max(FEWEST_LONGER, LONGER * cycles)
    batch = Batch([Case(spec.scene, prepare(spec.bed).state, spec.dt)], max_rows=total + 1, effects=spec.effects)
    batch.advance(total * spec.steps_per_cycle)
    later = batch.cycles(0).per_cycle()[cycles:]
    largest = maximum_energy(spec.scene.drive, float(np.sum(spec.scene.masses(spec.bed.grains))))
    return {
        "count": len(spec.bed.grains),
        "seed": spec.bed.seed,
        "frequency": spec.scene.drive.frequency,
        "gamma": spec.scene.drive.acceleration / STANDARD_GRAVITY,
        "claimed": claim["energy_dissipated"] / largest,
        "interval": claim["energy_dissipated_interval"] / largest,
        "averaging_interval": claim["energy_dissipated_standard_error"]
        * student(claim["degrees_of_freedom"])
        / largest,
        "status": claim["status"],
        "cycles": cycles,
        "reference": float(later.mean()) / largest,
        "reference_standard_error": standard_error(later) / largest,
    }


def main() -> None:
    """Run all and keep them."""
    specs = drawn()
    with processes() as executor:
        list(executor.map(prepare, {spec.bed.key(): spec.bed for spec in specs}.values()))
        found = list(executor.map(compare, specs))
    names = list(found[0])
    cases = xr.Dataset({name: ("case", np.array([row[name] for row in found])) for name in names})
    cases.attrs["title"] = (
        f"Claimed 95 % intervals at a tolerance of {100 * TOLERANCE:g} %, and what cases do afterwards"
    )
    write(cases, DOCS / "coverage.nc")
    inside = abs(cases["claimed"] - cases["reference"]) <= cases["interval"]
    steady = cases["status"] == 0
    print(f"{int((inside & steady).sum())} of {int(steady.sum())} steady cases inside")


if __name__ == "__main__":
    main()
