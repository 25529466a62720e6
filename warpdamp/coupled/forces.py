"""Forces on a structure as samples with straight lines between."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..config.coupled import RandomConfig, SweptConfig
    from ..scene.scene import Force

SAMPLES = 64
"""To a period of the highest frequency: straight lines then miss a sine by 0.12 % at most, (2 pi / 64)^2 / 8."""


def swept(config: SweptConfig, duration: float) -> tuple[np.ndarray, float]:
    """Samples [N] of a swept sine, and the step between them [s]."""
    from scipy.signal import chirp

    time, step = _times(max(config.from_, config.to), duration)
    phase = -90  # it starts at zero, as a sine
    return config.amplitude * chirp(time, config.from_, duration, config.to, phi=phase), step


def random(config: RandomConfig, duration: float) -> tuple[np.ndarray, float]:
    """Samples [N] of noise in a band, and the step between them [s].

    Raises
    ------
    ValueError
        If no line of the spectrum lies in the band: the run is too short for it.
    """
    time, step = _times(config.to, duration)
    lines = np.fft.rfftfreq(len(time), step)
    inside = (lines >= config.from_) & (lines <= config.to)
    if not inside.any():
        raise ValueError(f"no multiple of 1 / duration lies from {config.from_:g} to {config.to:g} Hz: run it longer")
    rng = np.random.default_rng(config.seed)
    spectrum = np.where(inside, rng.standard_normal(len(lines)) + 1j * rng.standard_normal(len(lines)), 0)
    noise = np.fft.irfft(spectrum, len(time))
    return noise * (config.rms / np.sqrt(np.mean(noise**2))), step


def recorded(path: Path) -> tuple[np.ndarray, float]:
    """Samples [N] from a CSV file with the columns time_s and force_N, and the step between them [s].

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
        if not {"time_s", "force_N"} <= set(names):
            raise ValueError(f"{path}:1: the columns must be time_s and force_N, got {', '.join(names) or 'none'}")
        rows = []
        for row in table:
            try:
                rows.append((float(row["time_s"]), float(row["force_N"])))
            except (TypeError, ValueError):
                raise ValueError(f"{path}:{table.line_num}: time_s and force_N must be numbers") from None
    values = np.array(rows, float).reshape(-1, 2)
    if len(values) < 2 or not np.isfinite(values).all():
        raise ValueError(f"{path}: needs at least two rows of finite numbers")
    time = values[:, 0]
    step = time[-1] / (len(time) - 1)
    if time[0] != 0 or step <= 0 or np.abs(time - step * np.arange(len(time))).max() > 0.05 * step:
        raise ValueError(f"{path}: time_s must start at 0 and be evenly spaced: resample the record")
    return values[:, 1].copy(), float(step)


def moments(force: Force, duration: float) -> np.ndarray:
    """Times at which to evaluate a force, evenly spaced [s]: its samples, or often enough to resolve its cycle."""
    if force.samples is not None:
        return np.arange(len(force.samples)) * force.sample_step
    rate = SAMPLES * force.frequency
    return np.arange(np.ceil(duration * rate) + 1) / rate


def applied(force: Force, time: np.ndarray) -> np.ndarray:
    """Force at given times, (n,) [N]."""
    whole = force.amplitude * np.sin(2 * np.pi * force.frequency * time) if force.amplitude else np.zeros(len(time))
    if force.samples is not None:
        whole += np.interp(time, moments(force, time[-1]), force.samples)
    return whole


def _times(highest: float, duration: float) -> tuple[np.ndarray, float]:
    n = max(2, int(np.ceil(duration * highest * SAMPLES)))
    step = duration / n
    return np.arange(n + 1) * step, step
