"""Cases that a study needs, given the results of those that are finished.

Without a tolerance all of them.  With one every point begins with a few packings and gets more of them until its
energy is known well enough.  The answer depends on finished cases only, not on when and where they ran: a
study that was interrupted continues as it would have.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..numerics.tolerance import PARTS, packings_needed
from ..sweep.plan import Fate

if TYPE_CHECKING:
    from ..sweep.plan import Plan
    from .store import Finished

_VALUES = (*PARTS, "maximum_energy")

NEEDED = ("status", *_VALUES)
"""Variables of the finished cases that are read."""


def needed_cases(plan: Plan, finished: Finished) -> np.ndarray:
    """Numbers of the cases that the study needs, finished ones among them.

    Where beds are carried on from one amplitude to the next, a packing needed at one of them is run at all.
    """
    numbers, accuracy = plan.to_run(), plan.cases.config.accuracy
    if accuracy is None:
        return numbers
    values = _values(plan, finished)
    needed = np.zeros(len(plan.keys), bool)
    for point in np.arange(len(plan.keys)).reshape(-1, plan.cases.shape[-1]):
        packings = point[plan.fate[point] == Fate.RUN]
        needed[packings[: packings_needed(*values[:, packings], accuracy.tolerance)]] = True
    return numbers[np.isin(plan.chain[numbers], plan.chain[needed])]


def _values(plan: Plan, finished: Finished) -> np.ndarray:
    """Energies of all cases and their uncertainties, (6, n); NaN where a case is not finished, or failed."""
    rows = finished.rows(plan.keys)
    done = rows >= 0
    values = np.full((len(_VALUES), len(rows)), np.nan)
    for row, name in zip(values, _VALUES, strict=True):
        if name in finished.values:
            row[done] = finished.values[name][rows[done]]
    return values
