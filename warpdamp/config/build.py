"""Construction of scene, particles and drive from a configuration of single values."""

from __future__ import annotations

import numpy as np

from ..numerics.timestep import Numerics
from ..scene.particles import Grains
from ..scene.scene import STANDARD_GRAVITY, Cylinder, Drive, Material, Scene, Surface
from .damper import WALLS
from .preparation import carried_path, preparation_word, state_asked
from .study import Config


def grains(config: Config) -> Grains:
    """Radius, species and aspect of every particle of a configuration."""
    mixture, names = config.damper.mixture, _species(config)
    aspects = tuple(part.shape.aspect for part in mixture for _ in range(part.count))
    return Grains(
        tuple(radius for part in mixture for radius in part.radii()),
        tuple(names.index(part.material) for part in mixture for _ in range(part.count)),
        aspects if config.damper.spheroids else (),
    )


def _species(config: Config) -> list[str]:
    """Names of the particles' materials, each once."""
    return list(dict.fromkeys(part.material for part in config.damper.mixture))


def material(config: Config, name: str) -> Material:
    """Material of that name in a configuration without lists."""
    return Material(**config.materials[name].elastic())


def scene(config: Config) -> Scene:
    """Scene of a configuration without lists, enclosure at rest."""
    contact, cavity, names = config.contact, config.damper.enclosure, _species(config)

    def surface(first: str, second: str) -> Surface:
        given = contact.pairs.get(f"{first} with {second}") or contact.pairs.get(f"{second} with {first}")
        given = given or (contact.walls if second == WALLS and contact.walls else contact)
        return Surface(given.restitution, given.friction, given.rolling_friction)

    pairs = tuple(tuple(surface(first, second) for second in names) for first in names)
    walls = tuple(surface(first, WALLS) for first in names)
    materials = tuple(material(config, name) for name in names)
    alone = len(names) == 1
    return Scene(
        particle=materials[0] if alone else materials,
        wall=material(config, cavity.material),
        particle_contact=pairs[0][0] if alone else pairs,
        wall_contact=walls[0] if alone else walls,
        enclosure=Cylinder(**cavity.model_dump(exclude={"material"})),
        gravity=tuple(config.excitation.gravity * part for part in config.excitation.gravity_direction),
    )


def bed(config: Config) -> dict:
    """How a bed of a configuration without lists is prepared, as arguments of ``Request``; carried ones begin loose."""
    if asked := state_asked(config.preparation):
        return {"preparation": "compacted", **asked}
    return {"preparation": "loose" if carried_path(config.preparation) else preparation_word(config.preparation)}


def numerics_of(config: Config) -> Numerics:
    """Numerical choices of a configuration without lists."""
    own = config.numerics
    return Numerics(own.precision, own.steps_per_contact, config.effects.forced(), own.device)


def drive(config: Config, frequency: float, gamma: float) -> Drive:
    """Drive of a configuration with acceleration amplitude Gamma g."""
    return Drive(frequency, gamma * STANDARD_GRAVITY, config.excitation.direction)


def particle_mass(config: Config) -> float:
    """Mass of all particles of a configuration without lists [kg]."""
    return float(np.sum(scene(config).masses(grains(config))))
