"""Steady averages of a series of cycles: end of the transient, mean, and standard error.

Energies of successive cycles are correlated and drift while a bed compacts.  The transient is cut where the standard
error of the rest is smallest (the MSER rule: White 1997, doi:10.1177/003754979706900601); the standard error of a
correlated mean uses the integrated autocorrelation time with Geyer's initial monotone sequence (Geyer 1992,
doi:10.1214/ss/1177011137); drift is judged by a straight line through what was kept.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Steady:
    """Average of a series after its transient.

    Parameters
    ----------
    mean, standard_error : in the series' unit
    discarded : number of values cut off at the start
    degrees : degrees of freedom of the standard error
    drifting : whether the values kept still change by more than chance allows
    """

    mean: float
    standard_error: float
    discarded: int
    degrees: float
    drifting: bool


DRIFT = 3.0
"""A trend of more standard errors than this is a drift (of stationary series, 1-2 % are called so)."""


def autocorrelation_time(series) -> float:
    """Integrated autocorrelation time in steps of the series: 1 for uncorrelated values.

    The larger of two estimates: Geyer's initial monotone sequence, which is free of a model but biased low in short
    series, and that of a first-order autoregression with its coefficient corrected for that bias, by (1 + 3 phi) / n
    (Marriott & Pope 1954, doi:10.1093/biomet/41.3-4.390).  At least 0.3: an alternating series must not claim a
    certainty that it does not have.
    """
    x = np.asarray(series, float)
    n = len(x)
    x = x - x.mean()
    variance = np.dot(x, x) / n
    if variance == 0:
        return 1.0
    correlation = np.array([np.dot(x[: n - k], x[k:]) for k in range(n // 2 + 1)]) / (n * variance)
    pairs = correlation[: len(correlation) // 2 * 2].reshape(-1, 2).sum(axis=1)
    positive = np.argmax(pairs <= 0) if np.any(pairs <= 0) else len(pairs)
    geyer = 2 * float(np.sum(np.minimum.accumulate(pairs[:positive]))) - 1
    phi = min(0.98, correlation[1] + (1 + 3 * correlation[1]) / n)
    return max(0.3, geyer, (1 + phi) / (1 - phi))


def standard_error(series) -> float:
    """Standard error of the mean of a stationary, correlated series, in its unit.

    The sample variance of correlated values is too small by about tau / n; it is corrected for.

    Parameters
    ----------
    series : (n,) array, n >= 4

    Returns
    -------
    float
    """
    return float(np.std(series) / math.sqrt(degrees_of_freedom(series)))


def degrees_of_freedom(series) -> float:
    """Degrees of freedom of a correlated series: its number of uncorrelated values less one, at least a half.

    Parameters
    ----------
    series : (n,) array, n >= 4

    Returns
    -------
    float
    """
    return max(1.5, len(series) / autocorrelation_time(series)) - 1


def steady(series, *, fewest: int, floor: float = 0.0, earliest: int = 0) -> Steady:
    """Cut the transient off a series and average the rest.

    Parameters
    ----------
    series : (n,) array, n >= fewest
    fewest : values to keep at the least (and never less than half the series)
    floor : changes smaller than this are no drift (in the series' unit)
    earliest : values to discard at the least
    """
    x = np.asarray(series, float)
    n = len(x)
    latest = max(earliest, min(n - fewest, n // 2))
    discarded = min(range(earliest, latest + 1), key=lambda d: np.var(x[d:]) / (n - d))
    rest = x[discarded:]
    change, chance = _trend(rest)
    return Steady(
        mean=float(rest.mean()),
        standard_error=standard_error(rest),
        discarded=discarded,
        degrees=degrees_of_freedom(rest),
        drifting=bool(change > DRIFT * chance and change > floor),
    )


def _trend(series: np.ndarray) -> tuple[float, float]:
    """Change of a straight line through the series from its first half to its second, and the error of that change.

    The error comes from what the line leaves over: a trend must not hide itself as correlation.
    """
    n = len(series)
    time = np.arange(n) - (n - 1) / 2
    slope = np.dot(time, series) / np.dot(time, time)
    rest = series - series.mean() - slope * time
    return abs(slope) * n / 2, math.sqrt(3) * standard_error(rest)
