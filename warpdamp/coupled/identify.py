"""Coupled runs, in which the structure answers the particles, read as an experimenter would read them.

The reference for the prediction from prescribed motion: natural frequency and damping of one mode from its steady
response to a harmonic force, or from its decay after release.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..scene.host import HostStructure
from ..scene.scene import STANDARD_GRAVITY

if TYPE_CHECKING:
    from ..modes import Modes


@dataclass(frozen=True)
class Identified:
    """Mode identified at one amplitude.

    Parameters
    ----------
    gamma : acceleration amplitude at the damper over g
    frequency : natural frequency [Hz]
    damping : damping ratio
    """

    gamma: float
    frequency: float
    damping: float


def host_of(modes: Modes, damping, **start) -> HostStructure:
    """Host structure of modes without particles, with their inherent damping ratios; ``start``: its further fields."""
    gammas = () if modes.participation is None else modes.participation @ np.asarray(modes.direction)
    return HostStructure(
        tuple(map(float, modes.frequency)),
        tuple(map(float, damping)),
        tuple(map(float, modes.amplitude)),
        participation=tuple(map(float, gammas)),
        **start,
    )


def first_harmonic(time, values, frequency: float) -> complex:
    """Amplitude V of the part Re(V exp(j w t)) in whole cycles of evenly spaced records."""
    return complex(2 * np.mean(values * np.exp(-2j * math.pi * frequency * time)))


def from_response(records: np.ndarray, host: HostStructure, cycles: int) -> list[Identified]:
    """Identify a mode from its steady response to a harmonic signal, window by window.

    X / S = phi load / (w_n^2 - w^2 + 2 j zeta w_n w) of an equivalent linear mode is solved for w_n and zeta; where a
    transient has no such mode they are NaN.  Early windows are of the transient: the reader chooses.

    Parameters
    ----------
    records : (n, 4) array
        See ``Batch.records``.
    host : HostStructure
        Of one mode, with a harmonic force or base motion.
    cycles : to a window
    """
    signal, scale = host.excitation, host.amplitude[0] * host.load[0]
    w = 2 * math.pi * signal.frequency
    applied = -1j * signal.amplitude  # A sin(w t) = Re(-j A exp(j w t))
    number = np.floor(records[:, 0] * signal.frequency / cycles + 1e-9).astype(int)
    end = records[-1, 0] + records[1, 0] - records[0, 0]
    found = []
    for k in range(int(end * signal.frequency / cycles + 1e-6)):
        window = records[number == k]
        place = first_harmonic(window[:, 0], window[:, 1], signal.frequency)
        stiffness = scale * applied / place  # w_n^2 - w^2 + 2 j zeta w_n w
        squared = w**2 + stiffness.real
        natural = math.sqrt(squared) if squared > 0 else math.nan
        acceleration = -(w**2) * place + (applied if host.base else 0.0)
        gamma = abs(acceleration) / STANDARD_GRAVITY
        found.append(Identified(gamma, natural / (2 * math.pi), stiffness.imag / (2 * natural * w)))
    return found


def from_decay(records: np.ndarray) -> list[Identified]:
    """Identify a mode from a decay, swing by swing: the logarithmic decrement between successive swings.

    A swing goes from a maximum to the next minimum, so that the particles' weight, which shifts both, does not count.
    """
    time, place = records[:, 0], records[:, 1] - records[:, 1].mean()
    moment, highest = _maxima(time, place)
    below, lowest = _maxima(time, -place)
    after = np.searchsorted(below, moment)
    whole = after < len(below)
    moment, swing = moment[whole], (highest[whole] + lowest[after[whole]]) / 2
    found = []
    for (t0, a0), (t1, a1) in zip(
        zip(moment, swing, strict=True), zip(moment[1:], swing[1:], strict=True), strict=False
    ):
        decrement = math.log(a0 / a1) / (2 * math.pi)
        damping = decrement / math.sqrt(1 + decrement**2)
        frequency = 1 / (t1 - t0) / math.sqrt(1 - damping**2)
        amplitude = math.sqrt(a0 * a1) * (2 * math.pi * frequency) ** 2 / STANDARD_GRAVITY
        found.append(Identified(amplitude, frequency, damping))
    return found


def _maxima(time, value) -> tuple[np.ndarray, np.ndarray]:
    """Moments and heights of the positive maxima: of parabolas through the three highest records."""
    k = 1 + np.flatnonzero((value[1:-1] > value[:-2]) & (value[1:-1] >= value[2:]) & (value[1:-1] > 0))
    left, middle, right = value[k - 1], value[k], value[k + 1]
    shift = 0.5 * (left - right) / (left - 2 * middle + right)
    return time[k] + shift * (time[1] - time[0]), middle - 0.25 * (left - right) * shift
