"""Three-dimensional elasticity on scikit-fem meshes: stiffness, mass, and the modes of what is held and loaded.

Displacements are numbered component by component, each on the same scalar basis of n nodes: that of node i along axis
j is number j n + i.  Nine scalar blocks D_ij = int d_i v d_j u give the whole stiffness,
lambda D_ij + mu (D_ji + delta_ij sum_k D_kk), fifty times faster than a vector element's assembly.

Masses fixed to a solid change few rows: with F = K - s M, the inverse of F - s R^T m R is that of F less
F^-1 R^T (R F^-1 R^T - 1 / (s m))^-1 R F^-1, Woodbury's formula, so that one factorisation of F serves whatever is
attached.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import block_diag, bmat, csr_matrix, diags, kron, spmatrix
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from threadpoolctl import threadpool_limits

from ..scene.scene import Material

if TYPE_CHECKING:
    from skfem import Basis, Mesh

AXES = (0, 1, 2)


class Elastic(Protocol):
    """What modes are found of: n displacements, some of them held.

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
        """(n, n) what they add to the mass matrix [kg]."""
        rows = self.rows[self.weights != 0]
        return rows.T @ diags(self.weights[self.weights != 0]) @ rows

    def inverse(self, solid: Elastic, free: np.ndarray) -> LinearOperator:
        """That of K - s M with what is attached in M, for the displacements ``free`` of a solid."""
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


@dataclass(frozen=True)
class Solid:
    """A discretised elastic solid.

    Parameters
    ----------
    stiffness, mass : (3 n, 3 n) sparse matrices [N/m, kg]
    place : (3, n) array, positions of the nodes [m]
    guess : about the square of its lowest angular frequency, to an order of magnitude or two [rad^2/s^2]
    held : (3 n,) array of bool, displacements that are kept at zero
    """

    stiffness: spmatrix
    mass: spmatrix
    place: np.ndarray
    guess: float
    held: np.ndarray

    def hold(self, nodes, axes=AXES) -> Solid:
        """The same solid with the displacement of ``nodes`` (array of bool) kept at zero along ``axes``."""
        held = self.held.copy()
        for axis in axes:
            held[axis * len(nodes) :][: len(nodes)] |= nodes
        return replace(self, held=held)

    @property
    def motions(self) -> np.ndarray:
        """(3 n, 6) displacements of three translations and three small rotations about the middle."""
        zero, one = np.zeros(self.place.shape[1]), np.ones(self.place.shape[1])
        x, y, z = self.place - self.place.mean(axis=1)[:, None]
        columns = [
            (one, zero, zero), (zero, one, zero), (zero, zero, one), (zero, -z, y), (z, zero, -x), (-y, x, zero)
        ]  # fmt: skip
        return np.array([np.concatenate(column) for column in columns]).T

    @cached_property
    def shift(self) -> float:
        """What moves without strain cannot be factorised, and a shift keeps clear of it [rad^2/s^2]."""
        return 0.0 if is_held(self) else -self.guess

    @cached_property
    def inverse(self) -> Callable:
        """Solves (K - s M) x = b for the displacements that are not held; factorised once."""
        free = np.flatnonzero(~self.held)
        return _factorised((self.stiffness - self.shift * self.mass)[free][:, free], free % self.place.shape[1])


def without_loose_nodes(mesh: Mesh) -> Mesh:
    """The mesh without the nodes that belong to no cell, as the points from which a geometry was built."""
    return mesh.remove_unused_nodes() if len(np.unique(mesh.t)) < mesh.p.shape[1] else mesh


def forms(basis: Basis, derivatives) -> dict:
    """Matrices int d_a v d_b u for every a and b of ``derivatives``; None stands for the function itself."""
    from skfem import BilinearForm

    def d(f, a):
        return f if a is None else f.grad[a]

    return {
        (a, b): BilinearForm(lambda u, v, w, a=a, b=b: d(v, a) * d(u, b)).assemble(basis)
        for a, b in itertools.product(derivatives, repeat=2)
    }


def meshed(basis: Basis, material: Material) -> Solid:
    """The solid that a three-dimensional basis describes."""
    form = forms(basis, AXES)
    volume = forms(basis, (None,))[None, None]
    return _solid(form, volume, basis.doflocs, material)


