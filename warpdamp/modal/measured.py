"""Measured damping and frequency of modes over Gamma, beside what was predicted.

The table has a row for each point; columns by their names, in any order:

| column | units |
|---|---|
| gamma | acceleration amplitude over g |
| damping_ratio, and damping_ratio_standard_error | % or 1 |
| frequency, and frequency_standard_error | Hz |
| mode (where the results have several) | number |
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from ..errors import ModalError, UsageError
from ..formats.text_table import TextTable, read_table
from .apparent_mass import corrected, require_modes

QUANTITIES = {"damping_ratio": "damping_ratio", "frequency": "corrected_natural_frequency"}
"""Columns that are compared, and the predictions beside them."""
COLUMNS = ("mode", "gamma", *QUANTITIES, *(f"{name}_standard_error" for name in QUANTITIES))
FACTORS = {"": 1.0, "-": 1.0, "1": 1.0, "%": 0.01, "hz": 1.0, "khz": 1e3}


@dataclass(frozen=True)
class Measured:
    """Measured points; what was not measured is NaN.

    Parameters
    ----------
    mode : (n,) numbers
    gamma : (n,)
    values, errors : by column, (n,) each, SI
    """

    mode: np.ndarray
    gamma: np.ndarray
    values: dict[str, np.ndarray]
    errors: dict[str, np.ndarray]


def read_measured(file: Path, modes: np.ndarray) -> Measured:
    """Measured points from a table.

    Parameters
    ----------
    file : path
    modes : (m,) numbers of the results' modes

    Raises
    ------
    ModalError
        With file and line, if a column is unknown or missing, a mode is none of the results', or a value cannot be.
    """
    table = read_table(Path(file))
    where = f"{file}:{max(table.header_line, 1)}"
    columns = _columns(table, where)
    if "gamma" not in columns or not set(QUANTITIES) & set(columns):
        raise ModalError(f"{where}: expected columns gamma and damping_ratio or frequency; known: {', '.join(COLUMNS)}")
    if "mode" not in columns and len(modes) > 1:
        raise ModalError(f"{where}: the results have modes {', '.join(map(str, modes))}: add a column mode")
    gamma = columns["gamma"]
    mode = columns.get("mode", np.full(len(gamma), float(modes[0])))
    for k, line in enumerate(table.lines):
        if gamma[k] <= 0:
            raise ModalError(f"{file}:{line}: gamma: {gamma[k]:g}: expected above 0")
        if mode[k] not in modes:
            raise ModalError(f"{file}:{line}: mode: the results have none {mode[k]:g}: {', '.join(map(str, modes))}")
        for name in QUANTITIES:
            if name in columns and columns[name][k] <= 0:
                raise ModalError(f"{file}:{line}: {name}: {columns[name][k]:g}: expected above 0")
            error = columns.get(f"{name}_standard_error")
            if error is not None and error[k] <= 0:
                raise ModalError(f"{file}:{line}: {name}_standard_error: {error[k]:g}: expected above 0")
    nothing = np.full(len(gamma), np.nan)
    return Measured(
        mode.astype(int),
        gamma,
        {name: columns.get(name, nothing) for name in QUANTITIES},
        {name: columns.get(f"{name}_standard_error", nothing) for name in QUANTITIES},
    )


def _columns(table: TextTable, where: str) -> dict[str, np.ndarray]:
    found: dict[str, np.ndarray] = {}
    for head, values in zip(table.columns, table.values.T, strict=True):
        name = head.name.strip().lower().replace(" ", "_")
        if name not in COLUMNS:
            raise ModalError(f"{where}: unknown column {head}; known: {', '.join(COLUMNS)}")
        if name in found:
            raise ModalError(f"{where}: column {name} is there twice")
        if head.unit.lower() not in FACTORS:
            raise ModalError(f"{where}: column {head}: unknown unit; write %, 1 or Hz")
        found[name] = values * FACTORS[head.unit.lower()]
    return found


def compare(dataset: xr.Dataset, measured: Measured) -> xr.Dataset:
    """Residuals of a prediction of single values, over the joint errors.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results with a structure.
    measured : Measured

    Returns
    -------
    xarray.Dataset
        On ``point``: of each quantity measured, predicted, their standard errors, and ``residual``, the difference over
        the joint standard error; NaN outside the Gammas that were run.

    Raises
    ------
    UsageError
        If a scalar was swept.
    """
    require_modes(dataset)
    swept = [dim for dim in dataset["damping_ratio"].dims if dim not in ("mode", "gamma")]
    if swept:
        raise UsageError(f"results over {', '.join(map(str, swept))}: choose by --at, or calibrate by --calibrate")
    known = corrected(dataset)
    predictions = {
        "damping_ratio": (dataset["damping_ratio"], dataset["damping_ratio_standard_error"]),
        "frequency": tuple(known[f"corrected_natural_frequency{s}"] for s in ("", "_standard_error")),
    }
    found = xr.Dataset({"mode": ("point", measured.mode), "gamma": ("point", measured.gamma)})
    for name, (value, error) in predictions.items():
        if not np.isfinite(measured.values[name]).any():
            continue
        predicted, spread = (_at(array, measured) for array in (value, error))
        joint = np.hypot(np.nan_to_num(measured.errors[name]), spread)
        found[name] = "point", measured.values[name]
        found[f"{name}_standard_error"] = "point", measured.errors[name]
        found[f"predicted_{name}"] = "point", predicted
        found[f"predicted_{name}_standard_error"] = "point", spread
        found[f"{name}_residual"] = "point", (measured.values[name] - predicted) / joint
    return found


def _at(array: xr.DataArray, measured: Measured) -> np.ndarray:
    """A prediction on (mode, gamma) at the measured points, straight between its Gammas; NaN beyond."""
    modes, gamma = array["mode"].values, array["gamma"].values
    table = array.transpose("mode", "gamma").values
    return np.array(
        [
            np.interp(g, gamma, table[int(np.flatnonzero(modes == mode)[0])], left=np.nan, right=np.nan)
            for mode, g in zip(measured.mode, measured.gamma, strict=True)
        ]
    )
