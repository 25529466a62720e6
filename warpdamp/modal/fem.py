"""A straight beam in three-dimensional finite elements, with a point mass: its bending modes by scikit-fem.

Triquadratic hexahedra, four across the width and two across the thickness, graded along the length towards the
supports and the mass: the clamps hold back Poisson's contraction in a boundary layer, and the mass bends the beam
sharply.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.sparse import block_diag, bmat, csr_matrix
from scipy.sparse.linalg import eigsh

from ..scene import Material
from .modes import Modes

Support = Literal["clamped", "free"]


@dataclass(frozen=True)
class Beam:
    """A beam of rectangular section along x, bending across its thickness (z).

    Parameters
    ----------
    length, width, thickness : [m]
    material : Material
    supports : how the ends x = 0 and x = length are held
    mass_position : of the attached mass and the damper [m]
    mass : attached, without particles [kg]
    finest, coarsest : element lengths at the ends and the mass, and far from them, in thicknesses
    """

    length: float
    width: float
    thickness: float
    material: Material
    supports: tuple[Support, Support] = ("clamped", "clamped")
    mass_position: float = 0.0
    mass: float = 0.0
    finest: float = 0.125
    coarsest: float = 1.5

    @property
    def section(self) -> float:
        """Area [m^2]."""
        return self.width * self.thickness


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


def beam_modes(beam: Beam, *, particle_mass: float = 0.0, highest: int = 5) -> Modes:
    """Bending modes 1 .. ``highest`` of a beam with its attached mass and the particles'.

    Modes are found by shape, not by their place in the spectrum: those whose kinetic energy is that of the centre line
    moving across the thickness.  Torsion and lateral modes lie between them.

    Parameters
    ----------
    beam : Beam
    particle_mass : added to the point mass [kg]
    highest : number of the highest mode wanted
    """
    stiffness, mass, tie, line, station = _assemble(beam)
    total = beam.mass + particle_mass
    mass = mass + total * (tie.T @ tie)

    wanted = 3 * highest + 3
    while True:
        wanted = min(wanted, stiffness.shape[0] - 2)
        start = np.ones(stiffness.shape[0])  # a fixed start: the same modes to the bit on every run
        values, vectors = eigsh(stiffness, wanted, mass, sigma=0.0, v0=start)
        at_mass = np.asarray(tie @ vectors)[2]
        shapes = np.asarray(line @ vectors).T
        line_density = beam.material.density * beam.section
        share = np.trapezoid(line_density * shapes**2, station, axis=1) + total * at_mass**2
        bending = np.flatnonzero(share > 0.5)
        if len(bending) >= highest or wanted == stiffness.shape[0] - 2:
            break
        wanted *= 2

    bending = bending[:highest]
    sign = np.where(at_mass[bending] < 0, -1.0, 1.0)
    return Modes(
        number=np.arange(1, len(bending) + 1),
        frequency=np.sqrt(values[bending]) / (2 * np.pi),
        amplitude=sign * at_mass[bending],
        station=station,
        shape=sign[:, None] * shapes[bending],
    )


def _assemble(beam: Beam):
    """Stiffness and mass of the free degrees of freedom, and two read-outs of them.

    Displacements are numbered component by component, each on the same scalar basis: nine scalar blocks
    D_ij = int d_i v d_j u give the whole stiffness, lambda D_ij + mu (D_ji + delta_ij sum_k D_kk), fifty times faster
    than a vector element's assembly.

    Returns ``stiffness``, ``mass``, ``tie`` (3 rows: mean displacement of the section at the mass), ``line`` (centre
    line's z displacement at ``station``), ``station``.
    """
    from skfem import Basis, BilinearForm, ElementHex2, MeshHex
    from skfem.models.elasticity import lame_parameters

    stations = graded(
        sorted({0.0, beam.mass_position, beam.length}), beam.finest * beam.thickness, beam.coarsest * beam.thickness
    )
    across, through = np.linspace(-0.5, 0.5, 5) * beam.width, np.linspace(-0.5, 0.5, 3) * beam.thickness
    mesh = MeshHex.init_tensor(stations, across, through)
    basis = Basis(mesh, ElementHex2(), intorder=4)
    axes = range(3)

    block = [
        [BilinearForm(lambda u, v, w, i=i, j=j: v.grad[i] * u.grad[j]).assemble(basis) for j in axes] for i in axes
    ]
    first, shear = lame_parameters(beam.material.youngs_modulus, beam.material.poissons_ratio)
    laplace = block[0][0] + block[1][1] + block[2][2]
    stiffness = bmat(
        [[first * block[i][j] + shear * (block[j][i] + (laplace if i == j else 0)) for j in axes] for i in axes]
    ).tocsc()
    density = BilinearForm(lambda u, v, w: beam.material.density * u * v).assemble(basis)
    mass = block_diag([density] * 3).tocsc()

    near = 1e-9 * beam.length
    held = [
        basis.get_dofs(lambda p, end=end: np.isclose(p[0], end, atol=near)).all()
        for end, support in zip((0.0, beam.length), beam.supports, strict=True)
        if support == "clamped"
    ]
    one = np.setdiff1d(np.arange(basis.N), np.concatenate(held))
    free = np.concatenate([axis * basis.N + one for axis in axes])

    x, y, z = basis.doflocs
    weights = _section_weights(across, through)
    at_mass = np.flatnonzero(np.isclose(x, beam.mass_position, atol=near))
    mean = np.zeros(basis.N)
    mean[at_mass] = [weights[_place(y[k], across), _place(z[k], through)] for k in at_mass]
    tie = block_diag([csr_matrix(mean)] * 3).tocsr()

    centre = np.flatnonzero(np.isclose(y, 0, atol=near) & np.isclose(z, 0, atol=near))
    centre = centre[np.argsort(x[centre])]
    line = csr_matrix(
        (np.ones(len(centre)), (np.arange(len(centre)), 2 * basis.N + centre)), shape=(len(centre), 3 * basis.N)
    )
    return stiffness[free][:, free], mass[free][:, free], tie[:, free], line[:, free], x[centre]


def _section_weights(across, through) -> np.ndarray:
    """Weights of the nodes of a section in the mean over it: Simpson's rule, exact for quadratic elements."""
    lines = []
    for stations in (across, through):
        n = len(stations) - 1
        line = np.zeros(2 * n + 1)
        for k in range(n):
            line[2 * k : 2 * k + 3] += np.array([1, 4, 1]) / (6 * n)
        lines.append(line)
    return np.outer(*lines)


def _place(coordinate, stations) -> int:
    """Number of a node along evenly spaced stations with one node between each two."""
    return round((coordinate - stations[0]) / (stations[1] - stations[0]) * 2)