def extruded(section: Basis, stations, material: Material, *, along: int) -> Solid:
    """The solid that a plane basis sweeps along an axis, on quadratic elements between ``stations`` [m].

    Every block is a Kronecker product of a matrix along the axis and one of the section, so that any plane mesh will
    do.  Node k s + i is node i of the s of the section at the k-th of the planes, those between stations included.
    """
    x, one = line_forms(stations)
    two = forms(section, (None, 0, 1))
    others = [axis for axis in AXES if axis != along]

    blocks = {}
    for i, j in itertools.product(AXES, repeat=2):
        (line_i, section_i), (line_j, section_j) = derivative(i, along), derivative(j, along)
        blocks[i, j] = kron(one[line_i, line_j], two[section_i, section_j], format="csr")
    volume = kron(one[None, None], two[None, None], format="csr")

    place = np.empty((3, len(x) * section.N))
    place[along] = np.repeat(x, section.N)
    place[others] = np.tile(section.doflocs, len(x))
    return _solid(blocks, volume, place, material)


def line_forms(stations) -> tuple[np.ndarray, dict]:
    """Positions (p,) of the nodes of quadratic elements between stations [m], and their ``forms`` by (None, 0)."""
    from skfem import Basis, ElementLineP2, MeshLine

    line = Basis(MeshLine(np.asarray(stations)), ElementLineP2(), intorder=4)
    order = np.argsort(line.doflocs[0])
    return line.doflocs[0][order], {key: matrix[order][:, order] for key, matrix in forms(line, (None, 0)).items()}


def derivative(axis: int, along: int) -> tuple:
    """Of what is extruded along an axis, d/d axis: the derivative along the line, and the one in the section."""
    return (0, None) if axis == along else (None, [other for other in AXES if other != along].index(axis))


def lame(material: Material) -> tuple[float, float]:
    """Lame's first parameter and the shear modulus [Pa]."""
    from skfem.models.elasticity import lame_parameters

    return lame_parameters(material.youngs_modulus, material.poissons_ratio)


def lowest_bending(material: Material, size) -> float:
    """About the square of the lowest angular frequency of a free solid of some ``size`` (3,) [m], [rad^2/s^2]."""
    thin, _, long = np.sort(size)
    return material.youngs_modulus / material.density / 12 * (math.pi**2 * thin / long**2) ** 2


def _solid(form: dict, volume, place, material: Material) -> Solid:
    first, shear = lame(material)
    laplace = form[0, 0] + form[1, 1] + form[2, 2]
    stiffness = bmat(
        [[first * form[i, j] + shear * (form[j, i] + (laplace if i == j else 0)) for j in AXES] for i in AXES]
    )
    guess = lowest_bending(material, np.ptp(place, axis=1))
    held = np.zeros(place.size, bool)
    return Solid(stiffness.tocsr(), block_diag([material.density * volume] * 3).tocsr(), place, guess, held)


def integrals(basis: Basis, weight: Callable) -> np.ndarray:
    """(n,) integrals of the basis functions times ``weight(place)``."""
    from skfem import LinearForm

    return LinearForm(lambda v, w: v * weight(w.x)).assemble(basis)


def elastic_modes(solid: Elastic, attached: Attached, select: Callable, *, count: int):
    """The lowest modes that strain the solid, mass-normalised.

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


def _factorised(matrix: spmatrix, node: np.ndarray) -> Callable:
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


def graded(points, finest: float, coarsest: float) -> np.ndarray:
    """Stations from the first of ``points`` to the last, each point among them.

    The spacing is ``finest`` at every point and grows by a third of the distance from it, up to ``coarsest``.
    """
    stations = [points[0]]
    for start, end in itertools.pairwise(points):
        fine = np.linspace(start, end, 10_001)
        distance = np.minimum(fine - start, end - fine)
        spacing = np.minimum(coarsest, finest + distance / 3)
        count = np.concatenate([[0], np.cumsum(np.diff(fine) / ((spacing[1:] + spacing[:-1]) / 2))])
        n = math.ceil(count[-1])
        stations += list(np.interp(np.arange(1, n + 1) * count[-1] / n, count, fine))
    return np.array(stations)
