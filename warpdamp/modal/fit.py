"""Frequency and damping from a measured accelerance, as the experimenter finds them.

All methods read the receptance H = -A / w^2 of a mode r near its peak,

    structural damping:   H = C / (w_r^2 - w^2 + j eta w_r^2) + B,        zeta = eta / 2,
    viscous damping:      H = C / (w_r^2 - w^2 + 2 j zeta w_r w) + B,

C the modal constant (phi^2 at a driving point) and B what the other modes leave there.  They differ in what they take B
for: the line fit leaves it out; Dobson's fit and the circle fit take it for a constant; least squares, in
``fit_together``, fits the other modes themselves, and residuals for those out of the band.

Both dampings are one pole p on a straight axis,

    h = C / (p - x) + b:    structural  h = H,     x = w^2,            p = w_r^2 (1 + j eta)
                            viscous     h = w H,   x = w - w_r^2 / w,  p = 2 j zeta w_r,

so that the fits of one mode are written once; of viscous damping w_r is found by iteration.

Standard errors of the fits of one mode are those of a jackknife: every tenth of the band's points left out in turn.

References
----------
Ewins, Modal Testing, 2nd ed. (2000), chapter 4: line fit, circle fit.
Dobson, A straight-line technique for extracting modal properties from frequency response data, Mech. Syst. Signal
Process. 1 (1987) 29-40, doi:10.1016/0888-3270(87)90081-9.
Miller, The jackknife - a review, Biometrika 61 (1974) 1-15, doi:10.1093/biomet/61.1.1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from ..errors import ModalError

FEWEST_POINTS = 5
"""In a band: two straight lines have four coefficients."""
NEAR = 1.2
"""A peak within this factor of where it is looked for is the one meant."""
GROUPS = 10
"""Of points that the jackknife leaves out in turn."""
FIXED_POINTS = 200
"""Of a band, that Dobson's differences are taken from at most."""
ITERATIONS = 20
"""Of a viscous mode's natural frequency; each divides its error by 10,000 or so."""
CONVERGED = 1e-10
"""Change of the natural frequency at which they end, over itself."""


class Damping(StrEnum):
    """Damping model of the fitted modes: structural (displacement) or viscous (velocity)."""

    STRUCTURAL = "structural"
    VISCOUS = "viscous"


@dataclass(frozen=True)
class Fit:
    """Mode fitted to an FRF.

    Parameters
    ----------
    frequency : natural frequency [Hz]
    damping_ratio : zeta = eta / 2 [-]; negative where the response runs ahead of the force
    modal_constant : C [kg^-1], complex where the method allows it
    frequency_error, damping_ratio_error : standard errors by the scatter about the fit
    quality : coefficient of determination of the fitted accelerance in the band [-]
    """

    frequency: float
    damping_ratio: float
    modal_constant: complex
    frequency_error: float = np.nan
    damping_ratio_error: float = np.nan
    quality: float = np.nan


def half_power_band(frequency, accelerance, near: float) -> slice:
    """Slice of the points round the peak next to ``near`` whose accelerance is at least 1 / sqrt 2 of the peak's.

    Parameters
    ----------
    frequency : (n,) increasing array [Hz]
    accelerance : (n,) complex array
    near : [Hz]

    Raises
    ------
    ModalError
        If there is no peak that stands out by 3 dB within 20 % of ``near``, or if its band holds too few points.
    """
    from scipy.signal import find_peaks

    frequency, size = np.asarray(frequency), np.abs(accelerance)
    peaks, _ = find_peaks(levels(size), prominence=np.log(2) / 2)
    away = np.abs(np.log(frequency[peaks] / near))
    if not len(peaks) or away.min() > np.log(NEAR):
        known = ", ".join(f"{f:.4g}" for f in frequency[peaks]) or "none"
        raise ModalError(
            f"no peak near {near:g} Hz that falls by 3 dB on both sides; the FRF's peaks: {known} "
            f"(data from {frequency[0]:.4g} to {frequency[-1]:.4g} Hz)"
        )
    peak = int(peaks[np.argmin(away)])
    low = size < size[peak] / np.sqrt(2)
    first, last = int(np.flatnonzero(low[:peak])[-1]) + 1, int(peak + np.flatnonzero(low[peak:])[0])
    if last - first < FEWEST_POINTS:
        raise ModalError(
            f"only {last - first} points in the half-power band near {near:g} Hz: "
            f"measure with steps of at most {(frequency[last] - frequency[first - 1]) / 10:.2g} Hz"
        )
    return slice(first, last)


