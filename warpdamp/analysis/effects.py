"""Effect of a factor on both optima of a damping curve: how much, in which direction, and how surely.

Every packing is run at every level of the factor, so that differences between levels are paired.  Packings are left out
one at a time, of all levels at once (the jackknife: Efron & Stein 1981, doi:10.1214/aos/1176345462); what an effect
scatters by then is its standard error, and its interval is Student's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from ..errors import UsageError
from .optimum import MOTIONS, Curves

if TYPE_CHECKING:
    import xarray as xr

RESPONSES = tuple(f"{what}_{which}" for which in MOTIONS for what in ("gamma", "effectiveness"))
"""Places and heights of both optima, in the order of the paper's Table 1."""

SURE = 3.0
"""Standard errors from none at which an effect is called one."""

SAME = 0.05
"""Relative change over the whole range of a factor within which a response counts as not affected."""

DOUBLING, STEP = "doubling", "step"


class Verdict(StrEnum):
    """What a factor does to a response, in the words of the paper's Table 1."""

    HIGHER = "higher"
    LOWER = "lower"
    NOT_MONOTONIC = "not monotonic"
    NOT_AFFECTED = "not affected"
    NONE = "does not exist"
    UNDECIDED = "undecided"


def effect_of(dataset: xr.Dataset, factor: str, *, step: float | None = None) -> xr.Dataset:
    """Effect of a swept scalar on both optima and on the curve, relative, by doubling or by a step.

    A straight line is laid through the logarithm of a response over the logarithm of the factor (over the factor itself
    where a level is zero, or a step is given), levels weighted by their own errors.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results with the dimensions ``gamma`` and ``seed``, the same seeds at every level.
    factor : str
        The scalar's key, as ``contact.friction``, or its coordinate's name.
    step : float, optional
        Change of the factor that an effect is stated for, in its unit (default: a doubling; where a level is zero or
        negative, all of the range).

    Returns
    -------
    xarray.Dataset
        On (response, ...): ``effect`` by doubling or step and ``effect_low``, ``effect_high`` [-], the same of
        ``change`` over the range of the levels that have it, ``exponent`` d log(response) / d log(factor) and its
        ``_standard_error``, ``paired_standard_error`` and ``unpaired_standard_error`` of the logarithm by doubling or
        step, ``p_value``, ``p_holm`` (Holm's, over all that is returned), ``p_monotony``, ``p_straight``, ``verdict``,
        ``packings_needed`` to decide what is undecided.  On the factor, too: ``level``, ``level_standard_error``.
        On (gamma, ...): ``curve_effect`` by doubling or step, its ``_low`` and ``_high``.  Attributes: ``factor``,
        ``per`` and ``packings``.

    Raises
    ------
    UsageError
        If there is no such factor, it has one level, or there are fewer than three packings.
    """
    import xarray as xr

    name = _coordinate(dataset, factor)
    (dim,) = dataset[name].dims
    dataset = dataset.sortby(name)
    levels = np.asarray(dataset[name].values, float)
    scale = _scale(levels, step)
    curves = Curves(dataset)
    packings = curves.packings
    if len(levels) < 2 or packings < 3:
        raise UsageError(f"an effect needs two levels and three packings, got {len(levels)} and {packings}")
    others = [d for d in curves.dims if d != dim]
    shape = tuple(curves.value.sizes[d] for d in others)
    lines = np.empty((len(RESPONSES), *shape), object)
    level, error = (np.full((len(RESPONSES), len(levels), *shape), np.nan) for _ in range(2))
    for index in np.ndindex(shape):
        at = dict(zip(others, index, strict=True))
        values, errors, without = _responses(curves, [at | {dim: k} for k in range(len(levels))])
        for r in range(len(RESPONSES)):
            level[(r, slice(None), *index)], error[(r, slice(None), *index)] = values[r], errors[r]
            lines[(r, *index)] = _line(scale.x, values[r], errors[r], without[r], packings)
    table = _table(lines, scale)
    dims = ("response", *others)
    coords = {d: dataset[d] for d in others if d in dataset.coords} | {"response": list(RESPONSES), name: dataset[name]}
    result = xr.Dataset({key: (dims, values) for key, values in table.items()}, coords)
    result["level"] = (("response", dim, *others), level)
    result["level_standard_error"] = (("response", dim, *others), error)
    result = result.merge(_curve(dataset, dim, scale), compat="no_conflicts")
    return result.assign_attrs(factor=name, per=scale.words(dataset[name].attrs.get("units", "1")), packings=packings)


@dataclass(frozen=True)
class Scale:
    """How a factor is measured: x of its levels, of which one unit is what an effect is stated for."""

    x: np.ndarray
    step: float | None

    def words(self, unit: str) -> str:
        """What an effect is stated for."""
        return DOUBLING if self.step is None else f"{STEP} of {self.step:.3g}{'' if unit == '1' else ' ' + unit}"


