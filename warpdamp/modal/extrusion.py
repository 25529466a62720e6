"""A plane section swept along x, in as few functions of the section as its modes need.

    u_j(x, y, z) = sum_pi a_pji N_p(x) f_ji(y, z)

N_p are the quadratic elements of the line, f_ji lie in the space of the section's finite elements.  Every block of the
stiffness is a sum of Kronecker products, a matrix of the line times one of the section,

    K_ij = sum_ab L_ab (x) Q_abij,    L_ab = int d_a N d_b N dx,

so that only Q, as f_i^T Q f_j, depends on the functions, and the stiffness of p planes with r functions in all is a
band matrix of half width 3 r.  A section has thousands of displacements and moves in a few dozen ways.

The functions begin as polynomials of degree 2, which hold rigid motions and Poisson's contraction.  Further ones come
from the residual R (s, p m) of the modes wanted: leading directions of (-Laplace + k^2)^-1 R in the section, for wave
numbers k that belong to a long stretch of beam, to its ends, and to their corners.  Each step lowers the frequencies
towards those of all functions, by a third of what is left to a thirtieth.  It is a subspace iteration of low rank:
D. Kressner, C. Tobler, Comput. Methods Appl. Math. 11 (2011) 363, doi:10.2478/cmam-2011-0018.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.sparse import csr_matrix, eye, kron, spmatrix
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

from ..scene.scene import Material
from .fem import AXES, derivative, forms, is_held, lame, line_forms, lowest_bending

if TYPE_CHECKING:
    from skfem import Basis

VALUE = None
COUPLED = 3
"""A plane of nodes and those after it that a quadratic element couples it with."""
DEGREE = 2
"""Of the polynomials to begin with."""
WAVE_NUMBERS, ADDED = (1.0, 4.0, 16.0), 4
"""Of the corrections, times the size of the section, and the functions that each adds to every axis."""
CONVERGED = 4e-7
"""Part of a squared frequency that is still to come, as the falls of the last two steps foretell it."""
BEST_RATE = 0.05
"""Of two falls that is believed."""
MOST_MEMORY = 4e8
"""Of a factorised band matrix [bytes]: where more functions would take more, there are no more."""


class Carried(NamedTuple):
    """Masses that follow a mean of every plane's displacement along an axis: weights (s,), masses (p,) [kg]."""

    axis: int
    weights: np.ndarray
    mass: np.ndarray


@dataclass(frozen=True)
class Extrusion:
    """A section swept along x.

    Parameters
    ----------
    station : (p,) array, positions of the planes of nodes [m]
    line : matrices (p, p) of the line, by the derivatives of both sides
    section : matrices (s, s) of the section [N/m^2 times m^2 or less], by derivatives along the line and axes
    area : (s, s) mass matrix of the section at unit density [m^2]
    laplace : (s, s) int grad v . grad u of the section
    place : (2, s) array, its nodes [m]
    material : Material
    ends : axes along which the section is held at the first plane, and at the last
    """

    station: np.ndarray
    line: dict
    section: dict
    area: spmatrix
    laplace: spmatrix
    place: np.ndarray
    material: Material
    ends: tuple[tuple[int, ...], tuple[int, ...]]

    @property
    def size(self) -> float:
        """Of the section, about the least [m]."""
        return float(np.ptp(self.place, axis=1).min())

    def polynomials(self) -> list[np.ndarray]:
        """The functions to begin with, for each axis."""
        y, z = self.place / np.abs(self.place).max(axis=1)[:, None]
        powers = [y**i * z**j for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)]
        return [orthonormal(np.stack(powers, axis=1), self.area) for _ in AXES]

    def residual(self, displacement, squares, carried) -> list[np.ndarray]:
        """K u - w^2 M u of modes, for each axis (s, p m), where the section is not held.

        Parameters
        ----------
        displacement : for each axis (s, p, m)
        squares : (m,) of angular frequencies
        carried : of Carried
        """
        forces = [np.zeros_like(u) for u in displacement]
        for (a, b, i, j), matrix in self.section.items():
            forces[i] += _along(self.line[a, b], _across(matrix, displacement[j]))
        inertia = [self.material.density * _along(self.line[VALUE, VALUE], _across(self.area, u)) for u in displacement]
        for axis, weights, mass in carried:
            mean = np.tensordot(weights, displacement[axis], 1)
            inertia[axis] += weights[:, None, None] * (mass[:, None] * mean)
        residual = [force - squares * mass for force, mass in zip(forces, inertia, strict=True)]
        for plane, axes in zip((0, -1), self.ends, strict=True):
            for axis in axes:
                residual[axis][:, plane] = 0.0
        return [of_axis.reshape(len(of_axis), -1) for of_axis in residual]

    @cached_property
    def smoothers(self) -> list[Callable]:
        """Solve (-Laplace + k^2) x = b in the section, one for each wave number."""
        matrices = [self.laplace + (k / self.size) ** 2 * self.area for k in WAVE_NUMBERS]
        symmetric = {"permc_spec": "MMD_AT_PLUS_A", "options": {"SymmetricMode": True}}
        return [splu(matrix.tocsc(), **symmetric).solve for matrix in matrices]


