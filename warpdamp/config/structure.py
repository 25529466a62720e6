"""The ``structure`` section of the configuration: where the modes come from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StrictInt, model_validator

from .base import NOT_NEGATIVE, POSITIVE, Model
from .damper import DamperConfig
from .quantities import Frequency, Length, Mass, Number, quantity

Support = Literal["clamped", "pinned", "free"]
Direction = Literal["x", "y", "z"] | Annotated[list[Number], Field(min_length=3, max_length=3)]
MeshUnit = Annotated[Length, POSITIVE]
ModeNumber = Annotated[StrictInt, Field(ge=1)]
Damping = Annotated[Number, Field(ge=0, lt=1)]
Participation = quantity("kg^0.5")


class SectionConfig(Model):
    """A section of any shape: a plane mesh, its first coordinate along the width, its second along the thickness."""

    file: str
    """Mesh file of the section, beside the configuration; needs the extra ``modes``."""
    unit: MeshUnit = 1.0
    """Unit of the mesh's coordinates."""


class BeamConfig(Model):
    """A straight beam.  Its section is width and thickness, diameter, diameter and wall, or a mesh."""

    length: Annotated[Length, POSITIVE]
    """Length between the ends."""
    width: Annotated[Length, POSITIVE] | None = None
    """Width of a rectangular section."""
    thickness: Annotated[Length, POSITIVE] | None = None
    """Thickness of a rectangular section, along the damper's axis."""
    diameter: Annotated[Length, POSITIVE] | None = None
    """Outer diameter of a round section."""
    wall: Annotated[Length, POSITIVE] | None = None
    """Wall thickness of a tube; left out: a solid rod."""
    section: SectionConfig | None = None
    """A section of any shape, from a mesh."""
    material: str
    """Name of the beam's material, one of ``materials`` or of the library."""
    supports: tuple[Support, Support] = ("clamped", "clamped")
    """How the two ends are held."""
    bends: Literal["thickness", "width"] = "thickness"
    """Side of the section across which the modes bend that are counted."""

    @model_validator(mode="after")
    def _one_section(self):
        given = {name for name in ("width", "thickness", "diameter", "wall", "section") if getattr(self, name)}
        if given not in ({"width", "thickness"}, {"diameter"}, {"diameter", "wall"}, {"section"}):
            raise ValueError(
                "a section is width and thickness, or diameter, or diameter and wall, or a mesh (section); "
                f"got {' and '.join(sorted(given)) or 'none of them'}"
            )
        if self.wall and 2 * self.wall >= self.diameter:
            raise ValueError("wall: leaves no hole; leave it out for a solid rod")
        return self


class PlateConfig(Model):
    """A rectangular plate from (0, 0) to (length, width); edges at x = 0, x = length, y = 0, y = width."""

    length: Annotated[Length, POSITIVE]
    """Side along x."""
    width: Annotated[Length, POSITIVE]
    """Side along y."""
    thickness: Annotated[Length, POSITIVE]
    """Thickness, along z, in which it bends."""
    material: str
    """Name of the plate's material, one of ``materials`` or of the library."""
    edges: tuple[Support, Support, Support, Support] = ("clamped",) * 4
    """How the edges at x = 0, x = length, y = 0 and y = width are held."""


class BoxConfig(Model):
    """A part of space: for each coordinate that matters a plane, or the limits [from, to]."""

    x: Length | Annotated[list[Length], Field(min_length=2, max_length=2)] | None = None
    """Plane, or limits, along x."""
    y: Length | Annotated[list[Length], Field(min_length=2, max_length=2)] | None = None
    """Plane, or limits, along y."""
    z: Length | Annotated[list[Length], Field(min_length=2, max_length=2)] | None = None
    """Plane, or limits, along z."""

    @model_validator(mode="after")
    def _some(self):
        if self.x is None and self.y is None and self.z is None:
            raise ValueError("give at least one of x, y and z")
        return self


