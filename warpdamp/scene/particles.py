"""Particles: what they are, and their state at one moment."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Grains:
    """What the particles are: radius [m] and species (position among the scene's materials) of each."""

    radius: tuple[float, ...]
    species: tuple[int, ...]

    @classmethod
    def alike(cls, radius: float, count: int) -> Grains:
        """Equal spheres of one material."""
        return cls((radius,) * count, (0,) * count)

    def __len__(self) -> int:
        return len(self.radius)


@dataclass
class State:
    """Particles at one moment.

    Parameters
    ----------
    position, velocity, spin : (n, 3) arrays [m, m/s, rad/s]
        Velocity and spin relative to the enclosure.
    radius : (n,) array [m]
    pairs : (m, 2) array of particle numbers i < j
        Touching pairs that remember something.
    pair_history : (m, 4) array [m]
        Stretch of their tangential springs (3) and contact radius; see ``warpdamp.kernels.contact``.
    wall_history : (n, 3, 4) array [m]
        The same for side, floor and lid.
    species : (n,) array of ints
        Position of each particle's material among the scene's; 0 for all unless given.
    pair_roll, wall_roll : (m, 3), (n, 3, 3) arrays [m]
        Stretch of the springs of rolling resistance.
    """

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    radius: np.ndarray
    pairs: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.int32))
    pair_history: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))
    wall_history: np.ndarray = field(default_factory=lambda: np.zeros((0, 3, 4)))
    species: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))
    pair_roll: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    wall_roll: np.ndarray = field(default_factory=lambda: np.zeros((0, 3, 3)))

    def __post_init__(self):
        n = len(self.position)
        if not len(self.wall_history):
            self.wall_history = np.zeros((n, 3, 4))
        if not len(self.wall_roll):
            self.wall_roll = np.zeros((n, 3, 3))
        if not len(self.pair_roll):
            self.pair_roll = np.zeros((len(self.pairs), 3))
        if not len(self.species):
            self.species = np.zeros(n, np.int32)
        if len(self.pairs) and np.any(self.pairs[:, 0] >= self.pairs[:, 1]):
            raise ValueError("pairs are (i, j) with i < j")

    @classmethod
    def at_rest(cls, position, radius, species=0) -> State:
        """Particles at rest at ``position`` (n, 3) with one radius and species, or one each."""
        position = np.array(position, float).reshape(-1, 3)
        radius = np.broadcast_to(np.asarray(radius, float), len(position)).copy()
        species = np.broadcast_to(np.asarray(species, np.int32), len(position)).copy()
        return cls(position, np.zeros_like(position), np.zeros_like(position), radius, species=species)

    def __len__(self) -> int:
        return len(self.position)

    def volume(self) -> float:
        """Of all particles [m^3]."""
        return float(np.sum(4 / 3 * math.pi * self.radius**3))
