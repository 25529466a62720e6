"""Optima of a damping curve over Gamma."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import UsageError
from ..numerics.regression import Maximum, packings_left_out, widened
from ..scene.scene import STANDARD_GRAVITY
from .results import over_packings

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Peak:
    """Maximum of a curve over Gamma: its place, its height, and the standard error of the height."""

    gamma: float
    height: float
    standard_error: float


def peaks(gamma, height, standard_error) -> list[Peak]:
    """Maxima of a noisy curve that stand out of the dips beside them by more than two standard errors, by rising Gamma.

    A curve without any has one, its largest point; points that are not finite are left out.

    Parameters
    ----------
    gamma, height, standard_error : (n,) arrays
        Amplitudes [-], the curve there and its standard errors, in any order.

    Returns
    -------
    list of Peak

    Examples
    --------
    >>> from warpdamp import peaks
    >>> peaks([1, 2, 3, 4], [0.1, 0.5, 0.3, 0.4], [0.01, 0.01, 0.01, 0.1])
    [Peak(gamma=2.0, height=0.5, standard_error=0.01)]
    """
    from scipy.signal import find_peaks

    order = np.argsort(np.asarray(gamma, float))
    gamma, height, standard_error = (np.asarray(a, float)[order] for a in (gamma, height, standard_error))
    known = np.isfinite(height)
    if not known.any():
        return []
    gamma, height, standard_error = gamma[known], height[known], standard_error[known]
    low = height.min() - 1.0
    tops, traits = find_peaks(np.concatenate([[low], height, [low]]), prominence=0)
    tops -= 1
    bases = np.minimum(traits["prominences"], height[tops] - height.min())
    prominent = [k for k, prominence in zip(tops, bases, strict=True) if prominence > 2 * standard_error[k]]
    prominent = prominent or [int(np.argmax(height))]
    return [Peak(float(gamma[k]), float(height[k]), float(standard_error[k])) for k in prominent]


BLOCK_FLUIDISATION = 2.58
"""Gamma at which a plastic block that does not meet the lid, under gravity along the axis, dissipates most."""

BLOCK_INTERCEPT = 1.08
"""Increase of the Gamma of eq. 1 by gravity along the axis (fit to the plastic block between floor and lid)."""


def collision_optimum(frequency, clearance, *, gravity: bool = True):
    """Gamma of two-sided collision of a plastic block, 4 pi f^2 h / g (eq. 1) [-].

    Parameters
    ----------
    frequency : float or array
        f [Hz].
    clearance : float or array
        h [m].
    gravity : bool
        Whether gravity acts along the axis; then ``BLOCK_INTERCEPT`` is added.

    Returns
    -------
    float or array
        Broadcast against each other.

    References
    ----------
    Terzioglu & Rongong, Selection of granular damper parameters to achieve optimum vibration attenuation on vibrating
    structures, eq. 1.
    """
    return 4 * np.pi * np.asarray(frequency) ** 2 * clearance / STANDARD_GRAVITY + (BLOCK_INTERCEPT if gravity else 0.0)


MOTIONS = ("fluidisation", "collision")

MOST_BELOW, MOST_ABOVE = {"fluidisation": 10.0, "collision": 3.0}, 3.0
"""A maximum further below, or above, the Gamma expected of a motion than these factors is not called that motion's.
A bed that is deep or soft for its frequency resounds, and fluidises far below a block (docs/parameters.md)."""


class Curves:
    """Curves of a variable over Gamma, packing by packing.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results with the dimension ``gamma``.
    of : str
        Variable with a ``_standard_error``.

    Raises
    ------
    ValueError
        If Gamma is not a dimension, or there is no such variable with its standard error.
    """

    def __init__(self, dataset: xr.Dataset, of: str = "effectiveness"):
        if lacking := [name for name in (of, f"{of}_standard_error") if name not in dataset]:
            raise UsageError(f"an optimum needs a curve and its errors: there is no {' and no '.join(lacking)}")
        if "gamma" not in dataset[of].dims:
            raise UsageError("an optimum needs a curve: gamma is not a dimension of this Dataset")
        self.dataset = dataset
        self.value, self.error = _of_packings(dataset, of)
        given = dataset[of], dataset[f"{of}_standard_error"]
        self.mean, self.claimed = given if of == "damping_ratio" else over_packings(dataset, of)
        self.dims = [dim for dim in self.value.dims if dim not in ("gamma", "seed")]
        self.gamma = dataset["gamma"].values
        self.packings = self.value.sizes.get("seed", 1)

    def optima(self, at: dict[str, int]) -> dict[str, Maximum | str]:
        """Maxima of the curve at an index along ``dims``, by the motion that they belong to, or why there is none."""
        if "damper" in self.dataset.dims:
            return dict.fromkeys(MOTIONS, "several dampers, each with its own")
        found = self.left_out(at)
        mean = _by_gamma_and_seed(self.mean.isel(at))[:, 0]
        return {
            which: found[which][0] if which in found else _why_none(which, self._expected(at), self.gamma, mean)
            for which in MOTIONS
        }

    def left_out(self, at: dict[str, int]) -> dict[str, tuple[Maximum, list[Maximum | None]]]:
        """Maxima at an index along ``dims``, by motion; each with the same of the curves without one packing."""
        value, error = (_by_gamma_and_seed(array.isel(at)) for array in (self.value, self.error))
        claimed = _by_gamma_and_seed(self.claimed.isel(at))[:, 0]
        found = packings_left_out(self.gamma, value, error)
        tops = {self._as_claimed(widened(top, without), claimed): without for top, without in found}
        return {which: (top, tops[top]) for which, top in _called(list(tops), self._expected(at)).items()}

    def _as_claimed(self, top: Maximum, claimed: np.ndarray) -> Maximum:
        """A maximum whose height is known no better than the points near it are claimed to be."""
        known = np.isfinite(claimed)
        if not known.any():
            return top
        order = np.argsort(self.gamma[known])
        near = float(np.interp(top.gamma, self.gamma[known][order], claimed[known][order]))
        return replace(top, height_standard_error=max(top.height_standard_error, near))

    def _expected(self, at: dict[str, int]) -> dict[str, float]:
        """Gamma at which a plastic block has each maximum; none of what clearance or gravity is needed for."""
        weight = self._weight(at)
        expected = {"fluidisation": weight * BLOCK_FLUIDISATION} if weight else {}
        if "clearance" not in self.dataset:
            return expected
        clearance = self.dataset["clearance"]
        here = {"frequency" if dim == "mode" else dim: k for dim, k in at.items()}
        clearance = float(clearance.isel({dim: k for dim, k in here.items() if dim in clearance.dims}).mean())
        frequency = _frequency(self.dataset, at)
        if math.isfinite(clearance) and math.isfinite(frequency):
            flight = float(collision_optimum(frequency, clearance, gravity=False))
            expected["collision"] = flight + weight * BLOCK_INTERCEPT
        return expected

    def _weight(self, at: dict[str, int]) -> float:
        """Gravity of a curve over the earth's, where it was swept."""
        if "gravity" not in self.dataset.coords:
            return 1.0
        gravity = self.dataset["gravity"]
        return float(gravity.isel({dim: k for dim, k in at.items() if dim in gravity.dims})) / STANDARD_GRAVITY


