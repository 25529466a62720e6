"""Three-dimensional elasticity on scikit-fem meshes: stiffness and mass, and what is held.

Displacements are numbered component by component, each on the same scalar basis of n nodes: that of node i along axis
j is number j n + i.  Nine scalar blocks D_ij = int d_i v d_j u give the whole stiffness,
lambda D_ij + mu (D_ji + delta_ij sum_k D_kk), fifty times faster than a vector element's assembly.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import block_diag, bmat, kron, spmatrix

from ..scene.scene import Material
from .eigenmodes import factorised, is_held

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

    @property
    def motions(self) -> np.ndarray:
        """Displacements of three translations and three small rotations about the middle, (3 n, 6)."""
        zero, one = np.zeros(self.place.shape[1]), np.ones(self.place.shape[1])
        x, y, z = self.place - self.place.mean(axis=1)[:, None]
        columns = [
            (one, zero, zero), (zero, one, zero), (zero, zero, one), (zero, -z, y), (z, zero, -x), (-y, x, zero)
        ]  # fmt: skip
        return np.array([np.concatenate(column) for column in columns]).T

    @cached_property
    def shift(self) -> float:
        """Shift s of K - s M that makes it regular where rigid motions are left [rad^2/s^2]."""
        return 0.0 if is_held(self) else -self.guess

    @cached_property
    def inverse(self) -> Callable:
        """Solver of (K - s M) x = b for the displacements that are not held; factorised once."""
        free = np.flatnonzero(~self.held)
        return factorised((self.stiffness - self.shift * self.mass)[free][:, free], free % self.place.shape[1])


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
    """Derivative d/d axis of an extruded function: the one along the line, and the one in the section."""
    return (0, None) if axis == along else (None, [other for other in AXES if other != along].index(axis))


def lame(material: Material) -> tuple[float, float]:
    """Lame's first parameter and the shear modulus [Pa]."""
    from skfem.models.elasticity import lame_parameters

    return lame_parameters(material.youngs_modulus, material.poissons_ratio)


def lowest_bending(material: Material, size) -> float:
    """Estimate of the square of a free solid's lowest angular frequency by its ``size`` (3,) [m], [rad^2/s^2]."""
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
    """Integrals of the basis functions times ``weight(place)``, (n,)."""
    from skfem import LinearForm

    return LinearForm(lambda v, w: v * weight(w.x)).assemble(basis)


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
