"""Acceleration of a structure over its excitation, from records of both.

The displacement is read and multiplied by -(2 pi f)^2: of the acceleration itself the impacts would be sampled by
chance, and fold back into the band.  Where the base moves, the displacement is relative to it, and one is added.

An excitation that ends within the run, as a blow, is transformed whole and exactly.  Samples s_k, h apart, with
straight lines between are a sum of triangles:

    F(f) = h sinc^2(f h) sum_k s_k exp(-2 pi j f k h),

the first of them half a triangle.  Nothing of it folds back, however short it is.  One that goes on to the end of the
run is taken in pieces under Hann windows.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..scene.host import Signal

LEAST_SIZE = 2e-2
"""Of the excitation's spectrum, over its largest: other lines, as between and above a blow's lobes, are left out."""

TAPER = 0.2
"""Part of a run, at its end, over which the displacement is faded out (half a cosine)."""

AT_REST = 0.01
"""A structure has come to rest if in that part it moves by less than this part of its largest displacement."""


def averaged(pairs, step: float, pieces: int) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration over excitation, H1 = S_fx / S_ff, spectra averaged over all records and their pieces.

    Parameters
    ----------
    pairs : of (n,) arrays: excitation [N or m/s^2], displacement [m]
    step : [s] between their values
    pieces : 1 (the whole, without a window: for what begins and ends at rest) or more (Hann windows)

    Returns
    -------
    frequency : (m,) array [Hz]
    response : (m,) complex array, [m s^-2 N^-1] or [-]
        NaN where the excitation has no power.
    """
    from scipy.signal import csd, welch

    n = len(pairs[0][0])
    length = 2 * n // (pieces + 1)
    options = {
        "fs": 1 / step,
        "nperseg": min(n, length),
        "window": "hann" if pieces > 1 else "boxcar",
        "detrend": False,
    }
    frequency, _ = welch(pairs[0][0], **options)
    cross = sum(csd(force, displacement, **options)[1] for force, displacement in pairs)
    power = sum(welch(force, **options)[1] for force, _ in pairs)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = -((2 * np.pi * frequency) ** 2) * cross / power
    return frequency, np.where(power > LEAST_SIZE**2 * power.max(), found, np.nan)


def whole(signal: Signal, displacements: Sequence[np.ndarray], step: float) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration over an excitation that ends within the run, mean over the ``displacements`` that it caused.

    Parameters
    ----------
    signal : Signal of samples, the last of them zero
    displacements : of (n,) arrays [m]
    step : [s] between their values

    Returns
    -------
    frequency : (m,) array [Hz]
    response : (m,) complex array, [m s^-2 N^-1] or [-]
        NaN where the excitation is below ``LEAST_SIZE`` of its largest.
    """
    n = len(displacements[0])
    fade = np.clip((np.arange(n) / n - (1 - TAPER)) / TAPER, 0, 1)
    window = 0.5 * (1 + np.cos(np.pi * fade))
    frequency = np.fft.rfftfreq(n, step)
    moved = step * np.fft.rfft(window * np.mean([x - x[0] for x in displacements], axis=0))
    size = transform(signal, len(frequency), frequency[1])
    kept = (np.abs(size) >= LEAST_SIZE * np.abs(size).max()) & (frequency <= 0.5 / signal.sample_step)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = -((2 * np.pi * frequency) ** 2) * moved / size
    return frequency, np.where(kept, found, np.nan)


def transform(signal: Signal, count: int, spacing: float) -> np.ndarray:
    """Fourier transform of samples with straight lines between, at ``count`` multiples of ``spacing`` [Hz]."""
    from scipy.signal import czt

    h, samples = signal.sample_step, signal.samples
    frequency = spacing * np.arange(count)
    triangles = h * np.sinc(frequency * h) ** 2
    turn = 2j * np.pi * frequency[1:] * h
    half = np.concatenate([[h / 2], h * (1 / turn + np.expm1(-turn) / turn**2)])
    summed = czt(samples, count, np.exp(-2j * np.pi * spacing * h))
    return triangles * (summed - samples[0]) + half * samples[0]


def highest(signal: Signal) -> float:
    """Highest frequency at which samples have ``LEAST_SIZE`` of their largest, at most half a sample's [Hz]."""
    count = 1 << (4 * len(signal.samples) - 1).bit_length()
    spacing = 0.5 / signal.sample_step / (count - 1)
    size = np.abs(transform(signal, count, spacing))
    return spacing * float(np.flatnonzero(size >= LEAST_SIZE * size.max())[-1])


def still_moving(displacement: np.ndarray) -> float:
    """Largest displacement in the part that is faded out over the largest of all, both from where it began."""
    moved = np.abs(displacement - displacement[0])
    return float(moved[int((1 - TAPER) * len(moved)) :].max() / moved.max())
