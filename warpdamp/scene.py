"""A scene: what is simulated.  SI units throughout."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

STANDARD_GRAVITY = 9.81
"""g [m/s^2] that turns Gamma into an acceleration (the paper's value)."""


@dataclass(frozen=True)
class Material:
    """An isotropic elastic material: density [kg/m^3], Young's modulus [Pa], Poisson's ratio [-]."""

    density: float
    youngs_modulus: float
    poissons_ratio: float

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) [Pa]."""
        return self.youngs_modulus / (2 * (1 + self.poissons_ratio))


@dataclass(frozen=True)
class Surface:
    """How two bodies meet: coefficients of restitution and of sliding friction [-]."""

    restitution: float
    friction: float


@dataclass(frozen=True)
class Cylinder:
    """The cavity: inner diameter and height [m], its axis along z, the origin at the centre of the floor."""

    diameter: float
    height: float

    @property
    def volume(self) -> float:
        """[m^3]."""
        return math.pi / 4 * self.diameter**2 * self.height


@dataclass(frozen=True)
class Drive:
    """Sinusoidal motion of the enclosure, X sin(2 pi f t) along ``direction``.

    Parameters
    ----------
    frequency : f [Hz]
    acceleration : amplitude X (2 pi f)^2 [m/s^2]
    direction : unit vector
    """

    frequency: float
    acceleration: float
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self):
        if self.frequency <= 0 or abs(math.hypot(*self.direction) - 1) > 1e-9:
            raise ValueError("a drive needs a positive frequency and a direction of length 1")

    @property
    def angular_frequency(self) -> float:
        """[rad/s]."""
        return 2 * math.pi * self.frequency

    @property
    def displacement(self) -> float:
        """Amplitude X [m]."""
        return self.acceleration / self.angular_frequency**2

    @property
    def speed(self) -> float:
        """Amplitude [m/s]."""
        return self.acceleration / self.angular_frequency


@dataclass(frozen=True)
class Scene:
    """Everything that stays constant while particles move.

    Parameters
    ----------
    particle, wall : Material
    particle_contact, wall_contact : Surface
        Particle against particle, particle against wall.
    enclosure : Cylinder or None
    gravity : vector [m/s^2]
    drive : Drive or None
    """

    particle: Material
    wall: Material
    particle_contact: Surface
    wall_contact: Surface
    enclosure: Cylinder | None
    gravity: tuple[float, float, float] = (0.0, 0.0, -STANDARD_GRAVITY)
    drive: Drive | None = None

    def driven(self, drive: Drive | None) -> Scene:
        """The same scene under another drive."""
        return replace(self, drive=drive)

    def mass(self, radius) -> np.ndarray:
        """Of spheres of the given radii [kg]."""
        return self.particle.density * 4 / 3 * math.pi * np.asarray(radius) ** 3


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
    """

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    radius: np.ndarray
    pairs: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.int32))
    pair_history: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))
    wall_history: np.ndarray = field(default_factory=lambda: np.zeros((0, 3, 4)))

    def __post_init__(self):
        if not len(self.wall_history):
            self.wall_history = np.zeros((len(self.position), 3, 4))
        if len(self.pairs) and np.any(self.pairs[:, 0] >= self.pairs[:, 1]):
            raise ValueError("pairs are (i, j) with i < j")

    @classmethod
    def at_rest(cls, position, radius) -> State:
        """Particles at rest at ``position`` (n, 3) with one radius or one each."""
        position = np.array(position, float).reshape(-1, 3)
        radius = np.broadcast_to(np.asarray(radius, float), len(position)).copy()
        return cls(position, np.zeros_like(position), np.zeros_like(position), radius)

    def __len__(self) -> int:
        return len(self.position)

    def volume(self) -> float:
        """Of all particles [m^3]."""
        return float(np.sum(4 / 3 * math.pi * self.radius**3))
