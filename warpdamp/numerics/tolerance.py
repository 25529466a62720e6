"""Tolerances: the step, the length and the packings that an accuracy asked for requires.

The tolerance is the standard error of the energy per cycle, all parts together: step, averaging, packing.  The step
is chosen beforehand, so that its error is a third of the tolerance at most; each case then runs until its own standard
error is what is left, and a point whose packings scatter too much gets more of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .limits import FEWEST_PACKINGS, FEWEST_STEPS_PER_CONTACT

STEP_ERROR = 0.005
"""Relative error of the energy per cycle that a study assumes at 24 steps a contact; of second order.  Six points
together show 0.1 %, single ones as much as chance allows to see (docs/accuracy.md)."""

STEP_SHARE = 1 / 3
"""Largest part of the tolerance that is left to the step."""

SLACK = 0.5
"""Part of the tolerance that a case may still drift by, or be out of balance by, and end: less than the error of
its bed's state."""

RESIDUAL_FACTOR = 2.5
"""Estimated step error of a case over the ledger's residual.  Six points together show 0.6; upper bounds of
single ones, in which chance is the most, reach 3.3 (docs/accuracy.md)."""

LOOSE_MEMORY, TIGHT_MEMORY = 0.04, 0.06
"""Relative standard error of a single bed, however well its cycles are averaged: a bed stays in one state for hundreds
of cycles, and what a state dissipates differs.  The larger of the root mean square beyond averages (3.8 and 4.3 %) and
what 95 % of the cases need to lie within their 95 % intervals (2.7 and 5.5 %), up to the next half percent: 36 and 24
cases of compacted beds 3.6 to 5.4 spheres across, one of them of many sizes; a larger draw of beds that were compacted
further gives a little more, and most for mixtures (docs/bed-states.md, docs/accuracy.md); packings average it out."""

TIGHT_FILL = 0.5
"""Part of the cavity that particles fill from which a bed counts as tight: 0.42-0.48 and 0.51-0.519 were measured."""

SMALLEST_EFFECTIVENESS = 1e-3
"""Energies below this part of the ideal damper's count as nothing: no error is relative to less."""

FINEST = 120.0


@dataclass(frozen=True)
class ToleranceSettings:
    """Settings of a study that its tolerance chooses before anything runs.

    Parameters
    ----------
    steps_per_contact : float
    standard_error : of the average over the cycles of one case, relative
    slack : drift, and difference of work and dissipation, that is not waited for, relative
    """

    steps_per_contact: float
    standard_error: float
    slack: float


def step_error(steps_per_contact: float) -> float:
    """Relative error of the energy per cycle that a study assumes for a step [-].

    Parameters
    ----------
    steps_per_contact : float

    Returns
    -------
    float
    """
    return STEP_ERROR * (24 / steps_per_contact) ** 2


def settings_for(tolerance: float) -> ToleranceSettings:
    """Settings for a tolerance: step and length of a run.

    Parameters
    ----------
    tolerance : float
        Relative standard error of the energy per cycle [-].

    Returns
    -------
    ToleranceSettings
    """
    needed = 24 * math.sqrt(STEP_ERROR / (STEP_SHARE * tolerance))
    steps = min(max(needed, FEWEST_STEPS_PER_CONTACT), FINEST)
    left = math.sqrt(max(tolerance**2 - step_error(steps) ** 2, (0.5 * tolerance) ** 2))
    return ToleranceSettings(steps, left, SLACK * tolerance)


def packings_needed(energies, errors, degrees, memories, steps, largest, tolerance: float) -> int:
    """Number of a point's packings that a tolerance requires, given those that ran.

    A few; then at once as many as their own errors would take if all agreed, so that their beds are made side by side;
    then one more at a time while they disagree.

    Parameters
    ----------
    energies, errors, degrees, memories, steps : (n,) energy per cycle, its standard error, that one's degrees of
        freedom, and the errors by the bed's state and by the step, of every packing that there may be; NaN where it has
        not run, or failed: more of what failed does not help
    largest : (n,) energy of the ideal damper [J]
    tolerance : relative
    """
    n = min(FEWEST_PACKINGS, len(energies))
    while n < len(energies) and np.isfinite(energies[:n]).all():
        answer = combined(energies[:n], errors[:n], degrees[:n], memories[:n], steps[:n])
        limit = allowed(tolerance, answer.mean, largest[0])
        if answer.total_error <= limit or answer.step_error >= limit:  # more packings do not reduce the step's error
            break
        needed = np.mean(errors[:n] ** 2 + memories[:n] ** 2) / (limit**2 - answer.step_error**2)
        n = min(max(n + 1, math.ceil(needed)), len(energies))
    return n


