"""Emulator of a search: effectiveness over mode, Gamma and design, in the numbers that it depends on.

Inputs are logarithms: of the frequency, of Gamma, of the Gamma of the collision optimum over Gamma (eqs 1 and 2), of
the bed's depth and the cavity's diameter over the particles', and of every variable that none of these holds; a choice
of words, as of a material, is a few numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from ..numerics.process import Process, fit
from ..scene.scene import STANDARD_GRAVITY
from .cases import Row
from .problem import Design, Problem

GEOMETRY = {("damper", "enclosure", "diameter"), ("damper", "enclosure", "height"), ("damper", "particles", "count")}
SMALLEST_CLEARANCE = 0.02
"""Clearance over a particle's diameter that is taken where eq. 2 gives less, or none."""
NO_EFFECT = 1e-9


@dataclass(frozen=True)
class Emulation:
    """Emulator of a search.

    Parameters
    ----------
    problem : Problem
    process : over the inputs of ``inputs``, less those that never changed
    kept : columns of the inputs that changed
    packing : packing fraction that eq. 2 is taken with
    """

    problem: Problem
    process: Process
    kept: np.ndarray
    packing: float

    def log_effectiveness(self, designs: list[Design], frequency, gamma) -> tuple[np.ndarray, np.ndarray]:
        """Means (k, n) and covariances (k, n, n) of the logarithm at frequencies and Gammas (k, n) of k designs."""
        points = [inputs(*drives, self.packing)[:, self.kept] for drives in zip(designs, frequency, gamma, strict=True)]
        with threadpool_limits(1):
            return self.process.joints(np.array(points))


def inputs(design: Design, frequency, gamma, packing: float) -> np.ndarray:
    """Inputs of the emulator at frequencies and Gammas (n,) of a design, (n, inputs)."""
    frequency, gamma = np.atleast_1d(frequency), np.atleast_1d(gamma)
    diameter = 2 * design.radius
    clearance = max(design.clearance(packing), SMALLEST_CLEARANCE * diameter)
    depth = max(design.cavity.height - clearance, diameter)
    optimum = 4 * math.pi * frequency**2 * clearance / STANDARD_GRAVITY
    rest = [_number(value) for path, value in design.values.items() if path not in GEOMETRY and path[0] != "structure"]
    same = [depth / diameter, design.cavity.diameter / diameter]
    fixed = [*np.log(same), *(number for numbers in rest for number in numbers)]
    moving = np.log([frequency, gamma, optimum / gamma]).T
    return np.hstack([moving, np.tile(fixed, (len(gamma), 1))])


def _number(value) -> list[float]:
    if isinstance(value, str):
        return _of_word(value)
    return [math.log(value)] if value > 0 else [float(value)]


def _of_word(word: str) -> list[float]:
    """Four numbers that differ from word to word: choices are equally far apart, about."""
    import hashlib

    digest = hashlib.sha256(word.encode()).digest()
    return [(digest[k] - 127.5) / 127.5 for k in range(4)]


def emulate(problem: Problem, rows: list[Row]) -> Emulation:
    """Emulator through finished cases; those of one bed do not err independently.

    Raises
    ------
    ValueError
        If there are too few.
    """
    known = [row for row in rows if row.known]
    packings = [row.packing for row in known if np.isfinite(row.packing)]
    packing = float(np.median(packings)) if packings else known[0].order.design.packing if known else 0.0
    points = np.array([inputs(row.order.design, row.frequency, row.order.gamma, packing)[0] for row in known])
    if not len(points):
        raise ValueError("no case ended with a result")
    kept = np.flatnonzero(np.ptp(points, axis=0) > NO_EFFECT)
    beds: dict[tuple, int] = {}
    groups = [beds.setdefault((row.order.design.key, row.order.seed), len(beds)) for row in known]
    values = np.log([row.effectiveness for row in known])
    return Emulation(problem, fit(points[:, kept], values, [row.error for row in known], groups), kept, packing)
