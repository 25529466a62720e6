"""Modes of what is elastic: the lowest ones, whatever masses are attached, and modes of all but equal frequency.

Masses fixed to a solid change few rows: with F = K - s M, the inverse of F - s R^T m R is that of F less
F^-1 R^T (R F^-1 R^T - 1 / (s m))^-1 R F^-1, Woodbury's formula, so that one factorisation of F serves whatever is
attached.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_matrix, diags, spmatrix
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from threadpoolctl import threadpool_limits


class Elastic(Protocol):
    """Elastic system of n displacements, some of them held, whose modes are sought.

    Attributes
    ----------
    mass : (n, n) sparse matrix [kg]
    held : (n,) array of bool, displacements that are kept at zero
    motions : (n, 6) array, displacements of the rigid motions
    shift : s [rad^2/s^2], zero if no rigid motion is left, else below zero
    inverse : ``inverse(b)`` solves (K - s M) x = b for the displacements that are not held
    """

    mass: spmatrix
    held: np.ndarray
    motions: np.ndarray
    shift: float
    inverse: Callable


@dataclass(frozen=True)
class Attached:
    """Masses that follow means of the displacements: rows (k, n) of a sparse matrix, weights (k,) [kg]."""

    rows: spmatrix
    weights: np.ndarray

    @property
    def mass(self) -> spmatrix:
        """Contribution to the mass matrix, (n, n) [kg]."""
        rows = self.rows[self.weights != 0]
        return rows.T @ diags(self.weights[self.weights != 0]) @ rows

    def inverse(self, solid: Elastic, free: np.ndarray) -> LinearOperator:
        """Inverse of K - s M with what is attached in M, for the displacements ``free`` of a solid."""
        shape = (len(free), len(free))
        counted = self.weights != 0
        if solid.shift == 0 or not counted.any():
            return LinearOperator(shape, solid.inverse, dtype=float)
        rows = self.rows[counted][:, free]
        moved = np.column_stack([solid.inverse(row) for row in rows.toarray()])
        seen = rows @ moved - np.diag(1 / (solid.shift * self.weights[counted]))

        def inverse(load):
            alone = solid.inverse(load)
            return alone - moved @ np.linalg.solve(seen, rows @ alone)

        return LinearOperator(shape, inverse, dtype=float)


def elastic_modes(solid: Elastic, attached: Attached, select: Callable, *, count: int):
    """Lowest modes that strain the solid, mass-normalised.

    On one thread: two gain little, they stand in each other's way where others work, and the last bits would depend
    on the number of cores.

    Parameters
    ----------
    solid : Elastic
    attached : Attached
    select : ``select(squares, vectors)`` returns the modes wanted, or None for more to select from
    count : number of modes to begin with

    Returns
    -------
    What ``select`` returned, of squares (m,) of angular frequencies and vectors (n, m).
    """
    free = np.flatnonzero(~solid.held)
    with threadpool_limits(1):
        mass = (solid.mass + attached.mass)[free][:, free]
        inverse = attached.inverse(solid, free)
        start = np.ones(len(free))  # a fixed start: the same modes to the bit on every run
        while True:
            count = min(count, len(free) - 2)
            # given the inverse, of the stiffness itself the size alone is asked
            squares, found = eigsh(inverse, count, mass, sigma=solid.shift, OPinv=inverse, v0=start)
            vectors = np.zeros((len(solid.held), count))
            vectors[free] = found
            strained = ~_rigid(solid, vectors)
            selected = select(squares[strained], vectors[:, strained])
            if selected is not None:
                return selected
            if count == len(free) - 2:
                raise ValueError("the mesh is too coarse for so many modes")
            count *= 2


def participation(solid: Elastic, attached: Attached, vectors) -> np.ndarray:
    """(m, 3) factors Gamma = phi^T M d [kg^0.5] of modes (n, m), d a unit displacement of all along x, y or z."""
    return vectors.T @ ((solid.mass + attached.mass) @ solid.motions[:, :3])


def factorised(matrix: spmatrix, node: np.ndarray) -> Callable:
    """Solves with a symmetric positive definite matrix of displacements of the nodes ``node`` (n,).

    Ordered by nested dissection of the nodes: of 8,640 quadratic tetrahedra, a fifth of the time of minimum degree.
    """
    order = _dissected(matrix, node)
    factors = splu(
        matrix[order][:, order].tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )

    def solve(load):
        answer = np.empty(len(order))
        answer[order] = factors.solve(np.ravel(load)[order])
        return answer

    return solve


def _dissected(matrix: spmatrix, node: np.ndarray) -> np.ndarray:
    """(n,) the rows of a matrix in the order of their nodes, which METIS dissects."""
    from pymetis import CSRAdjacency, nested_dissection

    known, number = np.unique(node, return_inverse=True)
    of_node = csr_matrix((np.ones(len(node)), (number, np.arange(len(node)))), (len(known), len(node)))
    pattern = csr_matrix((np.ones(matrix.nnz), matrix.indices, matrix.indptr), matrix.shape)
    graph = (of_node @ pattern @ of_node.T).tocsr()
    graph.setdiag(0)
    graph.eliminate_zeros()
    order, _ = nested_dissection(CSRAdjacency(graph.indptr, graph.indices))
    rank = np.empty(len(known), int)
    rank[order] = np.arange(len(known))
    return np.argsort(rank[number], kind="stable")


def is_held(solid: Elastic) -> bool:
    """Whether no rigid motion is left: none vanishes wherever displacements are held."""
    motions = solid.motions / np.abs(solid.motions).max(axis=0)
    return np.linalg.matrix_rank(motions[solid.held], tol=1e-6) == 6 if solid.held.any() else False


def _rigid(solid: Elastic, vectors) -> np.ndarray:
    """Which vectors are rigid motions: those that lie in their span, by the solid's own mass."""
    motions = solid.motions
    weighed = solid.mass @ motions
    seen = weighed.T @ vectors
    inside = np.einsum("im,im->m", seen, np.linalg.solve(motions.T @ weighed, seen))
    whole = np.einsum("im,im->m", vectors, solid.mass @ vectors)
    return inside > (1 - 1e-6) * whole


def turned(squares, vectors, seen):
    """Modes of all but equal frequency, turned so that the rows ``seen`` (r, m) of them are orthogonal, largest first.

    Any mixture of such modes is a mode: a round beam bends any way.  Turned by the motion of interest, one of them has
    all that there is of it.  All but equal is 0.05 %, so that a mesh slightly off its symmetry does no harm.

    Returns ``squares``, ``vectors``, ``seen``.
    """
    squares, vectors, seen = squares.copy(), vectors.copy(), seen.copy()
    edges = np.flatnonzero(np.diff(squares) > 1e-3 * squares[1:]) + 1
    for group in np.split(np.arange(len(squares)), edges):
        if len(group) > 1:
            _, turn = eigh(seen[:, group].T @ seen[:, group])
            turn = turn[:, ::-1]
            squares[group] = (turn**2).T @ squares[group]
            vectors[:, group], seen[:, group] = vectors[:, group] @ turn, seen[:, group] @ turn
    return squares, vectors, seen