class MeshConfig(Model):
    """A solid of any shape: a mesh of tetrahedra, hexahedra, wedges, pyramids, held at named boundaries or in boxes."""

    file: str
    """Mesh file, beside the configuration; needs the extra ``modes``."""
    unit: MeshUnit = 1.0
    """Unit of the mesh's coordinates."""
    material: str
    """Name of the solid's material, one of ``materials`` or of the library."""
    clamped: list[str | BoxConfig] = Field([])
    """What is held: names of boundaries or sets of nodes, planes, or boxes."""
    direction: Direction = "z"
    """Direction of the damper's axis on the structure."""


class PointMassConfig(Model):
    """A mass fixed to the structure: the empty damper with its fixtures, or any other.

    Its position is along a beam, [x, y] on a plate, [x, y, z] on a mesh; on plates and meshes it stands on a
    footprint of some diameter.
    """

    mass: Annotated[Mass, NOT_NEGATIVE]
    """Mass of the empty damper with its fixtures, or of whatever sits there."""
    position: Length | Annotated[list[Length], Field(min_length=2, max_length=3)]
    """Place along a beam, [x, y] on a plate, [x, y, z] on a mesh."""
    rotary_inertia: Annotated[quantity("kg m^2"), NOT_NEGATIVE] = 0.0
    """Moment of inertia about the axis of bending; on beams only."""
    footprint: Annotated[Length, POSITIVE] | None = None
    """Diameter of what the mass stands on; on plates and meshes."""


class FurtherDamperConfig(DamperConfig):
    """A damper beside the first one, with a filling of its own; and where it sits, by exactly one of these keys.

    ``point_mass``: on computed modes, the empty damper; ``node`` or ``position``: on modes from a file;
    ``amplitude``: on modes given in numbers, the mass-normalised shape of each mode there, with its sign.
    """

    point_mass: PointMassConfig | None = None
    """Empty damper and its place, on computed modes."""
    node: StrictInt | None = None
    """Node on which it sits, on modes from a file."""
    position: Annotated[list[Length], Field(min_length=3, max_length=3)] | None = None
    """Place on which it sits, the nearest node, on modes from a file."""
    amplitude: Annotated[list[quantity("kg^-0.5")], Field(min_length=1)] | None = None
    """Mass-normalised shape of each mode at its place, with its sign, on modes given in numbers."""

    @property
    def place(self) -> str:
        """The key that says where it sits."""
        return next(name for name in PLACES if getattr(self, name) is not None)

    @model_validator(mode="after")
    def _one_place(self):
        if sum(getattr(self, name) is not None for name in PLACES) != 1:
            raise ValueError(f"say where the damper sits, by one of {', '.join(PLACES)}")
        return self


PLACES = ("point_mass", "node", "position", "amplitude")


class ModeFileConfig(Model):
    """Modes from a file (UFF, CSV, Nastran's .f06 or .pch, Ansys's .rst), and where on it the damper sits.

    ``participation``: one factor for each of them, positive where base and damper move the same way.
    """

    file: str
    """File, beside the configuration, or a full path."""
    node: StrictInt | None = None
    """Node on which the damper sits."""
    position: Annotated[list[Length], Field(min_length=3, max_length=3)] | None = None
    """Place on which the damper sits: the nearest node."""
    direction: Direction = "z"
    """Direction of the damper's axis on the structure."""
    modal_mass: Annotated[Mass, POSITIVE] | list[Annotated[Mass, POSITIVE]] | None = None
    """Modal mass of the shapes as they are written, one or one per mode, where the file does not say."""
    participation: list[Participation] | None = None
    """Participation factor of each mode, for a base that moves."""
    units: Literal["SI", "BG", "MG", "BA", "MM", "CM", "IN", "GM", "MM-N"] | None = None
    """System of units of a universal file that does not say."""

    @model_validator(mode="after")
    def _one_place(self):
        if (self.node is None) == (self.position is None):
            raise ValueError("give the damper's node, or its position, as [0 mm, 0 mm, 290 mm]")
        return self


