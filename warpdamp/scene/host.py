"""Host structure that the enclosure is fixed to: its modes, and what moves it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Signal:
    """A function of time: a harmonic part A sin(2 pi f t), and samples with straight lines between.

    Parameters
    ----------
    amplitude : float
        A [N of a force, m/s^2 of a base's motion].
    frequency : float or None
        f of the harmonic part [Hz].
    samples : (n,) array or None
        Recorded, swept or random, in the same unit; after the last sample it keeps that value.
    sample_step : float
        Time between samples [s], the first at time 0.

    Raises
    ------
    ValueError
        If a harmonic part has no positive frequency, or there are fewer than two samples or no positive sample_step.
    """

    amplitude: float = 0.0
    frequency: float | None = None
    samples: np.ndarray | None = None
    sample_step: float = 0.0

    def __post_init__(self):
        if self.amplitude and not (self.frequency and self.frequency > 0):
            raise ValueError(f"a harmonic {self.name} needs a positive frequency")
        if self.samples is not None and (len(self.samples) < 2 or self.sample_step <= 0):
            raise ValueError(f"a sampled {self.name} needs at least two samples and a positive sample_step")


@dataclass(frozen=True, eq=False)
class Force(Signal):
    """Applied to the structure at the damper, along the host's direction [N]."""

    name = "force"


@dataclass(frozen=True, eq=False)
class BaseMotion(Signal):
    """Acceleration of the base that holds the structure, along the host's direction [m/s^2]."""

    name = "base motion"


@dataclass(frozen=True)
class HostStructure:
    """Structure that the enclosure is fixed to: its modes without the particles, and its initial state.

    Parameters
    ----------
    frequency : tuple of m floats
        Natural frequencies [Hz].
    damping : tuple of m floats
        Inherent damping ratios [-].
    amplitude : tuple of m floats
        Mass-normalised mode shapes at the damper, along ``direction`` [kg^-0.5].
    direction : tuple of 3 floats
        Unit vector.
    force : Force or None
        Force on the structure at the damper.
    position, velocity : tuple of m floats
        Modal q [m kg^0.5] and q' [m kg^0.5/s] at the start (zero unless given).
    record : int
        Steps between records of the enclosure's motion and of the particles' force on it; 0: none.
    base : BaseMotion or None
        Instead of a force.  Modal coordinates are then of the motion relative to the base.
    participation : tuple of m floats
        Gamma = phi^T M d of each mode, d the base's unit displacement [kg^0.5]; needed with a base that moves.

    Raises
    ------
    ValueError
        If there is no mode, the tuples differ in length, a frequency is not positive, the direction has not length 1,
        or there are a force and a base.
    """

    frequency: tuple[float, ...]
    damping: tuple[float, ...]
    amplitude: tuple[float, ...]
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)
    force: Force | None = None
    position: tuple[float, ...] = ()
    velocity: tuple[float, ...] = ()
    record: int = 0
    base: BaseMotion | None = None
    participation: tuple[float, ...] = ()

    def __post_init__(self):
        n = len(self.frequency)
        for name in ("position", "velocity"):
            if not getattr(self, name):
                object.__setattr__(self, name, (0.0,) * n)
        if n == 0 or any(len(getattr(self, name)) != n for name in ("damping", "amplitude", "position", "velocity")):
            raise ValueError(
                "a host structure needs a damping, an amplitude, a position and a velocity for each frequency"
            )
        if min(self.frequency) <= 0 or abs(math.hypot(*self.direction) - 1) > 1e-9:
            raise ValueError("a host structure needs positive frequencies and a direction of length 1")
        if self.force and self.base:
            raise ValueError("a host structure is moved by a force or by its base, not by both")
        if self.base and len(self.participation) != n:
            raise ValueError("a host structure on a base that moves needs a participation for each frequency")

    @property
    def excitation(self) -> Signal | None:
        """Excitation of the structure: the force, or the acceleration of its base."""
        return self.force or self.base

    @property
    def load(self) -> tuple[float, ...]:
        """Modal force per unit of the excitation, of each mode: phi of a force, -Gamma of a base acceleration."""
        return tuple(-gamma for gamma in self.participation) if self.base else self.amplitude

    @property
    def speed(self) -> float:
        """Largest speed of the enclosure in free vibration from the start [m/s]."""
        return sum(
            abs(phi) * math.hypot(v, 2 * math.pi * f * q)
            for f, phi, q, v in zip(self.frequency, self.amplitude, self.position, self.velocity, strict=True)
        )
