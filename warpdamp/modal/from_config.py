"""Modes of the configured structure: configuration -> Modes."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..config.build import material
from ..config.structure import BeamConfig, BoxConfig, PointMassConfig
from ..config.study import Config
from ..modes import Modes
from .clamp import Clamp
from .section import Circle, MeshedSection, Rectangle, Section, Tube

if TYPE_CHECKING:
    from .beam import Beam, PointMass
    from .solid import StandingMass


def modes(config: Config, *, particles: float, further: Sequence[float] = ()) -> Modes:
    """Modes of the configured structure carrying ``particles``, those that the configuration asks for.

    They are as the first damper sees them.

    Parameters
    ----------
    config : Config
    particles : float
        Mass of the particles in the first damper [kg].
    further : sequence of floats
        Mass of the particles in each of the further dampers [kg] (default: they are empty).

    Returns
    -------
    Modes

    Raises
    ------
    ConfigError
        If they cannot be had, or if a mode does not exist or has a node at the damper.
    """
    structure = config.structure
    with _placed(config, f"structure.{structure.source}"):
        every = _with_further(config, particles, further or [0.0] * len(config.dampers))
    with _placed(config, "structure.modes" if structure.modes else f"structure.{structure.source}"):
        found = every.pick(structure.modes or every.dampable)
    if structure.inherent_damping is None:
        return found
    given = np.asarray(structure.inherent_damping, float)
    if given.ndim and len(given) != len(found.number):
        raise config.error("structure.inherent_damping", f"{len(given)} values for {len(found.number)} modes")
    return replace(found, inherent_damping=np.broadcast_to(given, found.number.shape))


def _with_further(config: Config, particles: float, further: Sequence[float]) -> Modes:
    """Modes of the structure with the particles in each of its dampers."""
    structure, maker = config.structure, MAKERS[config.structure.source]
    if structure.computed and config.dampers:
        masses = [
            damper.point_mass.model_copy(update={"mass": damper.point_mass.mass + mass})
            for damper, mass in zip(config.dampers, further, strict=True)
        ]
        more = structure.model_copy(update={"other_masses": [*structure.other_masses, *masses]})
        return maker(config.model_copy(update={"structure": more}), particles)
    every = maker(config, particles)
    return every if structure.particles_included else with_further_masses(config, every, further)


def with_further_masses(config: Config, modes: Modes, masses: Sequence[float]) -> Modes:
    """Modes with a mass more in each of the further dampers [kg], as the first one sees them."""
    for k, mass in enumerate(masses):
        modes = seen_from_further(config, modes, k).with_mass(mass).seen_from(modes.damper, modes.direction)
    return modes


def seen_from_further(config: Config, modes: Modes, k: int) -> Modes:
    """The modes as the further damper number ``k`` sees them.

    Raises
    ------
    ValueError
        If there is no such place.
    """
    damper, source = config.dampers[k], config.structure.source
    if source == "beam":
        position = damper.point_mass.position
        return modes.at((position[0] if isinstance(position, list) else position, 0.0, 0.0))
    if source == "mode_file":
        return modes.at(damper.position) if damper.node is None else modes.at_label(damper.node)
    # on plates and meshes the masses, in the modes given in numbers the dampers, are the first of the points
    row = 1 + k + (len(config.structure.other_masses) if source != "modes_given" else 0)
    return modes.seen_from(row, modes.direction)


def seen_by_all(config: Config, modes: Modes) -> list[Modes]:
    """The modes as each damper sees them, the first one first.

    Raises
    ------
    ConfigError
        If a place does not exist.
    """
    found = [modes]
    for k in range(len(config.dampers)):
        with _placed(config, f"dampers.{k}.{config.dampers[k].place}"):
            found.append(seen_from_further(config, modes, k))
    return found


def amplitudes(config: Config, modes: Modes) -> np.ndarray:
    """Mass-normalised shapes at all dampers, (dampers, modes) [kg^-0.5], positive at the first one.

    Raises
    ------
    ConfigError
        If a place does not exist.
    """
    seen = seen_by_all(config, modes)  # with shapes that are positive at the damper itself
    at_first = np.array([own.shape[:, modes.damper] @ np.asarray(modes.direction) for own in seen])
    return np.sign(at_first) * [own.amplitude for own in seen]


@contextmanager
def _placed(config: Config, key: str):
    """Context in which a ValueError of a structure's constructors becomes a configuration error at ``key``."""
    try:
        yield
    except (ValueError, OSError, ImportError) as error:
        raise config.error(key, str(error)) from None


def beam(config: Config) -> tuple[Beam, PointMass]:
    """Configured beam, and the empty damper on it.

    Parameters
    ----------
    config : Config

    Returns
    -------
    Beam, PointMass
    """
    from .beam import Beam

    structure = config.structure
    own = structure.beam
    return Beam(
        length=own.length,
        section=_section(config, own),
        material=material(config, own.material),
        supports=own.supports,
        bends=own.bends,
        masses=tuple(_point_mass(mass) for mass in structure.other_masses),
    ), _point_mass(structure.point_mass)