def _across(matrix, u: np.ndarray) -> np.ndarray:
    """A matrix of the section times displacements (s, p, m)."""
    return (matrix @ u.reshape(len(u), -1)).reshape(u.shape)


def _along(matrix, u: np.ndarray) -> np.ndarray:
    """A matrix of the line times displacements (s, p, m)."""
    turned = np.ascontiguousarray(u.transpose(1, 0, 2))
    return _across(matrix, turned).transpose(1, 0, 2)


def swept(section: Basis, stations, material: Material, ends) -> Extrusion:
    """The extrusion of a plane basis on quadratic elements between ``stations`` [m]."""
    station, line = line_forms(stations)
    plane = forms(section, (VALUE, 0, 1))
    first, shear = lame(material)
    blocks = defaultdict(lambda: csr_matrix((section.N, section.N)))

    def add(factor, i, j, left, right):
        (a, c), (b, d) = derivative(left, 0), derivative(right, 0)
        blocks[a, b, i, j] = blocks[a, b, i, j] + factor * plane[c, d]

    for i, j in itertools.product(AXES, repeat=2):
        add(first, i, j, i, j)
        add(shear, i, j, j, i)
        add(shear, i, i, j, j)
    laplace = plane[0, 0] + plane[1, 1]
    return Extrusion(station, line, dict(blocks), plane[VALUE, VALUE], laplace, section.doflocs, material, ends)


def orthonormal(functions: np.ndarray, mass, known: np.ndarray | None = None) -> np.ndarray:
    """(s, r) functions orthonormal in ``mass`` that span those given, without what lies in the span of ``known``."""
    for _ in range(2):  # once more for the digits that the first lost
        if known is not None:
            functions = functions - known @ (known.T @ (mass @ functions))
        functions = functions / np.sqrt(np.einsum("sr,sr->r", functions, mass @ functions))
        squares, turn = np.linalg.eigh(functions.T @ (mass @ functions))
        kept = squares > 1e-10
        functions = functions @ (turn[:, kept] / np.sqrt(squares[kept]))
    return functions


