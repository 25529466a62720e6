"""Cost of a particle-step on this machine, by effects: measured, stored on disk, and read by ``explain``."""

from __future__ import annotations

import time

from ..damper.case import Request
from ..damper.preparation import prepare
from ..engine.batch import Batch, Case
from ..scene.effects import Effects
from ..scene.paper import COUNT, FREQUENCY, RADIUS, STEPS_PER_CYCLE, damper
from ..scene.particles import Grains, State
from ..scene.scene import Scene
from ..sweep.cases import Cases
from ..sweep.plan import make_plan
from .speeds import TOGGLES, remember, without

STILL = 1e-18
"""A step [s] so short that contacts stay as they are."""


SIMPLEST = Effects(friction=False, rotation=False, dashpots=False, gravity=False, channels=False, indicators=False)
"""The simplest law in a closed cavity: frictionless, elastic, no gravity, losses in total, nothing else recorded."""


def jammed_bed() -> tuple[Scene, State]:
    """Bed of the paper pressed against the floor, a quarter cycle into its fifth at Gamma 1, with its scene."""
    scene = damper(gamma=1.0)
    loose = prepare(Request(scene, Grains.alike(RADIUS, COUNT), 1, "loose")).state
    batch = Batch([Case(scene, loose, 1 / FREQUENCY / STEPS_PER_CYCLE)])
    batch.advance(4 * STEPS_PER_CYCLE + 3 * STEPS_PER_CYCLE // 4)
    return scene, batch.read()[0][0]


def frozen(sets: list[Effects], *, bed=None, rounds: int = 9, steps: int = 4000) -> dict[Effects, list[float]]:
    """Processor time per particle-step [ns] on one frozen set of contacts, by effects, measured in turn."""
    scene, state = bed or jammed_bed()
    batches = [Batch([Case(scene.driven(None), state, STILL)], effects=effects) for effects in sets]
    return _alternating(sets, batches, rounds, steps)


def moving(sets: list[Effects], *, rounds: int = 9) -> dict[Effects, list[float]]:
    """Processor time per particle-step [ns] in the paper's scene at Gamma 6, by effects, a cycle a round."""
    scene = damper()
    loose = prepare(Request(scene, Grains.alike(RADIUS, COUNT), 1, "loose")).state
    case = Case(scene, loose, 1 / FREQUENCY / STEPS_PER_CYCLE)
    batches = [Batch([case], max_rows=rounds + 4, effects=effects) for effects in sets]
    for batch in batches:
        batch.advance(STEPS_PER_CYCLE)
    return _alternating(sets, batches, rounds, STEPS_PER_CYCLE)


def _alternating(sets, batches, rounds: int, steps: int) -> dict[Effects, list[float]]:
    for batch in batches:
        batch.advance(batch.steps + 2)  # compiles
    spent: dict[Effects, list[float]] = {effects: [] for effects in sets}
    for _ in range(rounds):
        for effects, batch in zip(sets, batches, strict=True):
            started = time.process_time()
            batch.advance(batch.steps + steps)
            spent[effects].append((time.process_time() - started) / steps / COUNT * 1e9)
    return spent


def measure_study(config) -> None:
    """Measure the cost of a study's cases, and of each of their effects."""
    sets = {effects for effects, _ in make_plan(Cases(config)).groups}
    remember("moving", moving(list(sets)))
    remember("frozen", frozen(list(sets | {without(effects, name) for effects in sets for name in TOGGLES})))
