"""Particles: their constants, and their state at one moment."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from .shape import aspects, shape_of
from .sphere import inverse_sphere_inertia, sphere_volume


@dataclass(frozen=True)
class Grains:
    """Constants of the particles: radius, species and aspect of each.

    Parameters
    ----------
    radius : tuple of n floats
        Of the sphere of the same volume [m].
    species : tuple of n ints
        Position of each particle's material among the scene's.
    aspect : tuple of n floats
        Of spheroids, along over across their axes [-]; empty: spheres.  See ``scene.shape``.
    """

    radius: tuple[float, ...]
    species: tuple[int, ...]
    aspect: tuple[float, ...] = ()

    @classmethod
    def alike(cls, radius: float, count: int, *, aspect: float = 1.0) -> Grains:
        """Equal particles of one material.

        Parameters
        ----------
        radius : float
            Of the sphere of the same volume [m].
        count : int
        aspect : float
            [-]; 1: spheres.

        Returns
        -------
        Grains
        """
        return cls((radius,) * count, (0,) * count, () if aspect == 1 else (aspect,) * count)

    def given(self) -> dict:
        """Constants by name, without those that are as of spheres."""
        return {one.name: value for one in fields(self) if (value := getattr(self, one.name)) != one.default}

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
        Of the sphere of the same volume [m].
    pairs : (m, 2) array of ints
        Touching pairs i < j with a contact history.
    pair_history : ContactHistory of (m,) contacts
    wall_history : ContactHistory of (n, 3) contacts
        With side, floor and lid.
    species : (n,) array of ints
        Position of each particle's material among the scene's; 0 for all unless given.
    axis : (n, 3) array
        Unit vectors along the spheroids' axes; (0, 0, 1) for all unless given.
    aspect : (n,) array
        Of spheroids, along over across their axes [-]; 1, spheres, unless given.  See ``scene.shape``.

    Notes
    -----
    Axes and aspects that nobody gave, spheres', take no memory and cannot be written to.

    Raises
    ------
    ValueError
        If a pair is not (i, j) with i < j, or an axis has not length 1.

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
    axis: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    aspect: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self):
        n = len(self.position)
        if self.pair_history is None:
            self.pair_history = ContactHistory.none(len(self.pairs))
        if self.wall_history is None:
            self.wall_history = ContactHistory.none(n, 3)
        if not len(self.species):
            self.species = np.zeros(n, np.int32)
        if not len(self.axis):
            self.axis = np.broadcast_to(UPRIGHT, (n, 3))
        if not len(self.aspect):
            self.aspect = np.broadcast_to(1.0, n)
        if len(self.pairs) and np.any(self.pairs[:, 0] >= self.pairs[:, 1]):
            raise ValueError("pairs are (i, j) with i < j")
        length = np.linalg.norm(self.axis, axis=1)
        if np.any(np.abs(length - 1) > UNIT_WITHIN):
            k = int(np.argmax(np.abs(length - 1) > UNIT_WITHIN))
            raise ValueError(f"the axis of particle {k} has length {length[k]:g}: give unit vectors")

    @classmethod
    def at_rest(cls, position, radius, species=0, *, aspect=1.0, axis=(0.0, 0.0, 1.0)) -> State:
        """State of particles at rest, without contact history.

        Parameters
        ----------
        position : (n, 3) array
            [m].
        radius : float or (n,) array
            Of the sphere of the same volume [m].
        species : int or (n,) array of ints
            Position of each particle's material among the scene's.
        aspect : float or (n,) array
            [-]; 1: spheres.
        axis : (3,) or (n, 3) array
            Unit vectors along the spheroids' axes.

        Returns
        -------
        State
        """
        position = np.array(position, float).reshape(-1, 3)
        radius = np.broadcast_to(np.asarray(radius, float), len(position)).copy()
        species = np.broadcast_to(np.asarray(species, np.int32), len(position)).copy()
        spheres = np.ndim(aspect) == 0 and aspect == 1
        upright = np.shape(axis) == (3,) and tuple(axis) == UPRIGHT
        aspect = () if spheres else np.broadcast_to(np.asarray(aspect, float), len(position))
        axis = () if spheres and upright else np.broadcast_to(np.asarray(axis, float), position.shape)
        still = np.zeros_like(position)
        return cls(position, still, still.copy(), radius, species=species, aspect=np.array(aspect), axis=np.array(axis))

    @classmethod
    def of(cls, grains: Grains, position, axis) -> State:
        """State of particles at rest at positions (n, 3) [m], with their axes along unit vectors (n, 3)."""
        return cls.at_rest(position, grains.radius, grains.species, aspect=aspects(grains), axis=axis)

    def __len__(self) -> int:
        return len(self.position)

    @property
    def bounding_radius(self) -> np.ndarray:
        """Radius of the smallest sphere about each centre that holds the particle, (n,) [m]."""
        return shape_of(self).bounding_radius(self.radius, self.aspect)

    @property
    def semi_axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Semi-axes along and across each particle's axis, two of (n,) [m]."""
        return shape_of(self).semi_axes(self.radius, self.aspect)

    def constants(self, mass: np.ndarray) -> dict[str, np.ndarray]:
        """Constants of the particles, and their angular momentum, by their names in ``kernels.structs.Particle``.

        Parameters
        ----------
        mass : (n,) array
            [kg].

        Returns
        -------
        dict of (n,) arrays
            ``inverse_mass`` [1/kg]; of spheres ``inverse_inertia`` [1/(kg m^2)]; of spheroids ``across2`` b^2,
            ``excess`` a^2 - b^2 [m^2], ``reach`` max(a, b), ``tilt`` ``|a - b|``, ``flattest`` max(a, b)^2 / min(a, b)
            [m], ``inverse_transverse`` 1 / I_t, ``inverse_axial`` 1 / I_a [1/(kg m^2)], and ``half_momentum``
            (n, 3) [kg m^2/s].
        """
        a, b = self.semi_axes
        transverse, axial = shape_of(self).inertia(mass, self.radius, self.aspect)
        along = np.sum(self.spin * self.axis, axis=1)
        return {
            "inverse_mass": 1 / mass,
            "inverse_inertia": inverse_sphere_inertia(mass, self.radius),
            "across2": b**2,
            "excess": a**2 - b**2,
            "reach": np.maximum(a, b),
            "tilt": np.abs(a - b),
            "flattest": np.maximum(a, b) ** 2 / np.minimum(a, b),
            "inverse_transverse": 1 / transverse,
            "inverse_axial": 1 / axial,
            "half_momentum": transverse[:, None] * self.spin + ((axial - transverse) * along)[:, None] * self.axis,
        }

    def volume(self) -> float:
        """Volume of all particles together [m^3]."""
        return float(np.sum(sphere_volume(self.radius)))

    def arrays(self) -> dict[str, np.ndarray]:
        """Arrays of the state by name, as files hold them; see ``from_arrays``.

        Returns
        -------
        dict of arrays
            The fields; those of the histories as ``pair_history_stretch``.  What only spheroids have is left out where
            it has the values of spheres.
        """
        plain = {name: value for name, value in vars(self).items() if name not in _HISTORIES}
        histories = {
            f"{name}_{part}": array for name in _HISTORIES for part, array in vars(getattr(self, name)).items()
        }
        return {name: array for name, array in (plain | histories).items() if not _of_spheres(name, array)}

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

        def history(name: str) -> ContactHistory:
            keys = {part.name: f"{name}_{part.name}" for part in fields(ContactHistory)}
            return ContactHistory(
                **{part: rest.pop(key) for part, key in keys.items() if part not in _OF_SPHERES or key in rest}
            )

        histories = {name: history(name) for name in _HISTORIES}
        return cls(**rest, **histories)


