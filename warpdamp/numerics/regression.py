"""Fits through noisy points: maxima of smooth curves, and straight lines, with their uncertainties."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

DRAWS = 400
FINE = 161


@dataclass(frozen=True)
class Maximum:
    """Maximum of a fitted curve.

    Parameters
    ----------
    gamma, gamma_standard_error : where, from draws of the fit's posterior
    height, height_standard_error : of the curve there
    """

    gamma: float
    gamma_standard_error: float
    height: float
    height_standard_error: float


def maxima(gamma, height, standard_error) -> list[Maximum]:
    """Maxima of a smooth curve through noisy points, inside their range, with what is known of them.

    A Gaussian process over sqrt(Gamma), along which damping curves have features of one width, with a squared
    exponential kernel; its amplitude, width and further noise (the spread of seeds) are those of the largest marginal
    likelihood (Rasmussen & Williams 2006, algorithm 2.1, ISBN 0-262-18253-X).  Points that are not finite are left out.

    Parameters
    ----------
    gamma, height, standard_error : (n,) arrays; a Gamma may occur several times, as for several seeds
    """
    gamma, height, error = (np.asarray(a, float).ravel() for a in (gamma, height, standard_error))
    known = np.isfinite(height) & np.isfinite(error)
    if len(np.unique(gamma[known])) < 4:
        return []
    x, fine = np.sqrt(gamma[known]), np.linspace(*np.sqrt([gamma[known].min(), gamma[known].max()]), FINE)
    mean, covariance = _posterior(x, height[known], error[known], fine)
    rng = np.random.default_rng(0)  # the same answer each time
    jitter = 1e-9 * np.trace(covariance) * np.eye(FINE)  # the curve has fewer degrees of freedom than points
    draws = mean + rng.standard_normal((DRAWS, FINE)) @ np.linalg.cholesky(covariance + jitter).T
    spread = np.sqrt(np.maximum(np.diag(covariance), 0))
    return _maxima(fine**2, mean, spread, draws)


def packings_left_out(gamma, height, standard_error) -> list[tuple[Maximum, list[Maximum | None]]]:
    """Maxima of a curve measured on several packings, each with the same one of the curves without one packing.

    Every packing has an optimum of its own, so points of one curve do not err independently: see ``widened``.

    Parameters
    ----------
    gamma : (n,) array
        Amplitudes.
    height, standard_error : (n, packings) arrays
        Curves, NaN where a packing was not run, and what each point is known to.

    Returns
    -------
    list of (Maximum, list of Maximum or None)
        One for each packing, left out: None where that curve has no such maximum, or the packing was not run; of one
        packing the list is empty.
    """
    gamma, height, error = (np.asarray(a, float) for a in (gamma, height, standard_error))
    tops = maxima(np.broadcast_to(gamma[:, None], height.shape), height, error)
    ran = np.isfinite(height).any(axis=0)
    if not tops or ran.sum() < 2:
        return [(top, []) for top in tops]
    without = [
        _maxima_of_mean(gamma, np.delete(height, k, 1), np.delete(error, k, 1)) if ran[k] else []
        for k in range(len(ran))
    ]
    return [(top, [_same(top, tops, others) for others in without]) for top in tops]


def _maxima_of_mean(gamma, height, error) -> list[Maximum]:
    known = np.isfinite(height) & np.isfinite(error)
    n = np.maximum(known.sum(axis=1), 1)
    mean = np.where(known.any(axis=1), np.where(known, height, 0).sum(axis=1) / n, np.nan)
    return maxima(gamma, mean, np.sqrt(np.where(known, error**2, 0).sum(axis=1)) / n)


def _same(top: Maximum, tops: list[Maximum], others: list[Maximum]) -> Maximum | None:
    """The maximum of another curve that this one, and no other of its own curve, lies nearest to."""
    nearest = min(others, key=lambda other: abs(other.gamma - top.gamma), default=None)
    return nearest if nearest and min(tops, key=lambda own: abs(own.gamma - nearest.gamma)) is top else None


def widened(top: Maximum, without: list[Maximum | None]) -> Maximum:
    """A maximum with errors that hold for other packings, too.

    Each packing was left out in turn (the jackknife: Efron & Stein 1981, doi:10.1214/aos/1176345462); where that
    scatters more than the fit's posterior says, it is the standard error, widened for few packings as Student's t is.
    """
    from scipy.stats import norm, t

    found = [other for other in without if other is not None]
    n = len(found)
    if n < 2:
        return top
    factor = t.ppf(norm.cdf(1.0), n - 1) * math.sqrt(n - 1)

    def error(name: str) -> float:
        return max(getattr(top, f"{name}_standard_error"), factor * float(np.std([getattr(o, name) for o in found])))

    return replace(top, gamma_standard_error=error("gamma"), height_standard_error=error("height"))


def _posterior(x, y, error, fine):
    """Mean and covariance of the Gaussian process at ``fine``."""
    from scipy.linalg import cho_factor, cho_solve
    from scipy.optimize import minimize

    middle, scale = y.mean(), max(float(np.ptp(y)), 1e-12)
    z, noise = (y - middle) / scale, (error / scale) ** 2

    def kernel(a, b, amplitude, width):
        return amplitude**2 * np.exp(-0.5 * ((a[:, None] - b[None, :]) / width) ** 2)

    def factor(amplitude, width, further):
        return cho_factor(kernel(x, x, amplitude, width) + np.diag(noise + further**2 + 1e-8), lower=True)

    def unlikelihood(logs):
        lower = factor(*np.exp(logs))
        return 0.5 * z @ cho_solve(lower, z) + np.log(np.diag(lower[0])).sum()

    span = float(np.ptp(x))
    start = np.log([0.5, span / 5, 0.03])
    bounds = [(np.log(0.05), np.log(5)), (np.log(span / 25), np.log(span)), (np.log(1e-3), np.log(0.5))]
    amplitude, width, further = np.exp(minimize(unlikelihood, start, method="L-BFGS-B", bounds=bounds).x)
    lower, across = factor(amplitude, width, further), kernel(fine, x, amplitude, width)
    mean = across @ cho_solve(lower, z)
    covariance = kernel(fine, fine, amplitude, width) - across @ cho_solve(lower, across.T)
    return middle + scale * mean, scale**2 * covariance


def _maxima(gamma, mean, spread, draws) -> list[Maximum]:
    """Maxima of the mean curve that stand out; their uncertainty is that of each draw's maximum in the same basin."""
    from scipy.signal import find_peaks

    tops, traits = find_peaks(mean, prominence=0)
    prominent = [k for k, prominence in zip(tops, traits["prominences"], strict=True) if prominence > spread[k]]
    if not prominent:
        return []
    basins = [0, *(a + int(np.argmin(mean[a:b])) for a, b in itertools.pairwise(prominent)), len(mean) - 1]
    result = []
    for k, (first, last) in zip(prominent, itertools.pairwise(basins), strict=True):
        first, last = _around(k, first, last, mean, spread)
        at = first + np.argmax(draws[:, first : last + 1], axis=1)
        inside = (at > first) & (at < last)
        where = gamma[at[inside]]
        if inside.mean() < 0.5:
            continue
        heights = draws[np.flatnonzero(inside), at[inside]]
        step = gamma[min(k + 1, len(gamma) - 1)] - gamma[k]  # the fine grid's own uncertainty
        error = math.hypot(float(np.std(where)), step / math.sqrt(12))
        top, height = _vertex(np.sqrt(gamma[k - 1 : k + 2]), mean[k - 1 : k + 2])
        result.append(Maximum(top**2, error, height, float(np.std(heights))))
    return result


