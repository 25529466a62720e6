"""Meshes from files that meshio reads, whole: every cell is used, or the kinds that cannot be are named.

Meshes of one kind of triangles, quadrilaterals, tetrahedra or hexahedra stay as they are, first or second order; 8- and
20-node cells are completed to 9 and 27 nodes by their own shape functions, which keeps their geometry.  Mixed meshes,
wedges, pyramids and collapsed hexahedra are cut into tetrahedra or triangles.
"""

from __future__ import annotations

import io
import re
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ModalError
from .mesh_cells import EDGES, FACES, KNOWN, agree, bent, collapsed, corners, cut, dimension, tetrahedra, triangles
from .optional import needs

if TYPE_CHECKING:
    import meshio
    from skfem import Mesh

GENERATED = ("INCLUDE", "INSTANCE", "NCOPY", "NFILL", "NGEN", "ELGEN", "ELCOPY", "SYSTEM", "NMAP")
"""Keywords of Abaqus that make or move nodes and elements, which meshio passes over."""


@dataclass(frozen=True)
class NamedMesh:
    """A mesh in metres, and what its file names.

    Parameters
    ----------
    mesh : of scikit-fem, with its named boundaries
    nodes : (3, k) arrays of places [m] by the names of sets of nodes, edges or cells
    """

    mesh: Mesh
    nodes: dict[str, np.ndarray] = field(default_factory=dict)


def load_mesh(file: Path, unit: float = 1.0) -> Mesh:
    """Mesh of a file, in metres; see ``load_named``."""
    return load_named(file, unit).mesh


def load_named(file: Path, unit: float = 1.0) -> NamedMesh:
    """The mesh in a file, in metres, with all that its file names.

    Parameters
    ----------
    file : any format of meshio
    unit : length of the file's unit [m]

    Raises
    ------
    ModalError
        If there is no such file, it holds no mesh that meshio reads, or cells that cannot be used, which are named and
        counted.
    """
    source = _read(Path(file))
    cells = _cells(file, source)
    unknown = {kind: rows for kind, rows in cells.items() if kind not in KNOWN}
    if unknown or not cells:
        raise ModalError(f"{file} holds {_counts(unknown) or 'no cells'}: no such cells can be computed with")
    most = max(dimension(kind) for kind in cells)
    if most < 2:
        raise ModalError(f"{file} holds {_counts(cells)}: neither a plane mesh nor a solid")
    if not np.all(np.isfinite(source.points)):
        raise ModalError(f"{file}: a point has a coordinate that is not finite: export the mesh again")
    if any(rows.min() < 0 or rows.max() >= len(source.points) for rows in cells.values()):
        raise ModalError(f"{file}: a cell has a node that is no point of the mesh: export the mesh again")
    body = {kind: rows[_first(kind, rows)] for kind, rows in cells.items() if dimension(kind) == most}
    mesh, rank = _mesh(file, source, body)
    boundaries, nodes = _names(file, source, cells, mesh, rank)
    if boundaries or mesh.boundaries:
        mesh = mesh.with_boundaries({**(mesh.boundaries or {}), **boundaries})
    return NamedMesh(mesh.scaled(unit), {name: unit * source.points[rows].T for name, rows in nodes.items()})


def _read(file: Path) -> meshio.Mesh:
    needs("meshio", "mesh files")
    import meshio

    if not file.is_file():
        raise ModalError(f"there is no file {file}")
    if file.suffix.lower() == ".inp":
        _check_abaqus(file)
    said = io.StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):  # meshio prints what is wrong, and then exits
            return meshio.read(file)
    except (Exception, SystemExit) as error:  # its readers let through whatever they meet
        reason = " ".join(f"{said.getvalue()} {'' if isinstance(error, SystemExit) else error}".split())
        reason = reason or type(error).__name__
        raise ModalError(f"{file} holds no mesh that meshio reads: {reason}: export it again") from None


def _cells(file: Path, source: meshio.Mesh) -> dict[str, np.ndarray]:
    """Nodes of the cells of every kind that the mesh has, one cell a row."""
    try:
        return {kind: rows for kind, rows in source.cells_dict.items() if len(rows)}
    except ValueError:  # meshio joins the blocks of a kind, whatever is in them
        raise ModalError(
            f"{file}: of two blocks of a kind of cell, one is empty or has other nodes to a cell: export the mesh again"
        ) from None


