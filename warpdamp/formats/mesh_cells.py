"""Cells of mesh files: their kinds, their corners, and how they are cut into tetrahedra or triangles.

Every quadrilateral face is cut along the diagonal through its node of the lowest number, and every cell into the
tetrahedra from its own node of the lowest number to the triangles it is no part of: neighbours of any kind agree on
the face between them (J. Dompierre, P. Labbe, M.-G. Vallet and R. Camarero 1999, 8th Int. Meshing Roundtable, 195).
"""

from __future__ import annotations

import numpy as np

CORNERS = {  # of cells by their dimension; names and order of nodes are meshio's
    0: {"vertex": 1},
    1: {"line": 2, "line3": 2},
    2: {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4},
    3: {
        "tetra": 4, "tetra10": 4, "hexahedron": 8, "hexahedron20": 8, "hexahedron27": 8,
        "wedge": 6, "wedge15": 6, "pyramid": 5, "pyramid13": 5,
    },
}  # fmt: skip
KNOWN = {kind: (dimension, corners) for dimension, kinds in CORNERS.items() for kind, corners in kinds.items()}
FACES = {  # by a cell's corners
    4: ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    5: ((0, 1, 2, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    6: ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    8: ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}
EDGES = {  # between corners, in the order of the nodes in their middles
    "line3": ((0, 1),),
    "triangle6": ((0, 1), (1, 2), (2, 0)),
    "quad8": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "quad9": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "tetra10": ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    "pyramid13": ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)),
    "wedge15": ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
}
EDGES["hexahedron20"] = EDGES["hexahedron27"] = (
    (0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7),
)  # fmt: skip


def dimension(kind: str) -> int:
    """Dimension of a known kind of cells."""
    return KNOWN[kind][0]


def corners(kind: str, cells: np.ndarray) -> np.ndarray:
    """(n, c) nodes at the corners of cells (n, ...) of a kind."""
    return cells[:, : KNOWN[kind][1]]


def bent(kind: str, cells: np.ndarray, points: np.ndarray) -> bool:
    """Whether nodes of second-order cells lie off the middles of their edges."""
    edges = np.array(EDGES.get(kind, ()), int).reshape(-1, 2)
    first = KNOWN[kind][1]
    ends = points[cells[:, edges]]
    off = points[cells[:, first : first + len(edges)]] - ends.mean(axis=2)
    return bool(np.any(np.linalg.norm(off, axis=2) > 1e-3 * np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)))


def triangles(polygons: np.ndarray) -> np.ndarray:
    """(k, 3) triangles of which polygons (n, 3 or 4) are made."""
    return _whole(np.concatenate(cut(polygons)))


def tetrahedra(cells: np.ndarray) -> np.ndarray:
    """(k, 4) tetrahedra of which cells, given by their corners (n, c), are made."""
    lowest = cells.min(axis=1)
    parts = [np.empty((0, 4), int)]
    for face in FACES[cells.shape[1]]:
        polygons = cells[:, face]
        opposite = np.all(polygons != lowest[:, None], axis=1)
        parts += [np.column_stack([lowest[opposite], base]) for base in cut(polygons[opposite])]
    return _whole(np.concatenate(parts))


def cut(polygons: np.ndarray) -> list[np.ndarray]:
    """Triangles (n, 3) that polygons (n, 3 or 4) are cut into through their node of the lowest number: one or two."""
    if polygons.shape[1] == 3:
        return [polygons]
    start = np.argmin(polygons, axis=1)
    turned = np.take_along_axis(polygons, (start[:, None] + np.arange(4)) % 4, axis=1)
    return [turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]


def agree(whole: dict[str, np.ndarray]) -> bool:
    """Whether no triangular face of cells lies in a quadrilateral one of others, whose cut it may cross.

    ``whole`` are the corners (n, c) of the cells by their kinds.
    """
    faces = [cells[:, face] for cells in whole.values() if cells.shape[1] in FACES for face in FACES[cells.shape[1]]]
    three = np.concatenate([face for face in faces if face.shape[1] == 3] or [np.empty((0, 3), int)])
    four = [face for face in faces if face.shape[1] == 4]
    parts = [np.delete(face, corner, axis=1) for face in four for corner in range(4)]
    within = np.concatenate(parts or [np.empty((0, 3), int)])
    both = np.unique(np.sort(three, axis=1), axis=0), np.unique(np.sort(within[~collapsed(within)], axis=1), axis=0)
    return len(np.unique(np.concatenate(both), axis=0)) == len(both[0]) + len(both[1])


def collapsed(cells: np.ndarray) -> np.ndarray:
    """(n,) whether cells have a node more than once."""
    ordered = np.sort(cells, axis=1)
    return np.any(ordered[:, 1:] == ordered[:, :-1], axis=1)


def _whole(cells: np.ndarray) -> np.ndarray:
    """Those that are not collapsed."""
    return cells[~collapsed(cells)]
