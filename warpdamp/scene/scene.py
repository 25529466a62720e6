"""A scene: what is simulated.  SI units throughout."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

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
    """How two bodies meet: coefficients of restitution, of sliding friction and of rolling friction [-].

    The moment of rolling resistance is at most ``rolling_friction`` R* Fn.
    """

    restitution: float
    friction: float
    rolling_friction: float = 0.0


@dataclass(frozen=True)
class Cylinder:
    """The cavity: inner diameter and height [m], its axis along z, the origin at the centre of the floor.

    Each of its walls may be left out; those that are there reach as far as the particles do, so that the side of an
    open cup (``lid=False``) rises without end.
    """

    diameter: float
    height: float
    side: bool = True
    floor: bool = True
    lid: bool = True

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


@dataclass(frozen=True, eq=False)
class Signal:
    """A function of time: a harmonic part A sin(2 pi f t), and samples with straight lines between.

    Parameters
    ----------
    amplitude : A
    frequency : f [Hz], of the harmonic part
    samples : (n,) array or None
        Recorded, swept or random; after the last one it stays at that.
    sample_step : [s] between samples, the first at time 0
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
    """Applied to the structure at the damper, along the mount's direction [N]."""

    name = "force"


@dataclass(frozen=True, eq=False)
class BaseMotion(Signal):
    """Acceleration of the base that holds the structure, along the mount's direction [m/s^2]."""

    name = "base motion"


