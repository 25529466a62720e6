"""Signals that move a structure, a force or its base's acceleration, as samples with straight lines between."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..config.coupled import BaseSweptConfig, RandomConfig, SweptConfig
    from ..scene.scene import Signal

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
    ValueError
        If no line of the spectrum lies in the band: the run is too short for it.
    """
    time, step = times(config.to, duration)
    lines = np.fft.rfftfreq(len(time), step)
    inside = (lines >= config.from_) & (lines <= config.to)
    if not inside.any():
        raise ValueError(f"no multiple of 1 / duration lies from {config.from_:g} to {config.to:g} Hz: run it longer")
    rng = np.random.default_rng(config.seed)
    spectrum = np.where(inside, rng.standard_normal(len(lines)) + 1j * rng.standard_normal(len(lines)), 0)
    noise = np.fft.irfft(spectrum, len(time))
    return noise * (config.rms / np.sqrt(np.mean(noise**2))), step


def recorded(path: Path, columns: dict[str, float]) -> tuple[np.ndarray, float]:
    """Samples in SI from a CSV file with the column time_s and one of ``columns``, and the step between them [s].

    A sample of zero follows the last: after its record a signal is at rest.

    Parameters
    ----------
    path : Path
    columns : names that the second column may have, each with its unit in SI

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it does not hold what is said above; names the line.
    """
    with path.open(newline="", encoding="utf-8-sig") as file:
        table = csv.DictReader(file, skipinitialspace=True)
        names = [name.strip() for name in table.fieldnames or ()]
        table.fieldnames = names
        column = next((name for name in columns if sorted(names) == sorted(("time_s", name))), None)
        if column is None:
            wanted, got = " or ".join(columns), ", ".join(names) or "none"
            raise ValueError(f"{path}:1: the columns must be time_s and {wanted}, got {got}")
        rows = []
        for row in table:
            try:
                rows.append((float(row["time_s"]), float(row[column])))
            except (TypeError, ValueError):
                raise ValueError(f"{path}:{table.line_num}: time_s and {column} must be numbers") from None
    values = np.array(rows, float).reshape(-1, 2)
    if len(values) < 2 or not np.isfinite(values).all():
        raise ValueError(f"{path}: needs at least two rows of finite numbers")
    if not values[:, 1].any():
        raise ValueError(f"{path}: {column} is zero throughout")
    time = values[:, 0]
    step = time[-1] / (len(time) - 1)
    if time[0] != 0 or step <= 0 or np.abs(time - step * np.arange(len(time))).max() > 0.05 * step:
        raise ValueError(f"{path}: time_s must start at 0 and be evenly spaced: resample the record")
    return columns[column] * np.append(values[:, 1], 0.0), float(step)


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
