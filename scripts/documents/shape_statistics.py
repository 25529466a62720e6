"""Statistics of shapes of particles for ``sphericity``: trends over the aspect, and what the clearance explains."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.stats import f_oneway, t
from shared import mean_and_error

from warpdamp.analysis.optimum import collision_optimum
from warpdamp.numerics.regression import Line, straight_line


def interval(values: xr.DataArray) -> xr.DataArray:
    """Half the width of the 95 % interval of the mean over packings."""
    n = values.notnull().sum("seed")
    spread = t.ppf(0.975, np.maximum(n - 1, 1)) * values.std("seed", ddof=1) / np.sqrt(n)
    return spread.where(n > 1)


def clearances(results: xr.Dataset, aspect: float, name: str = "clearance") -> tuple[float, float]:
    """Mean over packings, and its standard error [m]."""
    return mean_and_error(results[name].sel(aspect=aspect, mode=1).mean("gamma"))


@dataclass(frozen=True)
class Trend:
    """Straight line of a quantity over |ln aspect|, and whether it is level."""

    line: Line
    points: int

    @property
    def p(self) -> float:
        """Probability of such a slope, or a steeper one, if there is no trend."""
        return float(2 * t.sf(abs(self.line.slope / self.line.slope_standard_error), self.points - 2))

    def __str__(self):
        return f"{self.line.slope:+.3g} ± {self.line.slope_standard_error:.2g} (p = {self.p:.2g})"


def trend(aspects, values, errors) -> Trend | None:
    """Trend over |ln aspect|; None of fewer than three points."""
    values, errors = np.asarray(values, float), np.asarray(errors, float)
    known = np.isfinite(values) & np.isfinite(errors)
    if known.sum() < 3:
        return None
    return Trend(straight_line(np.abs(np.log(aspects)), values, errors), int(known.sum()))


@dataclass(frozen=True)
class Collision:
    """Gamma of collision of a shape, and that of a plastic block with its clearance, each with its standard error."""

    aspect: float
    gamma: float
    gamma_error: float
    block: float
    block_error: float

    @property
    def over_block(self) -> tuple[float, float]:
        """Gamma of collision over that of the block, and its standard error."""
        ratio = self.gamma / self.block
        return ratio, ratio * math.hypot(self.gamma_error / self.gamma, self.block_error / self.block)

    def rise(self, sphere: Collision) -> tuple[float, float]:
        """Rise of Gamma over that of spheres, and its standard error."""
        return self.gamma - sphere.gamma, math.hypot(self.gamma_error, sphere.gamma_error)

    def explained(self, sphere: Collision) -> tuple[float, float]:
        """Part of the rise that the clearance explains, if shapes collide as far above their block as spheres do."""
        factor = sphere.gamma / sphere.block
        return factor * (self.block - sphere.block), factor * math.hypot(self.block_error, sphere.block_error)

    def left(self, sphere: Collision) -> tuple[float, float]:
        """Part of the rise that the clearance does not explain, and its standard error."""
        (rise, error), (explained, spread) = self.rise(sphere), self.explained(sphere)
        return rise - explained, math.hypot(error, spread)


def collisions(results: xr.Dataset, found: xr.Dataset) -> dict[float, Collision]:
    """Collisions of mode 1 by aspect, from results with a ``clearance`` and their optima ``found``."""
    frequency = float(results["natural_frequency"].sel(mode=1))
    per_metre = float(collision_optimum(frequency, 1.0, gravity=False))
    own = {}
    for aspect in results["aspect"].values.tolist():
        at, (height, error) = found.sel(mode=1, aspect=aspect), clearances(results, aspect)
        gamma = (float(at[f"gamma_collision{s}"]) for s in ("", "_standard_error"))
        own[aspect] = Collision(aspect, *gamma, float(collision_optimum(frequency, height)), per_metre * error)
    return own


def shared_part(own: dict[float, Collision]) -> tuple[float, float]:
    """Share of the rises of all shapes together that the clearance explains, and its standard error.

    Spheres are in every rise, and their error with it.
    """
    sphere = own[1.0]
    others = [shape for shape in own.values() if shape is not sphere and math.isfinite(shape.gamma)]
    rise, explained = (sum(getattr(shape, name)(sphere)[0] for shape in others) for name in ("rise", "explained"))

    def error(name: str) -> float:
        return math.hypot(len(others) * getattr(sphere, name), *(getattr(shape, name) for shape in others))

    share = explained / rise
    spread = sphere.gamma / sphere.block * error("block_error") / explained
    return share, abs(share) * math.hypot(error("gamma_error") / rise, spread)


@dataclass(frozen=True)
class Band:
    """Mean effectiveness over a band of amplitudes, packing by packing, of every shape."""

    mode: int
    values: dict[float, np.ndarray]

    @property
    def p(self) -> float:
        """Probability of such differences of the shapes' means if there are none (one-way analysis of variance)."""
        return float(f_oneway(*self.values.values()).pvalue)

    @property
    def trend(self) -> Trend:
        """Trend over |ln aspect|."""
        pairs = [mean_and_error(own) for own in self.values.values()]
        return trend(list(self.values), *zip(*pairs, strict=True))

    @property
    def differences(self) -> dict[float, float]:
        """Mean of every shape over that of spheres, less 1."""
        sphere = self.values[1.0].mean()
        return {aspect: float(own.mean() / sphere - 1) for aspect, own in self.values.items()}


def bands(results: xr.Dataset, amplitudes: dict[int, tuple[float, float]]) -> list[Band]:
    """Band of every mode, between its lowest and its highest amplitude."""
    own = []
    for mode, (low, high) in amplitudes.items():
        means = results["effectiveness"].sel(mode=mode, gamma=slice(low, high)).mean("gamma")
        values = {a: means.sel(aspect=a).dropna("seed").values for a in results["aspect"].values.tolist()}
        own.append(Band(mode, values))
    return own