@dataclass(frozen=True)
class Mount:
    """The structure that the enclosure is fixed to: its modes without the particles, and how it starts.

    Parameters
    ----------
    frequency : natural frequencies [Hz]
    damping : inherent damping ratios
    amplitude : mass-normalised mode shapes at the damper, along ``direction`` [kg^-0.5]
    direction : unit vector
    force : Force or None
    position, velocity : modal q [m kg^0.5] and q' [m kg^0.5/s] at the start (zero unless given)
    record : steps between records of the enclosure's motion and of the particles' force on it; 0: none
    base : BaseMotion or None
        Instead of a force.  Modal coordinates are then of the motion relative to the base.
    participation : Gamma = phi^T M d of each mode, d the base's unit displacement [kg^0.5]
        Needed with a base that moves.
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
            raise ValueError("a mount needs a damping, an amplitude, a position and a velocity for each frequency")
        if min(self.frequency) <= 0 or abs(math.hypot(*self.direction) - 1) > 1e-9:
            raise ValueError("a mount needs positive frequencies and a direction of length 1")
        if self.force and self.base:
            raise ValueError("a mount is moved by a force or by its base, not by both")
        if self.base and len(self.participation) != n:
            raise ValueError("a mount on a base that moves needs a participation for each frequency")

    @property
    def excitation(self) -> Signal | None:
        """What moves it: the force, or the acceleration of its base."""
        return self.force or self.base

    @property
    def load(self) -> tuple[float, ...]:
        """Of each mode, the modal force per unit of the excitation: phi of a force, -Gamma of a base acceleration."""
        return tuple(-gamma for gamma in self.participation) if self.base else self.amplitude

    @property
    def speed(self) -> float:
        """Largest speed of the enclosure in free vibration from the start [m/s]."""
        return sum(
            abs(phi) * math.hypot(v, 2 * math.pi * f * q)
            for f, phi, q, v in zip(self.frequency, self.amplitude, self.position, self.velocity, strict=True)
        )


@dataclass(frozen=True)
class Scene:
    """Everything that stays constant while particles move.

    Parameters
    ----------
    particle : Material, or one for each species of a mixture
    wall : Material
    particle_contact : Surface
        Of particles with each other; in a mixture, rows of them: ``particle_contact[i][j]`` of species i and j.
    wall_contact : Surface
        Of particles with the walls; in a mixture, one for each species.
    enclosure : Cylinder or None
    gravity : vector [m/s^2]
    drive : Drive or None
        Motion prescribed to the enclosure.
    mount : Mount or None
        Instead of a drive: the structure that it is fixed to, and that answers the particles.
    """

    particle: Material | tuple[Material, ...]
    wall: Material
    particle_contact: Surface | tuple[tuple[Surface, ...], ...]
    wall_contact: Surface | tuple[Surface, ...]
    enclosure: Cylinder | None
    gravity: tuple[float, float, float] = (0.0, 0.0, -STANDARD_GRAVITY)
    drive: Drive | None = None
    mount: Mount | None = None

    def __post_init__(self):
        n = len(self.materials)
        if self.drive and self.mount:
            raise ValueError("the motion of an enclosure is prescribed by a drive or follows from a mount, not both")
        if not isinstance(self.particle_contact, Surface):
            rows = self.particle_contact
            if [len(row) for row in rows] != [n] * n or any(
                rows[i][j] != rows[j][i] for i in range(n) for j in range(i)
            ):
                raise ValueError(f"particle_contact must be {n} rows of {n} surfaces, the same for (i, j) and (j, i)")
        if not isinstance(self.wall_contact, Surface) and len(self.wall_contact) != n:
            raise ValueError(f"wall_contact must be one surface, or one for each of the {n} species")

    @property
    def materials(self) -> tuple[Material, ...]:
        """Of the particles, by species."""
        return (self.particle,) if isinstance(self.particle, Material) else self.particle

    def pair_surface(self, i: int, j: int) -> Surface:
        """How particles of species i and j meet."""
        return self.particle_contact if isinstance(self.particle_contact, Surface) else self.particle_contact[i][j]

    def wall_surface(self, i: int) -> Surface:
        """How particles of species i meet the walls."""
        return self.wall_contact if isinstance(self.wall_contact, Surface) else self.wall_contact[i]

    def surfaces(self) -> list[Surface]:
        """All that may meet."""
        species = range(len(self.materials))
        pairs = [self.pair_surface(i, j) for i in species for j in species if i <= j]
        return pairs + ([self.wall_surface(i) for i in species] if self.enclosure else [])

    def driven(self, drive: Drive | None) -> Scene:
        """The same scene under another drive, fixed to nothing."""
        return replace(self, drive=drive, mount=None)

    def mounted(self, mount: Mount) -> Scene:
        """The same scene fixed to a structure."""
        return replace(self, drive=None, mount=mount)

    @property
    def excitation_frequency(self) -> float | None:
        """Of the drive, or of what moves the structure [Hz]; None where nothing is periodic."""
        if self.drive:
            return self.drive.frequency
        return self.mount.excitation.frequency if self.mount and self.mount.excitation else None

    def mass(self, radius, species=0) -> np.ndarray:
        """Of spheres of the given radii and species [kg]."""
        density = np.array([material.density for material in self.materials])[np.asarray(species)]
        return density * sphere_volume(radius)

    def masses(self, grains) -> np.ndarray:
        """Of particles with ``radius`` and ``species``, as a State [kg]."""
        return self.mass(grains.radius, grains.species)


def sphere_volume(radius):
    """Volume of spheres [m^3]."""
    return 4 / 3 * math.pi * np.asarray(radius) ** 3


def inverse_sphere_inertia(mass, radius):
    """One over the moment of inertia of solid spheres about their centres, 5 / (2 m R^2) [1/(kg m^2)]."""
    return 2.5 / (mass * radius**2)


@dataclass(frozen=True, eq=False)
class ContactHistory:
    """What contacts remember of the step before, an element for each contact; see ``warpdamp.kernels.contact``.

    Parameters
    ----------
    stretch : (..., 3) array [m]
        Of the tangential springs.
    radius : (...) array [m]
        Contact radius; 0: there was no contact.
    roll : (..., 3) array [m]
        Stretch of the springs of rolling resistance.
    """

    stretch: np.ndarray
    radius: np.ndarray
    roll: np.ndarray

    @classmethod
    def none(cls, *shape: int) -> ContactHistory:
        """Of contacts that there were not."""
        return cls(np.zeros((*shape, 3)), np.zeros(shape), np.zeros((*shape, 3)))

    def __len__(self) -> int:
        return len(self.radius)

    def __getitem__(self, which) -> ContactHistory:
        """Of some contacts."""
        return ContactHistory(self.stretch[which], self.radius[which], self.roll[which])

    def seen_from_the_other(self, where: np.ndarray) -> ContactHistory:
        """With i and j exchanged ``where`` (...) that is true: stretches change their sign."""
        sign = np.where(where, -1.0, 1.0)[..., None]
        return ContactHistory(sign * self.stretch, self.radius, sign * self.roll)


_HISTORIES = ("pair_history", "wall_history")
