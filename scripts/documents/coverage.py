"""Whether the claimed intervals hold, and what a single bed errs by beyond its averages; writes docs/coverage.nc.

    python scripts/documents/coverage.py [measured] [tested] [--workers N]

Beds of 30 to 120 equal spheres and of 60 of many sizes, three packings each, frequencies 60-380 Hz and Gamma 1.5-12
drawn at random.  A case runs as a study with a tolerance would run it; the reference is the mean over five times as
many cycles after those.  One draw, ``measured``, says what ``memory_error`` has to be; another,
``tested``, of other points and other packings, whether the intervals then hold.  Nine minutes on one core; may be
stopped and started again: results/coverage keeps what is done.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr
from shared import DOCS, ROOT, processes

from warpdamp import Batch, Case, Cylinder, Drive, Grains
from warpdamp.analysis.results import write
from warpdamp.damper.case import Criteria, Request, Spec
from warpdamp.damper.placement import fill
from warpdamp.damper.preparation import prepare
from warpdamp.damper.shake import shake
from warpdamp.engine.ledger import maximum_energy
from warpdamp.files import whole_file
from warpdamp.numerics.steady import standard_error
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.numerics.tolerance import bed_memory, settings_for, student
from warpdamp.scene.paper import RADIUS, damper
from warpdamp.scene.scene import STANDARD_GRAVITY
from warpdamp.scene.sphere import sphere_volume

TOLERANCE = 0.05
LONGER, FEWEST, MOST = 5, 30, 400
KEPT = ROOT / "results" / "coverage"


@dataclass(frozen=True)
class Draw:
    """Points drawn at random for every bed, more of them for mixtures, and the packings that each is run with."""

    name: str
    source: int
    points: int
    of_mixtures: int
    seeds: tuple[int, ...]


DRAWS = (Draw("measured", 15, 12, 36, (11, 12, 13)), Draw("tested", 16, 20, 20, (1, 3, 4)))

MIXTURE = "60 of many sizes"
BEDS = {
    "30 spheres": ((RADIUS,) * 30, 0.42),
    "60 spheres": ((RADIUS,) * 60, 0.46),
    "90 spheres": ((RADIUS,) * 90, 0.48),
    "120 spheres": ((RADIUS,) * 120, 0.519),
    MIXTURE: (tuple(np.linspace(2.5e-3, 5e-3, 60).tolist()), 0.51),
}
"""Radii, and the part of the cavity that they fill: near walls fewer fit."""


def bed(name: str, seed: int) -> Request:
    """A compacted bed in a cavity as high as wide."""
    radius, part = BEDS[name]
    size = (float(np.sum(sphere_volume(np.array(radius)))) / (part * np.pi / 4)) ** (1 / 3)
    return Request(damper(gamma=0, cavity=Cylinder(size, size)), Grains(radius, (0,) * len(radius)), seed)


def drawn(draw: Draw) -> list[tuple[str, int, Spec]]:
    """The cases of a draw: the bed's name, the number of the point, what is run."""
    rng, chosen = np.random.default_rng(draw.source), settings_for(TOLERANCE)
    cases = []
    for name in BEDS:
        for point in range(draw.of_mixtures if name == MIXTURE else draw.points):
            frequency, gamma = 60 * 10 ** rng.uniform(0, 0.8), rng.uniform(1.5, 12)
            for seed in draw.seeds:
                request = bed(name, seed)
                scene = request.scene.driven(Drive(frequency, STANDARD_GRAVITY * gamma))
                n = steps_per_cycle(scene, request.grains, steps_per_contact=chosen.steps_per_contact)
                cases.append((name, point, Spec((len(cases),), scene, n, request)))
    return cases


