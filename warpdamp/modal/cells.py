"""Finite elements on a mesh from a file whose cells all have a volume and a side that is theirs alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ModalError

if TYPE_CHECKING:
    from skfem import Basis, Mesh


def basis_on(mesh: Mesh, element, order: int, file: Path) -> Basis:
    """Basis of elements on a mesh, integrated to an order.

    Raises
    ------
    ModalError
        If cells are flat or folded: their stiffness means nothing.
    """
    from skfem import Basis

    with np.errstate(divide="ignore", invalid="ignore"):  # cells without volume are refused below
        try:
            basis = Basis(mesh, element, intorder=order)
        except Exception as error:  # scikit-fem raises no class of its own where a curved cell has no volume at a point
            if "Jacobian" not in str(error):
                raise
            raise ModalError(
                f"{file} holds cells that are folded: nodes in the middles of their edges, or corners, are in another "
                "order than the format's: export it again"
            ) from None
    determinant = np.broadcast_to(basis.mapping.detDF(basis.X), basis.dx.shape)
    flat = np.sum(np.abs(basis.dx).sum(axis=1) < 1e-9 * np.abs(basis.dx).sum(axis=1).mean())
    folded = np.sum(determinant.min(axis=1) * determinant.max(axis=1) < 0)
    if flat or folded:
        raise ModalError(f"{file} holds {flat} cells without volume and {folded} that are folded: mesh it again")
    return basis
