"""Simulation of a chosen design again, with packings that the search has not seen, before anything is claimed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .assess import Assessment, Drives, drawn, drives_of, judged
from .cases import Order, Row
from .emulation import Emulation
from .problem import Design
from .search import Search

FRESH = 1001
"""First seed of packings that no search uses."""
PACKINGS = 8
GAMMAS = 5
DRAWS = 4000


@dataclass(frozen=True)
class Verified:
    """A design simulated again.

    Parameters
    ----------
    design : Design
    drives : Drives
        Modes and Gammas that were simulated.
    damping : (packings, n) damping ratio of each packing there
    mean, interval : (n,) mean over the packings, and half-width of its 95 % interval (Student's t, step included)
    probability : that the target is met by the mean over packings: the smaller of what these packings say at these
        Gammas, and of what the emulator says between them, these packings included
    probability_interval : what the first would be without any one of the packings, the smallest and the largest
    least : Assessment
        By the emulator, between the Gammas, too.
    """

    design: Design
    drives: Drives
    damping: np.ndarray
    mean: np.ndarray
    interval: np.ndarray
    probability: float
    probability_interval: tuple[float, float]
    least: Assessment


def cases_needed(search: Search, design: Design) -> int:
    """Cases that simulating a design again takes."""
    return PACKINGS * len(drives_of(search.problem, design, search.masses, points=GAMMAS).gamma)


def orders_of(search: Search, design: Design, first: int, packings: int = PACKINGS) -> tuple[Drives, list[Order]]:
    """Cases of a design with fresh packings, by the first of their seeds."""
    drives = drives_of(search.problem, design, search.masses, points=GAMMAS)
    orders = [
        Order(design, int(mode), float(gamma), first + seed)
        for seed in range(packings)
        for mode, gamma in zip(drives.mode, drives.gamma, strict=True)
    ]
    return drives, orders


def verify(search: Search, design: Design, attempt: int) -> Verified:
    """Simulate a design again; the cases count for the emulator, too."""
    drives, orders = orders_of(search, design, FRESH + attempt * PACKINGS)
    rows = search.run(orders)
    emulation = search.assess_all()
    return verdict(search, design, drives, rows, emulation)


def verdict(search: Search, design: Design, drives: Drives, rows: list[Row], emulation: Emulation) -> Verified:
    """What packings of a design say, by their rows (packings x drives)."""
    from scipy.stats import t

    shape = (-1, len(drives.gamma))
    effectiveness = np.array([row.effectiveness for row in rows]).reshape(shape)
    step = np.nanmean([row.step_error for row in rows])
    effectiveness = effectiveness[np.isfinite(effectiveness).all(axis=1)]
    finer = drives_of(search.problem, design, search.masses)
    emulated = emulation.log_effectiveness([design], [finer.frequency], [finer.gamma])
    least = judged(search.problem, design, finer, drawn(*emulated, DRAWS, 1)[0])
    n = len(effectiveness)
    if n < 3:
        nothing = np.full(len(drives.gamma), np.nan)
        return Verified(design, drives, effectiveness, nothing, nothing, 0.0, (0.0, 0.0), least)
    damping = drives.damping(effectiveness, design.mass)
    error = np.std(damping, axis=0, ddof=1) / np.sqrt(n)
    interval = np.hypot(t.ppf(0.975, n - 1) * error, 2 * step * damping.mean(axis=0))
    own = probability(search, design, drives, effectiveness, step)
    without = [probability(search, design, drives, np.delete(effectiveness, k, 0), step) for k in range(n)]
    return Verified(
        design,
        drives,
        damping,
        damping.mean(axis=0),
        interval,
        min(own, least.probability),
        (min(*without, own, least.probability), max(without)),
        least,
    )


def probability(search: Search, design: Design, drives: Drives, effectiveness: np.ndarray, step: float) -> float:
    """Probability that the mean over packings meets the target at every drive: multivariate Student's t."""
    n = len(effectiveness)
    rng = np.random.default_rng(2)
    centred = effectiveness - effectiveness.mean(axis=0)
    normal = rng.standard_normal((DRAWS, n)) @ centred / np.sqrt(n * (n - 1))
    wider = np.sqrt((n - 1) / rng.chisquare(n - 1, (DRAWS, 1)))
    shared = 1 + step * rng.standard_normal((DRAWS, 1))  # packings share the step's error
    draws = np.maximum((effectiveness.mean(axis=0) + normal * wider) * shared, 0.0)
    return judged(search.problem, design, drives, draws).probability
