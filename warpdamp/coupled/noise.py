"""Noise of a given power spectral density, by the sum of its lines with random phases.

The density G(f) is straight between breakpoints on logarithmic scales, G = G_1 (f / f_1)^m.  In a run of T seconds

    x(t) = sum_k sqrt(2 G(f_k) / T) cos(2 pi f_k t + phase_k),     f_k = k / T,     phase_k uniform,

so that the root mean square of every realisation is that of the lines, whatever the phases: Shinozuka & Deodatis 1991,
doi:10.1115/1.3119501.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from ..errors import UsageError
from . import forces

Table = list[tuple[float, float]]


def density(table: Table, frequency: np.ndarray) -> np.ndarray:
    """Power spectral density at given frequencies [Hz]; zero beyond the table."""
    known, value = np.log(np.array(table)).T
    with np.errstate(divide="ignore"):
        found = np.exp(np.interp(np.log(frequency), known, value))
    return np.where((frequency >= table[0][0]) & (frequency <= table[-1][0]), found, 0.0)


def rms(table: Table) -> float:
    """Root mean square of a density: the root of its integral, in closed form from breakpoint to breakpoint."""
    return math.sqrt(sum(_area(*low, *high) for low, high in itertools.pairwise(table)))


def _area(f1: float, g1: float, f2: float, g2: float) -> float:
    """G_1 f_1 ((f_2 / f_1)^(m + 1) - 1) / (m + 1), the logarithm where m = -1."""
    octaves = math.log(f2 / f1)
    power = (math.log(g2 / g1) / octaves + 1) * octaves
    return g1 * f1 * octaves * (math.expm1(power) / power if abs(power) > 1e-12 else 1.0)


def samples(table: Table, seed: int, duration: float) -> tuple[np.ndarray, float]:
    """Samples of noise with the density of a table, and the step between them [s].

    The straight lines that join the samples pass sinc^2(f step) of a line: each is raised by as much.

    Raises
    ------
    UsageError
        If no multiple of 1 / duration lies in the table.
    """
    time, step = forces.times(table[-1][0], duration)
    n = len(time) - 1
    frequency = np.fft.rfftfreq(n, step)
    power = density(table, frequency) / duration
    if not power.any():
        raise UsageError(f"no multiple of 1 / duration lies from {table[0][0]:g} to {table[-1][0]:g} Hz: run it longer")
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, len(frequency))
    lines = np.sqrt(power / 2) * n * np.exp(1j * phase) / np.sinc(frequency * step) ** 2
    noise = np.fft.irfft(lines, n)
    return np.append(noise, noise[0]), step