@dataclass(frozen=True, eq=False)
class ContactHistory:
    """Contact history: what contacts keep from one step to the next, an element each; see ``warpdamp.kernels.contact``.

    Parameters
    ----------
    stretch : (..., 3) array
        Stretch of the tangential springs [m].
    radius : (...) array
        Contact radius [m]; 0: there was no contact.
    roll : (..., 3) array
        Stretch of the springs of rolling resistance [m].
    normal : (..., 3) array
        Unit vectors from j to i at spheroids' contacts, or ones that part them; zeros for spheres unless given.
    arm : (..., 3) array
        From i's centre to spheroids' contacts [m]; zeros for spheres unless given.

    Notes
    -----
    Normals and arms that nobody gave take no memory and cannot be written to.
    """

    stretch: np.ndarray
    radius: np.ndarray
    roll: np.ndarray
    normal: np.ndarray | None = None
    arm: np.ndarray | None = None

    def __post_init__(self):
        for name in ("normal", "arm"):
            if getattr(self, name) is None:
                object.__setattr__(self, name, np.broadcast_to(0.0, self.stretch.shape))

    @classmethod
    def none(cls, *shape: int) -> ContactHistory:
        """History of contacts that did not exist before, of the given shape."""
        return cls(np.zeros((*shape, 3)), np.zeros(shape), np.zeros((*shape, 3)))

    def __len__(self) -> int:
        return len(self.radius)

    def __getitem__(self, which) -> ContactHistory:
        """History of the contacts selected by ``which``."""
        return ContactHistory(*(array[which] for array in self._kept()))

    def seen_from_the_other(self, where: np.ndarray, between: np.ndarray | None = None) -> ContactHistory:
        """History with particles i and j exchanged where ``where`` is true: stretches and normals change their sign.

        Parameters
        ----------
        where : (...) array of bools
        between : (..., 3) array or None
            From j's centre to i's at the last step, by which the arms of the two differ [m]; None: spheres' arms are
            not kept.

        Returns
        -------
        ContactHistory
        """
        sign = np.where(where, -1.0, 1.0)[..., None]
        turned = ContactHistory(sign * self.stretch, self.radius, sign * self.roll)
        if self._of_spheres:
            return turned
        arm = self.arm if between is None else np.where(where[..., None], self.arm + between, self.arm)
        return replace(turned, normal=sign * self.normal, arm=arm)

    @property
    def _of_spheres(self) -> bool:
        """Whether nobody gave normals and arms: the zeros that stand for them are one number."""
        return not any(self.normal.strides + self.arm.strides)

    def _kept(self) -> tuple[np.ndarray, ...]:
        """The arrays, without the zeros that stand for spheres' normals and arms."""
        plain = (self.stretch, self.radius, self.roll)
        return plain if self._of_spheres else (*plain, self.normal, self.arm)


UPRIGHT = (0.0, 0.0, 1.0)
"""Axis of a particle that nobody turned."""

UNIT_WITHIN = 1e-5
"""Length of an axis: 1 to this; single precision keeps it to 1e-6."""

_HISTORIES = ("pair_history", "wall_history")

_OF_SPHERES = {"axis": UPRIGHT, "aspect": 1.0, "normal": 0.0, "arm": 0.0}
"""Values, by the last word of their names, that the arrays of spheroids have for spheres."""


def _of_spheres(name: str, array: np.ndarray) -> bool:
    part = name.rpartition("_")[2]
    return part in _OF_SPHERES and bool(np.all(array == _OF_SPHERES[part]))