def compare(draw: str, name: str, point: int, spec: Spec) -> None:
    """Keep what a case claims, and what it does afterwards."""
    path = KEPT / draw / f"{spec.index[0]}.json"
    if path.exists():
        return
    chosen = settings_for(TOLERANCE)
    ((_, claim),) = shake([[spec]], Criteria(chosen.standard_error, FEWEST, MOST, slack=chosen.slack))
    cycles = claim["cycles"]
    total = (1 + LONGER) * cycles
    batch = Batch([Case(spec.scene, prepare(spec.bed).state, spec.dt)], max_rows=total + 1, effects=spec.effects)
    batch.advance(total * spec.steps_per_cycle)
    later = batch.cycles(0).per_cycle()[cycles:]
    largest = maximum_energy(spec.scene.drive, float(np.sum(spec.scene.masses(spec.bed.grains))))
    cavity, radius = spec.bed.scene.enclosure, spec.bed.grains.radius
    values = {
        "draw": draw,
        "bed": name,
        "point": point,
        "seed": spec.bed.seed,
        "fill": fill(radius, cavity),
        "across": cavity.diameter / (2 * float(np.mean(radius))),
        "frequency": spec.scene.drive.frequency,
        "gamma": spec.scene.drive.acceleration / STANDARD_GRAVITY,
        "clearance": claim["clearance"],
        "claimed": claim["energy_dissipated"] / largest,
        "standard_error": claim["energy_dissipated_standard_error"] / largest,
        "degrees_of_freedom": claim["degrees_of_freedom"],
        "status": claim["status"],
        "cycles": cycles,
        "reference": float(later.mean()) / largest,
        "reference_standard_error": standard_error(later) / largest,
    }
    with whole_file(path) as part:
        part.write_text(json.dumps({key: getattr(value, "item", lambda v=value: v)() for key, value in values.items()}))


def collected() -> xr.Dataset:
    """All cases that are done, with the intervals that are claimed now."""
    rows = [json.loads(path.read_text()) for draw in DRAWS for path in sorted((KEPT / draw.name).glob("*.json"))]
    cases = xr.Dataset({name: ("case", np.array([row[name] for row in rows])) for name in rows[0]})
    cases.attrs["title"] = (
        f"Claimed 95 % intervals at a tolerance of {100 * TOLERANCE:g} %, and what cases do afterwards"
    )
    return with_intervals(cases)


def with_intervals(cases: xr.Dataset, memory_of=bed_memory) -> xr.Dataset:
    """The cases with the half-widths of their intervals, of the average alone and with the bed's memory by its fill."""
    averaging = cases["standard_error"] * student(cases["degrees_of_freedom"])
    memory = np.array([memory_of(part) for part in cases["fill"].values]) * cases["claimed"]
    interval = np.hypot(averaging, memory * student(np.inf))
    return cases.assign(averaging_interval=averaging, interval=interval)


def memory(cases: xr.Dataset) -> tuple[float, float]:
    """What single beds err by beyond the averages of claim and reference: root mean square, and its standard error."""
    off = (cases["claimed"] / cases["reference"] - 1).values
    known = (cases["standard_error"] / cases["claimed"]) ** 2
    known += (cases["reference_standard_error"] / cases["reference"]) ** 2
    squares = off**2 - known.values
    value = float(np.sqrt(max(squares.mean(), 0.0)))
    return value, float(squares.std(ddof=1) / np.sqrt(len(squares))) / (2 * max(value, 1e-3))


def holding(cases: xr.Dataset, part: float = 0.95) -> float:
    """Smallest ``memory_error``, relative, with which this part of the cases lies within their intervals."""
    off = abs(cases["claimed"] - cases["reference"])
    missing = np.sqrt(np.maximum(off**2 - cases["averaging_interval"] ** 2, 0)) / cases["claimed"]
    return float(np.quantile(missing / student(np.inf), part))


def by_rule(cases: xr.Dataset) -> float:
    """``memory_error`` of cases by its rule: the larger of ``memory`` and ``holding``, up to the next half percent."""
    return math.ceil(200 * max(memory(cases)[0], holding(cases))) / 200


def main() -> None:
    """Run what is not there yet and keep it all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("draws", nargs="*", metavar="draw")
    parser.add_argument("--workers", type=int)
    options = parser.parse_args()
    if unknown := set(options.draws) - {draw.name for draw in DRAWS}:
        parser.error(f"there is no draw {', '.join(sorted(unknown))}: measured, tested")
    for draw in DRAWS:
        if draw.name not in options.draws:
            continue
        (KEPT / draw.name).mkdir(parents=True, exist_ok=True)
        cases = sorted(drawn(draw), key=lambda case: case[1])  # what is done is a fair part of it at any time
        with processes(options.workers) as executor:
            list(executor.map(prepare, {spec.bed.key(): spec.bed for *_, spec in cases}.values()))
            list(executor.map(partial(compare, draw.name), *zip(*cases, strict=True)))
    cases = collected()
    write(cases, DOCS / "coverage.nc")
    inside = abs(cases["claimed"] - cases["reference"]) <= cases["interval"]
    for draw in DRAWS:
        of = (cases["draw"] == draw.name) & (cases["status"] == 0)
        print(f"{draw.name}: {int((inside & of).sum())} of {int(of.sum())} steady cases inside")


if __name__ == "__main__":
    main()
