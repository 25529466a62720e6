"""Modal fits of every curve of an FRF Dataset, with their uncertainties."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ModalError
from ..formats.frf_units import one_of
from ..variables import describe
from .fit import Damping, Fit, circle_fit, dobson, half_power_band, levels, line_fit
from .fit_together import least_squares
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
FIELDS = {
    "frequency": "fitted_frequency",
    "damping_ratio": "fitted_damping_ratio",
    "modal_constant": "fitted_modal_constant",
    "frequency_error": "fitted_frequency_standard_error",
    "damping_ratio_error": "fitted_damping_ratio_standard_error",
    "quality": "fitted_quality",
}
"""Fields of a ``Fit``, and what they are called in a Dataset."""
BANDS = ("band_start", "band_end", "band_lines")
SEVERAL = ("gamma", "frf")
"""Dimensions of an FRF Dataset along which every curve is fitted by itself."""

PROMINENCE = 2.0
"""A peak stands out of the dips beside it by this factor, when nobody says where the modes are."""
MOST_PEAKS = 30
"""That may be found; more are noise, or nobody's reading."""
LEAST_QUALITY = 0.5
"""Coefficient of determination below which a fit is none: less than half of the FRF's variation in the band is its."""
LARGEST_ERROR = 0.5
"""Of a damping ratio's standard error over the ratio: beyond, zero is within two standard errors."""


@dataclass(frozen=True)
class Fits:
    """Fits of the modes of one FRF.

    Parameters
    ----------
    found : by method and number of the peak, from 0
    bands : half-power bands by number of the peak
    refused : what could not be fitted, in sentences
    """

    found: dict[tuple[Method, int], Fit]
    bands: dict[int, slice]
    refused: list[str]