def _by_gamma_and_seed(array: xr.DataArray) -> np.ndarray:
    array = array if "seed" in array.dims else array.expand_dims("seed")
    return array.transpose("gamma", "seed").values


def _of_packings(dataset: xr.Dataset, of: str) -> tuple[xr.DataArray, xr.DataArray]:
    """A variable and its standard error; a damping ratio, which is one of all packings, packing by packing."""
    value, error = dataset[of], dataset[f"{of}_standard_error"]
    if of != "damping_ratio" or "energy_dissipated" not in dataset:
        return value, error

    def of_mode(name: str) -> xr.DataArray:
        array = dataset[name].drop_vars("frequency", errors="ignore").rename(frequency="mode")
        return array.assign_coords(mode=dataset["mode"])

    per_joule = (value - dataset["inherent_damping"]) / of_mode("energy_mean")
    packings = dataset["inherent_damping"] + per_joule * of_mode("energy_dissipated")
    return packings, per_joule * of_mode("energy_dissipated_standard_error")


def optimum(dataset: xr.Dataset, of: str = "effectiveness") -> xr.Dataset:
    """Gamma of fluidisation and of two-sided collision, with standard errors, for every curve of a Dataset.

    A maximum is assigned to the nearer, in ratio, of what a plastic block predicts: 2.58, and eq. 1 with the clearance
    measured, both with the gravity that was swept; of two, the lower is that of fluidisation.  None is called after a
    motion if it lies above three times the Gamma expected, or below a third (of collision) or a tenth (of fluidisation,
    which beds that resound reach far below a block).  Standard errors hold for other packings too, as far as those
    that were run differ from each other.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results with the dimension ``gamma``.
    of : str
        Variable with a ``_standard_error``.

    Returns
    -------
    xarray.Dataset
        ``gamma_fluidisation``, ``gamma_collision``, the heights there and standard errors, on the dimensions of ``of``
        without ``gamma`` and ``seed``; NaN where there is none.

    Raises
    ------
    ValueError
        If Gamma is not a dimension, there is no such variable with its standard error, or the results are of several
        dampers, each of which has a Gamma of its own.
    """
    import xarray as xr

    if "damper" in dataset.dims:
        raise ValueError("results of several dampers: an optimum is of one, as `warpdamp collect` gives each")
    curves = Curves(dataset, of)
    columns = {"gamma": "gamma", of: "height"}
    names = [f"{what}_{which}{s}" for which in MOTIONS for what in columns for s in ("", "_standard_error")]
    shape = tuple(curves.value.sizes[dim] for dim in curves.dims)
    table = {name: np.full(shape, np.nan) for name in names}
    for index in np.ndindex(shape):
        for which, top in curves.optima(dict(zip(curves.dims, index, strict=True))).items():
            for what, attribute in columns.items() if isinstance(top, Maximum) else ():
                for s in ("", "_standard_error"):
                    table[f"{what}_{which}{s}"][index] = getattr(top, f"{attribute}{s}")
    coords = {name: c for name, c in dataset.coords.items() if set(c.dims) <= set(curves.dims)}
    result = xr.Dataset({name: (curves.dims, values) for name, values in table.items()}, coords)
    for name in result.data_vars:
        result[name].attrs.update(units="1", long_name=name.replace("_", " "))
    return result


