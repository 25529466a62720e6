"""A study's axes: which scalars are lists, and the scene at every point of their product."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .config import Config
from .config_damper import WALLS
from .scene import STANDARD_GRAVITY, Cylinder, Drive, Grains, Material, Scene, Surface

if TYPE_CHECKING:
    from .modal.modes import Modes

UNITS = {
    "density": ("kg m-3", "density"),
    "youngs_modulus": ("Pa", "Young's modulus"),
    "poissons_ratio": ("1", "Poisson's ratio"),
    "restitution": ("1", "coefficient of restitution"),
    "friction": ("1", "coefficient of friction"),
    "rolling_friction": ("1", "coefficient of rolling friction"),
    "gravity": ("m s-2", "gravity"),
}


@dataclass(frozen=True)
class Axis:
    """A swept scalar: its name among the results' dimensions, its path in the configuration, its values (SI)."""

    name: str
    path: tuple[str, ...]
    values: tuple[float, ...]

    @property
    def attributes(self) -> dict:
        """CF attributes of its coordinate."""
        units, long_name = UNITS[self.path[-1]]
        return {"units": units, "long_name": long_name, "configuration_key": ".".join(self.path)}


@dataclass(frozen=True)
class Point:
    """One combination of the swept scalars: its configuration, its modes, and its excitation frequencies [Hz]."""

    index: tuple[int, ...]
    config: Config
    modes: Modes | None
    frequencies: list[float]


def as_list(value) -> list:
    """A swept scalar's values, whether one or a list."""
    return list(value) if isinstance(value, list) else [value]


def axes(config: Config) -> list[Axis]:
    """The swept scalars of materials, contact and gravity.

    An axis is called by its key; where two keys are the same, by its path.

    Raises
    ------
    ConfigError
        If an axis names a value twice.
    """
    values = config.model_dump()
    found = []
    for section in ("materials", "contact", "excitation"):
        found += [
            (path, tuple(value))
            for path, value in _leaves(values[section], (section,))
            if isinstance(value, list) and path[-1] not in ("gamma", "frequency", "direction", "gravity_direction")
        ]
    for path, points in [*found, (("excitation", "gamma"), tuple(as_list(config.excitation.gamma)))]:
        if len(set(points)) < len(points):
            raise config.error(".".join(path), "each value once")
    keys = [path[-1] for path, _ in found]
    return [Axis(path[-1] if keys.count(path[-1]) == 1 else "_".join(path[1:]), path, points) for path, points in found]


def _leaves(node, path):
    for key, value in node.items():
        if isinstance(value, dict):
            yield from _leaves(value, (*path, key))
        else:
            yield (*path, key), value


def points(config: Config):
    """Every combination of the swept scalars: (index, configuration with one value each)."""
    swept = axes(config)
    for index in itertools.product(*(range(len(axis.values)) for axis in swept)):
        values = config.model_dump()
        for axis, k in zip(swept, index, strict=True):
            node = values
            for key in axis.path[:-1]:
                node = node[key]
            node[axis.path[-1]] = axis.values[k]
        yield index, Config.model_validate(values)


def grains(config: Config) -> Grains:
    """Radius and species of every particle of a configuration."""
    mixture, names = config.damper.mixture, _species(config)
    return Grains(
        tuple(float(r) for part in mixture for r in part.radii()),
        tuple(names.index(part.material) for part in mixture for _ in range(part.count)),
    )


def _species(config: Config) -> list[str]:
    """Names of the particles' materials, each once."""
    return list(dict.fromkeys(part.material for part in config.damper.mixture))


def material(config: Config, name: str) -> Material:
    """A named material of a configuration without lists."""
    return Material(**config.materials[name].model_dump())


def scene(config: Config) -> Scene:
    """The scene of a configuration without lists, enclosure at rest."""
    contact, cavity, names = config.contact, config.damper.enclosure, _species(config)

    def surface(one: str, other: str) -> Surface:
        given = contact.pairs.get(f"{one} with {other}") or contact.pairs.get(f"{other} with {one}")
        given = given or (contact.walls if other == WALLS and contact.walls else contact)
        return Surface(given.restitution, given.friction, given.rolling_friction)

    pairs = tuple(tuple(surface(one, other) for other in names) for one in names)
    walls = tuple(surface(one, WALLS) for one in names)
    materials = tuple(material(config, name) for name in names)
    alone = len(names) == 1
    return Scene(
        particle=materials[0] if alone else materials,
        wall=material(config, cavity.material),
        particle_contact=pairs[0][0] if alone else pairs,
        wall_contact=walls[0] if alone else walls,
        enclosure=Cylinder(cavity.diameter, cavity.height, cavity.side, cavity.floor, cavity.lid),
        gravity=tuple(config.excitation.gravity * part for part in config.excitation.gravity_direction),
    )


def drive(config: Config, frequency: float, gamma: float) -> Drive:
    """With acceleration amplitude Gamma g."""
    return Drive(frequency, gamma * STANDARD_GRAVITY, config.excitation.direction)


def particle_mass(config: Config) -> float:
    """Of all particles of a configuration without lists [kg]."""
    return float(np.sum(scene(config).masses(grains(config))))
