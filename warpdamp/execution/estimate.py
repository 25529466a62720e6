"""Estimate of how much of a study is done, learnt from the cases that have finished."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..sweep.plan import Plan


class Estimate:
    """Share of the work that is done.

    Before a case runs, only the particle-steps that it takes at the least are known.  How many times as many the others
    will take is what those at the same frequency have taken; where none has finished, what all have.

    Parameters
    ----------
    plan : Plan
    numbers : (n,) array
        Cases to run.
    """

    def __init__(self, plan: Plan, numbers: np.ndarray):
        self._plan = plan
        self._left = np.zeros(len(plan.keys), bool)
        _, self._frequency = np.unique(plan.frequency, return_inverse=True)
        self._least, self._taken = np.zeros((2, self._frequency.max(initial=0) + 1))
        self.add(numbers)

    def add(self, numbers) -> None:
        """Count further cases in."""
        self._left[numbers] = True

    def finished(self, numbers, taken: float) -> None:
        """Count cases as done that took so many particle-steps together."""
        self._left[numbers] = False
        least = self._plan.cost[numbers]
        np.add.at(self._least, self._frequency[numbers], least)
        np.add.at(self._taken, self._frequency[numbers], taken * least / max(least.sum(), 1.0))

    @property
    def share(self) -> float:
        """Part of the work that is done, 0 to 1."""
        overall = self._taken.sum() / max(self._least.sum(), 1.0) or 1.0
        times = np.where(self._least > 0, self._taken / np.maximum(self._least, 1.0), overall)
        left = np.bincount(self._frequency, self._plan.cost * self._left, len(times)) @ times
        done = self._taken.sum()
        return float(done / (done + left)) if left > 0 else 1.0
