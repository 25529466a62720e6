"""A study's axes: which scalars are lists, and the scene at every point of their product."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .config import Config
from .scene import STANDARD_GRAVITY, Cylinder, Drive, Grains, Material, Scene, Surface

if TYPE_CHECKING:
    from .modal.modes import Modes

UNITS = {
    "density": ("kg m-3", "density"),
    "youngs_modulus": ("Pa", "Young's modulus"),
    "poissons_ratio": ("1", "Poisson's ratio"),
    "restitution": ("1", "coefficient of restitution"),
    "friction": ("1", "coefficient of friction"),
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
            if isinstance(value, list) and path[-1] not in ("gamma", "frequency")
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
    """Radius and species of every particle."""
    return Grains.alike(config.damper.particles.radius, config.damper.particles.count)


def material(config: Config, name: str) -> Material:
    """A named material of a configuration without lists."""
    return Material(**config.materials[name].model_dump())


def scene(config: Config) -> Scene:
    """The scene of a configuration without lists, enclosure at rest."""
    damper, contact = config.damper, config.contact
    surface = Surface(contact.restitution, contact.friction)
    walls = contact.walls
    return Scene(
        particle=material(config, damper.particles.material),
        wall=material(config, damper.enclosure.material),
        particle_contact=surface,
        wall_contact=Surface(walls.restitution, walls.friction) if walls else surface,
        enclosure=Cylinder(damper.enclosure.diameter, damper.enclosure.height),
        gravity=(0.0, 0.0, -config.excitation.gravity),
    )


def drive(frequency: float, gamma: float) -> Drive:
    """Along the axis, with acceleration amplitude Gamma g."""
    return Drive(frequency=frequency, acceleration=gamma * STANDARD_GRAVITY)


def particle_mass(config: Config) -> float:
    """Of all particles of a configuration without lists [kg]."""
    return float(np.sum(scene(config).masses(grains(config))))
