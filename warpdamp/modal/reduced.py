"""An extrusion in few functions of its section, which are added to until the frequencies of its modes stand.

The stiffness of p planes with r functions in all is a band matrix of half width 3 r.  The functions begin as
polynomials.  Further ones are the leading directions of (-Laplace + k^2)^-1 R in the section, R (s, p m) the residual
of the modes wanted, for wave numbers k that belong to a long stretch of beam, to its ends, and to their corners.  Each
step lowers the frequencies towards those of all functions, by a third of what is left to a thirtieth.  It is a subspace
iteration of low rank: D. Kressner, C. Tobler, Comput. Methods Appl. Math. 11 (2011) 363, doi:10.2478/cmam-2011-0018.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.sparse import eye, kron, spmatrix
from threadpoolctl import threadpool_limits

from .eigenmodes import is_held
from .extrusion import VALUE, Extrusion, orthonormal
from .fem import lowest_bending

COUPLED = 3
"""A plane of nodes and those after it that a quadratic element couples it with."""
ADDED = 4
"""Functions that each wave number adds to every axis in a step."""
CONVERGED = 4e-7
"""Part of a squared frequency that is still to come, as the falls of the last two steps foretell it."""
BEST_RATE = 0.05
"""Of two falls that is believed."""
MOST_MEMORY = 4e8
"""Of a factorised band matrix [bytes]: where more functions would take more, there are no more."""


@dataclass(frozen=True)
class Reduced:
    """Extrusion in some functions of the section: what ``elastic_modes`` takes.

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
        """Slices of each axis' functions among the r of a plane."""
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
        """Mass matrix, (p r, p r) [kg]."""
        line = self.extrusion.material.density * self.extrusion.line[VALUE, VALUE]
        return kron(line, eye(self.r), format="csr")

    @cached_property
    def held(self) -> np.ndarray:
        """Displacements that are held, (p r,) array of bool."""
        held = np.zeros((self.planes, self.r), bool)
        for plane, axes in zip((0, -1), self.extrusion.ends, strict=True):
            for axis in axes:
                held[plane, self.parts[axis]] = True
        return held.ravel()

    @cached_property
    def motions(self) -> np.ndarray:
        """Displacements of the rigid motions, which the polynomials hold, (p r, 6)."""
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
        """Shift s of K - s M, below zero where rigid motions are left [rad^2/s^2]."""
        size = [*np.ptp(self.extrusion.place, axis=1), np.ptp(self.extrusion.station)]
        return 0.0 if is_held(self) else -lowest_bending(self.extrusion.material, size)

    def rows(self, axis: int, weights: np.ndarray) -> spmatrix:
        """Matrix (p, p r) of every plane's mean displacement along an axis, with ``weights`` (s,)."""
        seen = np.zeros((1, self.r))
        seen[0, self.parts[axis]] = weights @ self.functions[axis]
        return kron(eye(self.planes), seen, format="csr")

    def displacement(self, vectors: np.ndarray) -> list[np.ndarray]:
        """Displacements of vectors (p r, m), for each axis (s, p, m)."""
        return [np.tensordot(f, a, (1, 1)) for f, a in zip(self.functions, self.coefficients(vectors), strict=True)]

    def coefficients(self, vectors: np.ndarray) -> list[np.ndarray]:
        """Coefficients of each axis' functions in vectors (p r, m), for each axis (p, r_j, m)."""
        vectors = vectors.reshape(self.planes, self.r, -1)
        return [vectors[:, part] for part in self.parts]

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
        """Solver of (K - s M) x = b for the displacements that are not held."""
        factor = cholesky_banded(self._band(), lower=True, overwrite_ab=True, check_finite=False)
        free = np.flatnonzero(~self.held)

        def solve(load):
            whole = np.zeros(len(self.held))
            whole[free] = np.ravel(load)
            return cho_solve_banded((factor, True), whole, overwrite_b=True, check_finite=False)[free]

        return solve

    def enriched(self, residual) -> Reduced:
        """Reduced extrusion with further functions, from the residual of its modes."""
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
        """Memory of the band matrix [bytes]."""
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
    """Sum of the falls to come, if they continue as the last two: by one factor."""
    rate = max(fall / last, BEST_RATE) if np.isfinite(last) else 1.0
    return fall * rate / (1 - rate) if rate < 1 else np.inf
