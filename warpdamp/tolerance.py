"""Accuracy bought by tolerance: the step, the length and the packings that an error asked for takes.

The tolerance is the standard error of the energy per cycle, all parts together: step, averaging, packing.  The step
is chosen beforehand, so that its error is a third of the tolerance at most; each case then runs until its own standard
error is what is left, and a point that its packings do not agree on well enough gets more of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .timestep import FEWEST_STEPS_PER_CONTACT

if TYPE_CHECKING:
    from .config import Config

PRESETS = {"fast": 0.05, "balanced": 0.02, "reference": 0.005}
"""Tolerances by name; their measured errors are in docs/accuracy.md."""

STEP_ERROR = 0.005
"""Relative error of the energy per cycle at 24 steps a contact, at most (docs/accuracy.md); of second order."""

STEP_SHARE = 1 / 3
"""Largest part of the tolerance that is left to the step."""

RESIDUAL_FACTOR = 2.5
"""Error of the energy per cycle over the ledger's residual, both of them the step's (docs/accuracy.md)."""

SMALLEST_EFFECTIVENESS = 1e-3
"""Energies below this part of the ideal damper's count as nothing: no error is relative to less."""

FINEST = 120.0
FEWEST_PACKINGS = 3


@dataclass(frozen=True)
class Plan:
    """What a tolerance takes before anything runs.

    Parameters
    ----------
    steps_per_contact : float
    standard_error : of one case, relative
    fewest_cycles : int
    """

    steps_per_contact: float
    standard_error: float
    fewest_cycles: int


def step_error(steps_per_contact: float) -> float:
    """Relative error of the energy per cycle that a step leaves at the most."""
    return STEP_ERROR * (24 / steps_per_contact) ** 2


def plan(tolerance: float) -> Plan:
    """Step and length for a tolerance.

    Parameters
    ----------
    tolerance : relative standard error of the energy per cycle
    """
    wanted = 24 * math.sqrt(STEP_ERROR / (STEP_SHARE * tolerance))
    steps = min(max(wanted, FEWEST_STEPS_PER_CONTACT), FINEST)
    left = math.sqrt(max(tolerance**2 - step_error(steps) ** 2, (0.5 * tolerance) ** 2))
    return Plan(steps, left, 20 if tolerance >= 0.05 else 30)


def applied(config: Config) -> Config:
    """The configuration with the step, the length and the packings that its tolerance takes.

    Raises
    ------
    ConfigError
        If it also asks for a step or an error of its own.
    """
    if config.accuracy is None:
        return config
    chosen = plan(config.accuracy.tolerance)
    for section, key in (("numerics", "steps_per_contact"), ("steady_state", "standard_error")):
        given = getattr(config, section)
        if key in given.model_fields_set and getattr(given, key) != getattr(chosen, key):
            raise config.error(f"{section}.{key}", "is chosen by accuracy.tolerance: leave one of the two out")
    if config.numerics.step != "auto" or config.steady_state.recipe != "detect":
        raise config.error("accuracy", "chooses the step and the length of a run: leave numerics.step and recipe out")
    steady = config.steady_state.model_copy(
        update={"standard_error": chosen.standard_error, "fewest_cycles": chosen.fewest_cycles}
    )
    numerics = config.numerics.model_copy(update={"steps_per_contact": chosen.steps_per_contact})
    seeds = config.seeds if "seeds" in config.model_fields_set else list(range(1, config.accuracy.most_packings + 1))
    changed = config.model_copy(update={"steady_state": steady, "numerics": numerics, "seeds": seeds})
    changed._source = config._source
    return changed


def first_round(config: Config, specs: dict) -> dict:
    """The cases to begin with: with a tolerance, those of the first few packings."""
    if config.accuracy is None:
        return specs
    return {index: spec for index, spec in specs.items() if index[-1] < FEWEST_PACKINGS}


def next_round(config: Config, specs: dict, values: dict) -> dict:
    """The cases to go on with: one more packing for every point that its packings do not tell well enough.

    Parameters
    ----------
    specs : all cases, by their index; the last part of it is the packing
    values : what the cases run so far gave
    """
    if config.accuracy is None:
        return {}
    points: dict[tuple, list[dict]] = {}
    for index, value in values.items():
        points.setdefault(index[:-1], []).append(value)
    further = {}
    for point, packings in points.items():
        index = (*point, len(packings))
        if index in specs and _untold(packings, config.accuracy.tolerance):
            further[index] = specs[index]
    return further


def _untold(packings: list[dict], tolerance: float) -> bool:
    """Whether the packings of a point leave more error than asked for, though each did what it could."""
    if any("energy_dissipated" not in value for value in packings):
        return False  # more of what failed does not help
    names = ("energy_dissipated", "energy_dissipated_standard_error", "degrees_of_freedom")
    answer = combined(*([value[name] for value in packings] for name in names))
    floor = SMALLEST_EFFECTIVENESS * packings[0]["maximum_energy"]
    return answer.standard_error > max(tolerance * answer.mean, floor)


@dataclass(frozen=True)
class Answer:
    """The mean over packings and what it is worth.

    Parameters
    ----------
    mean : in the unit of the values
    standard_error : of the mean: by the packings' spread, never below what their own errors give
    interval : half-width of the 95 % interval, by Student's t with the degrees of freedom of the larger part
    packings : how many
    """

    mean: float
    standard_error: float
    interval: float
    packings: int


def combined(means, errors, degrees) -> Answer:
    """Combine packings.

    Parameters
    ----------
    means, errors : (n,) mean and standard error of each packing
    degrees : (n,) degrees of freedom of each error
    """
    means, errors, degrees = (np.asarray(values, float) for values in (means, errors, degrees))
    n = len(means)
    within = math.sqrt(float(np.sum(errors**2))) / n
    between = float(means.std(ddof=1)) / math.sqrt(n) if n > 1 else 0.0
    own = (
        float(np.sum(errors**2) ** 2 / np.sum(errors**4 / degrees)) if within > 0 else math.inf
    )  # Welch, Satterthwaite
    error, freedom = max((within, own), (between, n - 1.0))
    return Answer(float(means.mean()), error, error * student(freedom), n)


def student(degrees: float) -> float:
    """Half-width of the 95 % interval over the standard error."""
    from scipy.special import stdtrit

    return float(stdtrit(min(max(degrees, 1.0), 1e6), 0.975))
