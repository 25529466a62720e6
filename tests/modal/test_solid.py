"""Plates against Kirchhoff's theory, meshes against the beam."""

import math

import numpy as np
import pytest

from plate_theory import LEISSA, SIDE, STEEL, THICKNESS, UNIT, loaded_pinned_plate
from warpdamp.errors import ModalError
from warpdamp.modal.beam import Beam, PointMass, beam_modes
from warpdamp.modal.section import Rectangle
from warpdamp.modal.solid import Clamp, MeshedSolid, Plate, StandingMass, plate_modes, solid_modes


@pytest.mark.parametrize("edges", LEISSA, ids="-".join)
def test_square_plates_agree_with_leissa(edges):
    """0.5 % where his values are exact or nearly; below them by up to 1.2 % where they are known to be high.

    Thickness 1/100 of the side: Mindlin's shear and rotary inertia lower a pinned plate's mode m, n by the part
    (pi^2 / 24) (m^2 + n^2) (h/a)^2 (1 + 2 / (kappa (1 - nu))), kappa = 5/6, which is 0.2 % for the fifth and left out.
    """
    plate = Plate(SIDE, SIDE, THICKNESS, STEEL, edges)
    modes = plate_modes(plate, StandingMass(0.0, (0.3 * SIDE, 0.4 * SIDE), 0.04), elements=4)
    off = modes.frequency / (UNIT * np.array(LEISSA[edges])) - 1
    assert np.all(off < 5e-3)
    assert np.all(off > (-1.2e-2 if "free" in edges else -5e-3))


@pytest.mark.parametrize(("mass", "x", "y"), [(2.5, 0.2, 0.2), (5.0, 0.1, 0.16)])
def test_a_plate_with_a_mass_on_it(mass, x, y):
    """Half to all of the plate's own mass (5 kg), at the middle and elsewhere: f and phi to 0.2 %."""
    modes = plate_modes(
        Plate(SIDE, SIDE, THICKNESS, STEEL, ("pinned",) * 4), StandingMass(mass, (x, y), 0.04), highest=1, elements=4
    )
    f, phi = loaded_pinned_plate(mass, x, y, 0.04)
    assert modes.frequency[0] == pytest.approx(f, rel=2e-3)
    assert modes.amplitude[0] == pytest.approx(phi, rel=2e-3)


def test_modes_of_equal_frequency_are_turned_towards_the_damper():
    """Modes (1, 2) and (2, 1): one moves a damper on the diagonal with 2 sqrt 2 / sqrt M of its place, one not at all."""
    x = 0.25
    modes = plate_modes(
        Plate(SIDE, SIDE, THICKNESS, STEEL, ("pinned",) * 4), StandingMass(0.0, (x * SIDE,) * 2, 0.001), highest=3
    )
    place = math.sin(math.pi * x) * math.sin(2 * math.pi * x)
    expected = 2 / math.sqrt(7800 * THICKNESS * SIDE**2) * place * math.sqrt(2)
    np.testing.assert_allclose(modes.amplitude[1:], [expected, 0], rtol=5e-3, atol=1e-6)


@pytest.fixture(scope="module")
def strip_file(tmp_path_factory):
    """The strip 200 x 20 x 4 mm in hexahedra and in tetrahedra, in millimetres, with a named end."""
    pytest.importorskip("meshio")
    from skfem import MeshHex, MeshTet

    folder = tmp_path_factory.mktemp("meshes")
    grid = (np.linspace(0, 200, 41), np.linspace(-10, 10, 5), np.linspace(-2, 2, 2))
    for name, kind in (("hexahedra", MeshHex), ("tetrahedra", MeshTet)):
        mesh = kind.init_tensor(*grid)
        mesh.with_boundaries({"root": lambda x: x[0] < 1e-6}).save(folder / f"{name}.vtk")
    MeshHex.init_tensor(*grid[:2], grid[2]).save(folder / "plain.msh")
    return folder


DAMPER = StandingMass(0.05, (0.15, 0.0, 0.002), 0.01)


