"""Nouns of a simulation: materials, surfaces, cavity, drive, host, scene.  SI units throughout."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from .gravity import STANDARD_GRAVITY
from .host import HostStructure
from .sphere import sphere_volume


@dataclass(frozen=True)
class Material:
    """Isotropic elastic material.

    Parameters
    ----------
    density : float
        Mass density [kg/m^3].
    youngs_modulus : float
        E [Pa].
    poissons_ratio : float
        nu [-].

    Raises
    ------
    ValueError
        If density or modulus is not positive, or Poisson's ratio not between -1 and 0.5.

    Examples
    --------
    >>> from warpdamp import Material
    >>> pmma = Material(density=920, youngs_modulus=3.3e9, poissons_ratio=0.37)
    >>> round(pmma.shear_modulus / 1e9, 3)  # G = E / (2 (1 + nu)) [GPa]
    1.204
    """

    density: float
    youngs_modulus: float
    poissons_ratio: float

    def __post_init__(self):
        if not (self.density > 0 and self.youngs_modulus > 0 and -1 < self.poissons_ratio < 0.5):
            raise ValueError(
                f"a material needs a positive density and modulus and a Poisson's ratio from -1 to 0.5, got {self}"
            )

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) [Pa]."""
        return self.youngs_modulus / (2 * (1 + self.poissons_ratio))


@dataclass(frozen=True)
class Surface:
    """Surface pairing of two bodies: coefficients of restitution, of sliding friction and of rolling friction.

    Parameters
    ----------
    restitution : float
        e [-], 0 to 1: speed after a head-on impact over the speed before it.
    friction : float
        mu [-]: the tangential force is at most mu times the normal force Fn.
    rolling_friction : float
        mu_r [-]: the moment of rolling resistance is at most mu_r R* Fn, R* the reduced radius.

    Raises
    ------
    ValueError
        If the restitution is not from 0 to 1, or a friction is negative.

    Examples
    --------
    >>> from warpdamp import Surface
    >>> Surface(restitution=0.52, friction=0.86)
    Surface(restitution=0.52, friction=0.86, rolling_friction=0.0)
    """

    restitution: float
    friction: float
    rolling_friction: float = 0.0

    def __post_init__(self):
        if not (0 <= self.restitution <= 1 and self.friction >= 0 and self.rolling_friction >= 0):
            raise ValueError(
                f"a surface needs a restitution from 0 to 1 and frictions that are not negative, got {self}"
            )


@dataclass(frozen=True)
class Cylinder:
    """Cylindrical cavity, its axis along z, the origin at the centre of the floor.

    Each of its walls may be left out; those that are present reach as far as the particles do, so that the side of an
    open cup (``lid=False``) rises without end.

    Parameters
    ----------
    diameter, height : float
        Inner dimensions [m].
    side, floor, lid : bool
        Whether the wall is present.

    Raises
    ------
    ValueError
        If diameter or height is not positive.

    Examples
    --------
    >>> from warpdamp import Cylinder
    >>> cavity = Cylinder(diameter=0.04, height=0.04)
    >>> round(1e6 * cavity.volume, 2)  # [cm^3]
    50.27
    """

    diameter: float
    height: float
    side: bool = True
    floor: bool = True
    lid: bool = True

    def __post_init__(self):
        if not (self.diameter > 0 and self.height > 0):
            raise ValueError(f"a cavity needs a positive diameter and height, got {self}")

    @property
    def volume(self) -> float:
        """Volume of the closed cavity [m^3]."""
        return math.pi / 4 * self.diameter**2 * self.height


@dataclass(frozen=True)
class Drive:
    """Sinusoidal motion prescribed to the enclosure, X sin(2 pi f t) along ``direction``.

    Parameters
    ----------
    frequency : float
        f [Hz].
    acceleration : float
        Amplitude X (2 pi f)^2 [m/s^2]; Gamma times g.
    direction : tuple of 3 floats
        Unit vector.

    Raises
    ------
    ValueError
        If the frequency is not positive, the amplitude negative, or the direction has not length 1.

    Examples
    --------
    >>> from warpdamp import Drive
    >>> drive = Drive(frequency=46.0, acceleration=6 * 9.81)
    >>> round(1e3 * drive.displacement, 3), round(drive.speed, 3)  # amplitudes [mm], [m/s]
    (0.705, 0.204)
    """

    frequency: float
    acceleration: float
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self):
        if not self.frequency > 0 or abs(math.hypot(*self.direction) - 1) > 1e-9:
            raise ValueError("a drive needs a positive frequency and a direction of length 1")
        if not self.acceleration >= 0:
            raise ValueError(f"a drive needs an amplitude that is not negative, got {self.acceleration:g} m/s^2")

    @property
    def angular_frequency(self) -> float:
        """Angular frequency 2 pi f [rad/s]."""
        return 2 * math.pi * self.frequency

    @property
    def displacement(self) -> float:
        """Displacement amplitude X [m]."""
        return self.acceleration / self.angular_frequency**2

    @property
    def speed(self) -> float:
        """Speed amplitude 2 pi f X [m/s]."""
        return self.acceleration / self.angular_frequency


