"""Signals that move a structure, a force or its base's acceleration, as samples with straight lines between."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import UsageError

if TYPE_CHECKING:
    from ..config.coupled import BaseSweptConfig, RandomConfig, SweptConfig
    from ..scene.host import Signal

SAMPLES = 64
"""To a period of the highest frequency: straight lines then miss a sine by 0.12 % at most, (2 pi / 64)^2 / 8."""


def swept(config: SweptConfig | BaseSweptConfig, duration: float) -> tuple[np.ndarray, float]:
    """Samples of a swept sine, and the step between them [s]."""
    from scipy.signal import chirp

    time, step = times(max(config.from_, config.to), duration)
    phase = -90  # it starts at zero, as a sine
    return config.amplitude * chirp(time, config.from_, duration, config.to, phi=phase), step


def random(config: RandomConfig, duration: float) -> tuple[np.ndarray, float]:
    """Samples [N] of noise in a band, and the step between them [s].

    Raises
    ------
    UsageError
        If no line of the spectrum lies in the band: the run is too short for it.
    """
    time, step = times(config.to, duration)
    lines = np.fft.rfftfreq(len(time), step)
    inside = (lines >= config.from_) & (lines <= config.to)
    if not inside.any():
        raise UsageError(f"no multiple of 1 / duration lies from {config.from_:g} to {config.to:g} Hz: run it longer")
    rng = np.random.default_rng(config.seed)
    spectrum = np.where(inside, rng.standard_normal(len(lines)) + 1j * rng.standard_normal(len(lines)), 0)
    noise = np.fft.irfft(spectrum, len(time))
    return noise * (config.rms / np.sqrt(np.mean(noise**2))), step


def moments(signal: Signal, duration: float) -> np.ndarray:
    """Times at which to evaluate a signal, evenly spaced [s]: its samples, or often enough to resolve its cycle."""
    if signal.samples is not None:
        return np.arange(len(signal.samples)) * signal.sample_step
    rate = SAMPLES * signal.frequency
    return np.arange(np.ceil(duration * rate) + 1) / rate


def applied(signal: Signal, time: np.ndarray) -> np.ndarray:
    """Signal at given times, (n,) in its unit."""
    whole = signal.amplitude * np.sin(2 * np.pi * signal.frequency * time) if signal.amplitude else np.zeros(len(time))
    if signal.samples is not None:
        whole += np.interp(time, moments(signal, time[-1]), signal.samples)
    return whole


def root_mean_square(samples: np.ndarray) -> float:
    """Root mean square of samples with straight lines between: the mean of (a^2 + a b + b^2) / 3."""
    a, b = samples[:-1], samples[1:]
    return float(np.sqrt(np.mean(a * a + a * b + b * b) / 3))


def times(highest: float, duration: float) -> tuple[np.ndarray, float]:
    """Moments of samples up to ``duration`` that show the ``highest`` frequency, and the step between them [s]."""
    n = max(2, int(np.ceil(duration * highest * SAMPLES)))
    step = duration / n
    return np.arange(n + 1) * step, step
