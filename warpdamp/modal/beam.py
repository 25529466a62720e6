"""Bending modes of a straight beam with point masses, in three-dimensional finite elements.

The section's mesh is swept along the beam, in lengths graded towards the supports and the masses: clamps hold back
Poisson's contraction in a boundary layer, and masses bend the beam sharply.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.sparse import diags, eye, kron, vstack

from ..errors import ModalError
from ..modes import Modes
from ..scene.scene import Material
from .eigenmodes import Attached, Elastic, elastic_modes, participation, turned
from .extrusion import Carried, swept
from .fem import Solid, extruded, graded, integrals
from .mesh_error import swept_error
from .reduced import converged
from .section import MeshedSection, Section, moments

Support = Literal["clamped", "pinned", "free"]
BENDS = {"width": 1, "thickness": 2}
HELD = {"clamped": (0, 1, 2), "pinned": (1, 2)}
FINEST, COARSEST = 0.125, 1.5
"""Lengths of the elements at the ends and the masses, and far from them, in thicknesses."""


@dataclass(frozen=True)
class PointMass:
    """Mass fixed to a beam: mass [kg], position along the beam [m], rotary inertia about the bending axis [kg m^2]."""

    mass: float
    position: float
    rotary_inertia: float = 0.0

    def loaded(self, mass: float) -> PointMass:
        """Point mass with a further ``mass`` [kg]."""
        return replace(self, mass=self.mass + mass)


@dataclass(frozen=True)
class Beam:
    """Straight beam along x.

    Parameters
    ----------
    length : [m]
    section : Rectangle, Circle, Tube or MeshedSection
    material : Material
    supports : how the ends x = 0 and x = length are held
        A clamped section does not move; a pinned one keeps its place and may warp and turn; a free one is free.
    bends : whether across the thickness (z) or the width (y)
    masses : tuple of PointMass, without the damper
    """

    length: float
    section: Section
    material: Material
    supports: tuple[Support, Support] = ("clamped", "clamped")
    bends: Literal["thickness", "width"] = "thickness"
    masses: tuple[PointMass, ...] = ()


def beam_modes(beam: Beam, damper: PointMass, *, highest: int = 5) -> Modes:
    """Bending modes 1 .. ``highest`` of a beam with its masses and a damper, as the damper sees them.

    Modes are found by shape, not by their place in the spectrum: those whose kinetic energy is that of the sections'
    mean motion in the direction of bending.  Torsion, stretching and bending the other way lie between them; rigid
    motions are not counted.

    Parameters
    ----------
    beam : Beam
    damper : PointMass
        Where the damper sits, and the mass of it.
    highest : number of the highest mode wanted

    Raises
    ------
    ValueError
        If a mass lies beyond the ends of the beam.
    """
    axis = BENDS[beam.bends]
    section = beam.section.basis()
    _longer_than_wide(beam, section)
    masses = (damper, *beam.masses)
    shared = 4 if beam.section.quarter else 1
    if beam.section.quarter:
        station, read, squares, vectors, gamma, error = _of_a_quarter(beam, section, masses, highest)
    else:
        station, read, squares, vectors, gamma, error = _of_a_mesh(beam, section, masses, highest)
    modes = Modes(
        number=np.arange(1, highest + 1),
        frequency=np.sqrt(squares) / (2 * np.pi),
        point=np.stack([station, 0 * station, 0 * station], axis=1),
        shape=np.stack([(mean @ vectors).T for mean in read[:3]], axis=2) / math.sqrt(shared),
        inherent_damping=np.zeros(highest),
        mesh_error=error,
        participation=math.sqrt(shared) * gamma,
    )
    return modes.at((damper.position, 0, 0), np.eye(3)[axis])


def _longer_than_wide(beam: Beam, section) -> None:
    """Refuses a meshed section wider than its beam is long: its unit is another."""
    extent = np.ptp(section.mesh.p, axis=1)
    if isinstance(beam.section, MeshedSection) and extent.max() > beam.length:
        size = " x ".join(f"{1e3 * side:.4g}" for side in extent)
        raise ModalError(
            f"{beam.section.file}: a section of {size} mm on a beam {1e3 * beam.length:.4g} mm long: is its unit "
            "right? write it, as unit: 1 mm"
        )


def _of_a_quarter(beam: Beam, section, masses, highest: int):
    """Planes [m], what reads their motion, squares, vectors, participation, no error: of a beam, by a quarter of it."""
    axis = BENDS[beam.bends]
    solid, station = _supported(beam, section, masses)
    solid = _bending_only(solid, axis)
    carried = _carried(section, masses, station, axis, parts=4)
    rows = [kron(np.eye(3)[along], kron(eye(len(station)), weights), format="csr") for along, weights, _ in carried]
    rows = [0 * mean if along != axis else mean for along, mean in enumerate(rows[:3])] + rows[3:]
    of_line = _line_mass(beam, section, station)
    squares, vectors = _bending_modes(solid, rows, carried, of_line, axis, highest, 1)
    gamma = participation(solid, _attached(rows, carried), vectors) * np.eye(3)[axis]  # the others' quarters cancel
    return station, rows, squares, vectors, gamma, None


def _of_a_mesh(beam: Beam, section, masses, highest: int):
    """Modes of a beam whose section is a mesh, as fine as possible, and the error of that mesh."""
    axis = BENDS[beam.bends]
    ends = tuple(HELD.get(support, ()) for support in beam.supports)
    stations = _stations(beam, section, masses)
    extrusion = swept(section, stations, beam.material, ends)
    station = extrusion.station
    carried = _carried(section, masses, station, axis, parts=1)
    of_line = _line_mass(beam, section, station)

    def rows(reduced):
        return [reduced.rows(along, weights) for along, weights, _ in carried]

    def modes(reduced):
        return _bending_modes(reduced, rows(reduced), carried, of_line, axis, highest, 3)

    found = converged(extrusion, carried, modes)
    reduced = found.reduced
    coefficients = reduced.coefficients(found.vectors)
    breaks = [mass.position for mass in masses]
    error = swept_error(section, stations, breaks, beam.material, found.squares, reduced.functions, coefficients)
    read = rows(reduced)
    gamma = participation(reduced, _attached(read, carried), found.vectors)
    return station, read, found.squares, found.vectors, gamma, error + found.rest / 2


def _bending_modes(solid: Elastic, rows, carried, of_line, axis: int, highest: int, families: int):
    """Squares and vectors of the bending modes of a beam.

    Parameters
    ----------
    solid : Elastic
    rows : matrices that read the mean displacement of every plane along x, y and z, and its rotation when bending
    carried : of Carried, the masses that follow them
    of_line : (p,) the beam's own mass at every plane [kg]
    axis : along which it bends
    highest : number of the highest mode
    families : of modes that lie between, those of bending included
    """
    attached = _attached(rows, carried)
    *_, load, inertia = (mass for _, _, mass in carried)
    in_bending = vstack([diags(np.sqrt(of_line + load)) @ rows[axis], diags(np.sqrt(inertia)) @ rows[3]])

    def select(squares, vectors):
        squares, vectors, seen = turned(squares, vectors, in_bending @ vectors)
        found = np.flatnonzero(np.sum(seen**2, axis=0) > 0.5)[:highest]
        return (squares[found], vectors[:, found]) if len(found) == highest else None

    return elastic_modes(solid, attached, select, count=families * highest + 4)


def _attached(rows, carried) -> Attached:
    """The masses that follow what the rows read."""
    return Attached(vstack(rows, format="csr"), np.concatenate([mass for _, _, mass in carried]))


def _line_mass(beam: Beam, section, station) -> np.ndarray:
    """(p,) the mass of the beam that belongs to every plane [kg]."""
    share = np.diff(np.concatenate([[0.0], (station[1:] + station[:-1]) / 2, [beam.length]]))
    return beam.material.density * moments(section).area * share


def _at_stations(masses, station) -> tuple[np.ndarray, np.ndarray]:
    """Mass [kg] and rotary inertia [kg m^2] at every station."""
    load, inertia = np.zeros(len(station)), np.zeros(len(station))
    for mass in masses:
        row = np.argmin(np.abs(station - mass.position))
        load[row] += mass.mass
        inertia[row] += mass.rotary_inertia
    return load, inertia


def _bending_only(solid: Solid, axis: int) -> Solid:
    """A quarter of a beam that bends along ``axis``, as the other three quarters hold it.

    Bending is symmetric about the plane in which it happens, and antisymmetric about the neutral plane.
    """
    side = ({1, 2} - {axis}).pop()
    near = 1e-9 * np.ptp(solid.place)
    solid = solid.hold(np.abs(solid.place[side]) < near, (side,))
    return solid.hold(np.abs(solid.place[axis]) < near, (0, side))


def _stations(beam: Beam, section, masses) -> np.ndarray:
    """Ends of the elements along the beam [m]."""
    thickness = moments(section).equivalent_thickness
    coarsest = np.clip(COARSEST * thickness, beam.length / 100, beam.length / 20)
    points = sorted({0.0, *(mass.position for mass in masses), beam.length})
    if points[0] < 0 or points[-1] > beam.length:
        raise ValueError(f"a mass lies beyond the ends of the beam, 0 and {beam.length:g} m")
    return graded(points, FINEST * thickness, coarsest)


def _supported(beam: Beam, section, masses) -> tuple[Solid, np.ndarray]:
    """The beam on its supports, and the positions of its planes of nodes [m]."""
    solid = extruded(section, _stations(beam, section, masses), beam.material, along=0)
    x = solid.place[0]
    for end, support in zip((0.0, beam.length), beam.supports, strict=True):
        if support != "free":
            solid = solid.hold(np.isclose(x, end, atol=1e-9 * beam.length), HELD[support])
    return solid, x[:: section.N]


def _carried(section, masses, station, axis: int, *, parts: int) -> list[Carried]:
    """The masses that every plane's mean displacement along x, y and z carries, and the inertias of its rotation.

    A section of a quarter carries a quarter.
    """
    of = moments(section)
    arm, second = (0, of.across) if axis == BENDS["width"] else (1, of.through)
    mean = integrals(section, lambda place: 1.0) / of.area
    tilt = integrals(section, lambda place: place[arm]) / second
    load, inertia = (mass / parts for mass in _at_stations(masses, station))
    return [*(Carried(along, mean, load) for along in range(3)), Carried(0, tilt, inertia)]
