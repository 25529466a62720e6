"""Where a study's modes come from."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .config import Config
from .sweep import material

if TYPE_CHECKING:
    from .modal.modes import Modes


def modes(config: Config, *, particles: float) -> Modes:
    """The configured modes of the structure carrying ``particles`` [kg].

    Raises
    ------
    ConfigError
        If a mode does not exist or has a node at the damper.
    """
    from .modal.fem import beam_modes

    structure = config.structure
    every = beam_modes(beam(config), particle_mass=particles, highest=max(structure.modes))
    try:
        return every.pick(structure.modes)
    except ValueError as error:
        raise config.error("structure.modes", str(error)) from None


def beam(config: Config):
    """The configured beam."""
    from .modal.fem import Beam

    structure = config.structure
    return Beam(
        length=structure.beam.length,
        width=structure.beam.width,
        thickness=structure.beam.thickness,
        material=material(config, structure.beam.material),
        supports=structure.beam.supports,
        mass_position=structure.point_mass.position,
        mass=structure.point_mass.mass,
    )
