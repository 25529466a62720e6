"""Modal fits of every curve of an FRF Dataset, and FRFs from files."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ModalError
from ..variables import describe
from .fit import Fit, circle_fit, dobson, half_power_band, least_squares, line_fit
from .frf import complex_accelerance

if TYPE_CHECKING:
    import xarray as xr


class Method(StrEnum):
    """Method of modal fitting."""

    LINE = "line"
    DOBSON = "dobson"
    CIRCLE = "circle"
    LEAST_SQUARES = "least squares"


ONE_MODE = {Method.LINE: line_fit, Method.DOBSON: dobson, Method.CIRCLE: circle_fit}
FIELDS = ("frequency", "damping_ratio", "modal_constant", "frequency_error", "damping_ratio_error")
NAMES = ("fitted_frequency", "fitted_damping_ratio", "fitted_modal_constant")

PROMINENCE = 2.0
"""A peak stands out of the dips beside it by this factor, when no frequencies are given."""


def fits(frf: xr.Dataset, near=None) -> xr.Dataset:
    """Fit every mode of every FRF by every method, each in its half-power band.

    Least squares fits all modes together, on their bands together.

    Parameters
    ----------
    frf : Dataset with ``accelerance_real`` and ``accelerance_imaginary`` on frequency, and gamma if there are several
    near : frequencies near the peaks [Hz] (default: those the Dataset knows, else every peak that stands out by 6 dB)

    Returns
    -------
    xarray.Dataset
        ``fitted_frequency``, ``fitted_damping_ratio`` and the size of ``fitted_modal_constant`` on (fit, mode,
        gamma), with standard errors where the method has them.  NaN where a band could not be fitted; the attribute
        ``refused`` says why.

    Raises
    ------
    ModalError
        If nothing could be fitted.

    Examples
    --------
    >>> from warpdamp import accelerance, fits, open_results
    >>> frf = accelerance(open_results("docs/beam.nc"), gamma=[2.0])
    >>> fitted = fits(frf).sel(mode=1, gamma=2.0)
    >>> [f"{method}: {100 * zeta:.1f} %" for method, zeta in fitted["fitted_damping_ratio"].to_series().items()]
    ['line: 1.8 %', 'dobson: 1.8 %', 'circle: 1.8 %', 'least squares: 1.8 %']
    """
    import xarray as xr

    curves = complex_accelerance(frf)
    if others := [dim for dim in curves.dims if dim not in ("gamma", "frequency")]:
        raise ModalError(
            f"there are several FRFs along {others[0]}: choose one, as --at {others[0]}={float(curves[others[0]][0]):g}"
        )
    several = "gamma" in curves.dims
    if not several:
        curves = curves.expand_dims(gamma=[np.nan])
    curves = curves.transpose("gamma", "frequency")
    frequency = curves["frequency"].values
    near = _near(frf, curves.values, frequency) if near is None else np.sort(np.atleast_1d(near))
    table = np.full((len(FIELDS), len(Method), len(near), len(curves)), np.nan)
    refused = []
    for j, curve in enumerate(curves.values):
        found, errors = fit_curve(frequency, curve, near)
        label = f"Gamma {curves['gamma'].values[j]:g}, " if several else ""
        refused += [label + error for error in errors]
        for (method, mode), fit in found.items():
            table[:, list(Method).index(method), mode, j] = [abs(getattr(fit, name)) for name in FIELDS]
    if np.isnan(table[0]).all():
        raise ModalError(refused[0])

    names = (*NAMES, "fitted_frequency_standard_error", "fitted_damping_ratio_standard_error")
    own = "mode" in frf.coords and frf.sizes["mode"] == len(near)
    out = xr.Dataset(
        {name: (("fit", "mode", "gamma"), values) for name, values in zip(names, table, strict=True)},
        {
            "fit": ("fit", [str(m) for m in Method]),
            "mode": ("mode", frf["mode"].values if own else np.arange(1, len(near) + 1)),
            "gamma": curves["gamma"],
        },
    )
    out.attrs = {"title": f"modal fits of {frf.attrs.get('title', 'an FRF')}", "refused": refused}
    return describe(out if several else out.isel(gamma=0, drop=True))


def fit_curve(frequency, accelerance, near) -> tuple[dict[tuple[Method, int], Fit], list[str]]:
    """Fits of one FRF by (method, number of the peak from 0), and what could not be fitted, in sentences."""
    found, bands, errors = {}, {}, []
    for mode, place in enumerate(near):
        try:
            band = half_power_band(frequency, accelerance, place)
        except ModalError as error:
            errors.append(str(error))
            continue
        bands[mode] = band
        for method, fit in ONE_MODE.items():
            found[method, mode] = fit(frequency[band], accelerance[band])
    if bands:
        together = np.concatenate([np.arange(band.start, band.stop) for band in bands.values()])
        start = [found[Method.DOBSON, mode] for mode in bands]
        try:
            every = least_squares(frequency[together], accelerance[together], start)
        except ModalError as error:
            errors.append(str(error))
        else:
            found |= {(Method.LEAST_SQUARES, mode): fit for mode, fit in zip(bands, every, strict=True)}
    return found, errors


def _near(frf: xr.Dataset, curves: np.ndarray, frequency) -> np.ndarray:
    """Where the modes are: as the Dataset says, or where the curves' geometric mean peaks."""
    from scipy.signal import find_peaks

    if "resonance_frequency" in frf:
        return frf["resonance_frequency"].mean([d for d in frf["resonance_frequency"].dims if d != "mode"]).values
    peaks, _ = find_peaks(np.log(np.abs(curves)).mean(axis=0), prominence=np.log(PROMINENCE))
    if not len(peaks):
        raise ModalError("the FRF has no peak that stands out by 6 dB: say where the modes are, as --near 39.5")
    return frequency[peaks]