def _beam_modes(config: Config, particles: float) -> Modes:
    from .beam import beam_modes

    own, damper = beam(config)
    return beam_modes(own, damper.loaded(particles), highest=max(config.structure.modes))


def _section(config: Config, own: BeamConfig) -> Section:
    if own.section:
        return MeshedSection(_file(config, own.section.file), own.section.unit)
    if own.wall:
        return Tube(own.diameter, own.wall)
    return Circle(own.diameter) if own.diameter else Rectangle(own.width, own.thickness)


def _point_mass(mass: PointMassConfig) -> PointMass:
    from .beam import PointMass

    position = mass.position[0] if isinstance(mass.position, list) else mass.position
    return PointMass(mass.mass, position, mass.rotary_inertia)


def _plate_modes(config: Config, particles: float) -> Modes:
    from .solid import Plate, plate_modes

    own = config.structure.plate
    plate = Plate(own.length, own.width, own.thickness, material(config, own.material), own.edges)
    damper, *others = _standing_masses(config)
    return plate_modes(plate, damper.loaded(particles), others, highest=max(config.structure.modes))


def _mesh_modes(config: Config, particles: float) -> Modes:
    from .solid import MeshedSolid, solid_modes

    own = config.structure.mesh
    solid = MeshedSolid(
        file=_file(config, own.file),
        material=material(config, own.material),
        clamps=tuple(_clamp(clamp) for clamp in own.clamped),
        unit=own.unit,
        direction=_direction(own.direction),
    )
    damper, *others = _standing_masses(config)
    return solid_modes(solid, damper.loaded(particles), others, highest=max(config.structure.modes))


def _clamp(clamp: str | BoxConfig) -> Clamp:
    if isinstance(clamp, str):
        return Clamp(boundary=clamp)
    limits = (clamp.x, clamp.y, clamp.z)
    return Clamp(box=tuple(tuple(x) if isinstance(x, list) else x if x is None else (x, x) for x in limits))


def _standing_masses(config: Config) -> list[StandingMass]:
    from .solid import StandingMass

    masses = (config.structure.point_mass, *config.structure.other_masses)
    return [StandingMass(mass.mass, tuple(mass.position), mass.footprint) for mass in masses]


def _mode_file(config: Config, particles: float) -> Modes:
    from ..formats.mode_file import read_modes

    own = config.structure.mode_file
    file = _file(config, own.file)
    every = read_modes(file, modal_mass=own.modal_mass, units=own.units)
    direction = _direction(own.direction)
    seen = every.at(own.position, direction) if own.node is None else every.at_label(own.node, direction)
    seen = _with_participation(seen, own.participation)
    return seen if config.structure.particles_included else seen.with_mass(particles)


def _modes_given(config: Config, particles: float) -> Modes:
    given = config.structure.modes_given
    elsewhere = [[damper.amplitude[k] for damper in config.dampers] for k in range(len(given))]
    alone = Modes(
        number=np.array([mode.number or k for k, mode in enumerate(given, 1)]),
        frequency=np.array([mode.frequency for mode in given]),
        point=np.zeros((1 + len(config.dampers), 3)),
        shape=np.array(
            [[[0.0, 0.0, phi] for phi in (mode.phi, *others)] for mode, others in zip(given, elsewhere, strict=True)]
        ),
        inherent_damping=np.array([mode.damping for mode in given]),
    )
    gammas = [mode.participation for mode in given]
    if any(gamma is not None for gamma in gammas):
        if None in gammas:
            raise ValueError(f"mode {alone.number[gammas.index(None)]} has no participation, and others have one")
        alone = _with_participation(alone, gammas)
    return alone if config.structure.particles_included else alone.with_mass(particles)


def _with_participation(modes: Modes, given: list[float] | None) -> Modes:
    """Modes with the participation factors of a base that moves along their direction, where they are given [kg^0.5].

    Raises
    ------
    ValueError
        If there is not one for each mode.
    """
    if given is None:
        return modes
    if len(given) != len(modes.number):
        raise ValueError(f"participation: {len(given)} values for {len(modes.number)} modes")
    return replace(modes, participation=np.outer(given, modes.direction))


MAKERS = {
    "beam": _beam_modes,
    "plate": _plate_modes,
    "mesh": _mesh_modes,
    "mode_file": _mode_file,
    "modes_given": _modes_given,
}


def _direction(direction) -> tuple[float, float, float]:
    return tuple(np.eye(3)["xyz".index(direction)] if isinstance(direction, str) else map(float, direction))


def _file(config: Config, name: str) -> Path:
    """Path of a file that a configuration names, beside it unless it is absolute."""
    return config.folder / name
