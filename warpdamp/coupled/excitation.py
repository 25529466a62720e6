"""Excitation of a coupled run, and the steps that resolve it: configuration -> Signal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..errors import UsageError
from ..scene.host import BaseMotion, Force, HostStructure, Signal
from ..scene.scene import STANDARD_GRAVITY
from . import forces, noise, recorded, response

if TYPE_CHECKING:
    from ..config.coupled import CoupledConfig
    from ..config.study import Config
    from ..modes import Modes

RECORDS = 32
"""To a period of the fastest thing that happens."""

RECORDS_OF_CONTENT = 8
"""To a period of the highest frequency of a record or a spectrum.

A displacement falls with the square of frequency above the modes, and a blow does beyond its first lobe: what folds
back at the highest frequency is (1 / 7)^2 of it at most.
"""

STEPS_OF_CONTENT = 32
"""To that period: central differences shift an acceleration by (2 pi / 32)^2 / 12, 0.3 %."""

LEAST_DAMPING = 0.01
"""Damping ratio with which the structure's largest speed is foreseen, if its own is less: the damper adds more."""

REST = 0.01
"""A record is at rest where it is below this part of its largest value."""


def signals(config: Config) -> list[Signal | None]:
    """The force or the base's acceleration of each level; None of a release.

    Raises
    ------
    ConfigError
        If a record cannot be read or does not end at rest, or if a run is too short for its noise.
    """
    own, kind = config.coupled, BaseMotion if config.coupled.base else Force
    harmonic = own.signals.harmonic
    if own.release:
        return [None] * len(own.levels)
    if harmonic:
        return [kind(level * harmonic.amplitude, harmonic.frequency) for level in own.levels]
    try:
        samples, step = _samples(config)
    except UsageError as error:
        raise config.error(f"coupled.{own.source}", str(error)) from None
    return [kind(samples=level * samples, sample_step=step) for level in own.levels]


def _samples(config: Config) -> tuple[np.ndarray, float]:
    own = config.coupled
    signal, duration = own.signals, own.duration
    if signal.swept:
        return forces.swept(signal.swept, duration)
    if signal.random:
        if signal.random.spectrum:
            return noise.samples(signal.random.spectrum, signal.random.seed, duration)
        return forces.random(signal.random, duration)
    samples, step = recorded.samples(config.folder / signal.recorded.file, "acceleration" if own.base else "force")
    end, largest = abs(samples[-2]), np.abs(samples).max()
    if (len(samples) - 2) * step < duration and end > REST * largest:
        raise UsageError(
            f"{signal.recorded.file}: the record ends before the run does, at {100 * end / largest:.2g} % of its "
            f"largest value: let it come to rest, or take a duration of at most {(len(samples) - 2) * step:.4g} s"
        )
    within = samples[: math.floor(duration / step) + 2]
    return np.append(within[:-1], 0.0), step


def ends_within(signal: Signal, duration: float) -> bool:
    """Whether samples have come to rest when a run begins to fade out, so that they can be transformed whole."""
    size = np.abs(signal.samples)
    last = np.flatnonzero(size > REST * size.max())[-1]
    return (last + 1) * signal.sample_step <= (1 - response.TAPER) * duration


def start(own: CoupledConfig, modes: Modes, level: float, weight: np.ndarray) -> tuple[float, ...]:
    """Modal coordinates at the start: as released; before a record, at rest under the particles' weight.

    Parameters
    ----------
    weight : (m,) array
        Modal force of the particles' weight on each mode [N kg^-0.5].
    """
    place = np.zeros(len(modes.number))
    w = 2 * math.pi * modes.frequency
    if own.release:
        k = int(np.flatnonzero(modes.number == own.release.mode)[0])
        place[k] = level * own.release.gamma * STANDARD_GRAVITY / w[k] ** 2 / modes.amplitude[k]
    elif own.signals.recorded:
        place = weight / w**2
    return tuple(place)


def reference(own: CoupledConfig, modes: Modes) -> float:
    """Highest frequency that the records are to show [Hz]; a harmonic signal's cycle is a whole number of theirs."""
    highest = float(max(modes.frequency))
    harmonic, random = own.signals.harmonic, own.signals.random
    if harmonic:
        return harmonic.frequency * max(1, math.ceil(highest / harmonic.frequency))
    band = own.signals.swept or (random if random and not random.spectrum else None)
    return max(highest, band.from_, band.to) if band else highest


def content(own: CoupledConfig, signal: Signal | None) -> float:
    """Highest frequency of a record or a spectrum [Hz]; 0 of what ``reference`` knows."""
    if own.signals.recorded:
        return response.highest(signal)
    random = own.signals.random
    return random.spectrum[-1][0] if random and random.spectrum else 0.0


def largest_speed(hosts: Sequence[HostStructure], loaded: Modes, amplitudes: np.ndarray, duration: float) -> float:
    """Largest speed of the enclosures [m/s], if the particles in each were one rigid mass: the step is chosen for it.

    Parameters
    ----------
    hosts : of HostStructure
        The structure as each damper sees it.
    loaded : Modes
        Its modes with those masses, as the first damper sees them.
    amplitudes : (dampers, m) array
        Their shapes at all dampers [kg^-0.5].
    duration : [s]
    """
    excitation = hosts[0].excitation
    if excitation is None:
        return max(host.speed for host in hosts)
    time = forces.moments(excitation, duration)
    signal = forces.applied(excitation, time)
    load, base = loaded.amplitude, np.zeros(len(time))
    if hosts[0].base:
        load = -base_participation(loaded)
        base = np.cumsum(signal - signal.mean()) * time[1]
    answers = [
        _modal_speed(signal, time[1], f, max(zeta, LEAST_DAMPING))
        for f, zeta in zip(loaded.frequency, loaded.inherent_damping, strict=True)
    ]
    return max(
        float(np.abs(sum((phi * own * v for phi, own, v in zip(there, load, answers, strict=True)), base)).max())
        for there in amplitudes
    )


def _modal_speed(signal: np.ndarray, step: float, frequency: float, damping: float) -> np.ndarray:
    """Speed of a mode under unit load times a signal with straight lines between its samples."""
    from scipy.signal import cont2discrete, lfilter

    w = 2 * math.pi * frequency
    numerator, denominator, _ = cont2discrete(([1, 0], [1, 2 * damping * w, w**2]), step, "foh")
    return lfilter(numerator.ravel(), denominator, signal)


def base_participation(modes: Modes) -> np.ndarray:
    """(m,) participation factors of a base that moves along the modes' direction [kg^0.5]."""
    return modes.participation @ np.asarray(modes.direction)