def _scale(levels: np.ndarray, step: float | None) -> Scale:
    if step is None and levels.min() > 0:
        return Scale(np.log2(levels), None)
    step = float(np.ptp(levels)) if step is None else step
    return Scale(levels / step, step)


@dataclass(frozen=True)
class Fit:
    """Straight line through the logarithm of a response, and what is known of it."""

    slope: float
    paired: float
    unpaired: float
    p_value: float
    p_monotony: float
    p_straight: float
    outlying: bool
    degrees: int
    span: float
    """Range of the levels that have the response, in units of x."""


def _line(x, values, errors, without, packings: int) -> Fit | None:
    """Line through the levels that have the response; None if fewer than two have."""
    from scipy.stats import t

    known = np.isfinite(values)
    if known.sum() < 2:
        return None
    x, y, spread = x[known], np.log(values[known]), errors[known] / values[known]
    deviations = _deviations(np.log(without[known]), y, packings)
    weight = 1 / np.maximum(spread, 0.005) ** 2
    degrees = packings - 1

    def error(contrast) -> float:
        return float(np.sqrt((packings - 1) / packings * np.sum((contrast @ deviations) ** 2)))

    def p_of(contrast, *, sides: int = 2) -> float:
        value, own = float(contrast @ y), max(error(contrast), 1e-12)
        return float(sides * t.sf(abs(value) / own, degrees)) if sides == 2 or value < 0 else 1.0

    slope = _contrast(x, weight, 1)
    b = float(slope @ y)
    steps = np.diff(np.eye(len(y)), axis=0) * (1 if b >= 0 else -1)
    monotony = min(1.0, len(steps) * min(p_of(one, sides=1) for one in steps))
    straight = p_of(_contrast(x, weight, 2)) if len(y) > 2 else math.nan
    from_first = np.eye(len(y))[1:] - np.eye(len(y))[0]
    smallest = min(p_of(one) for one in from_first)
    return Fit(
        slope=b,
        paired=error(slope),
        unpaired=float(np.sqrt(np.sum((slope * spread) ** 2))),
        p_value=p_of(slope),
        p_monotony=monotony,
        p_straight=straight,
        outlying=len(from_first) * smallest < 0.05,
        degrees=degrees,
        span=float(np.ptp(x)),
    )


def _contrast(x, weight, power: int) -> np.ndarray:
    """Weights of the levels in the highest coefficient of a weighted fit by a polynomial."""
    design = np.vander(x - np.average(x, weights=weight), power + 1, increasing=True)
    return (np.linalg.pinv(design * np.sqrt(weight)[:, None]) * np.sqrt(weight))[-1]


def _deviations(without, y, packings: int) -> np.ndarray:
    """How far each level lies off without each packing; levels with fewer packings move by as much as theirs do."""
    found = np.isfinite(without)
    own = found.sum(axis=1)
    mean = np.where(own > 0, np.nansum(np.where(found, without, 0), axis=1) / np.maximum(own, 1), y)
    factor = np.sqrt((own - 1).clip(0) / np.maximum(own, 1) * packings / (packings - 1))
    return factor[:, None] * np.where(found, without - mean[:, None], 0.0)


def _responses(curves: Curves, places: list[dict[str, int]]):
    """Responses of every level, their own errors, and the same without each packing; NaN where there is none."""
    shape = (len(RESPONSES), len(places))
    values, errors = np.full(shape, np.nan), np.full(shape, np.nan)
    without = np.full((*shape, curves.packings), np.nan)
    for k, at in enumerate(places):
        for which, (top, others) in curves.left_out(at).items():
            for what, attribute in (("gamma", "gamma"), ("effectiveness", "height")):
                r = RESPONSES.index(f"{what}_{which}")
                values[r, k], errors[r, k] = getattr(top, attribute), getattr(top, f"{attribute}_standard_error")
                own = [math.nan if other is None else getattr(other, attribute) for other in others]
                without[r, k, : len(own)] = own
    return values, errors, without


