"""Particles: what they are, and their state at one moment."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np

from .scene import _HISTORIES, ContactHistory, sphere_volume


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
    pair_history : ContactHistory of (m,) contacts
    wall_history : ContactHistory of (n, 3) contacts
        With side, floor and lid.
    species : (n,) array of ints
        Position of each particle's material among the scene's; 0 for all unless given.

    Raises
    ------
    ValueError
        If a pair is not (i, j) with i < j.
    """

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    radius: np.ndarray
    pairs: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.int32))
    pair_history: ContactHistory | None = None
    wall_history: ContactHistory | None = None
    species: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))

    def __post_init__(self):
        n = len(self.position)
        if self.pair_history is None:
            self.pair_history = ContactHistory.none(len(self.pairs))
        if self.wall_history is None:
            self.wall_history = ContactHistory.none(n, 3)
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

    @property
    def bounding_radius(self) -> np.ndarray:
        """Radius of the smallest sphere about each centre that holds the particle, (n,) [m]."""
        return self.radius

    def volume(self) -> float:
        """Volume of all particles [m^3]."""
        return float(np.sum(sphere_volume(self.radius)))

    def arrays(self) -> dict[str, np.ndarray]:
        """The state as named arrays, as files hold it; see ``from_arrays``."""
        plain = {name: value for name, value in vars(self).items() if name not in _HISTORIES}
        return plain | {
            f"{name}_{part}": array for name in _HISTORIES for part, array in vars(getattr(self, name)).items()
        }

    @classmethod
    def from_arrays(cls, arrays: dict[str, np.ndarray]) -> State:
        """The state of ``arrays``.

        Raises
        ------
        KeyError, TypeError
            If one is missing, or one too many.
        """
        rest = dict(arrays)
        histories = {
            name: ContactHistory(**{part.name: rest.pop(f"{name}_{part.name}") for part in fields(ContactHistory)})
            for name in _HISTORIES
        }
        return cls(**rest, **histories)
