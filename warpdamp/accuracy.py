"""What accuracy costs: one scene, or a few points of a sweep, along each numerical choice.

Every variation of a choice runs from the same beds for the same number of cycles, and its per-cycle energies are kept;
errors, costs, budget and cheapest settings are all read off those series.  The reference of a point is its finest step
in float64 over all its beds and cycles, and has a standard error of its own.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from .engine import SKIN, Batch, Case
from .ledger import maximum_energy
from .packing import Request, prepare
from .scene import STANDARD_GRAVITY, Material, Scene, State
from .shaking import Spec
from .steady import autocorrelation_time, standard_error
from .timestep import steps_per_cycle

if TYPE_CHECKING:
    import xarray as xr

    from .config import Config

REFERENCE = 48.0
"""Steps per contact of the reference: by second order a quarter of the error at the usual 24."""

CHOICES: dict[str, tuple[Any, ...]] = {
    "steps_per_contact": (10.0, 12.0, 16.0, 24.0, REFERENCE),
    "precision": ("float32",),
    "stiffness": (0.25, 0.05, 0.01),
    "preparation": ("loose",),
    "skin": (0.05, 0.5),
}
"""Numerical choices that take runs of their own, beside what is usual."""

USUAL = {
    "steps_per_contact": 24.0,
    "precision": "float64",
    "stiffness": 1.0,
    "preparation": "compacted",
    "skin": SKIN,
}


@dataclass(frozen=True)
class Variation:
    """One way to simulate a point: a choice, and what was chosen."""

    choice: str
    value: Any

    @property
    def label(self) -> str:
        """As ``steps_per_contact=16``."""
        return f"{self.choice}={self.value:g}" if isinstance(self.value, float) else f"{self.choice}={self.value}"

    @property
    def settings(self) -> dict:
        """All numerical choices."""
        return USUAL | {self.choice: self.value}

    def of(self, spec: Spec) -> Spec:
        """The case that it makes of a case."""
        settings = self.settings
        numerics = replace(spec.bed.numerics, precision=settings["precision"])
        scene = softened(spec.scene, settings["stiffness"])
        steps = steps_per_cycle(scene, spec.bed.grains, steps_per_contact=settings["steps_per_contact"])
        bed = replace(spec.bed, preparation=settings["preparation"])
        return replace(spec, scene=scene, steps_per_cycle=steps, bed=replace(bed, numerics=numerics))


def softened(scene: Scene, factor: float) -> Scene:
    """The same with every Young's modulus multiplied by ``factor``."""
    if factor == 1:
        return scene

    def soft(material: Material) -> Material:
        return replace(material, youngs_modulus=factor * material.youngs_modulus)

    particle = scene.particle
    softer = soft(particle) if isinstance(particle, Material) else tuple(soft(material) for material in particle)
    return replace(scene, particle=softer, wall=soft(scene.wall))


def variations() -> list[Variation]:
    """All that take runs of their own."""
    return [Variation(choice, value) for choice, values in CHOICES.items() for value in values]


