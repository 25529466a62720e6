"""Results as an xarray Dataset with CF attributes, written whole or not at all."""

from __future__ import annotations

import platform
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from ..errors import UsageError
from ..files import whole_file
from ..variables import NOT_RUN
from ..version import PHYSICS_VERSION, __version__

if TYPE_CHECKING:
    import xarray as xr


CLAIMED = ("energy_dissipated", "effectiveness")
"""Variables whose mean over packings carries the claim of ``energy_mean``: spread, memory, averaging and step."""


def over_packings(dataset: xr.Dataset, name: str) -> tuple[xr.DataArray, xr.DataArray]:
    """Mean of a variable over the packings that ran, and its standard error.

    The energy per cycle and the effectiveness have the error of ``energy_mean``, with all its parts.  That of any other
    variable is the larger of what the packings' spread and their own errors say; not a number where there is neither.
    A point of which a packing failed is not a number.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results.
    name : str
        Of the variable.

    Returns
    -------
    mean, standard_error : xarray.DataArray
        Without the dimension ``seed``, in the unit of the variable.
    """
    import xarray as xr

    value = dataset[name]
    own = dataset.get(f"{name}_standard_error", xr.full_like(value, np.nan))
    there = ran(dataset)
    if "seed" not in value.dims:
        value, own, there = (a.expand_dims("seed") if "seed" not in a.dims else a for a in (value, own, there))
    n = there.sum("seed")

    def total(values):
        return values.where(there, 0.0).sum("seed", skipna=False)

    mean = total(value) / n
    if name in CLAIMED and "energy_mean" in dataset:
        return mean, mean * dataset["energy_mean_standard_error"] / dataset["energy_mean"]
    between = np.sqrt(total((value - mean) ** 2) / (n * (n - 1)).where(n > 1))
    return mean, np.fmax(between, np.sqrt(total(own**2)) / n)


def worst_status(dataset: xr.Dataset) -> xr.DataArray:
    """How the worst packing of every point ended, of all dampers where there are several."""
    status = dataset["status"]
    return status.max([dim for dim in ("seed", "damper") if dim in status.dims])


def ran(dataset: xr.Dataset) -> xr.DataArray:
    """Which cases were run: of the packings of a point those that a tolerance called for."""
    import xarray as xr

    return dataset["status"] != NOT_RUN if "status" in dataset else xr.ones_like(dataset["seed"], bool)


def provenance() -> dict:
    """Global attributes: who made this, with what, when."""
    import numpy
    import scipy
    import skfem
    import warp
    import xarray

    versions = {"numpy": numpy, "scipy": scipy, "scikit-fem": skfem, "warp-lang": warp, "xarray": xarray}
    return {
        "Conventions": "CF-1.11",
        "source": f"warpdamp {__version__} (physics {PHYSICS_VERSION}), python {platform.python_version()}, "
        + ", ".join(f"{name} {module.__version__}" for name, module in versions.items()),
        "history": f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ} warpdamp run",
        "references": "Terzioglu & Rongong, Selection of granular damper parameters to achieve optimum vibration "
        "attenuation on vibrating structures",
    }


def read(path: Path) -> xr.Dataset:
    """Results of a run, from their file into memory.

    Raises
    ------
    UsageError
        If the file is not there, is no netCDF file, or holds no results.
    """
    import xarray as xr

    try:
        dataset = xr.load_dataset(path)
    except ValueError:
        raise UsageError(f"{path}: is no netCDF file") from None
    if "effectiveness" not in dataset:
        raise UsageError(f"{path}: is no results file of warpdamp (it has no effectiveness)")
    return dataset


def write(dataset: xr.Dataset, path: Path) -> None:
    """Write a netCDF file whole or not at all."""
    with whole_file(path) as part:
        dataset.to_netcdf(part, engine="netcdf4")