@dataclass(frozen=True)
class Scene:
    """Everything that stays constant while particles move.

    Parameters
    ----------
    particle : Material, or tuple of Material
        One, or one for each species of a mixture.
    wall : Material
    particle_contact : Surface, or tuple of tuples of Surface
        Surfaces of particles against each other; in a mixture ``particle_contact[i][j]`` of species i and j.
    wall_contact : Surface, or tuple of Surface
        Surfaces of particles against the walls; in a mixture, one for each species.
    enclosure : Cylinder or None
        Cavity; None: no walls.
    gravity : tuple of 3 floats
        [m/s^2].
    drive : Drive or None
        Motion prescribed to the enclosure.
    host : HostStructure or None
        Instead of a drive: the structure that the enclosure is fixed to, and that answers the particles.

    Raises
    ------
    ValueError
        If there is a drive and a host structure, or a mixture's surfaces are not one for each pair, the same both ways.

    Examples
    --------
    >>> from warpdamp import Cylinder, Drive, Material, Scene, Surface
    >>> pmma, surface = Material(920, 3.3e9, 0.37), Surface(0.52, 0.86)
    >>> scene = Scene(pmma, pmma, surface, surface, Cylinder(0.04, 0.04), drive=Drive(46.0, 6 * 9.81))
    >>> scene.excitation_frequency
    46.0
    >>> round(1e3 * float(scene.mass(3.73e-3)), 4)  # one particle of radius 3.73 mm [g]
    0.2
    """

    particle: Material | tuple[Material, ...]
    wall: Material
    particle_contact: Surface | tuple[tuple[Surface, ...], ...]
    wall_contact: Surface | tuple[Surface, ...]
    enclosure: Cylinder | None
    gravity: tuple[float, float, float] = (0.0, 0.0, -STANDARD_GRAVITY)
    drive: Drive | None = None
    host: HostStructure | None = None

    def __post_init__(self):
        n = len(self.materials)
        if self.drive and self.host:
            raise ValueError(
                "the motion of an enclosure is prescribed by a drive or follows from a host structure, not both"
            )
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
        """Materials of the particles, one for each species."""
        return (self.particle,) if isinstance(self.particle, Material) else self.particle

    def pair_surface(self, i: int, j: int) -> Surface:
        """Surface of particles of one species against those of another.

        Parameters
        ----------
        i, j : int
            Species, positions in ``materials``.

        Returns
        -------
        Surface
        """
        return self.particle_contact if isinstance(self.particle_contact, Surface) else self.particle_contact[i][j]

    def wall_surface(self, i: int) -> Surface:
        """Surface of particles of one species against the walls.

        Parameters
        ----------
        i : int
            Species, position in ``materials``.

        Returns
        -------
        Surface
        """
        return self.wall_contact if isinstance(self.wall_contact, Surface) else self.wall_contact[i]

    def surfaces(self) -> list[Surface]:
        """Surfaces of every pair of species and, in an enclosure, of every species with the walls."""
        species = range(len(self.materials))
        pairs = [self.pair_surface(i, j) for i in species for j in species if i <= j]
        return pairs + ([self.wall_surface(i) for i in species] if self.enclosure else [])

    def driven(self, drive: Drive | None) -> Scene:
        """Scene with another drive, and without a host structure.

        Parameters
        ----------
        drive : Drive or None

        Returns
        -------
        Scene
        """
        return replace(self, drive=drive, host=None)

    def on_host(self, host: HostStructure) -> Scene:
        """Scene with another host, and without a drive.

        Parameters
        ----------
        host : HostStructure

        Returns
        -------
        Scene
        """
        return replace(self, drive=None, host=host)

    def softened(self, factor: float) -> Scene:
        """Scene with every Young's modulus multiplied by ``factor``."""
        if factor == 1:
            return self

        def soft(material: Material) -> Material:
            return replace(material, youngs_modulus=factor * material.youngs_modulus)

        one = isinstance(self.particle, Material)
        particle = soft(self.particle) if one else tuple(soft(material) for material in self.particle)
        return replace(self, particle=particle, wall=soft(self.wall))

    @property
    def excitation_frequency(self) -> float | None:
        """Frequency of the drive, or of what moves the structure [Hz]; None if nothing is periodic."""
        if self.drive:
            return self.drive.frequency
        return self.host.excitation.frequency if self.host and self.host.excitation else None

    def mass(self, radius, species=0) -> np.ndarray:
        """Mass of spheres of the given radii and species [kg].

        Parameters
        ----------
        radius : (...) array
            [m].
        species : (...) array of ints
            Position of each sphere's material in ``materials``.

        Returns
        -------
        (...) array
            [kg].
        """
        density = np.array([material.density for material in self.materials])[np.asarray(species)]
        return density * sphere_volume(np.asarray(radius))

    def masses(self, grains) -> np.ndarray:
        """Mass of each particle [kg].

        Parameters
        ----------
        grains : State, Grains, or anything with ``radius`` and ``species``

        Returns
        -------
        (n,) array
            [kg].
        """
        return self.mass(grains.radius, grains.species)
