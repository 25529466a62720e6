"""Three-dimensional elasticity on scikit-fem meshes: stiffness, mass, and the modes of what is held and loaded.

Displacements are numbered component by component, each on the same scalar basis of n nodes: that of node i along axis
j is number j n + i.  Nine scalar blocks D_ij = int d_i v d_j u give the whole stiffness,
lambda D_ij + mu (D_ji + delta_ij sum_k D_kk), fifty times faster than a vector element's assembly.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import block_diag, bmat, kron, spmatrix
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from ..scene.scene import Material

if TYPE_CHECKING:
    from skfem import Basis

AXES = (0, 1, 2)


@dataclass(frozen=True)
class Solid:
    """Discretised elastic solid.

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
        """Solid with the displacement of ``nodes`` (array of bool) kept at zero along ``axes``."""
        held = self.held.copy()
        for axis in axes:
            held[axis * len(nodes) :][: len(nodes)] |= nodes
        return replace(self, held=held)


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
    """Solid that a three-dimensional basis describes."""
    form = forms(basis, AXES)
    volume = forms(basis, (None,))[None, None]
    return _solid(form, volume, basis.doflocs, material)


def extruded(section: Basis, stations, material: Material, *, along: int) -> Solid:
    """Solid that a plane basis sweeps along an axis, on quadratic elements between ``stations`` [m].

    Every block is a Kronecker product of a matrix along the axis and one of the section, so that any plane mesh will
    do.  Node k s + i is node i of the s of the section at the k-th of the planes, those between stations included.
    """
    from skfem import Basis, ElementLineP2, MeshLine

    line = Basis(MeshLine(np.asarray(stations)), ElementLineP2(), intorder=4)
    order = np.argsort(line.doflocs[0])
    one = {key: matrix[order][:, order] for key, matrix in forms(line, (None, 0)).items()}
    two = forms(section, (None, 0, 1))
    others = [axis for axis in AXES if axis != along]

    def part(axis):
        """Derivative along the line, derivative in the section."""
        return (0, None) if axis == along else (None, others.index(axis))

    blocks = {}
    for i, j in itertools.product(AXES, repeat=2):
        (line_i, section_i), (line_j, section_j) = part(i), part(j)
        blocks[i, j] = kron(one[line_i, line_j], two[section_i, section_j], format="csr")
    volume = kron(one[None, None], two[None, None], format="csr")

    planes, nodes = len(order), section.N
    place = np.empty((3, planes * nodes))
    place[along] = np.repeat(line.doflocs[0][order], nodes)
    place[others] = np.tile(section.doflocs, planes)
    return _solid(blocks, volume, place, material)


def _solid(form: dict, volume, place, material: Material) -> Solid:
    from skfem.models.elasticity import lame_parameters

    first, shear = lame_parameters(material.youngs_modulus, material.poissons_ratio)
    laplace = form[0, 0] + form[1, 1] + form[2, 2]
    stiffness = bmat(
        [[first * form[i, j] + shear * (form[j, i] + (laplace if i == j else 0)) for j in AXES] for i in AXES]
    )
    thin, _, long = np.sort(np.ptp(place, axis=1))
    bending = material.youngs_modulus / material.density / 12 * (math.pi**2 * thin / long**2) ** 2
    held = np.zeros(place.size, bool)
    return Solid(stiffness.tocsr(), block_diag([material.density * volume] * 3).tocsr(), place, bending, held)


def integrals(basis: Basis, weight: Callable) -> np.ndarray:
    """Integrals of the basis functions times ``weight(place)``, (n,)."""
    from skfem import LinearForm

    return LinearForm(lambda v, w: v * weight(w.x)).assemble(basis)


def elastic_modes(solid: Solid, attached: spmatrix, select: Callable, *, count: int):
    """Lowest modes that strain the solid, mass-normalised.

    Parameters
    ----------
    solid : Solid
    attached : (3 n, 3 n) sparse matrix, what is fixed to the solid adds to its mass [kg]
    select : ``select(squares, vectors)`` returns the modes wanted, or None for more to select from
    count : number of modes to begin with

    Returns
    -------
    What ``select`` returned, of squares (m,) of angular frequencies and vectors (3 n, m).
    """
    free = np.flatnonzero(~solid.held)
    stiffness = solid.stiffness[free][:, free].tocsc()
    mass = (solid.mass + attached)[free][:, free].tocsc()
    # what moves without strain cannot be factorised, and a shift keeps clear of it
    shift = 0.0 if _is_held(solid) else -solid.guess
    inverse = _inverse(stiffness - shift * mass)
    start = np.ones(len(free))  # a fixed start: the same modes to the bit on every run
    while True:
        count = min(count, len(free) - 2)
        squares, found = eigsh(stiffness, count, mass, sigma=shift, OPinv=inverse, v0=start)
        vectors = np.zeros((len(solid.held), count))
        vectors[free] = found
        strained = ~_rigid(solid, vectors)
        selected = select(squares[strained], vectors[:, strained])
        if selected is not None:
            return selected
        if count == len(free) - 2:
            raise ValueError("the mesh is too coarse for so many modes")
        count *= 2


def _inverse(matrix) -> LinearOperator:
    """Inverse of a symmetric positive definite matrix, factorised as such: a fifth of the fill of eigsh's own."""
    factors = splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return LinearOperator(matrix.shape, factors.solve, dtype=float)


def _rigid_motions(solid: Solid) -> np.ndarray:
    """(3 n, 6) displacements of three translations and three small rotations about the middle."""
    zero, one = np.zeros(solid.place.shape[1]), np.ones(solid.place.shape[1])
    x, y, z = solid.place - solid.place.mean(axis=1)[:, None]
    columns = [(one, zero, zero), (zero, one, zero), (zero, zero, one), (zero, -z, y), (z, zero, -x), (-y, x, zero)]
    return np.array([np.concatenate(column) for column in columns]).T


def _is_held(solid: Solid) -> bool:
    """Whether no rigid motion is left: none vanishes wherever displacements are held."""
    motions = _rigid_motions(solid)
    motions = motions / np.abs(motions).max(axis=0)
    return np.linalg.matrix_rank(motions[solid.held], tol=1e-6) == 6 if solid.held.any() else False


def _rigid(solid: Solid, vectors) -> np.ndarray:
    """Which vectors are rigid motions: those that lie in their span, by the solid's own mass."""
    motions = _rigid_motions(solid)
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
