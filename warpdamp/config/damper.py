"""Models of the configuration: the damper, how it is shaken, and what is simulated of it."""

from __future__ import annotations

import math
from collections import Counter
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, StrictInt, create_model, field_validator, model_validator

from ..scene.effects import FORCIBLE
from ..scene.sphere import sphere_volume
from .base import NOT_NEGATIVE as _not_negative
from .base import POSITIVE as _positive
from .base import Model
from .quantities import Acceleration, Density, Frequency, Length, Number, Pressure
from .sweep import swept as _swept

WALLS = "walls"
"""Stands for the enclosure in the keys of ``contact.pairs``."""


def between(key: str) -> tuple[str, str]:
    """Pair of materials, or a material and the walls, that a key of ``contact.pairs`` names."""
    first, _, second = key.partition(" with ")
    return first.strip(), second.strip()


class MaterialConfig(Model):
    """Isotropic elastic material.

    ``library`` names the one of the library (``warpdamp materials``) that stands for what is left out here; ``source``
    says where values are from.
    """

    density: _swept(Density, _positive)
    """Mass over volume."""
    youngs_modulus: _swept(Pressure, _positive)
    """Young's modulus; the softer a material, the longer the steps."""
    poissons_ratio: _swept(Number, Field(gt=-1, lt=0.5))
    """Poisson's ratio."""
    library: str | None = None
    """Name in the library (``warpdamp materials``) of what stands for the values left out."""
    source: str | None = None
    """Where the values are from."""

    def elastic(self) -> dict[str, Any]:
        """Density, Young's modulus and Poisson's ratio by name."""
        return self.model_dump(exclude={"library", "source"})


class SurfaceConfig(Model):
    """Surface pairing: restitution, sliding friction and rolling friction."""

    restitution: _swept(Number, Field(ge=0, le=1))
    """Normal velocity after an impact over that before it: the dashpots are calibrated to return it."""
    friction: _swept(Number, _not_negative)
    """Coefficient of Coulomb friction; 0 leaves friction and rotation out of the kernels."""
    rolling_friction: _swept(Number, _not_negative) = 0.0
    """Largest resisting moment over normal force and reduced radius; nothing without friction."""


class ContactConfig(SurfaceConfig):
    """Contact of particles with each other and, unless ``walls`` says otherwise, with the walls.

    ``pairs`` has the surfaces of a mixture that differ, as ``steel with pmma`` and ``steel with walls``.  What the
    library knows of the particles' material on itself may be left out; ``source`` then says where it is from.
    """

    walls: SurfaceConfig | None = None
    """Surface of the particles with the walls, where it differs from that between particles."""
    pairs: dict[Annotated[str, Field(pattern=r"^\S+ with \S+$")], SurfaceConfig] = Field({})
    """Surfaces of pairs of materials that differ, by ``A with B`` or ``A with walls``."""
    source: str | None = None
    """Where restitution and friction are from."""


class EnclosureConfig(Model):
    """Cylindrical cavity; a wall set to false is absent (``lid: false``: an open cup whose side has no end)."""

    diameter: Annotated[Length, _positive]
    """Inner diameter of the cylinder."""
    height: Annotated[Length, _positive]
    """Inner height of the cylinder, from floor to lid."""
    material: str
    """Name of the walls' material, one of ``materials`` or of the library."""
    side: bool = True
    """Whether the cylinder's side is there."""
    floor: bool = True
    """Whether the floor is there."""
    lid: bool = True
    """Whether the lid is there; without it the side has no end."""

    def open_towards(self, direction) -> dict[str, bool]:
        """Walls that are absent though a fall along ``direction`` ends there, as {name: whether}."""
        x, y, z = direction
        return {
            "floor": z < 0 and not self.floor,
            "lid": z > 0 and not self.lid,
            "side": math.hypot(x, y) > 0 and not self.side,
        }


class NormalSizes(Model):
    """Radii of a normal distribution."""

    mean: Annotated[Length, _positive]
    """Mean of the radii."""
    deviation: Annotated[Length, _positive]
    """Standard deviation of the radii, at most a quarter of the mean."""


class LognormalSizes(Model):
    """Radii of a lognormal distribution; ``deviation`` is that of ln(radius)."""

    median: Annotated[Length, _positive]
    """Median of the radii."""
    deviation: Annotated[Number, _positive]
    """Standard deviation of the logarithm of the radii."""


