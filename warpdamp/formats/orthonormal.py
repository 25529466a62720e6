"""Whether mode shapes are orthonormal with respect to a mass matrix: phi_i^T M phi_j = m_i delta_ij.

A shape that was damaged, mixed up with another, or that belongs to another mesh is not.
"""

from __future__ import annotations

import numpy as np

from ..errors import ModalError

TOLERANCE = 1e-3
"""Of phi_i^T M phi_j by sqrt(m_i m_j): files keep seven digits, one value off by more shows."""


def check(file, number, product: np.ndarray, mass: np.ndarray, *, complete: bool = True) -> None:
    """Refuse shapes whose products (m, m) with a mass matrix are not those of modes with modal masses (m,).

    Parameters
    ----------
    file : for the message
    number : of the modes
    product : phi^T M phi
    mass : modal masses
    complete : whether the matrix holds all the mass; of a part, no more can be found than of the whole

    Raises
    ------
    ModalError
        With the pair of modes that is farthest off.
    """
    off = product / np.sqrt(np.outer(mass, mass))
    # of a part of the mass: what is missing adds no negative energy
    off = np.abs(off - np.eye(len(mass))) if complete else np.diag(np.diag(off) - 1)
    i, j = np.unravel_index(np.argmax(off), off.shape)
    if off[i, j] > TOLERANCE:
        what = f"mode {number[i]} has" if i == j else f"modes {number[i]} and {number[j]} have"
        expected = mass[i] if i == j else 0.0
        raise ModalError(
            f"{file}: {what} the modal mass phi^T M phi = {product[i, j]:.5g} where {expected:.5g} is right: the "
            "shapes or the masses are damaged, or of another model: export them again"
        )