def _vertex(x, y) -> tuple[float, float]:
    """Top of the parabola through three points, evenly spaced, of which the middle one is the highest."""
    below, above = y[1] - y[0], y[1] - y[2]
    part = 0.5 * (below - above) / (below + above)
    return float(x[1] + part * (x[2] - x[1])), float(y[1] + 0.25 * (below - above) * part)


def _around(k: int, first: int, last: int, mean, spread) -> tuple[int, int]:
    """Part of a basin round its top that may, within three standard errors, be as high."""
    low = mean[k] - mean > 3 * np.hypot(spread, spread[k])
    below, above = np.flatnonzero(low[first:k]), np.flatnonzero(low[k : last + 1])
    return (first + int(below[-1]) if len(below) else first), (k + int(above[0]) if len(above) else last)


@dataclass(frozen=True)
class Line:
    """Straight line y = intercept + slope x, with standard errors, and chi^2 per degree of freedom."""

    slope: float
    slope_standard_error: float
    intercept: float
    intercept_standard_error: float
    scatter: float


def straight_line(x, y, error) -> Line:
    """Line by weighted least squares; where points scatter more than their errors, the line's errors grow with them.

    Parameters
    ----------
    x, y, error : (n,) arrays
        ``error``: standard error of y.  Points that are not finite are left out.

    Returns
    -------
    Line

    Raises
    ------
    ValueError
        If fewer than three points are finite.
    """
    x, y, error = (np.asarray(a, float).ravel() for a in (x, y, error))
    known = np.isfinite(x) & np.isfinite(y) & np.isfinite(error)
    if known.sum() < 3:
        raise ValueError(f"a line with uncertainties needs three points, got {known.sum()}")
    x, y, weight = x[known], y[known], 1 / error[known]
    design = np.stack([np.ones_like(x), x], axis=1) * weight[:, None]
    inverse = np.linalg.inv(design.T @ design)
    intercept, slope = inverse @ design.T @ (y * weight)
    scatter = float(np.sum(((y - intercept - slope * x) * weight) ** 2) / (len(x) - 2))
    errors = np.sqrt(np.diag(inverse) * max(1.0, scatter))
    return Line(float(slope), float(errors[1]), float(intercept), float(errors[0]), scatter)
