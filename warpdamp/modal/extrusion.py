"""A plane section swept along x, in as few functions of the section as its modes need.

    u_j(x, y, z) = sum_pi a_pji N_p(x) f_ji(y, z)

N_p are the quadratic elements of the line, f_ji lie in the space of the section's finite elements.  Every block of the
stiffness is a sum of Kronecker products, a matrix of the line times one of the section,

    K_ij = sum_ab L_ab (x) Q_abij,    L_ab = int d_a N d_b N dx,

so that only Q, as f_i^T Q f_j, depends on the functions.  A section has thousands of displacements and moves in a few
dozen ways (``reduced``).
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.sparse import csr_matrix, spmatrix
from scipy.sparse.linalg import splu

from ..scene.scene import Material
from .fem import AXES, derivative, forms, lame, line_forms

if TYPE_CHECKING:
    from skfem import Basis

VALUE = None
DEGREE = 2
"""Of the polynomials to begin with."""
WAVE_NUMBERS = (1.0, 4.0, 16.0)
"""Of the corrections, times the size of the section."""


class Carried(NamedTuple):
    """Masses that follow a mean of every plane's displacement along an axis: weights (s,), masses (p,) [kg]."""

    axis: int
    weights: np.ndarray
    mass: np.ndarray


@dataclass(frozen=True)
class Extrusion:
    """Section swept along x.

    Parameters
    ----------
    station : (p,) array, positions of the planes of nodes [m]
    line : matrices (p, p) of the line, by the derivatives of both sides
    section : stiffness matrices (s, s) of the section, by the derivatives along the line and the axes of both sides
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
        """Size of the section, about the least [m]."""
        return float(np.ptp(self.place, axis=1).min())

    def polynomials(self) -> list[np.ndarray]:
        """Polynomials of the section to begin with, for each axis."""
        y, z = self.place / np.abs(self.place).max(axis=1)[:, None]
        powers = [y**i * z**j for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)]
        return [orthonormal(np.stack(powers, axis=1), self.area) for _ in AXES]

    def residual(self, displacement, squares, carried) -> list[np.ndarray]:
        """Residual K u - w^2 M u of modes, for each axis (s, p m), where the section is not held.

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
        """Solvers of (-Laplace + k^2) x = b in the section, one for each wave number."""
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
    """Extrusion of a plane basis on quadratic elements between ``stations`` [m]."""
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
    """Functions (s, r) orthonormal in ``mass`` that span those given, without what lies in the span of ``known``."""
    for _ in range(2):  # once more for the digits that the first lost
        if known is not None:
            functions = functions - known @ (known.T @ (mass @ functions))
        functions = functions / np.sqrt(np.einsum("sr,sr->r", functions, mass @ functions))
        squares, turn = np.linalg.eigh(functions.T @ (mass @ functions))
        kept = squares > 1e-10
        functions = functions @ (turn[:, kept] / np.sqrt(squares[kept]))
    return functions
