"""Models of the configuration: the damper, how it is shaken, and what is simulated of it."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, StrictInt, create_model, field_validator, model_validator

from ..scene.effects import FORCIBLE
from ..scene.particles import sphere_volume
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
    """Isotropic elastic material."""

    density: _swept(Density, _positive)
    youngs_modulus: _swept(Pressure, _positive)
    poissons_ratio: _swept(Number, Field(gt=-1, lt=0.5))


class SurfaceConfig(Model):
    """Surface pairing: restitution, sliding friction and rolling friction."""

    restitution: _swept(Number, Field(ge=0, le=1))
    friction: _swept(Number, _not_negative)
    rolling_friction: _swept(Number, _not_negative) = 0.0


class ContactConfig(SurfaceConfig):
    """Contact of particles with each other and, unless ``walls`` says otherwise, with the walls.

    ``pairs`` has the surfaces of a mixture that differ, as ``steel with pmma`` and ``steel with walls``.
    """

    walls: SurfaceConfig | None = None
    pairs: dict[Annotated[str, Field(pattern=r"^\S+ with \S+$")], SurfaceConfig] = Field({})


class EnclosureConfig(Model):
    """Cylindrical cavity; a wall set to false is absent (``lid: false``: an open cup whose side has no end)."""

    diameter: Annotated[Length, _positive]
    height: Annotated[Length, _positive]
    material: str
    side: bool = True
    floor: bool = True
    lid: bool = True

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
    deviation: Annotated[Length, _positive]


class LognormalSizes(Model):
    """Radii of a lognormal distribution; ``deviation`` is that of ln(radius)."""

    median: Annotated[Length, _positive]
    deviation: Annotated[Number, _positive]


class SizesConfig(Model):
    """Distribution of radii, one of the four.

    Particles get the radii at the middle of equal parts of the distribution: every seed has the same particles, in
    other places.
    """

    uniform: tuple[Length, Length] | None = None
    normal: NormalSizes | None = None
    lognormal: LognormalSizes | None = None
    each: Annotated[list[Annotated[Length, _positive]], Field(min_length=1)] | None = None

    @model_validator(mode="after")
    def _one(self):
        if sum(value is not None for value in vars(self).values()) != 1:
            raise ValueError("give one of uniform: [a, b], normal, lognormal and each: [...]")
        if self.uniform and not 0 < self.uniform[0] < self.uniform[1]:
            raise ValueError("uniform: give the smallest and the largest radius, both positive")
        if self.normal and self.normal.deviation > self.normal.mean / 4:
            raise ValueError("normal.deviation: is more than a quarter of the mean, so that radii might be negative")
        return self

    def radii(self, count: int) -> np.ndarray:
        """Radii of ``count`` particles, (count,) [m]."""
        from scipy.special import ndtri

        part = (np.arange(count) + 0.5) / count
        if self.uniform:
            return self.uniform[0] + (self.uniform[1] - self.uniform[0]) * part
        if self.normal:
            return self.normal.mean + self.normal.deviation * ndtri(part)
        if self.lognormal:
            return self.lognormal.median * np.exp(self.lognormal.deviation * ndtri(part))
        return np.array(self.each)


class ParticlesConfig(Model):
    """Spheres of one material."""

    count: Annotated[StrictInt, Field(ge=1)]
    radius: Annotated[Length, _positive] | SizesConfig
    material: str

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

    def radii(self) -> np.ndarray:
        """Radii of the particles, (count,) [m]."""
        return (
            self.radius.radii(self.count) if isinstance(self.radius, SizesConfig) else np.full(self.count, self.radius)
        )


class DamperConfig(Model):
    """Damper: the cavity, and equal particles or a list of components of a mixture."""

    enclosure: EnclosureConfig
    particles: ParticlesConfig | Annotated[list[ParticlesConfig], Field(min_length=1)]

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
        radii = np.concatenate([part.radii() for part in self.mixture])
        size = f"{1e3 * self.enclosure.diameter:g} x {1e3 * self.enclosure.height:g} mm"
        if 2 * radii.max() >= min(self.enclosure.diameter, self.enclosure.height):
            raise ValueError(
                f"particles.radius: particles of diameter {2e3 * radii.max():g} mm do not fit the cavity ({size})"
            )
        fill, densest = self.fill, self.densest
        if fill > densest:
            most = math.floor(densest / fill * len(radii))
            raise ValueError(
                f"particles.count: too many particles: they would fill {fill:.3f} of the cavity, and not "
                f"even {'a crystal fills' if densest < 1 else 'all sizes together fill'} more than {densest:.3f}; "
                f"take at most {most}"
            )
        return self

    @property
    def fill(self) -> float:
        """Volume of the particles over that of the cavity [-]."""
        volume = sum(float(np.sum(sphere_volume(part.radii()))) for part in self.mixture)
        return volume / (math.pi / 4 * self.enclosure.diameter**2 * self.enclosure.height)

    @property
    def densest(self) -> float:
        """Packing fraction that no bed exceeds [-]: a crystal's of equal spheres, all space of several sizes."""
        radii = np.concatenate([part.radii() for part in self.mixture])
        return 0.74 if radii.min() == radii.max() else 1.0


def _unit(vector) -> tuple[float, float, float]:
    length = math.hypot(*vector)
    if length == 0:
        raise ValueError("a direction cannot be [0, 0, 0]")
    return tuple(component / length for component in vector)


_NAMED = {"axial": (0.0, 0.0, 1.0), "lateral": (1.0, 0.0, 0.0)}
Direction = Annotated[
    tuple[float, float, float],
    BeforeValidator(lambda value: _NAMED.get(value, value) if isinstance(value, str) else value),
    Field(description="axial, lateral, or [x, y, z] with z along the axis of the cavity"),
]


class ExcitationConfig(Model):
    """Sinusoidal motion of the cavity, along its axis unless ``direction`` says otherwise."""

    gamma: _swept(Number, _positive)
    frequency: Literal["modes"] | _swept(Frequency, _positive) = "modes"
    direction: Direction = (0.0, 0.0, 1.0)
    gravity: _swept(Acceleration, _not_negative) = 9.81
    gravity_direction: Direction = (0.0, 0.0, -1.0)

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


Switch = Annotated[bool | None, BeforeValidator(_switch), Field(description="on, off, or auto")]


_Switches = create_model(
    "_Switches", __base__=Model, **{name: (Switch, None) for name in FORCIBLE if name != "channels"}
)


class EffectsConfig(_Switches):
    """Effects forced on or off, whatever the scene requires; ``ledger``: losses by channel, or totals."""

    ledger: Literal["channels", "totals"] = "channels"

    def forced(self) -> tuple[tuple[str, bool], ...]:
        """Forced effects as sorted pairs (name, whether on)."""
        chosen = {name: value for name, value in vars(self).items() if name != "ledger" and value is not None}
        if self.ledger == "totals":
            chosen["channels"] = False
        return tuple(sorted(chosen.items()))
