"""Measured speeds of this machine, by what was measured and by effects: kept on disk, and read by ``explain``."""

from __future__ import annotations

import json
import os
import platform
import statistics
import time
from dataclasses import asdict, replace
from pathlib import Path

from ..files import cache_folder, cache_path, whole_file
from ..scene.effects import EFFECTS, Effects
from ..version import PHYSICS_VERSION

TOGGLES: dict[str, dict] = {
    name: {other: False for other, effect in EFFECTS.items() if name in (other, *effect.needs, *effect.idle_without)}
    for name in EFFECTS
    if name != "structure"  # the beds that are timed are fixed to nothing
} | {"precision": {"precision": "float32"}}
"""Changes to the effects when one of them is off (precision: float32 instead of float64)."""


def without(effects: Effects, name: str) -> Effects:
    """Effects with one of them off."""
    return replace(effects, **TOGGLES[name])


def within(effects: Effects, name: str) -> Effects:
    """Effects with one of them on."""
    return replace(effects, **dict.fromkeys(TOGGLES[name], True))


def _file() -> Path:
    return cache_path("speeds") / "speed.json"


def _machine() -> str:
    return f"{platform.node()} {platform.machine()} {os.cpu_count()} physics {PHYSICS_VERSION}"


def remember(measured: str, spent: dict[Effects, list[float]]) -> None:
    """Store the medians of what was ``measured``, ``frozen`` or ``moving``, for ``explain``."""
    times_by_key = _stored() | {_key(measured, effects): statistics.median(times) for effects, times in spent.items()}
    record = {"machine": _machine(), "date": f"{time.strftime('%Y-%m-%d')}", "nanoseconds": times_by_key}
    cache_folder("speeds")
    with whole_file(_file()) as part:
        part.write_text(json.dumps(record))


def recall(measured: str, effects: Effects) -> float | None:
    """Time per particle-step as last ``measured`` on this machine [ns]; None if never."""
    return _stored().get(_key(measured, effects))


def _key(measured: str, effects: Effects) -> str:
    return " ".join([measured, *(f"{name}={value}" for name, value in asdict(effects).items())])


def _stored() -> dict[str, float]:
    try:
        stored = json.loads(_file().read_text())
    except (FileNotFoundError, NotADirectoryError, json.JSONDecodeError):
        return {}
    return stored["nanoseconds"] if stored["machine"] == _machine() else {}