def series(spec: Spec, variation: Variation, cycles: int) -> dict:
    """Run a case one way: effectiveness of every cycle, ledger residual over the last two thirds, and the cost.

    A variation starts from the bed made with the usual numerics; a softened one, from its positions alone.
    """
    varied = variation.of(spec)
    bed = prepare(replace(varied.bed, numerics=spec.bed.numerics, scene=spec.bed.scene))
    state = bed.state
    if varied.scene.particle != spec.scene.particle:
        state = State.at_rest(state.position, state.radius, state.species)
    case = Case(varied.scene, state, varied.dt)
    batch = Batch([case], max_rows=cycles + 1, effects=varied.effects, skin=variation.settings["skin"])
    batch.advance(1)  # compiles, or loads
    started = time.process_time()
    batch.advance(cycles * varied.steps_per_cycle)
    spent = time.process_time() - started
    ledger = batch.cycles(0)
    window = ledger.between(cycles // 3, cycles)
    mass = float(np.sum(spec.scene.masses(spec.bed.grains)))
    return {
        "effectiveness": ledger.per_cycle() / maximum_energy(spec.scene.drive, mass),
        "residual": float(window.residual[-1] / (window.dissipated[-1] - window.dissipated[0])),
        "cost_per_cycle": spent / cycles,
        "steps_per_cycle": varied.steps_per_cycle,
    }


def study(
    specs: Iterable[Spec],
    cycles: Callable[[Spec], int],
    executor: Executor,
    *,
    report: Callable[[float], None] = lambda done: None,
) -> xr.Dataset:
    """Run every case in every variation.

    Parameters
    ----------
    specs : cases; those of equal frequency and Gamma, of several seeds, are one point
    cycles : how many a case runs
    executor : where they run
    report : told the part that is done

    Returns
    -------
    xarray.Dataset
        ``effectiveness`` (point, variation, seed, cycle), NaN beyond a point's cycles; ``residual``, ``cost_per_cycle``
        [s] and ``steps_per_cycle`` (point, variation, seed).
    """
    import xarray as xr

    specs = list(specs)
    points = sorted({(spec.scene.drive.frequency, spec.scene.drive.acceleration) for spec in specs})
    seeds = sorted({spec.bed.seed for spec in specs})
    every = variations()
    beds: dict[str, Request] = {}
    for spec in specs:
        for how in ("loose", "compacted"):
            bed = replace(spec.bed, preparation=how)
            beds[bed.key()] = bed
    for future in as_completed([executor.submit(prepare, bed) for bed in beds.values()]):
        future.result()

    longest = max(cycles(spec) for spec in specs)
    shape = (len(points), len(every), len(seeds))
    values = np.full((*shape, longest), np.nan, np.float32)
    numbers = {name: np.full(shape, np.nan) for name in ("residual", "cost_per_cycle", "steps_per_cycle")}
    pending = {}
    for spec in sorted(specs, key=lambda s: -cycles(s) * s.steps_per_cycle):
        drive = spec.scene.drive
        for k, variation in enumerate(every):
            at = (points.index((drive.frequency, drive.acceleration)), k, seeds.index(spec.bed.seed))
            pending[executor.submit(series, spec, variation, cycles(spec))] = at
    for done, future in enumerate(as_completed(pending), 1):
        found, at = future.result(), pending[future]
        values[at][: len(found["effectiveness"])] = found["effectiveness"]
        for name, array in numbers.items():
            array[at] = found[name]
        report(done / len(pending))
    dims = ("point", "variation", "seed")
    return xr.Dataset(
        {"effectiveness": ((*dims, "cycle"), values), **{name: (dims, array) for name, array in numbers.items()}},
        {
            "frequency": ("point", [f for f, _ in points]),
            "gamma": ("point", [a / STANDARD_GRAVITY for _, a in points]),
            "variation": [variation.label for variation in every],
            "seed": seeds,
        },
    )


def _kept(row) -> np.ndarray:
    """The last two thirds of a series: the first third is the transient."""
    x = np.asarray(row, float)
    x = x[np.isfinite(x)]
    return x[len(x) // 3 :]


def systematic(runs: xr.Dataset) -> xr.Dataset:
    """Relative error of each variation against the reference, bed by bed, with its standard error, and its cost.

    The difference of a bed from its own reference is free of the beds' spread; what is left is the chance of two
    finite series, from their standard errors.

    Returns
    -------
    xarray.Dataset
        ``error``, ``error_standard_error`` [-], ``cost`` [core-s per cycle] (point, variation).
    """
    import xarray as xr

    reference = Variation("steps_per_contact", REFERENCE).label
    shape = (runs.sizes["point"], runs.sizes["variation"])
    error, chance = np.empty(shape), np.empty(shape)
    for p in range(shape[0]):
        own = runs["effectiveness"].isel(point=p).sel(variation=reference).values
        truth = np.mean([_kept(row).mean() for row in own])
        for v in range(shape[1]):
            rows = runs["effectiveness"].isel(point=p, variation=v).values
            pairs = [(_kept(a), _kept(b)) for a, b in zip(rows, own, strict=True)]
            differences = np.array([a.mean() - b.mean() for a, b in pairs])
            within = math.sqrt(sum(standard_error(a) ** 2 + standard_error(b) ** 2 for a, b in pairs)) / len(pairs)
            between = differences.std(ddof=1) / math.sqrt(len(pairs)) if len(pairs) > 1 else 0.0
            error[p, v] = differences.mean() / truth
            chance[p, v] = max(within, between) / truth
    dims = ("point", "variation")
    return xr.Dataset(
        {
            "error": (dims, error),
            "error_standard_error": (dims, chance),
            "cost": (dims, runs["cost_per_cycle"].mean("seed").values),
        },
        {name: runs[name] for name in ("frequency", "gamma", "variation")},
    )


def step_errors(errors: xr.Dataset) -> dict[float, tuple[float, float]]:
    """Of one point: steps per contact -> (relative error by the fitted law, core-seconds per cycle).

    Leapfrog is of second order, so a single strength c is fitted to |error| = c / N^2 - c / N_ref^2, by weights of the
    standard errors; where chance hides it, its one-sigma upper bound is taken.
    """
    names = [v for v in errors["variation"].values if v.startswith("steps_per_contact")]
    steps = np.array([float(name.split("=")[1]) for name in names])
    error = errors["error"].sel(variation=names).values
    weight = 1 / np.maximum(errors["error_standard_error"].sel(variation=names).values, 1e-6) ** 2
    law = 1 / steps**2 - 1 / REFERENCE**2
    information = np.sum(weight * law**2)
    strength = np.sum(weight * law * error) / information
    bound = abs(strength) + 1 / math.sqrt(information)
    costs = errors["cost"].sel(variation=names).values
    return {float(n): (bound / n**2, float(cost)) for n, cost in zip(steps, costs, strict=True)}


@dataclass(frozen=True)
class Chance:
    """What averaging leaves of the error at a point, all relative to the mean.

    Parameters
    ----------
    one_cycle : standard error of one uncorrelated cycle, so that n cycles leave one_cycle / sqrt(n)
    packing : standard deviation between beds
    """

    one_cycle: float
    packing: float


def chance(rows) -> Chance:
    """From the series of one point's beds, (seeds, cycles)."""
    kept = [_kept(row) for row in rows]
    means = np.array([x.mean() for x in kept])
    mean = means.mean()
    variance = np.mean([np.var(x) * autocorrelation_time(x) for x in kept])
    own = np.mean([standard_error(x) ** 2 for x in kept])
    spread = max(0.0, means.var(ddof=1) - own) if len(means) > 1 else 0.0
    return Chance(math.sqrt(variance) / mean, math.sqrt(spread) / mean)


def transient(rows, discarded: int) -> float:
    """Relative error of averaging half a run after so many cycles, root mean square over the beds."""
    misses = []
    for row in rows:
        x = np.asarray(row, float)
        x = x[np.isfinite(x)]
        misses.append(x[discarded : discarded + len(x) // 2].mean() / _kept(row).mean() - 1)
    return float(np.sqrt(np.mean(np.square(misses))))


def averaged(rows, lengths) -> list[tuple[float, float]]:
    """Observed error of averaging n cycles, root mean square over all windows of that length: (n, relative error)."""
    out = []
    for n in lengths:
        misses = []
        for row in rows:
            x = _kept(row)
            windows = len(x) // n
            if windows >= 3:
                means = x[: windows * n].reshape(windows, n).mean(axis=1)
                misses += list((means - means.mean()) ** 2 * windows / (windows - 1))
        if misses:
            mean = np.mean([_kept(row).mean() for row in rows])
            out.append((n, math.sqrt(np.mean(misses)) / mean))
    return out


def cheapest(step_errors: dict[float, tuple[float, float]], point: Chance, tolerance: float, *, bed: float = 0.0):
    """Settings of least cost with which the standard error of all parts together stays within a tolerance.

    Parameters
    ----------
    step_errors : steps per contact -> (relative error, core-seconds per cycle)
    point : Chance
    tolerance : relative
    bed : core-seconds to make a bed

    Returns
    -------
    (steps per contact, packings, cycles each, core-seconds) or None
    """
    best = None
    for steps, (error, cost) in step_errors.items():
        for packings in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32):
            left = tolerance**2 - error**2 - point.packing**2 / packings
            if left <= 0:
                continue
            cycles = max(12, math.ceil(point.one_cycle**2 / (packings * left)))
            total = packings * (bed + 1.5 * cycles * cost)  # a third of a run is its transient
            if best is None or total < best[3]:
                best = (steps, packings, cycles, total)
    return best


def points_of(config: Config, most: int = 6) -> list[Spec]:
    """A few cases that span a study: of every frequency the Gammas at a third and two thirds of its list, all seeds."""
    from .cases import Cases

    specs = list(Cases(config).specs())
    frequencies = sorted({spec.scene.drive.frequency for spec in specs})[: max(1, most // 2)]
    gammas = sorted({spec.scene.drive.acceleration for spec in specs})
    chosen = {gammas[len(gammas) // 3], gammas[2 * len(gammas) // 3]}
    return [s for s in specs if s.scene.drive.frequency in frequencies and s.scene.drive.acceleration in chosen]
