"""Clamped parts of a meshed solid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import ModalError


@dataclass(frozen=True)
class Clamp:
    """Clamped part of a solid: a boundary or a set of nodes that the mesh's file names, or all nodes in a box.

    Parameters
    ----------
    boundary : name, or None
    box : for x, y and z, None or the limits (from, to) [m]; equal limits are a plane
    """

    boundary: str | None = None
    box: tuple[tuple[float, float] | None, ...] = (None, None, None)

    def nodes(self, basis, sets=None) -> np.ndarray:
        """Nodes of a basis that the clamp holds, (n,) array of bool.

        ``sets`` are places (3, k) [m] by the names of sets of nodes.

        Raises
        ------
        ModalError
            If there are none.
        """
        held = np.zeros(basis.N, bool)
        if self.boundary is not None:
            sets, named = sets or {}, basis.mesh.boundaries or {}
            if self.boundary in named:
                held[basis.get_dofs(self.boundary).all()] = True
                return held
            if self.boundary in sets:
                return _of_set(basis, sets[self.boundary], self.boundary)
            names = ", ".join((*named, *sets))
            known = f"it has {names}" if names else "it names none; clamp planes or boxes, as {x: 0 mm}"
            raise ModalError(f"the mesh has no boundary or set of nodes '{self.boundary}': {known}")
        near = 1e-6 * np.ptp(basis.doflocs, axis=1).max()
        held[:] = True
        for place, limits in zip(basis.doflocs, self.box, strict=True):
            if limits is not None:
                held &= (limits[0] - near <= place) & (place <= limits[1] + near)
        if not held.any():
            size = " x ".join(f"{1e3 * x.min():g}..{1e3 * x.max():g}" for x in basis.doflocs)
            raise ModalError(f"nothing of the mesh, {size} mm, lies there: is its unit right?")
        return held


def _of_set(basis, place: np.ndarray, name: str) -> np.ndarray:
    """(n,) array of bool, the nodes of a basis at places (3, k), and those between them on edges and faces.

    Raises
    ------
    ModalError
        If a place is that of no node.
    """
    from scipy.spatial import cKDTree

    size = np.ptp(basis.doflocs, axis=1).max()
    away, found = cKDTree(basis.doflocs.T).query(place.T)
    if np.any(away > 1e-6 * size):
        raise ModalError(f"the set '{name}' holds {np.sum(away > 1e-6 * size)} nodes that are none of the solid's")
    held = np.zeros(basis.N, bool)
    held[found] = True
    vertex = held[basis.nodal_dofs[0]]
    for dofs, vertices in ((basis.edge_dofs, basis.mesh.edges), (basis.facet_dofs, basis.mesh.facets)):
        if len(dofs):  # tetrahedra have none on their faces
            held[dofs[:, vertex[vertices].all(axis=0)]] = True
    return held
