"""Calculator of the damping that a damper gives to any mode, from its results; a report's page computes the same."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.results import over_packings
from ..errors import UsageError
from ..modal.apparent_mass import ROUNDING
from ..modal.damping import damping_of_effectiveness

if TYPE_CHECKING:
    import xarray as xr

NORMAL = 1.96
"""Half-width of a 95 % interval over the standard error where results hold no interval of their own."""


@dataclass(frozen=True)
class Calculator:
    """Effectiveness of a damper over frequency and Gamma, and what follows for a mode.

    Parameters
    ----------
    frequency, gamma : (f,), (g,) arrays
        Ascending [Hz], [-].
    effectiveness, half_width : (f, g) arrays
        Mean over packings, and half-width of its 95 % interval [-].
    """

    frequency: np.ndarray
    gamma: np.ndarray
    effectiveness: np.ndarray
    half_width: np.ndarray

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Calculator:
        """Calculator of results in which nothing but frequency, Gamma and seed is varied.

        Raises
        ------
        UsageError
            If something else is, or frequency or Gamma is no dimension.
        """
        value, half = interval_of(dataset, "effectiveness")
        if set(value.dims) != {"frequency", "gamma"}:
            raise UsageError(
                "a calculator is of results over frequency and gamma: these are over " + ", ".join(map(str, value.dims))
            )
        value, half = (a.sortby(["frequency", "gamma"]).transpose("frequency", "gamma") for a in (value, half))
        return cls(value["frequency"].values, value["gamma"].values, value.values, half.values)

    def damping(self, mass: float, amplitude: float, frequency: float, gamma: float) -> tuple[float, float]:
        """Damping ratio zeta = (2 / pi) eps m phi^2 of a mode, and the half-width of its 95 % interval [-].

        Between what was run the effectiveness and the square of its half-width are linear in frequency and in Gamma;
        beyond it both are not a number.

        Parameters
        ----------
        mass : m, of all particles [kg]
        amplitude : phi, mass-normalised mode shape at the damper [kg^-0.5]
        frequency : of the mode [Hz]
        gamma : acceleration amplitude over g [-]
        """
        weights = [
            (i, j, u * v) for i, u in _weights(self.frequency, frequency) for j, v in _weights(self.gamma, gamma)
        ]
        if not weights:
            return math.nan, math.nan
        value = sum(w * float(self.effectiveness[i, j]) for i, j, w in weights)
        variance = sum(w * float(self.half_width[i, j]) ** 2 for i, j, w in weights)
        pair = (damping_of_effectiveness(x, mass, amplitude) for x in (value, math.sqrt(variance)))
        return tuple(map(float, pair))


def _weights(grid: np.ndarray, value: float) -> list[tuple[int, float]]:
    """Places in an ascending grid and their weights, none of them 0; empty outside the grid."""
    low, high = float(grid[0]), float(grid[-1])
    if not low * (1 - ROUNDING) <= value <= high * (1 + ROUNDING):
        return []
    value = min(max(value, low), high)
    k = max(0, min(len(grid) - 2, int(np.searchsorted(grid, value, side="right")) - 1))
    if len(grid) == 1:
        return [(0, 1.0)]
    part = (value - float(grid[k])) / (float(grid[k + 1]) - float(grid[k]))
    return [(place, weight) for place, weight in ((k, 1 - part), (k + 1, part)) if weight != 0]


def interval_of(dataset: xr.Dataset, name: str) -> tuple[xr.DataArray, xr.DataArray]:
    """Mean over packings of a variable, and the half-width of its 95 % interval.

    That of the energy, the effectiveness and the damping ratio is in proportion to ``energy_mean_interval``; where the
    results have none, and of other variables, it is ``NORMAL`` standard errors.
    """
    if name in ("damping_ratio", "energy_mean"):
        value, error = dataset[name], dataset[f"{name}_standard_error"]
    else:
        value, error = over_packings(dataset, name)
    claims = name in ("damping_ratio", "energy_mean", "effectiveness", "energy_dissipated")
    if not claims or "energy_mean_interval" not in dataset:
        return value, NORMAL * error
    wider = dataset["energy_mean_interval"] / dataset["energy_mean_standard_error"]
    if "mode" in value.dims:
        wider = wider.drop_vars("frequency", errors="ignore").rename(frequency="mode").assign_coords(mode=value["mode"])
    return value, (error * wider).transpose(*value.dims)
