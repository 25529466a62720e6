"""What an emulator says of a design: the least damping over the range, and the probability that the target is met."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..modal.damping import damping_of_effectiveness
from ..scene.scene import STANDARD_GRAVITY
from .bounds import largest_damping
from .emulation import Emulation
from .problem import Design, Problem

GRID = 9
"""Gammas over the range, in equal ratios, at which the damping of each mode must hold."""
DRAWS = 256


@dataclass(frozen=True)
class Drives:
    """Modes and Gammas at which a design must hold, flat over both.

    Parameters
    ----------
    mode : (n,) rows of the modes
    frequency, amplitude, inherent : (n,) of the mode [Hz, kg^-0.5, -]
    gamma : (n,)
    force : (m, 2) range of the force at the damper in each mode [N], or None
    """

    mode: np.ndarray
    frequency: np.ndarray
    amplitude: np.ndarray
    inherent: np.ndarray
    gamma: np.ndarray
    force: np.ndarray | None = None

    def damping(self, effectiveness, mass: float):
        """Damping ratio of effectiveness (..., n)."""
        return damping_of_effectiveness(effectiveness, mass, self.amplitude) + self.inherent

    def counts(self, damping) -> np.ndarray:
        """Whether each Gamma is in the range, (..., n), of forces that make it so with a damping (..., n)."""
        if self.force is None:
            return np.ones(np.shape(damping), bool)
        force = 2 * damping * self.gamma * STANDARD_GRAVITY / self.amplitude**2
        low, high = self.force[self.mode].T
        return (force >= low) & (force <= high)


@dataclass(frozen=True)
class Assessment:
    """A design as the emulator sees it.

    Parameters
    ----------
    design : Design
    probability : that the target is met at every Gamma of every mode, mean over packings; 1 where there is no target
    least : least damping over the range, mean of the emulator's draws
    interval : its 95 % interval
    merit : (draws,) what is to be as large as possible where the goal is not the mass
    decisive : (n,) parts of the draws in which each drive is the least
    drives : Drives
    force : amplitude of the force on the structure at the upper end of the range [N]
    """

    design: Design
    probability: float
    least: float
    interval: tuple[float, float]
    merit: np.ndarray
    decisive: np.ndarray
    drives: Drives
    force: float


def drives_of(problem: Problem, design: Design, masses: tuple[float, float], points: int = GRID) -> Drives:
    """Modes and Gammas at which a design must hold."""
    frequency, amplitude, inherent = problem.shapes(design, masses)
    target, force = problem.target, None
    if target.over == "gamma":
        ends = np.tile(np.array(target.gamma, float), (len(frequency), 1))
    else:
        scale = np.ones(len(frequency)) if target.over == "force" else problem.participation(design) / amplitude
        force = scale[:, None] * np.array(getattr(target, target.over))
        most = np.maximum(largest_damping(design.mass, amplitude, inherent), target.damping)
        per_force = amplitude**2 / (2 * STANDARD_GRAVITY)
        ends = np.stack([per_force * force[:, 0] / most, per_force * force[:, 1] / target.damping], axis=1)
    gamma = np.geomspace(ends[:, 0], ends[:, 1], points, axis=1)

    def of_mode(values):
        return np.repeat(values, points)

    rows = of_mode(np.arange(len(frequency)))
    return Drives(rows, *map(of_mode, (frequency, amplitude, inherent)), gamma.ravel(), force)


def assess(emulation: Emulation, designs: list[Design], masses: tuple[float, float], seed: int = 0) -> list[Assessment]:
    """What the emulator says of designs, each for itself."""
    if not designs:
        return []
    problem = emulation.problem
    drives = [drives_of(problem, design, masses) for design in designs]
    drive = ([own.frequency for own in drives], [own.gamma for own in drives])
    draws = drawn(*emulation.log_effectiveness(designs, *drive), DRAWS, seed)
    return [judged(problem, *each) for each in zip(designs, drives, draws, strict=True)]


def drawn(mean: np.ndarray, covariance: np.ndarray, draws: int, seed: int) -> np.ndarray:
    """Draws of the effectiveness (k, draws, n) from means (k, n) and covariances (k, n, n) of its logarithm.

    They are the same each time, and of one normal draw for all k.
    """
    value, vector = np.linalg.eigh(covariance)
    root = vector * np.sqrt(np.maximum(value, 0.0))[:, None, :]
    normal = np.random.default_rng(seed).standard_normal((draws, mean.shape[1]))
    return np.exp(mean[:, None, :] + np.einsum("dn,kmn->kdm", normal, root, optimize=True))


def judged(problem: Problem, design: Design, drives: Drives, effectiveness: np.ndarray) -> Assessment:
    """A design judged by draws of its effectiveness (draws, n)."""
    damping = drives.damping(effectiveness, design.mass)
    counted = drives.counts(damping)
    within = np.where(counted, damping, np.inf)
    least, at = within.min(axis=1), within.argmin(axis=1)
    least = np.where(np.isfinite(least), least, damping.max(axis=1))  # nothing of the range is answered to
    met = least >= (problem.target.damping or 0.0)
    merit = least if problem.design.goal != "response" else np.min(within / drives.amplitude**2, axis=1)
    top = float(drives.gamma.max())
    largest = float(np.median(effectiveness[:, int(np.argmax(drives.gamma))]))
    force = design.mass * top * STANDARD_GRAVITY * float(np.hypot(1.0, 4 / np.pi * largest))
    low, high = np.quantile(least, [0.025, 0.975])
    return Assessment(
        design,
        float(np.mean(met)),
        float(np.mean(least)),
        (float(low), float(high)),
        merit,
        np.bincount(at, minlength=len(drives.mode)) / len(at),
        drives,
        force,
    )