class SizesConfig(Model):
    """Distribution of radii, one of the four.

    Particles get the radii at the middle of equal parts of the distribution: every seed has the same particles, in
    other places.
    """

    uniform: tuple[Length, Length] | None = None
    """Smallest and largest radius, all between them as frequent."""
    normal: NormalSizes | None = None
    """Normal distribution of radii."""
    lognormal: LognormalSizes | None = None
    """Lognormal distribution of radii."""
    each: Annotated[list[Annotated[Length, _positive]], Field(min_length=1)] | None = None
    """Radius of every particle, ``count`` of them."""

    @model_validator(mode="after")
    def _one(self):
        if sum(value is not None for value in vars(self).values()) != 1:
            raise ValueError("give one of uniform: [a, b], normal, lognormal and each: [...]")
        if self.uniform and not 0 < self.uniform[0] < self.uniform[1]:
            raise ValueError("uniform: give the smallest and the largest radius, both positive")
        if self.normal and self.normal.deviation > self.normal.mean / 4:
            raise ValueError("normal.deviation: is more than a quarter of the mean, so that radii might be negative")
        return self

    def radii(self, count: int) -> list[float]:
        """Radii of ``count`` particles [m]."""
        if self.each:
            return list(self.each)
        import numpy as np
        from scipy.special import ndtri

        part = (np.arange(count) + 0.5) / count
        if self.uniform:
            radii = self.uniform[0] + (self.uniform[1] - self.uniform[0]) * part
        elif self.normal:
            radii = self.normal.mean + self.normal.deviation * ndtri(part)
        else:
            radii = self.lognormal.median * np.exp(self.lognormal.deviation * ndtri(part))
        return radii.tolist()


class ShapeConfig(Model):
    """Shape of particles: spheroids of an ``aspect``, d1 along over d2 across their axis, or spheres (1).

    Above 1 they are prolate, below oblate.  Their radius stays that of the sphere of the same volume.
    """

    aspect: Annotated[Number, _positive] = 1.0
    """Semi-axis along the axis of symmetry over that across it."""


class ParticlesConfig(Model):
    """Particles of one material and one shape."""

    count: Annotated[StrictInt, Field(ge=1)]
    """Number of particles."""
    radius: Annotated[Length, _positive] | SizesConfig
    """Radius of the spheres (of spheroids: of the sphere of the same volume), or a distribution of radii."""
    material: str
    """Name of the particles' material, one of ``materials`` or of the library."""
    shape: ShapeConfig = ShapeConfig()
    """Shape of the particles; spheres unless given."""

    @field_validator("radius", mode="wrap")
    @classmethod
    def _size_or_sizes(cls, value, validate):
        return SizesConfig.model_validate(value) if isinstance(value, dict) else validate(value)

    @model_validator(mode="after")
    def _each(self):
        each = self.radius.each if isinstance(self.radius, SizesConfig) else None
        if each is not None and len(each) != self.count:
            raise ValueError(f"radius.each: {len(each)} radii for {self.count} particles")
        return self

    def radii(self) -> list[float]:
        """Radii of the particles [m]."""
        return self.radius.radii(self.count) if isinstance(self.radius, SizesConfig) else [self.radius] * self.count

    def sizes(self) -> Counter[float]:
        """Number of particles of each radius [m]."""
        return Counter(self.radii()) if isinstance(self.radius, SizesConfig) else Counter({self.radius: self.count})


class DamperConfig(Model):
    """Damper: the cavity, and particles of one kind or a list of components of a mixture."""

    enclosure: EnclosureConfig
    """The cavity."""
    particles: ParticlesConfig | Annotated[list[ParticlesConfig], Field(min_length=1)]
    """The particles; a list makes a mixture."""

    @property
    def mixture(self) -> list[ParticlesConfig]:
        """Components of the mixture, one or more."""
        return self.particles if isinstance(self.particles, list) else [self.particles]

    def materials(self, place: str = "damper") -> dict[str, str]:
        """Names of the materials, by the keys that name them, below the damper's own (``place``)."""
        keys = (
            [f"particles.{k}" for k in range(len(self.mixture))] if isinstance(self.particles, list) else ["particles"]
        )
        named = {f"{place}.{key}.material": part.material for key, part in zip(keys, self.mixture, strict=True)}
        return {f"{place}.enclosure.material": self.enclosure.material, **named}

    @model_validator(mode="after")
    def _fits(self):
        sizes = self.sizes
        self._check_shapes()
        size = f"{1e3 * self.enclosure.diameter:g} x {1e3 * self.enclosure.height:g} mm"
        if 2 * max(sizes) >= min(self.enclosure.diameter, self.enclosure.height):
            raise ValueError(
                f"particles.radius: particles of diameter {2e3 * max(sizes):g} mm do not fit the cavity ({size})"
            )
        fill, densest = self.fill, self.densest
        if fill > densest:
            most = math.floor(densest / fill * sizes.total())
            raise ValueError(
                f"particles.count: too many particles: they would fill {fill:.3f} of the cavity, and not "
                f"even {'a crystal fills' if densest < 1 else 'sizes and shapes fill'} more than {densest:.3f}; "
                f"take at most {most}"
            )
        return self

    @property
    def sizes(self) -> Counter[float]:
        """Number of particles of each radius [m]."""
        return sum((part.sizes() for part in self.mixture), Counter())

    @property
    def spheroids(self) -> bool:
        """Whether any particle is not a sphere."""
        return any(part.shape.aspect != 1 for part in self.mixture)

    def _check_shapes(self):
        """Spheroids fit the cavity at full length, and touch its side in one place at the most."""
        if not self.spheroids:
            return
        from ..scene.shape import SPHEROIDS

        for k, part in enumerate(self.mixture):
            radii, aspect, cavity = part.radii(), part.shape.aspect, self.enclosure
            if aspect == 1:
                continue
            place = f"particles.{k}.shape.aspect" if isinstance(self.particles, list) else "particles.shape.aspect"
            if refusal := SPHEROIDS.refused(radii, aspect, cavity.diameter / 2):
                raise ValueError(f"{place}: {refusal}")
            longest = 2 * float(SPHEROIDS.bounding_radius(radii, aspect).max())
            if longest >= min(cavity.diameter, cavity.height):
                raise ValueError(
                    f"{place}: particles {1e3 * longest:.3g} mm across do not fit the cavity "
                    f"({1e3 * cavity.diameter:g} x {1e3 * cavity.height:g} mm)"
                )

    @property
    def fill(self) -> float:
        """Volume of the particles over that of the cavity [-]."""
        volume = sum(number * sphere_volume(radius) for radius, number in self.sizes.items())
        return volume / (math.pi / 4 * self.enclosure.diameter**2 * self.enclosure.height)

    @property
    def densest(self) -> float:
        """Packing fraction that no bed exceeds [-]: a crystal's of equal spheres, all space of other particles."""
        return 0.74 if len(self.sizes) == 1 and not self.spheroids else 1.0


