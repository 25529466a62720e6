"""Optima of a damping curve over Gamma."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..numerics.regression import Maximum, maxima
from ..scene.scene import STANDARD_GRAVITY

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


def optimum(dataset: xr.Dataset, of: str = "effectiveness") -> xr.Dataset:
    """Gamma of fluidisation and of two-sided collision, with standard errors, for every curve of a Dataset.

    A maximum is assigned to the nearer, in ratio, of what a plastic block predicts: 2.58, and eq. 1 with the clearance
    measured; of two, the lower is that of fluidisation.

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
        If Gamma is not a dimension, or the results are of several dampers, each of which has a Gamma of its own.
    """
    import xarray as xr

    if "damper" in dataset.dims:
        raise ValueError("results of several dampers: an optimum is of one, as `warpdamp collect` gives each")
    value, error = dataset[of], dataset[f"{of}_standard_error"]
    if "gamma" not in value.dims:
        raise ValueError("an optimum needs a curve: gamma is not a dimension of this Dataset")
    inner = [dim for dim in ("gamma", "seed") if dim in value.dims]
    outer = [dim for dim in value.dims if dim not in inner]
    clearance = dataset["clearance"].mean([dim for dim in dataset["clearance"].dims if dim not in outer])
    names = [
        f"{what}_{which}{s}"
        for which in ("fluidisation", "collision")
        for what in ("gamma", of)
        for s in ("", "_standard_error")
    ]
    shape = tuple(value.sizes[dim] for dim in outer)
    table = {name: np.full(shape, np.nan) for name in names}
    for index in np.ndindex(shape):
        at = dict(zip(outer, index, strict=True))
        curve, noise = value.isel(at).transpose(*inner), error.isel(at).transpose(*inner)
        gammas = np.broadcast_to(dataset["gamma"].values.reshape(-1, *[1] * (curve.ndim - 1)), curve.shape)
        frequency = _frequency(dataset, at)
        free_travel = clearance.isel({dim: k for dim, k in at.items() if dim in clearance.dims})
        for which, top in _called(maxima(gammas, curve.values, noise.values), frequency, float(free_travel)).items():
            table[f"gamma_{which}"][index] = top.gamma
            table[f"gamma_{which}_standard_error"][index] = top.gamma_standard_error
            table[f"{of}_{which}"][index] = top.height
            table[f"{of}_{which}_standard_error"][index] = top.height_standard_error
    coords = {name: c for name, c in dataset.coords.items() if set(c.dims) <= set(outer)}
    result = xr.Dataset({name: (outer, values) for name, values in table.items()}, coords)
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


def _called(tops: list[Maximum], frequency: float, clearance: float) -> dict[str, Maximum]:
    """Maxima by the motion that they belong to."""
    expected = {"fluidisation": BLOCK_FLUIDISATION}
    if math.isfinite(clearance) and math.isfinite(frequency):
        expected["collision"] = float(collision_optimum(frequency, clearance))

    def miss(which, top):
        return abs(math.log(top.gamma / expected[which]))

    if len(tops) > 1 and "collision" in expected:
        pairs = [(a, b) for i, a in enumerate(tops) for b in tops[i + 1 :]]
        low, high = min(pairs, key=lambda pair: miss("fluidisation", pair[0]) + miss("collision", pair[1]))
        return {"fluidisation": low, "collision": high}
    if not tops:
        return {}
    top = max(tops, key=lambda top: top.height)
    return {min(expected, key=lambda which: miss(which, top)): top}
