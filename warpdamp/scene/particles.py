"""Particles: their constants, and their state at one moment."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np

from .scene import _HISTORIES, ContactHistory, sphere_volume


@dataclass(frozen=True)
class Grains:
    """Constants of the particles: radius and species of each.

    Parameters
    ----------
    radius : tuple of n floats
        [m].
    species : tuple of n ints
        Position of each particle's material among the scene's.
    """

    radius: tuple[float, ...]
    species: tuple[int, ...]

    @classmethod
    def alike(cls, radius: float, count: int) -> Grains:
        """Equal spheres of one material.

        Parameters
        ----------
        radius : float
            [m].
        count : int

        Returns
        -------
        Grains
        """
        return cls((radius,) * count, (0,) * count)

    def __len__(self) -> int:
        return len(self.radius)


@dataclass
class State:
    """State of the particles at one moment.

    Parameters
    ----------
    position, velocity, spin : (n, 3) arrays
        [m], [m/s], [rad/s]; velocity and spin relative to the enclosure.
    radius : (n,) array
        [m].
    pairs : (m, 2) array of ints
        Touching pairs i < j with a contact history.
    pair_history : ContactHistory of (m,) contacts
    wall_history : ContactHistory of (n, 3) contacts
        With side, floor and lid.
    species : (n,) array of ints
        Position of each particle's material among the scene's; 0 for all unless given.

    Raises
    ------
    ValueError
        If a pair is not (i, j) with i < j.

    Examples
    --------
    >>> from warpdamp import State
    >>> state = State.at_rest([[0, 0, 0.01], [0, 0, 0.02]], radius=3.73e-3)
    >>> len(state), state.velocity.shape
    (2, (2, 3))
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
        """State of particles at rest, without contact history.

        Parameters
        ----------
        position : (n, 3) array
            [m].
        radius : float or (n,) array
            [m].
        species : int or (n,) array of ints
            Position of each particle's material among the scene's.

        Returns
        -------
        State
        """
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
        """Volume of all particles together [m^3]."""
        return float(np.sum(sphere_volume(self.radius)))

    def arrays(self) -> dict[str, np.ndarray]:
        """Arrays of the state by name, as files hold them; see ``from_arrays``.

        Returns
        -------
        dict of arrays
            The fields; those of the histories as ``pair_history_stretch``.
        """
        plain = {name: value for name, value in vars(self).items() if name not in _HISTORIES}
        return plain | {
            f"{name}_{part}": array for name in _HISTORIES for part, array in vars(getattr(self, name)).items()
        }

    @classmethod
    def from_arrays(cls, arrays: dict[str, np.ndarray]) -> State:
        """State from named arrays; the inverse of ``arrays``.

        Parameters
        ----------
        arrays : dict of arrays

        Returns
        -------
        State

        Raises
        ------
        KeyError, TypeError
            If an array is missing, or there is one too many.
        """
        rest = dict(arrays)
        histories = {
            name: ContactHistory(**{part.name: rest.pop(f"{name}_{part.name}") for part in fields(ContactHistory)})
            for name in _HISTORIES
        }
        return cls(**rest, **histories)
