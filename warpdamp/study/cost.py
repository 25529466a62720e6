"""Cost of a particle-step on this machine, by effects: measured, stored on disk, and read by ``explain``."""

from __future__ import annotations

import json
import os
import platform
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

from ..damper.case import Request
from ..damper.preparation import prepare
from ..engine.batch import Batch, Case
from ..files import cache_folder, whole_file
from ..scene.effects import EFFECTS, Effects
from ..scene.paper import COUNT, FREQUENCY, RADIUS, STEPS_PER_CYCLE, damper
from ..scene.particles import Grains, State
from ..scene.scene import Scene
from ..sweep.cases import Cases
from ..sweep.plan import make_plan
from ..version import PHYSICS_VERSION

STILL = 1e-18
"""A step [s] so short that contacts stay as they are."""

TOGGLES: dict[str, dict] = {
    name: {other: False for other, effect in EFFECTS.items() if name in (other, *effect.needs, *effect.idle_without)}
    for name in EFFECTS
    if name != "structure"  # the beds that are timed are fixed to nothing
} | {"precision": {"precision": "float32"}}
"""Changes to the effects when one of them is off (precision: float32 instead of float64)."""

SIMPLEST = Effects(friction=False, rotation=False, dashpots=False, gravity=False, channels=False, indicators=False)
"""The simplest law in a closed cavity: frictionless, elastic, no gravity, losses in total, nothing else recorded."""


def without(effects: Effects, name: str) -> Effects:
    """Effects with one of them off."""
    return replace(effects, **TOGGLES[name])


def within(effects: Effects, name: str) -> Effects:
    """Effects with one of them on."""
    return replace(effects, **dict.fromkeys(TOGGLES[name], True))


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


def _file() -> Path:
    return cache_folder("speeds") / "speed.json"


def _machine() -> str:
    return f"{platform.node()} {platform.machine()} {os.cpu_count()} physics {PHYSICS_VERSION}"


def remember(measured: Callable, spent: dict[Effects, list[float]]) -> None:
    """Store the medians of what was ``measured``, ``frozen`` or ``moving``, for ``explain``."""
    times_by_key = _stored() | {_key(measured, effects): statistics.median(times) for effects, times in spent.items()}
    path = _file()
    record = {"machine": _machine(), "date": f"{time.strftime('%Y-%m-%d')}", "nanoseconds": times_by_key}
    with whole_file(path) as part:
        part.write_text(json.dumps(record))


def recall(measured: Callable, effects: Effects) -> float | None:
    """Time per particle-step as last ``measured`` on this machine [ns]; None if never."""
    return _stored().get(_key(measured, effects))


def _key(measured: Callable, effects: Effects) -> str:
    return " ".join([measured.__name__, *(f"{name}={value}" for name, value in asdict(effects).items())])


def _stored() -> dict[str, float]:
    try:
        stored = json.loads(_file().read_text())
    except (FileNotFoundError, json.JSONDecodeError):
        return {}
    return stored["nanoseconds"] if stored["machine"] == _machine() else {}


def measure_study(config) -> None:
    """Measure the cost of a study's cases, and of each of their effects."""
    sets = {effects for effects, _ in make_plan(Cases(config)).groups}
    remember(moving, moving(list(sets)))
    remember(frozen, frozen(list(sets | {without(effects, name) for effects in sets for name in TOGGLES})))
