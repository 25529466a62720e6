"""Frequency and damping from a measured accelerance, as the experimenter finds them.

All methods read the receptance H = -A / w^2 of a mode r with hysteretic damping, near its peak,

    H = C / (w_r^2 - w^2 + j eta w_r^2) + B,        zeta = eta / 2,

C the modal constant (phi^2 at a driving point) and B what the other modes leave there.  They differ in what they take B
for: the line fit leaves it out; Dobson's fit and the circle fit take it for a constant; least squares fits the other
modes themselves, and residuals for those out of the band.

References
----------
Ewins, Modal Testing, 2nd ed. (2000), chapter 4: line fit, circle fit.
Dobson, A straight-line technique for extracting modal properties from frequency response data, Mech. Syst. Signal
Process. 1 (1987) 29-40, doi:10.1016/0888-3270(87)90081-9.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import ModalError

FEWEST_POINTS = 5
"""In a band: two straight lines have four coefficients."""
NEAR = 1.2
"""A peak within this factor of where it is looked for is the one meant."""


@dataclass(frozen=True)
class Fit:
    """Mode fitted to an FRF.

    Parameters
    ----------
    frequency : natural frequency [Hz]
    damping_ratio : zeta = eta / 2 [-]
    modal_constant : C [kg^-1], complex where the method allows it
    frequency_error, damping_ratio_error : standard errors by the scatter about the fit; NaN if the method has none
    """

    frequency: float
    damping_ratio: float
    modal_constant: complex
    frequency_error: float = np.nan
    damping_ratio_error: float = np.nan


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
    peaks, _ = find_peaks(np.log(size), prominence=np.log(2) / 2)
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


def line_fit(frequency, accelerance) -> Fit:
    """Line fit: real and imaginary part of 1 / H are straight lines over w^2, (w_r^2 - w^2 + j eta w_r^2) / C.

    The natural frequency is where the real line crosses zero; the damping is the imaginary line there, over the real
    line's slope.  Neighbouring modes bias it: B bends both lines.
    """
    scale, x, h = _receptance(frequency, accelerance)
    real, real_cov = np.polyfit(x, (1 / h).real, 1, cov=True)
    imaginary, imaginary_cov = np.polyfit(x, (1 / h).imag, 1, cov=True)

    def modal(p):
        square = -p[1] / p[0]
        return np.array([np.sqrt(square) * scale, -(p[2] * square + p[3]) / (p[0] * square) / 2])

    lines = np.concatenate([real, imaginary])
    error = _propagated(modal, lines, np.block([[real_cov, np.zeros((2, 2))], [np.zeros((2, 2)), imaginary_cov]]))
    return Fit(*map(float, modal(lines)), complex(-1 / real[0]), *error)


def dobson(frequency, accelerance) -> Fit:
    """Dobson's fit: differences from a fixed point W, (w^2 - W^2) / (H(w) - H(W)), are free of a constant B.

    They are (w_r^2 - w^2 + j eta w_r^2) (w_r^2 - W^2 + j eta w_r^2) / C: straight over w^2 for each W, with slopes that
    are straight over W^2.  Every point of the band serves as W.  Points weigh by the size of the difference, which is
    what keeps their noise in bounds near W.
    """
    scale, x, h = _receptance(frequency, accelerance)
    slope, weight = np.empty(len(x), complex), np.empty(len(x))
    for k in range(len(x)):
        rest = np.arange(len(x)) != k
        span, difference = x[rest] - x[k], h[rest] - h[k]
        slope[k], weight[k] = _line_slope(x[rest], span / difference, np.abs(difference) ** 2 / np.abs(span))
    across = np.stack([np.ones(len(x)), x], axis=1) * weight[:, None]
    (at_zero, slope_of_slopes), *_ = np.linalg.lstsq(across, slope * weight, rcond=None)
    square = -at_zero / slope_of_slopes  # w_r^2 (1 + j eta)
    return Fit(*_modal(square, scale), complex(1 / slope_of_slopes))


def circle_fit(frequency, accelerance) -> Fit:
    """Circle fit: H runs along a circle of diameter C / (eta w_r^2), moved by B; its angle gives the frequency.

    Seen from the centre the angle is psi + 2 atan((w_r^2 - w^2) / (eta w_r^2)), fitted to all points at once: the same
    as the mean over all pairs of points, each weighed as its spacing deserves.
    """
    from scipy.optimize import least_squares as solve

    scale, x, h = _receptance(frequency, accelerance)
    (a, b, c), *_ = np.linalg.lstsq(np.stack([h.real, h.imag, np.ones(len(h))], axis=1), np.abs(h) ** 2, rcond=None)
    start = np.array([a / 2, b / 2, np.sqrt(c + (a**2 + b**2) / 4)])
    circle = solve(lambda p: np.abs(h - p[0] - 1j * p[1]) - p[2], start, x_scale=start[2]).x
    angle = np.unwrap(np.angle(h - circle[0] - 1j * circle[1]))
    peak = int(np.argmax(np.abs(accelerance)))
    width = (x[-1] - x[0]) / 2
    sweep = solve(
        lambda p: angle - p[0] - 2 * np.arctan((p[1] - x) / p[2]),
        [angle[peak], x[peak], width],
        x_scale=[1, width, width],
    )
    psi, square, loss = sweep.x
    turn = np.exp(1j * (psi + np.pi / 2))  # at resonance H - B = C / (j eta w_r^2)
    return Fit(*_modal(square + 1j * loss, scale), complex(2 * circle[2] * loss * turn))


def least_squares(frequency, accelerance, start: list[Fit]) -> list[Fit]:
    """Least-squares fit of several modes at once, with residuals for the modes below and above the data.

    A = sum C_r w^2 / (w^2 - w_r^2 (1 + j eta_r)) + below - above w^2, each point weighed by its own size.  Frequencies
    and loss factors are sought; modal constants and residuals, complex as a damper at one point makes them, are linear
    and solved for on the way (variable projection).

    Parameters
    ----------
    frequency, accelerance : (n,) arrays [Hz], [m s^-2 N^-1]
        Of all modes' bands together.
    start : first guesses

    Raises
    ------
    ModalError
        If there are fewer points than unknowns, or if the iteration does not end.
    """
    from scipy.optimize import least_squares as solve

    f, a = np.asarray(frequency, float), np.asarray(accelerance, complex)
    count = len(start)
    scale = np.array([g.frequency for g in start] + [g.damping_ratio for g in start])
    unknowns = 2 * count + 2 * (count + 2)
    if 2 * len(f) <= unknowns:
        raise ModalError(f"{len(f)} points cannot determine {unknowns} unknowns: fit fewer modes or give more points")
    wanted = a / np.abs(a)

    def columns(p):
        own, zeta = p[:count] * scale[:count], p[count:] * scale[count:]
        modes = f[:, None] ** 2 / (f[:, None] ** 2 - own**2 * (1 + 2j * zeta))
        residuals = np.stack([np.ones(len(f)), -((f / f[-1]) ** 2)], axis=1)
        return np.concatenate([modes, residuals], axis=1) / np.abs(a)[:, None]

    def constants(p):
        return np.linalg.lstsq(columns(p), wanted, rcond=None)[0]

    def misfit(p):
        return _parts(columns(p) @ constants(p) - wanted)

    found = solve(misfit, np.ones(2 * count), xtol=1e-12, ftol=1e-12)
    if not found.success:
        raise ModalError(f"the least-squares fit did not end: {found.message}")
    value, constant = found.x * scale, constants(found.x)
    moved = [_parts((columns(found.x + h) - columns(found.x - h)) @ constant / 2e-7) for h in 1e-7 * np.eye(2 * count)]
    every = columns(found.x)
    slopes = np.concatenate([np.stack(moved, axis=1), _parts(every), _parts(1j * every)], axis=1)
    variance = 2 * found.cost / (2 * len(f) - unknowns)
    error = np.sqrt(variance * np.diag(np.linalg.pinv(slopes.T @ slopes))[: 2 * count]) * scale
    return [
        Fit(*map(float, value[[r, count + r]]), complex(constant[r]), *map(float, error[[r, count + r]]))
        for r in range(count)
    ]


def _parts(values):
    """Real and imaginary parts, one below the other."""
    return np.concatenate([values.real, values.imag])


def _receptance(frequency, accelerance):
    """Frequency unit fc, (f / fc)^2, and -A / (f / fc)^2: numbers near one."""
    frequency = np.asarray(frequency, float)
    scale = float(np.mean(frequency))
    x = (frequency / scale) ** 2
    return scale, x, -np.asarray(accelerance, complex) / x


def _modal(square: complex, scale: float) -> tuple[float, float]:
    """Natural frequency [Hz] and damping ratio from w_r^2 (1 + j eta) in units of the scale."""
    return float(np.sqrt(square.real) * scale), float(square.imag / square.real / 2)


def _line_slope(x, y, weight):
    """Slope of the weighted straight line through complex y, and one over its standard error for unit noise."""
    mean = np.average(x, weights=weight**2)
    lean = weight * (x - mean)
    steep = lean @ lean
    return lean @ (weight * (y - np.average(y, weights=weight**2))) / steep, np.sqrt(steep)


def _propagated(function, values, covariance) -> tuple[float, ...]:
    """Standard errors of ``function(values)`` to first order."""
    step = 1e-6 * np.where(values == 0, 1.0, np.abs(values))
    slope = np.array([(function(values + h) - function(values - h)) / (2 * h.sum()) for h in np.diag(step)]).T
    return tuple(float(e) for e in np.sqrt(np.einsum("ij,jk,ik->i", slope, covariance, slope)))