@pytest.mark.parametrize("name", ["hexahedra.vtk", "tetrahedra.vtk", "plain.msh"])
def test_a_mesh_gives_the_beams_modes(strip_file, name):
    """A cantilever with a mass on it, those modes of the solid that move it.

    1 % of f, and of phi by the mode's largest: the meshes are not graded, and a patch of 10 mm is not a section.
    """
    clamp = Clamp("root") if name.endswith(".vtk") else Clamp(box=((0.0, 0.0), None, None))
    solid = solid_modes(MeshedSolid(strip_file / name, STEEL, (clamp,), 1e-3), DAMPER, highest=5)
    bending = np.flatnonzero(~solid.on_node)[:3]
    beam = beam_modes(Beam(0.2, Rectangle(0.02, 0.004), STEEL, ("clamped", "free")), PointMass(0.05, 0.15), highest=3)
    np.testing.assert_allclose(solid.frequency[bending], beam.frequency, rtol=1e-2)
    off = np.abs(solid.amplitude[bending] - beam.amplitude)
    assert np.all(off < 1e-2 * np.max(np.abs(beam.shape), axis=(1, 2)))


def test_a_free_solid_has_its_rigid_motions_left_out(strip_file):
    solid = solid_modes(
        MeshedSolid(strip_file / "plain.msh", STEEL, (), 1e-3), StandingMass(0.0, (0.2, 0, 0), 0.01), highest=1
    )
    beam = beam_modes(Beam(0.2, Rectangle(0.02, 0.004), STEEL, ("free", "free")), PointMass(0.0, 0.2), highest=1)
    assert solid.frequency[0] == pytest.approx(beam.frequency[0], rel=2e-3)


def test_a_solid_hinged_on_an_edge_has_one_rigid_motion(strip_file):
    """Held along a line it may turn about it: first comes the pinned-free beam's mode; 10 % for the edge's own give."""
    hinge = Clamp(box=((0.0, 0.0), None, (-0.002, -0.002)))
    solid = solid_modes(
        MeshedSolid(strip_file / "plain.msh", STEEL, (hinge,), 1e-3), StandingMass(0.0, (0.2, 0, 0), 0.01), highest=1
    )
    assert "rigid-body motions" in solid.remark  # a turn about the hinge is left out, and that is said
    beam = beam_modes(Beam(0.2, Rectangle(0.02, 0.004), STEEL, ("pinned", "free")), PointMass(0.0, 0.2), highest=1)
    assert solid.frequency[0] == pytest.approx(beam.frequency[0], rel=0.1)


@pytest.mark.parametrize(
    ("name", "clamp", "damper", "message"),
    [
        ("hexahedra.vtk", Clamp("rot"), DAMPER, "has no boundary or set of nodes 'rot': it has root"),
        ("plain.msh", Clamp("root"), DAMPER, "it names none; clamp planes or boxes"),
        ("plain.msh", Clamp(box=((1.0, 1.0), None, None)), DAMPER, r"nothing of the mesh, 0..200 x -10..10 x -2..2 mm, lies there"),
        ("plain.msh", Clamp(box=((0.0, 0.0), None, None)), StandingMass(0.1, (0.1, 0, 0.05), 0.02), r"no surface within 10 mm of \(100, 0, 50\) mm; the nearest is 48"),
    ],
)  # fmt: skip
def test_solids_that_cannot_be_solved(strip_file, name, clamp, damper, message):
    with pytest.raises(ValueError, match=message):
        solid_modes(MeshedSolid(strip_file / name, STEEL, (clamp,), 1e-3), damper, highest=1)


def test_files_that_hold_no_solid(tmp_path):
    pytest.importorskip("meshio")
    from skfem import MeshTet, MeshTri

    with pytest.raises(ModalError, match="there is no file"):
        solid_modes(MeshedSolid(tmp_path / "nothing.msh", STEEL), DAMPER)
    (tmp_path / "text.msh").write_text("hello")
    with pytest.raises(ValueError, match=r"text.msh holds no mesh that meshio reads: .*: export it again$"):
        solid_modes(MeshedSolid(tmp_path / "text.msh", STEEL), DAMPER)
    MeshTri().save(tmp_path / "flat.msh")
    with pytest.raises(ValueError, match="holds a MeshTri1: a solid is a mesh of tetrahedra or hexahedra"):
        solid_modes(MeshedSolid(tmp_path / "flat.msh", STEEL), DAMPER)
    one = MeshTet().refined(1)
    (one + one.translated((3.0, 0, 0))).save(tmp_path / "two.msh")
    with pytest.raises(ValueError, match="falls into 2 parts that share no nodes"):
        solid_modes(MeshedSolid(tmp_path / "two.msh", STEEL), StandingMass(0, (0, 0, 0), 0.5))