def fits(frf: xr.Dataset, near=None, *, damping: Damping | str = Damping.STRUCTURAL) -> xr.Dataset:
    """Fit every mode of every FRF by every method, each in its half-power band.

    Least squares fits all modes together, on their bands together.

    Parameters
    ----------
    frf : Dataset with ``accelerance_real`` and ``accelerance_imaginary`` on frequency, and gamma or frf if there are
        several; lines without a value are left out
    near : frequencies near the peaks [Hz] (default: those the Dataset knows, else every peak that stands out by 6 dB)
    damping : of the modes that are fitted, structural or viscous

    Returns
    -------
    xarray.Dataset
        On (fit, mode, gamma or frf): ``fitted_frequency`` [Hz], ``fitted_damping_ratio``, the size of
        ``fitted_modal_constant`` [kg^-1], standard errors, and ``fitted_quality``, the coefficient of determination of
        the fitted FRF in the band.  On (mode, gamma or frf): ``band_start`` and ``band_end`` [Hz] and ``band_lines``.
        NaN where a band could not be fitted or the fit means nothing; the attribute ``refused`` says why.

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

    damping = one_of(Damping, damping, "damping")
    curves = complex_accelerance(frf)
    if others := [dim for dim in curves.dims if dim not in (*SEVERAL, "frequency")]:
        first = curves[others[0]].values[0]
        raise ModalError(f"there are several FRFs along {others[0]}: choose one, as --at {others[0]}={first:g}")
    several = next((dim for dim in SEVERAL if dim in curves.dims), None)
    if several is None:
        curves = curves.expand_dims(gamma=[np.nan])
    curves = curves.transpose(several or "gamma", "frequency").sortby("frequency")
    frequency, values = curves["frequency"].values, curves.values
    near = _near(frf, values, frequency) if near is None else _asked(near)
    table = np.full((len(FIELDS), len(Method), len(near), len(values)), np.nan)
    bands = np.full((len(BANDS), len(near), len(values)), np.nan)
    refused = []
    for j, curve in enumerate(values):
        kept = np.isfinite(curve) & (frequency > 0)
        own = fit_curve(frequency[kept], curve[kept], near, damping)
        label = _label(several, curves, j)
        refused += [label + sentence for sentence in own.refused]
        for (method, mode), fit in own.found.items():
            values_of_fit = [abs(v) if isinstance(v, complex) else v for v in (getattr(fit, name) for name in FIELDS)]
            table[:, list(Method).index(method), mode, j] = values_of_fit
        for mode, band in own.bands.items():
            inside = frequency[kept][band]
            bands[:, mode, j] = inside[0], inside[-1], len(inside)
    if np.isnan(table[0]).all():
        raise ModalError(refused[0])

    dims = ("mode", several or "gamma")
    known = "mode" in frf.coords and frf.sizes["mode"] == len(near)
    out = xr.Dataset(
        {name: (("fit", *dims), part) for name, part in zip(FIELDS.values(), table, strict=True)}
        | {name: (dims, part) for name, part in zip(BANDS, bands, strict=True)},
        {
            "fit": ("fit", [str(m) for m in Method]),
            "mode": ("mode", frf["mode"].values if known else np.arange(1, len(near) + 1)),
            dims[1]: curves[dims[1]],
        },
    )
    out.attrs = {"title": f"modal fits of {frf.attrs.get('title', 'an FRF')}", "refused": refused}
    out.attrs |= {"damping": str(damping)} | {key: frf.attrs[key] for key in ("read_as",) if key in frf.attrs}
    return describe(out if several else out.isel(gamma=0, drop=True))


def _label(several, curves, j: int) -> str:
    """The beginning of a sentence about one of several curves."""
    if several is None:
        return ""
    value = curves[several].values[j]
    return f"Gamma {value:g}, " if several == "gamma" else f"{value}, "


def fit_curve(frequency, accelerance, near, damping: Damping = Damping.STRUCTURAL) -> Fits:
    """Fits of one FRF round every peak that is asked for."""
    fits = Fits({}, {}, [])
    if not len(frequency):
        fits.refused.append("the FRF has no values")
        return fits
    for mode, place in enumerate(near):
        try:
            fits.bands[mode] = _new_band(frequency, accelerance, place, fits.bands.values())
        except ModalError as error:
            fits.refused.append(str(error))
            continue
        band = fits.bands[mode]
        for method, fit in ONE_MODE.items():
            _keep(fits, method, mode, frequency[band], partial(fit, frequency[band], accelerance[band], damping))
    if fits.found:
        _fit_together(fits, frequency, accelerance, damping)
    return fits


def _new_band(frequency, accelerance, near: float, others) -> slice:
    """Half-power band of a peak that no other frequency has claimed."""
    band = half_power_band(frequency, accelerance, near)
    if band in others:
        peak = frequency[band][np.argmax(np.abs(accelerance[band]))]
        raise ModalError(f"near {near:g} Hz the peak is that at {peak:.4g} Hz, which is fitted already: give it once")
    return band


def _fit_together(fits: Fits, frequency, accelerance, damping: Damping) -> None:
    """Least squares of all modes that some other method has found, from where it found them."""
    start = {mode: fit for (_, mode), fit in fits.found.items()}
    bands = {mode: fits.bands[mode] for mode in start}
    together = np.concatenate([np.arange(band.start, band.stop) for band in bands.values()])
    try:
        every = least_squares(frequency[together], accelerance[together], list(start.values()), damping)
    except ModalError as error:
        fits.refused.append(str(error))
        return
    for (mode, band), fit in zip(bands.items(), every, strict=True):
        _keep(fits, Method.LEAST_SQUARES, mode, frequency[band], partial(replace, fit))


def _keep(fits: Fits, method: Method, mode: int, band, fitted) -> None:
    """Keep a fit that means something; say of any other why it does not."""
    try:
        fit = fitted()
        why = _meaningless(fit, band)
    except ModalError as error:
        why = str(error)
    if why:
        fits.refused.append(f"{method} fit from {band[0]:.4g} to {band[-1]:.4g} Hz: {why}")
    else:
        fits.found[method, mode] = fit


def _meaningless(fit: Fit, band) -> str | None:
    """Why a fit says nothing about a mode in its band; None if it does."""
    ratio, error = 100 * fit.damping_ratio, 100 * fit.damping_ratio_error
    if not band[0] <= fit.frequency <= band[-1]:
        return f"its natural frequency, {fit.frequency:.4g} Hz, lies outside the band"
    if not fit.damping_ratio > 0:
        return (
            f"its damping ratio is negative, {ratio:.3g} %: the FRF's imaginary part or phase has the other sign, or "
            "its ordinate is another"
        )
    if not fit.quality >= LEAST_QUALITY:
        return f"it explains {100 * fit.quality:.0f} % of the FRF there: noise, or no single mode"
    if not error <= LARGEST_ERROR * ratio:
        return f"its damping ratio, {ratio:.3g} %, has a standard error of {error:.2g} %: noise, or too few lines"
    return None


def _asked(near) -> np.ndarray:
    """Frequencies near the peaks, sorted, each once."""
    near = np.atleast_1d(np.asarray(near, float))
    if not len(near) or not np.isfinite(near).all() or (near <= 0).any():
        raise ModalError(f"near: expected frequencies above 0 Hz, got {', '.join(f'{f:g}' for f in near) or 'none'}")
    return np.unique(near)


def _near(frf: xr.Dataset, curves: np.ndarray, frequency) -> np.ndarray:
    """Where the modes are: as the Dataset says, or where the curves' geometric mean peaks."""
    from scipy.signal import find_peaks

    if "resonance_frequency" in frf:
        return frf["resonance_frequency"].mean([d for d in frf["resonance_frequency"].dims if d != "mode"]).values
    kept = np.isfinite(curves).all(axis=0) & (frequency > 0)
    if not kept.any():
        raise ModalError("the FRF has no line with a value")
    size = np.mean([levels(np.abs(curve)) for curve in curves[:, kept]], axis=0)
    peaks, _ = find_peaks(size, prominence=np.log(PROMINENCE))
    if not len(peaks):
        raise ModalError("the FRF has no peak that stands out by 6 dB: say where the modes are, as --near 39.5")
    if len(peaks) > MOST_PEAKS:
        raise ModalError(
            f"the FRF has {len(peaks)} peaks that stand out by 6 dB, as noise has: say where the modes are, as "
            "--near 39.5"
        )
    return frequency[kept][peaks]