@dataclass(frozen=True)
class Reduced:
    """An extrusion in some functions of the section: what ``elastic_modes`` takes.

    Displacements are numbered plane by plane: function i along axis j of plane p is number p r + offset_j + i.

    Parameters
    ----------
    extrusion : Extrusion
    functions : for each axis (s, r_j) array, orthonormal in the section's mass
    """

    extrusion: Extrusion
    functions: list[np.ndarray]

    @cached_property
    def parts(self) -> list[slice]:
        """For each axis, where its functions lie among the r of a plane."""
        edges = np.cumsum([0, *(of_axis.shape[1] for of_axis in self.functions)])
        return [slice(int(a), int(b)) for a, b in itertools.pairwise(edges)]

    @property
    def r(self) -> int:
        """Number of functions."""
        return self.parts[-1].stop

    @property
    def planes(self) -> int:
        """Number of planes of nodes."""
        return len(self.extrusion.station)

    @property
    def mass(self) -> spmatrix:
        """(p r, p r) [kg]."""
        line = self.extrusion.material.density * self.extrusion.line[VALUE, VALUE]
        return kron(line, eye(self.r), format="csr")

    @cached_property
    def held(self) -> np.ndarray:
        """(p r,) array of bool."""
        held = np.zeros((self.planes, self.r), bool)
        for plane, axes in zip((0, -1), self.extrusion.ends, strict=True):
            for axis in axes:
                held[plane, self.parts[axis]] = True
        return held.ravel()

    @cached_property
    def motions(self) -> np.ndarray:
        """(p r, 6) displacements of the rigid motions, which the polynomials hold."""
        (y, z), x = self.extrusion.place, self.extrusion.station - self.extrusion.station.mean()
        one, along = np.ones_like(y), np.ones_like(x)
        of_axes = [
            [(0, along, one)],
            [(1, along, one)],
            [(2, along, one)],
            [(1, along, -z), (2, along, y)],
            [(0, along, z), (2, -x, one)],
            [(0, along, -y), (1, x, one)],
        ]
        motions = np.zeros((self.planes, self.r, 6))
        for column, terms in enumerate(of_axes):
            for axis, line, section in terms:
                seen = self.functions[axis].T @ (self.extrusion.area @ section)
                motions[:, self.parts[axis], column] += np.outer(line, seen)
        return motions.reshape(-1, 6)

    @cached_property
    def shift(self) -> float:
        """Below zero where rigid motions are left [rad^2/s^2]."""
        size = [*np.ptp(self.extrusion.place, axis=1), np.ptp(self.extrusion.station)]
        return 0.0 if is_held(self) else -lowest_bending(self.extrusion.material, size)

    def rows(self, axis: int, weights: np.ndarray) -> spmatrix:
        """(p, p r) matrix that reads every plane's mean displacement along an axis, with ``weights`` (s,)."""
        seen = np.zeros((1, self.r))
        seen[0, self.parts[axis]] = weights @ self.functions[axis]
        return kron(eye(self.planes), seen, format="csr")

    def displacement(self, vectors: np.ndarray) -> list[np.ndarray]:
        """For each axis (s, p, m), what vectors (p r, m) stand for."""
        vectors = vectors.reshape(self.planes, self.r, -1)
        return [np.tensordot(f, vectors[:, part], (1, 1)) for f, part in zip(self.functions, self.parts, strict=True)]

    def _section(self) -> dict:
        """(r, r) matrices of the section by the derivatives along the line, of K - s M."""
        blocks = {key: np.zeros((self.r, self.r)) for key in self.extrusion.line}
        for (a, b, i, j), matrix in self.extrusion.section.items():
            blocks[a, b][self.parts[i], self.parts[j]] += self.functions[i].T @ (matrix @ self.functions[j])
        blocks[VALUE, VALUE] -= self.shift * self.extrusion.material.density * np.eye(self.r)
        return blocks

    def _band(self) -> np.ndarray:
        """(3 r, p r) lower band of K - s M, with ones on the diagonal where displacements are held."""
        planes, r, free = self.planes, self.r, ~self.held.reshape(self.planes, self.r)
        blocks = self._section()
        column = np.zeros((planes, r, COUPLED * r))
        for d in range(COUPLED):
            block = sum(line.diagonal(-d)[:, None, None] * blocks[key] for key, line in self.extrusion.line.items())
            block *= free[d:, :, None] & free[: planes - d, None, :]
            for k in range(r):
                first = k if d == 0 else 0
                column[: planes - d, k, d * r - k + first : (d + 1) * r - k] = block[:, first:, k]
        column[:, :, 0] += ~free
        return column.reshape(planes * r, -1).T

    @cached_property
    def inverse(self) -> Callable:
        """Solves (K - s M) x = b for the displacements that are not held."""
        factor = cholesky_banded(self._band(), lower=True, overwrite_ab=True, check_finite=False)
        free = np.flatnonzero(~self.held)

        def solve(load):
            whole = np.zeros(len(self.held))
            whole[free] = np.ravel(load)
            return cho_solve_banded((factor, True), whole, overwrite_b=True, check_finite=False)[free]

        return solve

    def enriched(self, residual) -> Reduced:
        """The same with further functions, from the residual of its modes."""
        return Reduced(
            self.extrusion,
            [
                np.hstack([known, self._corrections(of_axis, known)])
                for known, of_axis in zip(self.functions, residual, strict=True)
            ],
        )

    def _corrections(self, residual: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Leading directions of what each smoother makes of a residual (s, p m), orthonormal and new."""
        room = len(known) - known.shape[1]
        if room == 0 or not residual.any():
            return known[:, :0]
        start = np.random.default_rng(0).standard_normal((residual.shape[1], ADDED))  # the same on every run
        found = []
        for smooth in self.extrusion.smoothers:
            sample = start
            for _ in range(3):  # power iteration: Halko, Martinsson, Tropp 2011, doi:10.1137/090771806
                sample, _ = np.linalg.qr(sample)
                direction = smooth(residual @ sample)
                sample = residual.T @ direction
            found.append(direction)
        return orthonormal(np.hstack(found), self.extrusion.area, known)[:, :room]

    @property
    def memory(self) -> int:
        """Of the band matrix [bytes]."""
        return 8 * COUPLED * self.planes * self.r**2


class Converged(NamedTuple):
    """Modes in as many functions as they need, and the part by which their squares would still fall with all."""

    reduced: Reduced
    squares: np.ndarray
    vectors: np.ndarray
    rest: float


def converged(extrusion: Extrusion, carried, modes: Callable) -> Converged:
    """Modes of an extrusion, whose functions of the section are added to until the frequencies stand.

    Parameters
    ----------
    extrusion : Extrusion
    carried : of Carried, the masses on it
    modes : ``modes(reduced)`` returns squares (m,) of angular frequencies and vectors (p r, m)
    """
    with threadpool_limits(1):
        reduced, last = Reduced(extrusion, extrusion.polynomials()), np.inf
        squares, vectors = modes(reduced)
        while True:
            residual = extrusion.residual(reduced.displacement(vectors), squares, carried)
            richer, before = reduced.enriched(residual), squares
            if richer.r == reduced.r:
                return Converged(reduced, squares, vectors, 0.0)
            squares, vectors = modes(richer)
            fall = float(np.max(np.abs(before / squares - 1)))
            rest = _rest(fall, last)
            if rest < CONVERGED or richer.memory > MOST_MEMORY:
                return Converged(richer, squares, vectors, rest)
            reduced, last = richer, fall


def _rest(fall: float, last: float) -> float:
    """Sum of the falls to come, if they go on as the last two: by one factor."""
    rate = max(fall / last, BEST_RATE) if np.isfinite(last) else 1.0
    return fall * rate / (1 - rate) if rate < 1 else np.inf