def levels(size) -> np.ndarray:
    """Logarithm of sizes, those of nothing as far below the largest as doubles reach."""
    return np.log(np.maximum(size, np.max(size) * np.finfo(float).tiny) + np.finfo(float).tiny)


def line_fit(frequency, accelerance, damping: Damping = Damping.STRUCTURAL) -> Fit:
    """Line fit: the real and the imaginary part of 1 / h are straight lines over x, (p - x) / C.

    The natural frequency is where the real line crosses zero; the damping is the imaginary line there, over the real
    line's slope.  Neighbouring modes bias it: B bends both lines.

    Parameters
    ----------
    frequency, accelerance : (n,) arrays [Hz], [m s^-2 N^-1]
    damping : structural or viscous

    Raises
    ------
    ModalError
        If the lines are those of no resonance.
    """
    return _one_mode(_line, frequency, accelerance, damping, residual=False)


def dobson(frequency, accelerance, damping: Damping = Damping.STRUCTURAL) -> Fit:
    """Dobson's fit: differences from a fixed point W, (x - X) / (h(x) - h(X)), are free of a constant B.

    They are (p - x) (p - X) / C: straight over x for each W, with slopes that are straight over X.  Every point of the
    band serves as W, of long bands 200 of them.  Points weigh by the size of the difference, which is what keeps their
    noise in bounds near W.

    Parameters and errors as of ``line_fit``.
    """
    return _one_mode(_differences, frequency, accelerance, damping)


def circle_fit(frequency, accelerance, damping: Damping = Damping.STRUCTURAL) -> Fit:
    """Circle fit: h runs along a circle of diameter C / Im p, moved by B, and its angle tells the frequency.

    Seen from the centre the angle is psi + 2 atan((Re p - x) / Im p), fitted to all points at once: the same as the
    mean over all pairs of points, each weighed as its spacing deserves.

    Parameters and errors as of ``line_fit``.
    """
    return _one_mode(_circle, frequency, accelerance, damping)


def _line(x, h) -> tuple[complex, complex]:
    """Pole and modal constant by two straight lines."""
    real, imaginary = (np.polyfit(x, part, 1) for part in ((1 / h).real, (1 / h).imag))
    at = -real[1] / real[0]
    return complex(at, -np.polyval(imaginary, at) / real[0]), complex(-1 / real[0])


def _differences(x, h) -> tuple[complex, complex]:
    """Pole and modal constant by Dobson's differences."""
    fixed = np.unique(np.linspace(0, len(x) - 1, min(len(x), FIXED_POINTS)).astype(int))
    slope, weight = np.empty(len(fixed), complex), np.empty(len(fixed))
    for row, k in enumerate(fixed):
        rest = np.arange(len(x)) != k
        span, difference = x[rest] - x[k], h[rest] - h[k]
        slope[row], weight[row] = _line_slope(x[rest], span / difference, np.abs(difference) ** 2 / np.abs(span))
    across = np.stack([np.ones(len(fixed)), x[fixed]], axis=1) * weight[:, None]
    (at_zero, slope_of_slopes), *_ = np.linalg.lstsq(across, slope * weight, rcond=None)
    return complex(-at_zero / slope_of_slopes), complex(1 / slope_of_slopes)