def allowed(tolerance: float, mean, largest):
    """Standard error that a tolerance allows a mean, in its unit.

    Parameters
    ----------
    tolerance : float
        Relative [-].
    mean : (...) array
    largest : (...) array
        The ideal damper's energy: below ``SMALLEST_EFFECTIVENESS`` of it no error is relative.

    Returns
    -------
    (...) array
    """
    return np.maximum(tolerance * mean, SMALLEST_EFFECTIVENESS * largest)


@dataclass(frozen=True)
class Answer:
    """Means over packings with their uncertainties, each an array over points.

    Parameters
    ----------
    mean : in the unit of the values
    standard_error : of the mean: by the packings' spread, never below what their own errors and memories give
    step_error : of the mean; packings share it, so that it does not average out
    interval : half-width of the 95 % interval: Student's t with the degrees of freedom of the larger statistical part,
        and twice the step's error
    packings : how many
    """

    mean: np.ndarray
    standard_error: np.ndarray
    step_error: np.ndarray
    interval: np.ndarray
    packings: np.ndarray

    @property
    def total_error(self) -> np.ndarray:
        """Standard error, all parts together: what is compared with a tolerance."""
        return np.hypot(self.standard_error, self.step_error)


PARTS = (
    "energy_dissipated",
    "energy_dissipated_standard_error",
    "degrees_of_freedom",
    "memory_error",
    "discretisation_error",
)
"""Variables of a case that ``combined`` and ``packings_needed`` begin with, in their order."""


def combined(means, errors, degrees, memories=0.0, steps=0.0, ran=True) -> Answer:
    """Mean over packings with its standard errors and interval.

    Parameters
    ----------
    means, errors : (..., n) mean of each packing, and the standard error of its average over cycles
    degrees : (..., n) degrees of freedom of each error
    memories : (..., n) standard error of each by the state that its bed is in
    steps : (..., n) error of the step of each
    ran : (..., n) which of them there are
    """
    given = (means, errors, degrees, memories, steps, ran)
    means, errors, degrees, memories, steps, ran = np.broadcast_arrays(*(np.asarray(a) for a in given))

    def total(values):
        return np.sum(np.where(ran, values, 0.0), axis=-1)

    n = ran.sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = total(means) / n
        within = np.sqrt(total(errors**2 + memories**2)) / n
        between = np.where(n > 1, np.sqrt(total((means - mean[..., None]) ** 2) / ((n - 1) * n)), 0.0)
        step = total(steps) / n
        degrees_within = total(errors**2 + memories**2) ** 2 / total(errors**4 / degrees)  # Welch, Satterthwaite
    degrees_within = np.where(within > 0, degrees_within, math.inf)
    error = np.maximum(within, between)
    interval = np.hypot(error * student(np.where(between > within, n - 1.0, degrees_within)), 2 * step)
    return Answer(mean, error, step, interval, n)


def bed_memory(fill: float) -> float:
    """Relative standard error of a single bed that averaging over cycles cannot reduce [-].

    Parameters
    ----------
    fill : float
        Volume of the particles over the cavity's [-].

    Returns
    -------
    float
    """
    return TIGHT_MEMORY if fill >= TIGHT_FILL else LOOSE_MEMORY


def single_interval(error: float, degrees: float, memory: float) -> float:
    """Half-width of the 95 % interval of a single bed: of its average over cycles, and for its state.

    Parameters
    ----------
    error, degrees : float
        Standard error of the average over cycles, and its degrees of freedom.
    memory : float
        Standard error by the bed's state, in the same unit.

    Returns
    -------
    float
    """
    return float(np.hypot(error * student(degrees), memory * student(math.inf)))


def student(degrees):
    """Ratio of the 95 % interval's half-width to the standard error [-].

    Parameters
    ----------
    degrees : (...) array
        Degrees of freedom.

    Returns
    -------
    (...) array
    """
    from scipy.special import stdtrit

    return stdtrit(np.clip(degrees, 1.0, 1e6), 0.975)