def _unit(vector) -> tuple[float, float, float]:
    length = math.hypot(*vector)
    if length == 0:
        raise ValueError("a direction cannot be [0, 0, 0]")
    return tuple(component / length for component in vector)


_NAMED = {"axial": (0.0, 0.0, 1.0), "lateral": (1.0, 0.0, 0.0)}


def _named(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    if value not in _NAMED:
        raise ValueError(f"'{value}' is not one of {', '.join(_NAMED)}; or give [x, y, z], z along the cavity's axis")
    return _NAMED[value]


Direction = Annotated[
    tuple[float, float, float],
    BeforeValidator(
        _named,
        json_schema_input_type=Literal["axial", "lateral"] | tuple[float, float, float],
    ),
]


class ExcitationConfig(Model):
    """Sinusoidal motion of the cavity, along its axis unless ``direction`` says otherwise."""

    gamma: _swept(Number, _positive)
    """Acceleration amplitude of the cavity over the standard acceleration of gravity, 9.81 m/s^2."""
    frequency: Literal["modes"] | _swept(Frequency, _positive) = "modes"
    """Frequencies of the shaking; ``modes``: the structure's natural frequencies with the particles' mass."""
    direction: Direction = (0.0, 0.0, 1.0)
    """Direction of the shaking: ``axial``, ``lateral``, or [x, y, z] with z along the axis of the cavity."""
    gravity: _swept(Acceleration, _not_negative) = 9.81
    """Acceleration of gravity; 0 for none."""
    gravity_direction: Direction = (0.0, 0.0, -1.0)
    """Direction of gravity: [x, y, z] with z from floor to lid, ``axial`` (towards the lid) or ``lateral``."""

    @field_validator("gamma", "frequency")
    @classmethod
    def _rising(cls, values):
        if isinstance(values, list):
            if len(set(values)) < len(values):
                raise ValueError("each value once")
            return sorted(values)
        return values

    @field_validator("direction", "gravity_direction")
    @classmethod
    def _of_length_one(cls, vector):
        return _unit(vector)


def _switch(value: Any) -> Any:
    return {"on": True, "off": False, "auto": None}.get(value, value) if isinstance(value, str) else value


Switch = Annotated[
    bool | None, BeforeValidator(_switch, json_schema_input_type=bool | Literal["on", "off", "auto"] | None)
]
SWITCHES = {
    "friction": "Coulomb friction, with the history of the tangential spring",
    "rotation": "Whether particles turn",
    "dashpots": "Whether contacts lose energy in dashpots",
    "rolling": "Rolling resistance",
    "gravity": "Gravity",
    "indicators": "Impulses of floor and lid and displacements over a cycle, from which regimes are told",
}
"""What the effects are that may be forced."""


_Switches = create_model(
    "_Switches",
    __base__=Model,
    **{
        name: (Switch, Field(None, description=f"{SWITCHES.get(name, name)}; auto: as the scene calls for."))
        for name in FORCIBLE
        if name != "channels"
    },
)


class EffectsConfig(_Switches):
    """Effects forced on or off, whatever the scene requires; ``ledger``: losses by channel, or totals."""

    ledger: Literal["channels", "totals"] = "channels"
    """Losses by channel, or their total alone, which is a little faster."""

    def forced(self) -> tuple[tuple[str, bool], ...]:
        """Forced effects as sorted pairs (name, whether on)."""
        chosen = {name: value for name, value in vars(self).items() if name != "ledger" and value is not None}
        if self.ledger == "totals":
            chosen["channels"] = False
        return tuple(sorted(chosen.items()))