def _circle(x, h) -> tuple[complex, complex]:
    """Pole and modal constant by the angle along a circle; the circle is as large as it is, whatever the damping."""
    from scipy.optimize import least_squares as solve

    (a, b, c), *_ = np.linalg.lstsq(np.stack([h.real, h.imag, np.ones(len(h))], axis=1), np.abs(h) ** 2, rcond=None)
    start = np.array([a / 2, b / 2, np.sqrt(c + (a**2 + b**2) / 4)])
    circle = solve(lambda p: np.abs(h - p[0] - 1j * p[1]) - p[2], start, x_scale=start[2]).x
    angle = np.unwrap(np.angle(h - circle[0] - 1j * circle[1]))
    peak = int(np.argmax(np.abs(h)))
    width = (x[-1] - x[0]) / 2
    sweep = solve(
        lambda p: angle - p[0] - 2 * np.arctan((p[1] - x) / p[2]),
        [angle[peak], x[peak], width if angle[-1] < angle[0] else -width],
        x_scale=[1, width, width],
    )
    psi, at, loss = sweep.x
    turn = np.exp(1j * (psi + np.pi / 2))  # at resonance h - b = C / (j Im p)
    return complex(at, loss), complex(2 * circle[2] * loss * turn)


def _one_mode(solve: Callable, frequency, accelerance, damping: Damping, *, residual: bool = True) -> Fit:
    """A fit with its standard errors and its quality; ``residual``: with a constant b."""
    f, a = np.asarray(frequency, float), np.asarray(accelerance, complex)
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused
            found, fitted = _pole(solve, f, a, damping, residual)
            groups = min(len(f), GROUPS)
            parts = [_pole(solve, f[left], a[left], damping, residual)[0] for left in _left_out(len(f), groups)]
    except (np.linalg.LinAlgError, ValueError) as error:
        raise ModalError(f"the points from {f[0]:.4g} to {f[-1]:.4g} Hz are those of no resonance") from error
    values = np.array([[part.frequency, part.damping_ratio] for part in parts])
    error = np.sqrt((groups - 1) * np.mean((values - values.mean(axis=0)) ** 2, axis=0))
    return replace(
        found, frequency_error=float(error[0]), damping_ratio_error=float(error[1]), quality=quality(a, fitted)
    )


def _left_out(count: int, groups: int):
    """Which points are left, every group left out in turn."""
    return (np.arange(count) % groups != k for k in range(groups))


def quality(measured, fitted) -> float:
    """Coefficient of determination of complex values, 1 - sum |a - fit|^2 / sum |a - mean|^2; NaN of less than two."""
    if len(measured) < 2:
        return np.nan
    return float(1 - np.sum(np.abs(measured - fitted) ** 2) / np.sum(np.abs(measured - np.mean(measured)) ** 2))


def _pole(solve: Callable, f, a, damping: Damping, residual: bool) -> tuple[Fit, np.ndarray]:
    """The mode of a pole without errors, and the accelerance that it gives."""
    scale = float(np.mean(f))
    s = f / scale
    if damping is Damping.STRUCTURAL:
        x, h = s**2, -a / s**2
        pole, constant = solve(x, h)
        natural, ratio = np.sqrt(pole.real), pole.imag / pole.real / 2
    else:
        natural, h = s[np.argmax(np.abs(a))], -a / s
        for _ in range(ITERATIONS):
            x = s - natural**2 / s
            pole, constant = solve(x, h)
            before, natural = natural, pole.real / 2 + np.sqrt(pole.real**2 / 4 + natural**2)
            if not abs(natural - before) > CONVERGED * natural:
                break
        ratio = pole.imag / natural / 2
    if not np.isfinite([natural, ratio, abs(constant)]).all():
        raise ValueError("no pole")
    of_mode = constant / (pole - x)
    rest = np.mean(h - of_mode) if residual else 0.0
    return Fit(float(natural * scale), float(ratio), constant), (of_mode + rest) * a / h


def _line_slope(x, y, weight):
    """Slope of the weighted straight line through complex y, and one over its standard error for unit noise."""
    mean = np.average(x, weights=weight**2)
    lean = weight * (x - mean)
    steep = lean @ lean
    return lean @ (weight * (y - np.average(y, weights=weight**2))) / steep, np.sqrt(steep)
