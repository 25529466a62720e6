"""Errors and costs read off the series of an accuracy study: step, transient, chance, cheapest settings."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..numerics.steady import autocorrelation_time, standard_error

if TYPE_CHECKING:
    import xarray as xr

REFERENCE = 48.0
"""Steps per contact of the reference: by second order a quarter of the error at the usual 24."""

REFERENCE_LABEL = f"steps_per_contact={REFERENCE:g}"
"""Name of the reference along the dimension ``variation``."""


def _after_transient(row) -> np.ndarray:
    """The last two thirds of a series: the first third is the transient."""
    x = np.asarray(row, float)
    x = x[np.isfinite(x)]
    return x[len(x) // 3 :]


def systematic(runs: xr.Dataset) -> xr.Dataset:
    """Relative error of each variation against the reference, bed by bed, with its standard error, and its cost.

    The difference of a bed from its own reference is free of the beds' spread; what is left is the chance of two
    finite series, from their standard errors.

    Parameters
    ----------
    runs : xarray.Dataset
        See ``warpdamp.study.accuracy.study``.

    Returns
    -------
    xarray.Dataset
        ``error``, ``error_standard_error`` [-], ``cost`` [core-s per cycle] (point, variation).
    """
    import xarray as xr

    shape = (runs.sizes["point"], runs.sizes["variation"])
    error, chance = np.empty(shape), np.empty(shape)
    for p in range(shape[0]):
        references = runs["effectiveness"].isel(point=p).sel(variation=REFERENCE_LABEL).values
        truth = np.mean([_after_transient(row).mean() for row in references])
        for v in range(shape[1]):
            rows = runs["effectiveness"].isel(point=p, variation=v).values
            pairs = [(_after_transient(a), _after_transient(b)) for a, b in zip(rows, references, strict=True)]
            differences = np.array([a.mean() - b.mean() for a, b in pairs])
            within = math.sqrt(sum(standard_error(a) ** 2 + standard_error(b) ** 2 for a, b in pairs)) / len(pairs)
            between = differences.std(ddof=1) / math.sqrt(len(pairs)) if len(pairs) > 1 else 0.0
            error[p, v] = differences.mean() / truth
            chance[p, v] = max(within, between) / truth
    dims = ("point", "variation")
    return xr.Dataset(
        {
            "error": (dims, error),
            "error_standard_error": (dims, chance),
            "cost": (dims, runs["cost_per_cycle"].mean("seed").values),
        },
        {name: runs[name] for name in ("frequency", "gamma", "variation")},
    )


def step_errors(errors: xr.Dataset) -> dict[float, tuple[float, float]]:
    """Step error of one point at each step: relative error by the fitted law, and cost.

    Leapfrog is of second order, so a single strength c is fitted to |error| = c / N^2 - c / N_ref^2, by weights of the
    standard errors; where chance hides it, its one-sigma upper bound is taken.

    Parameters
    ----------
    errors : xarray.Dataset
        One point of ``systematic``.

    Returns
    -------
    dict
        Steps per contact -> (relative error, core-seconds per cycle).
    """
    names = [v for v in errors["variation"].values if v.startswith("steps_per_contact")]
    steps = np.array([float(name.split("=")[1]) for name in names])
    error = errors["error"].sel(variation=names).values
    weight = 1 / np.maximum(errors["error_standard_error"].sel(variation=names).values, 1e-6) ** 2
    law = 1 / steps**2 - 1 / REFERENCE**2
    information = np.sum(weight * law**2)
    strength = np.sum(weight * law * error) / information
    bound = abs(strength) + 1 / math.sqrt(information)
    costs = errors["cost"].sel(variation=names).values
    return {float(n): (bound / n**2, float(cost)) for n, cost in zip(steps, costs, strict=True)}


@dataclass(frozen=True)
class Chance:
    """Statistical error that averaging leaves at a point, relative to the mean.

    Parameters
    ----------
    one_cycle : float
        Standard error of one uncorrelated cycle [-], so that n cycles leave one_cycle / sqrt(n).
    packing : float
        Standard deviation between beds [-].
    """

    one_cycle: float
    packing: float


def chance(rows) -> Chance:
    """Statistical error of one point, from the series of its beds.

    Parameters
    ----------
    rows : (seeds, cycles) array
        Energy, or effectiveness, of every cycle; NaN beyond the end of a series.

    Returns
    -------
    Chance
    """
    series = [_after_transient(row) for row in rows]
    means = np.array([x.mean() for x in series])
    mean = means.mean()
    variance = np.mean([np.var(x) * autocorrelation_time(x) for x in series])
    within = np.mean([standard_error(x) ** 2 for x in series])
    spread = max(0.0, means.var(ddof=1) - within) if len(means) > 1 else 0.0
    return Chance(math.sqrt(variance) / mean, math.sqrt(spread) / mean)


def transient(rows, discarded: int) -> float:
    """Relative error of averaging half a run after discarded cycles, root mean square over the beds [-].

    Parameters
    ----------
    rows : (seeds, cycles) array
        Energy, or effectiveness, of every cycle; NaN beyond the end of a series.
    discarded : int
        Cycles left out at the start.

    Returns
    -------
    float
    """
    misses = []
    for row in rows:
        x = np.asarray(row, float)
        x = x[np.isfinite(x)]
        misses.append(x[discarded : discarded + len(x) // 2].mean() / _after_transient(row).mean() - 1)
    return float(np.sqrt(np.mean(np.square(misses))))


def averaged(rows, lengths) -> list[tuple[float, float]]:
    """Observed error of averaging n cycles, root mean square over all windows of that length.

    Parameters
    ----------
    rows : (seeds, cycles) array
        Energy, or effectiveness, of every cycle; NaN beyond the end of a series.
    lengths : iterable of int
        Values of n; those of which a series has fewer than three windows are left out.

    Returns
    -------
    list of (n, relative error)
    """
    out = []
    for n in lengths:
        misses = []
        for row in rows:
            x = _after_transient(row)
            windows = len(x) // n
            if windows >= 3:
                means = x[: windows * n].reshape(windows, n).mean(axis=1)
                misses += list((means - means.mean()) ** 2 * windows / (windows - 1))
        if misses:
            mean = np.mean([_after_transient(row).mean() for row in rows])
            out.append((n, math.sqrt(np.mean(misses)) / mean))
    return out


def cheapest(step_errors: dict[float, tuple[float, float]], point: Chance, tolerance: float, *, bed: float = 0.0):
    """Settings of least cost with which the standard error of all parts together stays within a tolerance.

    Parameters
    ----------
    step_errors : dict
        Steps per contact -> (relative error, core-seconds per cycle).
    point : Chance
    tolerance : float
        Relative standard error [-].
    bed : float
        Cost of making a bed [core-s].

    Returns
    -------
    (steps per contact, packings, cycles each, core-seconds) or None
        None where no combination reaches the tolerance.
    """
    best = None
    for steps, (error, cost) in step_errors.items():
        for packings in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32):
            left = tolerance**2 - error**2 - point.packing**2 / packings
            if left <= 0:
                continue
            cycles = max(12, math.ceil(point.one_cycle**2 / (packings * left)))
            total = packings * (bed + 1.5 * cycles * cost)  # a third of a run is its transient
            if best is None or total < best[3]:
                best = (steps, packings, cycles, total)
    return best
