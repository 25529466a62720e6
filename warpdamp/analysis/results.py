"""Results as an xarray Dataset with CF attributes, written whole or not at all."""

from __future__ import annotations

import platform
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import UsageError
from ..files import netcdf_errors, whole_file
from ..variables import NOT_RUN
from ..version import PHYSICS_VERSION, __version__

if TYPE_CHECKING:
    import xarray as xr

CLAIMED = ("energy_dissipated", "effectiveness")
"""Variables whose mean over packings has the error of ``energy_mean``: spread, memory, averaging and step."""


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
    errors = dataset.get(f"{name}_standard_error", xr.full_like(value, np.nan))
    done = ran(dataset)
    if "seed" not in value.dims:
        value, errors, done = (a.expand_dims("seed") if "seed" not in a.dims else a for a in (value, errors, done))
    n = done.sum("seed")

    def total(values):
        return values.where(done, 0.0).sum("seed", skipna=False)

    mean = total(value) / n
    if name in CLAIMED and "energy_mean" in dataset:
        return mean, mean * dataset["energy_mean_standard_error"] / dataset["energy_mean"]
    between = np.sqrt(total((value - mean) ** 2) / (n * (n - 1)).where(n > 1))
    return mean, np.fmax(between, np.sqrt(total(errors**2)) / n)


def worst_status(dataset: xr.Dataset) -> xr.DataArray:
    """Largest ``status`` among the packings of every point, and among its dampers where there are several.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results.

    Returns
    -------
    xarray.DataArray
        Numbers of ``warpdamp.status.Status``, without the dimensions ``seed`` and ``damper``.
    """
    status = dataset["status"]
    return status.max([dim for dim in ("seed", "damper") if dim in status.dims])


def ran(dataset: xr.Dataset) -> xr.DataArray:
    """Cases that were run: of the packings of a point those that a tolerance required.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results.

    Returns
    -------
    xarray.DataArray of bool
        On the dimensions of ``status``.
    """
    import xarray as xr

    return dataset["status"] != NOT_RUN if "status" in dataset else xr.ones_like(dataset["seed"], bool)


def provenance() -> dict:
    """Global attributes of a results file: program and library versions, date, references."""
    libraries = ("numpy", "scipy", "scikit-fem", "warp-lang", "xarray")
    return {
        "Conventions": "CF-1.11",
        "source": f"warpdamp {__version__} (physics {PHYSICS_VERSION}), python {platform.python_version()}, "
        + ", ".join(f"{name} {metadata.version(name)}" for name in libraries),
        "history": f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ} warpdamp run",
        "references": "Terzioglu & Rongong, Selection of granular damper parameters to achieve optimum vibration "
        "attenuation on vibrating structures",
    }


def is_coupled(dataset: xr.Dataset) -> bool:
    """Whether a Dataset is of coupled runs."""
    return "structure_displacement" in dataset


def is_design(dataset: xr.Dataset) -> bool:
    """Whether a Dataset is the answer to a design problem."""
    return "damping_ratio_mean" in dataset


def read(path: Path, *, coupled: bool = False, design: bool = False) -> xr.Dataset:
    """Results of a run, read from their file into memory.

    Parameters
    ----------
    path : Path
        netCDF file.
    coupled : bool
        Whether those of coupled runs will do, too.
    design : bool
        Whether the answer to a design problem will do, too.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    UsageError
        If there is no such file, it is not a netCDF file, or holds no results.
    """
    import xarray as xr

    with netcdf_errors(path):
        dataset = xr.load_dataset(path)
    accepted = (coupled and is_coupled(dataset)) or (design and is_design(dataset))
    if "effectiveness" not in dataset and not accepted:
        raise UsageError(f"{path}: {kind_of(dataset)} (it has no effectiveness)")
    return dataset


def kind_of(dataset: xr.Dataset) -> str:
    """Sentence on what a file is that is no results of a study."""
    return next((what for name, what in OTHERS.items() if name in dataset), "is not a results file of warpdamp")


OTHERS = {
    "structure_displacement": "holds coupled runs, no study of prescribed motion: warpdamp plot draws them, warpdamp "
    "fit reads their FRF; for a card or an FRF over Gamma take the results of `warpdamp run`",
    "damping_ratio_mean": "holds the answer of a design: `warpdamp report` makes a page of it, `warpdamp run` of the "
    "YAML file beside it gives results",
    "accelerance_real": "is an FRF: warpdamp fit reads it; here the results of `warpdamp run` are wanted",
    "fitted_frequency": "holds fits of an FRF; here the results of `warpdamp run` are wanted",
    "damper_share": "holds the damping by several cards; here the results of `warpdamp run` are wanted",
}
"""Other files that the package writes, by a variable that tells them, and what they are."""


def write(dataset: xr.Dataset, path: Path) -> None:
    """Write a netCDF file whole or not at all.

    Parameters
    ----------
    dataset : xarray.Dataset
    path : Path
        Replaced if it exists.
    """
    with whole_file(path) as part:
        dataset.to_netcdf(part, engine="netcdf4")
