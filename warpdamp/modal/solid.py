"""Modes of plates and solids of any shape, with masses that stand on a patch of the surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.sparse import csr_matrix, eye, kron, vstack
from scipy.sparse.csgraph import connected_components

from ..errors import ModalError
from ..formats.mesh_file import load_named
from ..modes import Modes
from ..scene.scene import Material
from .cells import basis_on
from .clamp import Clamp
from .eigenmodes import Attached, elastic_modes, is_held, participation, turned
from .fem import Solid, extruded, graded, integrals, meshed
from .mesh_error import solid_error

Edge = Literal["clamped", "pinned", "free"]

FLOATS = "left out: rigid-body motions, which what is clamped leaves free"
PATCH_ORDER = 12
"""Of the quadrature that finds the edge of a patch: elements there may be as large as the patch."""


@dataclass(frozen=True)
class StandingMass:
    """Mass on a round patch of a surface, whose mean displacement it follows.

    Parameters
    ----------
    mass : [kg]
    position : (2,) on a plate, (3,) on a solid, the middle of the patch [m]
    footprint : diameter of the patch [m]
        A mass on a point would sink into an elastic solid without limit.
    """

    mass: float
    position: tuple[float, ...]
    footprint: float

    def loaded(self, mass: float) -> StandingMass:
        """Standing mass with a further ``mass`` [kg]."""
        return replace(self, mass=self.mass + mass)


@dataclass(frozen=True)
class Plate:
    """Rectangular plate from (0, 0) to (length, width), bending along z.

    Parameters
    ----------
    length, width, thickness : along x, y and z [m]
    material : Material
    edges : how x = 0, x = length, y = 0 and y = width are held
        Clamped edges do not move; pinned ones keep their height and do not shift along themselves.
    """

    length: float
    width: float
    thickness: float
    material: Material
    edges: tuple[Edge, Edge, Edge, Edge] = ("clamped",) * 4


def plate_modes(plate: Plate, damper: StandingMass, masses=(), *, highest: int = 5, elements: int = 6) -> Modes:
    """Lowest modes of a plate with a damper and further masses on it, as the damper sees them along z.

    Quadratic hexahedra, one through the thickness and about ``elements`` along a side, graded towards the edges and
    the masses.

    Parameters
    ----------
    plate : Plate
    damper : StandingMass
    masses : of StandingMass, further ones
    highest : number of the highest mode wanted
    elements : along each side
    """
    from skfem import Basis, ElementTriP4, MeshTri

    standing = (damper, *masses)
    coarsest = max(plate.length, plate.width) / elements
    sides = [
        graded(sorted({0.0, side, *(mass.position[axis] for mass in standing)}), coarsest / 4, coarsest)
        for axis, side in enumerate((plate.length, plate.width))
    ]
    mesh = MeshTri.init_tensor(*sides)
    plan = Basis(mesh, ElementTriP4(), intorder=8)
    through = np.array([-0.5, 0.5]) * plate.thickness
    solid = _on_edges(extruded(plan, through, plate.material, along=2), plate)
    mean = np.array([1, 4, 1]) / 6  # through the thickness, of one quadratic element
    patches = [np.kron(mean, _disc(plan, mass, (plate.length, plate.width))) for mass in standing]
    middle = plan.N + plan.nodal_dofs[0]
    return _modes(solid, standing, patches, middle, (0.0, 0.0, 1.0), highest)


def _disc(plan, mass: StandingMass, size) -> np.ndarray:
    """(n,) weights of a plan's nodes in the mean over a mass's footprint, or over what of it lies on the plate.

    Sampled at four radii (Gauss's points for the area) and twelve angles.
    """
    radius = mass.footprint / 2 * np.sqrt((np.polynomial.legendre.leggauss(4)[0] + 1) / 2)
    weight = np.repeat(np.polynomial.legendre.leggauss(4)[1], 12)
    angle = 2 * np.pi * np.arange(12) / 12
    ring = np.array([np.cos(angle), np.sin(angle)])
    points = np.concatenate([r * ring for r in radius], axis=1) + np.array(mass.position)[:, None]
    inside = np.all((points >= 0) & (points <= np.array(size)[:, None]), axis=0)
    return plan.probes(points[:, inside]).T @ (weight[inside] / weight[inside].sum())


def _on_surface(surface, mass: StandingMass) -> np.ndarray:
    """(n,) weights of a solid's nodes in the mean over its surface within a mass's footprint.

    Raises
    ------
    ModalError
        If no surface is there.
    """
    middle, radius = np.array(mass.position)[:, None, None], mass.footprint / 2
    weights = integrals(surface, lambda place: 1.0 * (np.linalg.norm(place - middle, axis=0) < radius))
    if weights.sum() <= 0:
        near = np.min(np.linalg.norm(np.array(surface.global_coordinates()) - middle, axis=0))
        where = ", ".join(f"{1e3 * x:g}" for x in mass.position)
        raise ModalError(
            f"there is no surface within {1e3 * radius:g} mm of ({where}) mm; the nearest is {1e3 * near:.3g} mm away: "
            "move the mass onto it or widen its footprint"
        )
    return weights / weights.sum()


def _on_edges(solid: Solid, plate: Plate) -> Solid:
    """Clamped, or pinned: no displacement but the one across the edge."""
    ends = ((0, 0.0), (0, plate.length), (1, 0.0), (1, plate.width))
    for (axis, end), edge in zip(ends, plate.edges, strict=True):
        on_edge = np.isclose(solid.place[axis], end, atol=1e-9 * plate.length)
        if edge == "clamped":
            solid = solid.hold(on_edge)
        elif edge == "pinned":
            solid = solid.hold(on_edge, (1 - axis, 2))
    return solid


@dataclass(frozen=True)
class MeshedSolid:
    """Solid of any shape, as a mesh of tetrahedra or hexahedra in a file that meshio reads.

    Wedges and pyramids are cut into tetrahedra, and so is what stands beside them.

    Parameters
    ----------
    file : path
    material : Material
    clamps : tuple of Clamp; none leaves the solid free
    unit : length of the mesh's unit [m]
    direction : of the damper's excitation
    """

    file: Path
    material: Material
    clamps: tuple[Clamp, ...] = ()
    unit: float = 1.0
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)


def solid_modes(solid: MeshedSolid, damper: StandingMass, masses=(), *, highest: int = 5) -> Modes:
    """Lowest modes of a solid with a damper and further masses on its surface, as the damper sees them.

    Quadratic elements on the mesh's own cells, whatever their order in the file.  Modes of the same frequency are
    turned so that one of them has all the motion at the damper; rigid motions are not counted.

    Parameters
    ----------
    solid : MeshedSolid
    damper : StandingMass
    masses : of StandingMass, further ones
    highest : number of the highest mode wanted
    """
    from skfem import BoundaryFacetBasis

    file = Path(solid.file)
    basis, body = _body(solid, file.stat().st_mtime_ns if file.is_file() else None)
    surface = BoundaryFacetBasis(basis.mesh, basis.elem, intorder=PATCH_ORDER)
    standing = (damper, *masses)
    patches = [_on_surface(surface, mass) for mass in standing]

    def error(squares, vectors):
        return solid_error(basis, solid.material, squares, vectors)

    found = _modes(body, standing, patches, basis.nodal_dofs[0], solid.direction, highest, error)
    return found if is_held(body) else replace(found, remark=FLOATS)


@lru_cache(maxsize=1)
def _body(solid: MeshedSolid, changed: int | None):
    """A solid's basis, and the solid held, with its factors: the same for the empty damper and for the filled one.

    ``changed`` is when its file was [ns].
    """
    basis, sets = _quadratic(solid)
    body = meshed(basis, solid.material)
    for clamp in solid.clamps:
        body = body.hold(clamp.nodes(basis, sets))
    return basis, body


def _quadratic(solid: MeshedSolid):
    from skfem import ElementHex2, ElementTetP2, MeshHex1, MeshTet1

    named = load_named(solid.file, solid.unit)
    mesh = named.mesh
    if isinstance(mesh, MeshTet1):
        element = ElementTetP2()
    elif isinstance(mesh, MeshHex1):
        element = ElementHex2()
    else:
        raise ModalError(f"{solid.file} holds a {type(mesh).__name__}: a solid is a mesh of tetrahedra or hexahedra")
    basis = basis_on(mesh, element, 4, solid.file)
    parts, _ = connected_components(basis.mesh.p2t @ basis.mesh.p2t.T)
    if parts > 1:
        raise ModalError(f"{solid.file} falls into {parts} parts that share no nodes: merge the nodes where they touch")
    return basis, named.nodes


def _modes(solid: Solid, standing, patches, nodes, direction, highest: int, error: Callable | None = None) -> Modes:
    """Modes of a solid with masses on patches, at each of these (the damper is the first) and at ``nodes``.

    ``error(squares, vectors)`` is what their mesh makes.
    """
    rows = [kron(eye(3), patch[None], format="csr") for patch in patches]
    attached = Attached(vstack(rows, format="csr"), np.repeat([mass.mass for mass in standing], 3))
    at_damper = csr_matrix([direction]) @ rows[0]

    def select(squares, vectors):
        squares, vectors, _ = turned(squares, vectors, at_damper @ vectors)
        # the last of what was found may lack others of its frequency
        return (squares[:highest], vectors[:, :highest]) if len(squares) > highest + 1 else None

    squares, vectors = elastic_modes(solid, attached, select, count=highest + 8)
    of_nodes = vectors.reshape(3, -1, highest)[:, nodes]
    point = np.column_stack([*(solid.place @ patch for patch in patches), solid.place[:, nodes]])
    modes = Modes(
        number=np.arange(1, highest + 1),
        frequency=np.sqrt(squares) / (2 * np.pi),
        point=point.T,
        shape=np.concatenate([np.stack([row @ vectors for row in rows], axis=1), of_nodes], axis=1).transpose(2, 1, 0),
        inherent_damping=np.zeros(highest),
        mesh_error=error and error(squares, vectors),
        participation=participation(solid, attached, vectors),
    )
    return modes.seen_from(0, direction)
