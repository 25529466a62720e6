"""Cross-sections of a beam: width along y, thickness along z, the centroid at the origin.

Those of a closed form are symmetric about both axes and give the quarter y, z > 0 of themselves, in which only bending
one way is left.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..errors import ModalError
from .cells import basis_on

if TYPE_CHECKING:
    from skfem import Basis, Mesh


@dataclass(frozen=True)
class Rectangle:
    """Rectangular section: width along y and thickness along z [m]."""

    width: float
    thickness: float
    quarter: ClassVar[bool] = True

    def basis(self) -> Basis:
        """Quadratic elements on the quarter, two across the width and one across the thickness."""
        from skfem import Basis, ElementQuad2, MeshQuad

        across, through = np.linspace(0, 0.5, 3) * self.width, np.linspace(0, 0.5, 2) * self.thickness
        return Basis(MeshQuad.init_tensor(across, through), ElementQuad2(), intorder=4)


@dataclass(frozen=True)
class Circle:
    """Solid round section of a diameter [m]."""

    diameter: float
    quarter: ClassVar[bool] = True

    def basis(self) -> Basis:
        """Four quadratic triangles on the quarter, their outer sides curved."""
        from skfem import ElementTriP2, MeshTri, MeshTri2

        disc = MeshTri.init_circle(1)
        straight = MeshTri2.from_mesh(disc.restrict(disc.elements_satisfying(lambda x: np.all(x > 0, axis=0))))
        outer = straight.facets_satisfying(lambda x: np.linalg.norm(x, axis=0) > 0.9)
        outer = straight.dofs.get_facet_dofs(outer).flatten()
        place = self.diameter / 2 * straight.doflocs
        place[:, outer] *= self.diameter / 2 / np.linalg.norm(place[:, outer], axis=0)
        return _with_area(replace(straight, doflocs=place), ElementTriP2(), np.pi / 16 * self.diameter**2)


@dataclass(frozen=True)
class Tube:
    """Round tube: outer diameter and thickness of the wall [m]."""

    diameter: float
    wall: float
    quarter: ClassVar[bool] = True

    def basis(self) -> Basis:
        """Three quadratic quadrilaterals on the quarter, with curved sides, one through the wall."""
        from skfem import ElementQuad2, MeshQuad, MeshQuad2

        outer, inner = self.diameter / 2, self.diameter / 2 - self.wall
        flat = MeshQuad2.from_mesh(MeshQuad.init_tensor(np.array([inner, outer]), np.linspace(0, np.pi / 2, 4)))
        radius, angle = flat.doflocs
        curved = replace(flat, doflocs=radius * np.array([np.cos(angle), np.sin(angle)]))
        return _with_area(curved, ElementQuad2(), np.pi / 4 * (outer**2 - inner**2))


def _with_area(mesh: Mesh, element, area: float) -> Basis:
    """Parabolic sides cut a little off a circle: scaled to the right area, second moments come right, too."""
    from skfem import Basis

    of = moments(Basis(mesh, element, intorder=6))
    return Basis(mesh.scaled(np.sqrt(area / of.area)), element, intorder=6)


@dataclass(frozen=True)
class MeshedSection:
    """Section of any shape, as a plane mesh of triangles or quadrilaterals in a file that meshio reads.

    The mesh's first coordinate is taken along the width, its second along the thickness.

    Parameters
    ----------
    file : path
    unit : length of the mesh's unit [m]
    """

    file: Path
    unit: float = 1.0
    quarter: ClassVar[bool] = False

    def basis(self) -> Basis:
        """Quadratic elements on the mesh, moved so that its centroid is the origin.

        Raises
        ------
        ModalError
            If the file is no plane mesh, or if the section's principal axes are not those of the beam.
        """
        from skfem import ElementQuad2, ElementTriP2, MeshQuad1, MeshTri1

        from ..formats.mesh_file import load_mesh

        mesh = load_mesh(self.file, self.unit)
        if not isinstance(mesh, MeshTri1 | MeshQuad1):
            raise ModalError(f"{self.file} holds a {type(mesh).__name__}: a section is a plane mesh")
        element = ElementTriP2() if isinstance(mesh, MeshTri1) else ElementQuad2()
        centroid = moments(basis_on(mesh, element, 6, self.file)).centroid
        basis = basis_on(mesh.translated(-centroid), element, 6, self.file)
        of = moments(basis)
        if abs(of.mixed) > 0.01 * max(of.across, of.through):
            turn = np.degrees(0.5 * np.arctan2(2 * of.mixed, of.across - of.through))
            raise ModalError(
                f"{self.file}: the section's principal axes are turned by {turn:.1f} degrees: it would not bend along "
                "y or z; turn the mesh"
            )
        return basis


Section = Rectangle | Circle | Tube | MeshedSection


@dataclass(frozen=True)
class Moments:
    """Moments of a section: area [m^2], centroid (2,) [m]; int y^2, int z^2, int y z about the origin [m^4]."""

    area: float
    centroid: np.ndarray
    across: float
    through: float
    mixed: float

    @property
    def equivalent_thickness(self) -> float:
        """Thickness of the rectangle with its smaller radius of gyration [m]."""
        return float(np.sqrt(12 * min(self.across, self.through) / self.area))


def moments(basis: Basis) -> Moments:
    """Area and moments of the section that a plane basis covers."""
    from skfem import Functional

    def over(f):
        return float(Functional(lambda w: f(*w.x)).assemble(basis))

    area = over(lambda y, z: 1.0 + 0 * y)
    centroid = np.array([over(lambda y, z: y), over(lambda y, z: z)]) / area
    return Moments(area, centroid, over(lambda y, z: y**2), over(lambda y, z: z**2), over(lambda y, z: y * z))