def read_frf(path: Path) -> xr.Dataset:
    """FRF from a file: netCDF as this package writes it, CSV, or universal file (dataset 58).

    A CSV file has three columns: frequency [Hz], real and imaginary part of the accelerance [m s^-2 N^-1]; its first
    line may hold their names.  A universal file must hold one FRF; mobilities and receptances are converted.

    Raises
    ------
    OSError
        If the file is not there, or holds no FRF; says what is wrong.
    """
    path = Path(path)
    reader = {".nc": _read_netcdf, ".csv": _read_csv, ".uff": _read_universal, ".unv": _read_universal}.get(path.suffix)
    if reader is None:
        raise OSError(f"{path}: name a file that ends in .nc, .csv, .uff or .unv")
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such file")
    return reader(path)


def _read_netcdf(path: Path) -> xr.Dataset:
    import xarray as xr

    try:
        dataset = xr.load_dataset(path)
    except ValueError:
        raise OSError(f"{path}: is no netCDF file") from None
    if "accelerance_real" not in dataset or "frequency" not in dataset["accelerance_real"].dims:
        raise OSError(f"{path}: holds no FRF over frequency; `warpdamp frf RESULTS.nc -o FRF.nc` writes one")
    return dataset


def _read_csv(path: Path) -> xr.Dataset:
    lines = [line.strip() for line in path.read_text(encoding="utf-8-sig").splitlines()]
    rows = []
    for number, line in enumerate(lines, start=1):
        if not line or line.startswith("#"):
            continue
        try:
            row = [float(cell) for cell in line.split(",")]
        except ValueError:
            if not rows and number == 1:  # the names of the columns
                continue
            row = []
        if len(row) != 3 or not np.isfinite(row).all():
            raise OSError(f"{path}:{number}: expected frequency, real, imaginary, got '{line}'")
        rows.append(row)
    if not rows:
        raise OSError(f"{path}: holds no data; expected lines of frequency, real, imaginary")
    frequency, real, imaginary = np.array(rows).T
    return _dataset(path, frequency, real + 1j * imaginary)


def _read_universal(path: Path) -> xr.Dataset:
    try:
        import pyuff
    except ImportError:
        raise OSError(f"{path}: universal files need pyuff: pip install 'warpdamp[modes]'") from None
    found = [s for s in _sets(pyuff.UFF(str(path))) if s.get("type") == 58 and int(s.get("func_type", 0)) == 4]
    if len(found) != 1:
        raise OSError(
            f"{path}: holds {len(found)} FRFs (dataset 58, function 4); expected one: write it to its own file"
        )
    frequency, data = np.asarray(found[0]["x"], float), np.asarray(found[0]["data"], complex)
    kind = int(found[0].get("ordinate_spec_data_type", 12))
    derivatives = {8: 2, 11: 1, 12: 0}  # displacement, velocity, acceleration
    if kind not in derivatives:
        raise OSError(f"{path}: the FRF's ordinate has the data type {kind}; expected 8, 11 or 12")
    return _dataset(path, frequency, data * (2j * np.pi * frequency) ** derivatives[kind])


def _sets(file):
    sets = file.read_sets()
    return sets if isinstance(sets, list) else [sets]


def _dataset(path: Path, frequency, accelerance) -> xr.Dataset:
    import xarray as xr

    if len(np.unique(frequency)) < len(frequency) or frequency.min() < 0:
        raise OSError(f"{path}: frequencies must be positive, each given once")
    order = np.argsort(frequency)
    order = order[frequency[order] > 0]
    out = xr.Dataset(
        {
            "accelerance_real": ("frequency", accelerance[order].real),
            "accelerance_imaginary": ("frequency", accelerance[order].imag),
        },
        {"frequency": ("frequency", frequency[order], {"units": "Hz", "long_name": "frequency"})},
        {"title": path.name},
    )
    return describe(out)
