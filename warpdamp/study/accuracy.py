"""Accuracy study: error and cost of each numerical choice, at one scene or a few points of a sweep.

Every variation of a choice runs from the same beds for the same number of cycles, and its per-cycle energies are kept;
errors, costs, budget and cheapest settings are all read off those series.  The reference of a point is its finest step
in float64 over all its beds and cycles, and has a standard error of its own.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.accuracy import REFERENCE
from ..config.preparation import PreparationConfig, preparation_word
from ..damper.case import Request, Spec
from ..damper.preparation import prepare
from ..engine.batch import SKIN, Batch, Case
from ..engine.ledger import maximum_energy
from ..numerics.timestep import steps_per_cycle
from ..scene.particles import State
from ..scene.scene import STANDARD_GRAVITY
from ..sweep.cases import Cases

if TYPE_CHECKING:
    import xarray as xr

    from ..config.study import Config


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
    """Variation of one numerical choice from what is usual."""

    choice: str
    value: Any

    @property
    def label(self) -> str:
        """Label of the variation, as ``steps_per_contact=16``."""
        return f"{self.choice}={self.value:g}" if isinstance(self.value, float) else f"{self.choice}={self.value}"

    @property
    def settings(self) -> dict:
        """Numerical choices of the variation, all by name."""
        return USUAL | {self.choice: self.value}

    def of(self, spec: Spec) -> Spec:
        """Case with the variation applied."""
        settings = self.settings
        numerics = replace(spec.bed.numerics, precision=settings["precision"])
        scene = spec.scene.softened(settings["stiffness"])
        steps = steps_per_cycle(scene, spec.bed.grains, steps_per_contact=settings["steps_per_contact"])
        bed = replace(spec.bed, preparation=settings["preparation"])
        return replace(spec, scene=scene, steps_per_cycle=steps, bed=replace(bed, numerics=numerics))


def variations() -> list[Variation]:
    """Variations that need runs of their own."""
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
    report : called with the part that is done, 0 to 1

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
    ways = variations()
    beds: dict[str, Request] = {}
    for spec in specs:
        for how in ("loose", "compacted"):
            bed = replace(spec.bed, preparation=how)
            beds[bed.key()] = bed
    for future in as_completed([executor.submit(prepare, bed) for bed in beds.values()]):
        future.result()

    longest = max(cycles(spec) for spec in specs)
    shape = (len(points), len(ways), len(seeds))
    values = np.full((*shape, longest), np.nan, np.float32)
    numbers = {name: np.full(shape, np.nan) for name in ("residual", "cost_per_cycle", "steps_per_cycle")}
    pending = {}
    for spec in sorted(specs, key=lambda s: -cycles(s) * s.steps_per_cycle):
        drive = spec.scene.drive
        for k, variation in enumerate(ways):
            at = (points.index((drive.frequency, drive.acceleration)), k, seeds.index(spec.bed.seed))
            pending[executor.submit(series, spec, variation, cycles(spec))] = at
    for done, future in enumerate(as_completed(pending), 1):
        result, at = future.result(), pending[future]
        values[at][: len(result["effectiveness"])] = result["effectiveness"]
        for name, array in numbers.items():
            array[at] = result[name]
        report(done / len(pending))
    dims = ("point", "variation", "seed")
    return xr.Dataset(
        {"effectiveness": ((*dims, "cycle"), values), **{name: (dims, array) for name, array in numbers.items()}},
        {
            "frequency": ("point", [f for f, _ in points]),
            "gamma": ("point", [a / STANDARD_GRAVITY for _, a in points]),
            "variation": [variation.label for variation in ways],
            "seed": seeds,
        },
    )


def points_of(config: Config, most: int = 6) -> list[Spec]:
    """Few cases that span a study: at every frequency the Gammas at a third and two thirds of its list, all seeds.

    Raises
    ------
    ConfigError
        If beds are to be carried, or brought to a state: the study prepares them in ways of its own.
    """
    if isinstance(config.preparation, PreparationConfig) or config.preparation == "carried":
        said = f"is '{preparation_word(config.preparation)}', and a study of accuracy takes loose and compacted beds"
        raise config.error("preparation", f"{said}: name one of the two")
    specs = list(Cases(config).specs())
    frequencies = sorted({spec.scene.drive.frequency for spec in specs})[: max(1, most // 2)]
    gammas = sorted({spec.scene.drive.acceleration for spec in specs})
    chosen = {gammas[len(gammas) // 3], gammas[2 * len(gammas) // 3]}
    return [s for s in specs if s.scene.drive.frequency in frequencies and s.scene.drive.acceleration in chosen]