def _frequency(dataset, at) -> float:
    name = (
        "natural_frequency"
        if "mode" in at
        else "excitation_frequency"
        if "excitation_frequency" in dataset
        else "frequency"
    )
    frequency = dataset[name]
    return float(frequency.isel({dim: k for dim, k in at.items() if dim in frequency.dims}).mean())


def _called(tops: list[Maximum], expected: dict[str, float]) -> dict[str, Maximum]:
    """Maxima by the motion that they belong to."""

    def miss(which, top):
        return abs(math.log(top.gamma / expected[which]))

    def plausible(which, top):
        if which not in expected:
            return False
        return -math.log(MOST_BELOW[which]) <= math.log(top.gamma / expected[which]) <= math.log(MOST_ABOVE)

    pairs = [
        (low, high)
        for low, high in itertools.combinations(tops, 2)
        if plausible("fluidisation", low) and plausible("collision", high)
    ]
    if pairs:
        low, high = min(pairs, key=lambda pair: miss("fluidisation", pair[0]) + miss("collision", pair[1]))
        return {"fluidisation": low, "collision": high}
    for top in sorted(tops, key=lambda top: -top.height) if expected else ():
        which = min(expected, key=lambda which: miss(which, top))
        if plausible(which, top):
            return {which: top}
    return {}


def _why_none(which: str, expected: dict[str, float], gamma: np.ndarray, mean: np.ndarray) -> str:
    """Why a curve has no maximum of a motion."""
    known = np.isfinite(mean)
    if len(np.unique(gamma[known])) < 4:
        return "fewer than four amplitudes"
    low, high = float(gamma[known].min()), float(gamma[known].max())
    if which not in expected:
        return "no clearance between floor and lid" if which == "collision" else "no gravity"
    if not low <= expected[which] <= high:
        return f"expected at Γ {expected[which]:.3g}, not among those run"
    largest = float(gamma[known][np.argmax(mean[known])])
    if largest == (low if which == "fluidisation" else high):
        way = "falls from" if largest == low else "still rises at"
        return f"the curve {way} Γ {largest:g}, the edge of what was run"
    return "no maximum stands out"