class GivenModeConfig(Model):
    """A mode in numbers: its shape at the damper as modal mass 1 / phi^2 or as amplitude phi.

    ``participation``: Gamma = phi^T M d, of a base that moves along the excitation.
    """

    frequency: Annotated[Frequency, POSITIVE]
    """Natural frequency."""
    modal_mass: Annotated[Mass, POSITIVE] | None = None
    """Modal mass of the shape scaled to 1 at the damper."""
    amplitude: Annotated[quantity("kg^-0.5"), POSITIVE] | None = None
    """Mass-normalised shape at the damper, 1 / sqrt(modal_mass)."""
    damping: Damping = 0.0
    """Damping ratio without the damper."""
    participation: Participation | None = None
    """Participation factor of the mode, for a base that moves."""
    number: ModeNumber | None = None
    """Number of the mode in the results; left out: its place in the list."""

    @model_validator(mode="after")
    def _scaled(self):
        if self.modal_mass is None and self.amplitude is None:
            raise ValueError(
                "no modal mass: nothing says how much of the structure moves with the damper; give modal_mass (in kg, "
                "of the shape scaled to 1 at the damper) or amplitude (the mass-normalised shape there, in kg^-0.5)"
            )
        if self.modal_mass is not None and self.amplitude is not None:
            raise ValueError("amplitude: is 1 / sqrt(modal_mass): give one of the two")
        return self

    @property
    def phi(self) -> float:
        """Mass-normalised shape at the damper [kg^-0.5]."""
        return self.amplitude if self.modal_mass is None else self.modal_mass**-0.5


class StructureConfig(Model):
    """The vibrating structure that the damper sits on, by exactly one of the first five keys."""

    beam: BeamConfig | None = None
    """A straight beam, whose modes are computed."""
    plate: PlateConfig | None = None
    """A rectangular plate, whose modes are computed."""
    mesh: MeshConfig | None = None
    """A solid from a mesh file, whose modes are computed."""
    mode_file: ModeFileConfig | None = None
    """Modes from a measurement or another program."""
    modes_given: Annotated[list[GivenModeConfig], Field(min_length=1)] | None = None
    """Modes in numbers, one or more."""
    point_mass: PointMassConfig | None = None
    """The empty damper and its place; on computed modes."""
    other_masses: list[PointMassConfig] = Field([])
    """Other masses fixed to the structure; on computed modes."""
    particles_included: bool | None = None
    """Whether known modes were found with the particles in place; if not, the particles' mass is added."""
    modes: Annotated[list[Annotated[StrictInt, Field(ge=1, le=200)]], Field(min_length=1)] | None = None
    """Numbers of the modes to damp; of known modes, left out: all that move the damper."""
    inherent_damping: Damping | list[Damping] | None = None
    """Damping ratio of the bare structure, one or one per mode, added to what the damper gives."""

    @property
    def source(self) -> str:
        """Key that says where the modes come from."""
        return next(name for name in SOURCES if getattr(self, name) is not None)

    @property
    def computed(self) -> bool:
        """Whether finite elements compute the modes."""
        return self.source in ("beam", "plate", "mesh")

    @property
    def material(self) -> str | None:
        """Name of the structure's material, where it has one."""
        return getattr(self, self.source).material if self.computed else None

    def found_from(self, folder: Path) -> StructureConfig:
        """Section with absolute paths of its files; relative ones start at ``folder``."""
        own = getattr(self, self.source)
        if self.source == "beam" and own.section:
            section = own.section.model_copy(update={"file": str(folder / own.section.file)})
            return self.model_copy(update={"beam": own.model_copy(update={"section": section})})
        if self.source in ("mesh", "mode_file"):
            return self.model_copy(update={self.source: own.model_copy(update={"file": str(folder / own.file)})})
        return self

    @model_validator(mode="after")
    def _consistent(self):
        sources = [name for name in SOURCES if getattr(self, name) is not None]
        if len(sources) != 1:
            raise ValueError(f"give one of {', '.join(SOURCES)}; got {' and '.join(sources) or 'none of them'}")
        if self.computed:
            self._check_computed()
        else:
            self._check_known()
        if self.modes and len(set(self.modes)) < len(self.modes):
            raise ValueError("modes: each mode once")
        given = self.inherent_damping
        if isinstance(given, list) and len(given) != len(self.modes or given):
            raise ValueError(
                f"inherent_damping: {len(given)} values for {len(self.modes)} modes: give one, or one per mode"
            )
        return self

    def _check_computed(self):
        for name in ("point_mass", "modes"):
            if getattr(self, name) is None:
                raise ValueError(f"{name} is missing: {NEEDED[name]}")
        if self.particles_included is not None:
            raise ValueError("particles_included: is for known modes; to computed ones the particles are always added")
        _check_place(self, "point_mass", self.point_mass)
        for k, mass in enumerate(self.other_masses):
            _check_place(self, f"other_masses.{k}", mass)

    def _check_known(self):
        for name in ("point_mass", "other_masses"):
            if getattr(self, name):
                raise ValueError(
                    f"{name}: is for computed modes: known ones contain the masses that they were made with"
                )
        if self.particles_included is None:
            raise ValueError(
                "particles_included is missing: say true if these modes were measured or computed with the particles' "
                "mass in place, false if with the empty damper; the particles are then added"
            )
        if self.modes_given:
            numbers = [given.number or k for k, given in enumerate(self.modes_given, 1)]
            if len(set(numbers)) < len(numbers):
                raise ValueError("modes_given: each number once")
            if self.inherent_damping is not None and any(given.damping for given in self.modes_given):
                raise ValueError("inherent_damping: is given for each mode already, as damping")