def _check_abaqus(file: Path) -> None:
    try:
        lines = file.read_text(encoding="latin-1").splitlines()
    except OSError as error:
        raise ModalError(f"{file}: cannot be read: {error.strerror or error}") from None
    for number, line in enumerate(lines, 1):
        keyword = re.match(r"\*\s*([A-Z ]+)", line.upper())
        name = keyword[1].strip() if keyword else ""
        if name in GENERATED or (name == "NODE" and re.search(r"SYSTEM\s*=\s*[^R\s]", line.upper())):
            raise ModalError(
                f"{file}:{number}: '{line.strip()}' makes or moves nodes or elements: export a flat mesh without it"
            )


def _mesh(file: Path, source: meshio.Mesh, body: dict[str, np.ndarray]) -> tuple[Mesh, np.ndarray]:
    """The mesh of the cells of the highest dimension, and (p,) numbers of its vertices by those of the file's points.

    Points that are no vertex of a cell have the number -1.
    """
    from skfem import MeshTet1, MeshTri1

    solid = dimension(next(iter(body))) == 3
    whole = {kind: corners(kind, rows) for kind, rows in body.items()}
    vertex = np.unique(np.concatenate([rows.ravel() for rows in whole.values()]))
    rank = np.full(len(source.points), -1)
    rank[vertex] = np.arange(len(vertex))
    (kind, *others) = body
    uniform = not others and kind.startswith(("tetra", "hexahedron", "triangle", "quad"))
    if uniform and not np.any(collapsed(whole[kind])):
        return _uniform(file, source, kind, body[kind], rank), rank
    for kind, rows in body.items():
        if bent(kind, rows, source.points):
            raise ModalError(
                f"{file} holds {_counts(body)}, the {kind} with curved edges: such cells can only be used alone: mesh "
                "it with one kind of cells, or with straight edges"
            )
    if solid and not agree(whole):
        raise ModalError(
            f"{file} holds {_counts(body)}, triangular faces of some against quadrilateral ones of others: join them "
            "by pyramids, or mesh it with one kind of cells"
        )
    pieces = np.concatenate([(tetrahedra if solid else triangles)(rank[rows]) for rows in whole.values()])
    points = _plane(file, source.points) if not solid else source.points
    return (MeshTet1 if solid else MeshTri1)(
        np.ascontiguousarray(points[vertex].T), np.ascontiguousarray(pieces.T)
    ), rank


def _uniform(file: Path, source: meshio.Mesh, kind: str, rows: np.ndarray, rank: np.ndarray) -> Mesh:
    """A mesh of one kind of cells, without the points that none of them uses."""
    import meshio
    from skfem.io.meshio import from_meshio

    points = source.points if dimension(kind) == 3 else _plane(file, source.points)
    completed = kind in ("quad8", "hexahedron20")
    own = corners(kind, rows) if completed else rows
    used, numbered = np.unique(own, return_inverse=True)
    keep = _first(kind, source.cells_dict[kind])
    data = {name: [parts[kind][keep]] for name, parts in source.cell_data_dict.items() if kind in parts}
    single = meshio.Mesh(
        points[used],
        [(kind.rstrip("028") if completed else kind, numbered.reshape(own.shape))],
        cell_data={} if completed else data,
    )
    mesh = from_meshio(single)
    return _completed(mesh, kind, rows, points, rank) if completed else mesh


def _first(kind: str, rows: np.ndarray) -> np.ndarray:
    """Which cells to keep: gmsh 2.2 writes those of two groups twice."""
    return np.sort(np.unique(np.sort(corners(kind, rows), axis=1), axis=0, return_index=True)[1])


def _completed(mesh: Mesh, kind: str, rows: np.ndarray, points: np.ndarray, rank: np.ndarray) -> Mesh:
    """The second-order mesh of 8- or 20-node cells, by their shape functions in the middles of faces and cells.

    There the corners of a quadrilateral face weigh -1/4 and its edges 1/2; those of a hexahedron -1/4 and 1/4.
    """
    from skfem import MeshHex2, MeshQuad2

    solid = kind == "hexahedron20"
    second = (MeshHex2 if solid else MeshQuad2).from_mesh(mesh)
    place, dofs = second.doflocs.copy(), second.dofs
    edges = np.array(EDGES[kind])
    vertices = rank[corners(kind, rows)]
    middle = points[rows[:, len(vertices[0]) :]]
    number = _find(mesh.edges if solid else mesh.facets, vertices[:, edges].reshape(-1, 2))
    of_edges = (dofs.edge_dofs if solid else dofs.facet_dofs)[0]
    place[:, of_edges[number]] = middle.reshape(-1, points.shape[1]).T
    ends = points[corners(kind, rows)]
    place[:, dofs.interior_dofs[0]] = (middle.sum(axis=1) * (0.25 if solid else 0.5) - 0.25 * ends.sum(axis=1)).T
    for face in FACES[8] if solid else ():
        sides = [k for k, edge in enumerate(edges) if set(edge) <= set(face)]
        at = 0.5 * middle[:, sides].sum(axis=1) - 0.25 * ends[:, face].sum(axis=1)
        place[:, dofs.facet_dofs[0][_find(mesh.facets, vertices[:, face])]] = at.T
    return replace(second, doflocs=place)


