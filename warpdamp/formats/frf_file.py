"""FRFs from files of any kind, as a Dataset."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ModalError, printable
from ..variables import describe
from .frf_curve import Curve
from .frf_table import read_frf_table
from .frf_uff import listed, read_frf_uff
from .frf_units import Ordinate, one_of
from .text_file import TableError

if TYPE_CHECKING:
    import xarray as xr


def read_frf(
    path: Path, *, response=None, reference=None, number=None, every=False, ordinate=None, units=None
) -> xr.Dataset:
    """An FRF from a file, as accelerance [m s^-2 N^-1]: netCDF as this package writes it, text table, universal file.

    Columns of a table are told by their names and units (``frf_table``), functions of a universal file by their fields
    (``frf_uff``).

    Parameters
    ----------
    path : .nc, .csv, .txt or .tsv, or .uff, .unv or .uf
    response, reference : node and direction of one FRF of several in a universal file, as "2z" or "2"
    number : its place among the functions of the file, from 1
    every : all FRFs that are asked for, on the dimension ``frf``
    ordinate : accelerance, mobility or receptance, where the file does not say
    units : of response over force, as "g/lbf", where the file does not say

    Raises
    ------
    ModalError
        If the file is not there or holds no FRF, the choice is not unique, or something that the file says cannot be
        used.
    """
    path = Path(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise ModalError(f"{path}: name a file that ends in {', '.join(READERS)}")
    if not path.is_file():
        raise ModalError(f"{path}: there is no such file")
    given = {"given": one_of(Ordinate, ordinate, "ordinate") if ordinate else None, "unit": units or ""}
    chosen = {"response": response, "reference": reference, "number": number}
    if reader is not read_frf_uff and (every or any(value is not None for value in chosen.values())):
        raise ModalError(f"{path}: FRFs are chosen by node and number in universal files only: leave the options out")
    if reader is _read_netcdf:
        if any(given.values()):
            raise ModalError(f"{path}: says that it is an accelerance in SI: leave ordinate and units out")
        return reader(path)
    try:
        curves = reader(path, **given, **chosen) if reader is read_frf_uff else [reader(path, **given)]
    except (ModalError, TableError) as error:
        raise ModalError(printable(str(error))) from None
    if len(curves) > 1 and not every:
        names = listed([curve.name for curve in curves])
        raise ModalError(
            f"{path}: {len(curves)} FRFs (response/reference) are meant: {names}: choose one by response, reference or "
            "number, or every one"
        )
    return _dataset(path, curves, several=every)


def _read_netcdf(path: Path) -> xr.Dataset:
    import xarray as xr

    try:
        dataset = xr.load_dataset(path)
    except (ValueError, OSError, RuntimeError, AttributeError):
        raise ModalError(f"{path}: is no netCDF file, or a damaged one") from None
    names = ("accelerance_real", "accelerance_imaginary")
    if "branch" in dataset.variables:
        raise ModalError(
            f"{path}: holds branches at constant force, along which the damper's mass changes: no linear mode fits "
            "them: fit the FRF at controlled Gamma, that of `warpdamp frf` without --constant-force"
        )
    if not all(name in dataset and "frequency" in dataset[name].dims for name in names):
        raise ModalError(f"{path}: holds no FRF over frequency; `warpdamp frf RESULTS.nc -o FRF.nc` writes one")
    for name, unit in {"frequency": "Hz", **dict.fromkeys(names, "m s-2 N-1")}.items():
        said = dataset[name].attrs.get("units", unit)
        if said != unit:
            raise ModalError(f"{path}: {name} is in {said}: expected {unit}")
    return dataset


def _dataset(path: Path, curves: list[Curve], *, several: bool) -> xr.Dataset:
    import xarray as xr

    first = curves[0]
    for curve in curves[1:]:
        if not np.array_equal(curve.frequency, first.frequency):
            raise ModalError(f"{path}: {first.name} and {curve.name} have different frequencies: choose one of them")
    values = np.array([curve.accelerance for curve in curves])
    dims = ("frf", "frequency") if several else ("frequency",)
    values = values if several else values[0]
    out = xr.Dataset(
        {"accelerance_real": (dims, values.real), "accelerance_imaginary": (dims, values.imag)},
        {"frequency": ("frequency", first.frequency, {"units": "Hz", "long_name": "frequency"})},
        {"title": path.name, "read_as": first.said},
    )
    if several:
        names = {"long_name": "response and reference, node and direction each"}
        out = out.assign_coords(frf=("frf", _distinct([curve.name for curve in curves]), names))
    return describe(out)


def _distinct(names: list[str]) -> list[str]:
    """Names, with the place of those that are there more than once."""
    return [name if names.count(name) == 1 else f"{name} #{k}" for k, name in enumerate(names, 1)]


READERS = dict.fromkeys((".csv", ".txt", ".tsv", ".dat"), read_frf_table)
READERS |= dict.fromkeys((".uff", ".unv", ".uf", ".u58"), read_frf_uff) | {".nc": _read_netcdf}