SOURCES = ("beam", "plate", "mesh", "mode_file", "modes_given")
NEEDED = {
    "point_mass": "the empty damper's mass and position, as {mass: 200 g, position: 290 mm}",
    "modes": "the numbers of the modes to damp, as [1, 3]",
}
PLACE_OF = {"mode_file": ("node", "position"), "modes_given": ("amplitude",)}
"""How a further damper says where it sits, by the source of the modes; on computed ones as ``point_mass``."""
COORDINATES = {"beam": 1, "plate": 2, "mesh": 3}
SHOWN = {1: "290 mm", 2: "[100 mm, 50 mm]", 3: "[100 mm, 50 mm, 2 mm]"}


def check_further(structure: StructureConfig, place: str, damper: FurtherDamperConfig) -> None:
    """A further damper says where it sits as its structure calls for.

    Raises
    ------
    ValueError
        That begins with the key at fault, below ``place``.
    """
    known = PLACE_OF.get(structure.source, ("point_mass",))
    if damper.place not in known:
        raise ValueError(f"{place}.{damper.place}: on structure.{structure.source} give {' or '.join(known)} instead")
    if damper.point_mass:
        _check_place(structure, f"{place}.point_mass", damper.point_mass)
    if damper.amplitude and len(damper.amplitude) != len(structure.modes_given):
        count = f"{len(damper.amplitude)} values for {len(structure.modes_given)} modes"
        raise ValueError(f"{place}.amplitude: {count} of structure.modes_given")


def _check_place(structure: StructureConfig, place: str, mass: PointMassConfig) -> None:
    """Check that a mass has the coordinates of its structure, and sits where it can move."""
    source = structure.source
    position = mass.position if isinstance(mass.position, list) else [mass.position]
    if len(position) != COORDINATES[source]:
        raise ValueError(f"{place}.position: on a {source} it is written as {SHOWN[COORDINATES[source]]}")
    if source == "beam" and mass.footprint is not None:
        raise ValueError(f"{place}.footprint: a mass on a beam is fixed to the whole section")
    if source != "beam" and mass.footprint is None:
        raise ValueError(f"{place}: footprint is missing: the diameter of what the mass stands on, as 40 mm")
    if source != "beam" and mass.rotary_inertia:
        raise ValueError(f"{place}.rotary_inertia: is for beams only")
    if source == "mesh":
        return
    held = structure.beam.supports if source == "beam" else structure.plate.edges
    sides = [structure.beam.length] if source == "beam" else [structure.plate.length, structure.plate.width]
    for axis, (x, side) in enumerate(zip(position, sides, strict=True)):
        if not 0 <= x <= side:
            raise ValueError(f"{place}.position: lies beyond the end of the {source}")
        for end, support in zip((0.0, side), held[2 * axis :], strict=False):
            if support != "free" and x == end:
                raise ValueError(f"{place}.position: is at a {support} end, which does not move")
