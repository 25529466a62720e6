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

if TYPE_CHECKING:
    import xarray as xr


def over_seeds(dataset: xr.Dataset, name: str) -> tuple[xr.DataArray, xr.DataArray]:
    """Mean of a variable over packings, and its standard error: of the effectiveness with all its parts."""
    value, error = dataset[name], dataset[f"{name}_standard_error"]
    if name == "effectiveness" and "energy_mean_standard_error" in dataset:
        mean = value.mean("seed") if "seed" in value.dims else value
        return mean, mean * dataset["energy_mean_standard_error"] / dataset["energy_mean"]
    if "seed" not in value.dims:
        return value, error
    return value.mean("seed"), np.sqrt((error**2).sum("seed")) / value.notnull().sum("seed")


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

    from ..version import PHYSICS_VERSION, __version__

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


def open_results(path: str | Path) -> xr.Dataset:
    """Open a results file; its Dataset has ``.damper``.

    Raises
    ------
    OSError
        If it is not there, or is no results file.
    """
    try:
        dataset = xr.open_dataset(path)
    except ValueError:
        raise UsageError(f"{path}: is no netCDF file") from None
    if "status" not in dataset:
        dataset.close()
        raise UsageError(f"{path}: is no results file of warpdamp (it has no status)")
    return dataset
