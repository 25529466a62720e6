"""Film of a case: what is shown of a trajectory, and what its particles are coloured by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np

from ..damper.trajectory import Frame, Trajectory
from ..scene.bodies import Bodies
from ..scene.shape import SPHERES, bodies_of, shape_of


class Colour(StrEnum):
    """Quantity that colours the particles."""

    SPEED = "speed"
    SPIN = "spin"
    ENERGY = "energy"


@dataclass(frozen=True)
class Quantity:
    """Quantity of a particle: name, unit as shown, and its value in every particle of a frame."""

    name: str
    unit: str
    of: Callable[[Frame], np.ndarray]


QUANTITIES = {
    Colour.SPEED: Quantity("speed in the cavity", "mm/s", lambda f: 1e3 * np.linalg.norm(f.state.velocity, axis=1)),
    Colour.SPIN: Quantity("spin", "rad/s", lambda f: np.linalg.norm(f.state.spin, axis=1)),
    Colour.ENERGY: Quantity("energy lost in this film", "µJ", lambda f: 1e6 * f.lost),
}

BRIGHTEST = 99.0
"""Percentile of a quantity, over all frames, that has the last colour: single fast particles would darken the rest."""


@dataclass(frozen=True)
class Film:
    """Film of a case.

    Parameters
    ----------
    trajectory : Trajectory
    title : of the study
    label : what the case is known by
    remark : how its numbers compare with those of the results
    source : versions and references
    discarded : cycles at the start that the averages leave out
    colour : what colours the particles at first
    forces : whether contact forces are drawn at first
    beside : films of other dampers of the structure in the same moments, to be shown beside this one
    """

    trajectory: Trajectory
    title: str
    label: str
    remark: str = ""
    source: str = ""
    discarded: int = 0
    colour: Colour = Colour.SPEED
    forces: bool = False
    beside: tuple[Film, ...] = ()

    @property
    def every(self) -> tuple[Film, ...]:
        """The film and those beside it."""
        return (self, *self.beside)

    @property
    def frames(self) -> list[Frame]:
        """Frames in their order."""
        return self.trajectory.frames

    @property
    def particles(self) -> int:
        """Number of particles."""
        return len(self.frames[0].state)

    @property
    def shown(self) -> int:
        """Cycles of the drive that the frames show."""
        first, last = self.frames[0].cycle, self.frames[-1].cycle
        return max(1, round((last - first) * len(self.frames) / max(1, len(self.frames) - 1)))

    def values(self, colour: Colour) -> np.ndarray:
        """Quantity of every particle in every frame, (frames, n), in the unit of ``QUANTITIES``."""
        return np.array([QUANTITIES[colour].of(frame) for frame in self.frames])

    def most(self, colour: Colour) -> float:
        """Value that has the last colour, in every film; positive."""
        values = np.concatenate([film.values(colour).ravel() for film in self.every])
        return float(np.percentile(values, BRIGHTEST)) or 1.0

    @cached_property
    def strongest(self) -> float:
        """Largest contact force of all frames of every film [N]; positive."""
        sizes = [np.linalg.norm(frame.touching.force, axis=1) for film in self.every for frame in film.frames]
        return float(max((s.max() for s in sizes if len(s)), default=0.0)) or 1.0


def turned(frame: Frame) -> Bodies | None:
    """Particles of a frame as they lie [m]; None if all are spheres."""
    return None if shape_of(frame.state) is SPHERES else bodies_of(frame.state)