def _table(lines: np.ndarray, scale: Scale) -> dict[str, np.ndarray]:
    """Columns of the answer, of all fits together: Holm's correction is over all of them."""
    from scipy.stats import t

    flat = lines.ravel()
    adjusted = holm([fit.p_value if fit else math.nan for fit in flat])
    rows = []
    for fit, p_holm in zip(flat, adjusted, strict=True):
        if fit is None:
            rows.append({"verdict": str(Verdict.NONE), "packings_needed": math.nan})
            continue
        width = float(t.ppf(0.975, fit.degrees)) * fit.paired
        ends = {"": 0.0, "_low": -width, "_high": width}
        row = {f"effect{key}": math.expm1(fit.slope + end) for key, end in ends.items()}
        row |= {f"change{key}": math.expm1(fit.span * (fit.slope + end)) for key, end in ends.items()}
        verdict, needed = decide(fit, width)
        row |= {"paired_standard_error": fit.paired, "unpaired_standard_error": fit.unpaired, "p_holm": p_holm}
        row |= {name: getattr(fit, name) for name in ("p_value", "p_monotony", "p_straight")}
        if scale.step is None:
            row |= {"exponent": fit.slope / math.log(2), "exponent_standard_error": fit.paired / math.log(2)}
        rows.append(row | {"verdict": str(verdict), "packings_needed": needed})
    names = dict.fromkeys(name for row in rows for name in row)
    table = {name: np.array([row.get(name, math.nan) for row in rows]) for name in names}
    return {name: values.reshape(lines.shape) for name, values in table.items()}


def decide(fit: Fit, width: float) -> tuple[Verdict, float]:
    """Verdict of a fit, and the packings that would decide it (not a number where it is decided).

    Parameters
    ----------
    fit : Fit
    width : float
        Half-width of the slope's 95 % interval.
    """
    if abs(fit.slope) >= max(SURE * fit.paired, width):
        return (Verdict.HIGHER if fit.slope > 0 else Verdict.LOWER), math.nan
    if fit.outlying:
        return Verdict.NOT_MONOTONIC, math.nan
    change, half = abs(fit.slope) * fit.span, width * fit.span
    if change + half <= math.log1p(SAME):
        return Verdict.NOT_AFFECTED, math.nan
    factors = [(max(SURE * fit.paired, width) / abs(fit.slope)) ** 2] if fit.slope else []
    if change < math.log1p(SAME):
        factors.append((half / (math.log1p(SAME) - change)) ** 2)
    return Verdict.UNDECIDED, float(math.ceil((fit.degrees + 1) * min(factors)))


def holm(p) -> np.ndarray:
    """P-values adjusted for that many tests by Holm's step-down rule (1979, Scand. J. Statist. 6, 65); NaN stay.

    Parameters
    ----------
    p : (n,) array

    Returns
    -------
    (n,) array
    """
    p = np.asarray(p, float)
    known = np.flatnonzero(np.isfinite(p))
    order = known[np.argsort(p[known])]
    stepped = np.maximum.accumulate(p[order] * np.arange(len(order), 0, -1))
    adjusted = np.full(len(p), np.nan)
    adjusted[order] = np.minimum(stepped, 1.0)
    return adjusted


SMALLEST = 0.01
"""Effectiveness below which a bed is at rest, and no effect on it is stated."""


def _curve(dataset: xr.Dataset, dim: str, scale: Scale) -> xr.Dataset:
    """Effect on the effectiveness at each Gamma, packing by packing, of the levels at which all of them were run."""
    import xarray as xr
    from scipy.stats import t

    eps = dataset["effectiveness"]
    logs = np.log(eps.where(eps.mean("seed") > SMALLEST)).transpose(..., "seed", dim)
    everywhere = np.isfinite(logs.values).all(axis=-2, keepdims=True)
    count = everywhere.sum(axis=-1, keepdims=True)
    x = np.where(everywhere, scale.x - (everywhere * scale.x).sum(axis=-1, keepdims=True) / np.maximum(count, 1), 0.0)
    square = np.where(count > 1, (x**2).sum(axis=-1, keepdims=True), np.nan)
    slope = np.sum(x / square * np.where(everywhere, logs.values, 0.0), axis=-1)
    n = slope.shape[-1]
    mean, error = slope.mean(axis=-1), slope.std(axis=-1, ddof=1) / math.sqrt(n)
    width = float(t.ppf(0.975, n - 1)) * error
    dims = [d for d in logs.dims if d not in ("seed", dim)]
    ends = {"curve_effect": mean, "curve_effect_low": mean - width, "curve_effect_high": mean + width}
    coords = {d: dataset[d] for d in dims if d in dataset.coords}
    return xr.Dataset({name: (dims, np.expm1(values)) for name, values in ends.items()}, coords)


def _coordinate(dataset: xr.Dataset, factor: str) -> str:
    """Name of the coordinate of a factor, by its key or its name."""
    keys = {
        str(name): str(c.attrs.get("configuration_key", ""))
        for name, c in dataset.coords.items()
        if c.ndim == 1 and name not in ("gamma", "seed") and np.issubdtype(c.dtype, np.number)
    }
    found = [name for name, key in keys.items() if factor in (name, key) or key.endswith(f".{factor}")]
    if len(found) != 1:
        known = ", ".join(sorted(key or name for name, key in keys.items()))
        raise UsageError(f"'{factor}' is not one factor of these results: take one of {known or 'none'}")
    return found[0]
