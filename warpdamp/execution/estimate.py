"""Estimate of how much of a study is done, learnt from the cases that have finished."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..sweep.plan import Plan

CELLS = 0.02, 0.1
"""Cases whose frequencies and least costs agree to this part, as logarithms, are taken as alike: to the first or, where
that makes more than ``MOST_CELLS`` kinds of cases, to the second.  (In the main job what a case takes falls from 12 to
0.1 s over the amplitudes of mode 3, while its least cost rises by 7 %.)"""

MOST_CELLS = 1000

FREQUENCY_WEIGHT = 3.0
"""How much more two cases differ by their frequencies than by their costs: at 730 Hz a case may take thirty times the
cycles that it takes at the least, at 40 Hz hardly more."""


class Estimate:
    """Share of the work that is done, in seconds of processor time.

    Before a case runs, only the particle-steps that it takes at the least are known.  What a particle-step of those
    will take is interpolated, as a logarithm, from the cases that have finished, over the frequency and the cost, by
    the inverse square of the distance.

    Parameters
    ----------
    plan : Plan
    numbers : (n,) array
        Cases to run.
    """

    def __init__(self, plan: Plan, numbers: np.ndarray):
        self._cost = plan.cost
        places = np.log(np.maximum(np.nan_to_num(np.stack([plan.frequency, plan.cost]), nan=1.0), 1e-9))
        for width in CELLS:
            cells, self._cell = np.unique(np.round(places / width), axis=1, return_inverse=True)
            if cells.shape[1] <= MOST_CELLS:
                break
        self._places = width / CELLS[-1] * cells.T * (FREQUENCY_WEIGHT, 1.0)
        self._left = np.zeros(len(plan.keys), bool)
        self._least, self._seconds = np.zeros((2, len(self._places)))
        self.add(numbers)

    def add(self, numbers) -> None:
        """Count further cases in."""
        self._left[numbers] = True

    def finished(self, numbers, seconds) -> None:
        """Count cases as done that took so many seconds each; 0 for those that could not be run."""
        self._left[numbers] = False
        ran = np.asarray(seconds) > 0
        np.add.at(self._least, self._cell[numbers], np.where(ran, self._cost[numbers], 0.0))
        np.add.at(self._seconds, self._cell[numbers], seconds)

    @property
    def share(self) -> float:
        """Part of the work that is done, 0 to 1."""
        left = np.bincount(self._cell, self._cost * self._left, len(self._places))
        wanted = np.flatnonzero(left)
        if not len(wanted):
            return 1.0
        if not self._least.any():
            return 0.0
        rest = float(left[wanted] @ np.exp(self._rates(wanted)))
        done = float(self._seconds.sum())
        return done / (done + rest)

    @property
    def costs(self) -> np.ndarray:
        """Particle-steps that each case of the plan is expected to take, (n,).

        At the least, until some have finished; then times how much longer those like it took than the quickest did.
        """
        if not self._least.any():
            return self._cost
        rates = self._rates(np.arange(len(self._places)))
        return self._cost * np.exp(rates - rates.min())[self._cell]

    def _rates(self, cells: np.ndarray) -> np.ndarray:
        """Logarithms of the seconds that kinds of cases take for each of their least particle-steps, (m,)."""
        known = np.flatnonzero(self._least)
        rates = np.log(self._seconds[known] / self._least[known])
        distance = np.abs(self._places[cells, None] - self._places[None, known]).sum(axis=-1)
        weights = 1 / (distance + 1e-3) ** 2
        return weights @ rates / weights.sum(axis=1)