def _find(known: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Columns of ``known`` (c, n) that hold the same vertices as the rows of ``wanted`` (k, c); -1 where none does."""
    count = int(max(known.max(), wanted.max(initial=0))) + 1

    def key(rows):
        rows = np.sort(rows, axis=1)[:, :3]  # no two faces share three vertices
        return rows @ count ** np.arange(rows.shape[1])

    keys = key(known.T)
    order = np.argsort(keys)
    at = order[np.minimum(np.searchsorted(keys, key(wanted), sorter=order), len(keys) - 1)]
    return np.where((keys[at] == key(wanted)) & np.all(wanted >= 0, axis=1), at, -1)


def _names(file: Path, source: meshio.Mesh, cells, mesh: Mesh, rank: np.ndarray):
    """Facets by the names of boundaries, and points by the names of all other sets."""
    most = max(dimension(kind) for kind in cells)
    facets: dict[str, list[np.ndarray]] = {}  # of every cell of a kind, those of the mesh it is made of
    for kind, rows in cells.items():
        if dimension(kind) == most - 1:
            facets[kind] = _facets(file, kind, rank[corners(kind, rows)], mesh)
        elif kind.startswith("line") and np.any(_find(mesh.edges, rank[corners(kind, rows)]) < 0):
            raise ModalError(f"{file} holds lines that are no edges of its solid: beams are not modelled: remove them")
    boundaries: dict[str, np.ndarray] = {}
    nodes = {name: np.asarray(rows, int) for name, rows in source.point_sets.items() if len(rows)}
    for name, members in _groups(source).items():
        on = [facets[kind][:, rows].ravel() for kind, rows in members.items() if kind in facets and len(rows)]
        others = [source.cells_dict[kind][rows].ravel() for kind, rows in members.items() if kind not in facets]
        if on:
            boundaries[name] = np.unique(np.concatenate(on))
        elif others and name not in nodes:
            nodes[name] = np.unique(np.concatenate(others)).astype(int)
    return boundaries, nodes


def _facets(file: Path, kind: str, vertices: np.ndarray, mesh: Mesh) -> np.ndarray:
    """(1 or 2, n) facets of the mesh that cells on its faces are made of."""
    pieces = vertices[None]
    if vertices.shape[1] > len(mesh.facets):  # a quadrilateral on a mesh that was cut
        pieces = np.array(cut(vertices))
    found = np.array([_find(mesh.facets, piece) for piece in pieces])
    strange = np.sum(np.any(found < 0, axis=0))
    if strange or vertices.shape[1] < len(mesh.facets):
        raise ModalError(
            f"{file} holds {strange or len(vertices)} {kind} cells that are no faces of its other cells: shells and "
            "beams beside a solid are not modelled: remove them"
        )
    return found


def _groups(source: meshio.Mesh) -> dict[str, dict[str, np.ndarray]]:
    """Rows of cells by the names of their sets and by their kinds."""
    groups = {name: dict(members) for name, members in source.cell_sets_dict.items() if not name.startswith("gmsh:")}
    physical = source.cell_data_dict.get("gmsh:physical", {})
    for name, tag in source.field_data.items():
        if name not in groups and len(tag) > 1:
            members = {kind: np.flatnonzero(tags == tag[0]) for kind, tags in physical.items() if kind in KNOWN}
            groups[name] = {kind: rows for kind, rows in members.items() if len(rows) and dimension(kind) == tag[1]}
    return groups


def _plane(file: Path, points: np.ndarray) -> np.ndarray:
    """(p, 2) points of a plane mesh."""
    if points.shape[1] > 2 and np.ptp(points[:, 2]) > 1e-6 * np.ptp(points[:, :2], axis=0).max():
        raise ModalError(
            f"{file} holds no cells of a solid, and no section: that lies in a plane z = constant, and its points "
            f"reach over {np.ptp(points[:, 2]):g}"
        )
    return points[:, :2]


def _counts(cells: dict[str, np.ndarray]) -> str:
    """Kinds of cells and how many there are of each."""
    return ", ".join(f"{len(rows)} {kind}" for kind, rows in cells.items())
