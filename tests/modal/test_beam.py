"""The beam family in three dimensions against beam theory.

With nu > 0 the finite elements lie a little higher, up to 0.5 % in slender beams: a clamp stops Poisson's contraction,
as if the beam were 0.1 % shorter at each, which moves the slopes of a fourth mode by up to 1 % of its height.  Beam
theory leaves that out, and with nu = 0 it is met to 0.1 % in both.
"""

import math

import numpy as np
import pytest

from beam_theory import Timoshenko, circle, rectangle, tube
from warpdamp import Material
from warpdamp.modal.beam import Beam, PointMass, beam_modes
from warpdamp.modal.fem import graded
from warpdamp.modal.section import Circle, MeshedSection, Rectangle, Tube, moments

LENGTH, WIDTH, THICKNESS = 0.58, 0.02, 0.004
SUPPORTS = [("clamped", "clamped"), ("clamped", "free"), ("pinned", "pinned"), ("free", "free")]
MASSES = ((0.2, 0.29, 0.0),)
TWO_MASSES = ((0.2, 0.21, 2e-5), (0.1, 0.41, 0.0))


def steel(nu=0.3):
    return Material(density=7800, youngs_modulus=210e9, poissons_ratio=nu)


def strip(supports, masses=(), *, nu=0.3, bends="thickness", highest=4):
    """The paper's strip: its modes, and beam theory's frequencies and shapes at the same stations."""
    depth = (WIDTH, THICKNESS) if bends == "thickness" else (THICKNESS, WIDTH)
    theory = Timoshenko(LENGTH, rectangle(*depth, nu), steel(nu), supports, masses)
    beam = Beam(LENGTH, Rectangle(WIDTH, THICKNESS), steel(nu), supports, bends)
    return solved(beam, theory, masses, highest)


def solved(beam, theory, masses, highest):
    first, *others = [PointMass(*mass) for mass in masses] or [PointMass(0.0, 0.37 * LENGTH)]
    beam = Beam(beam.length, beam.section, beam.material, beam.supports, beam.bends, tuple(others))
    modes = beam_modes(beam, first, highest=highest)
    frequency, place, shape = theory.modes(highest)
    return modes, frequency, np.array([np.interp(modes.point[:, 0], place, line) for line in shape])


def assert_same(modes, frequency, shape, tolerance, of_shape=1e-2):
    np.testing.assert_allclose(modes.frequency, frequency, rtol=tolerance)
    for own, line in zip(modes.shape @ np.array(modes.direction), shape, strict=True):
        sign = np.sign(own @ line)
        assert np.max(np.abs(sign * own - line)) < of_shape * np.max(np.abs(line))


def test_the_reference_knows_the_textbook():
    """Roots of the slender beam's frequency equations; 1e-4 for shear and rotary inertia at length 1000 depths."""
    textbook = {
        ("clamped", "clamped"): [4.73004, 7.85320, 10.9956],
        ("clamped", "free"): [1.87510, 4.69409, 7.85476],
        ("pinned", "pinned"): [math.pi, 2 * math.pi, 3 * math.pi],
        ("free", "free"): [4.73004, 7.85320, 10.9956],
        ("clamped", "pinned"): [3.92660, 7.06858, 10.2102],
    }
    for supports, roots in textbook.items():
        found, _, _ = Timoshenko(1.0, rectangle(1e-3, 1e-3, 0.3), steel(), supports).modes(3)
        expected = np.array(roots) ** 2 * math.sqrt(210e9 / 7800 / 12) * 1e-3 / (2 * math.pi)
        np.testing.assert_allclose(found, expected, rtol=1e-4)


@pytest.mark.parametrize("masses", [(), TWO_MASSES], ids=["bare", "two masses"])
@pytest.mark.parametrize("supports", SUPPORTS, ids="-".join)
def test_the_family_agrees_with_beam_theory(supports, masses):
    """Frequencies of modes 1 to 4 to 0.5 %, and their shapes."""
    assert_same(*strip(supports, masses), 5e-3)


@pytest.mark.parametrize("supports", SUPPORTS, ids="-".join)
def test_bending_across_the_width(supports):
    """The other family of the same strip, five times as stiff, with torsion and the first family between; 0.5 %."""
    assert_same(*strip(supports, MASSES, bends="width", highest=3), 5e-3)


@pytest.mark.parametrize("supports", [*SUPPORTS, ("clamped", "pinned"), ("pinned", "free")], ids="-".join)
def test_without_poissons_effect_it_agrees_closely(supports):
    """0.1 %: what is left is the mesh."""
    assert_same(*strip(supports, TWO_MASSES, nu=0.0), 1e-3, of_shape=1e-3)


def test_the_papers_beam():
    """The figures for f [Hz] and phi [kg^-0.5] of beam theory, with and without particles; 0.5 %."""
    reference = {0.0: ((40.742, 1.7201), (281.12, 0.8300), (729.88, 0.5963)),
                 0.0239985: ((39.367, 1.6627), (278.97, 0.7692), (727.03, 0.5458))}  # fmt: skip
    empty = PointMass(0.2, 0.29)
    for particles, expected in reference.items():
        modes = beam_modes(Beam(LENGTH, Rectangle(WIDTH, THICKNESS), steel()), empty.loaded(particles)).pick([1, 3, 5])
        np.testing.assert_allclose(modes.frequency, [f for f, _ in expected], rtol=5e-3)
        np.testing.assert_allclose(modes.amplitude, [phi for _, phi in expected], rtol=5e-3)


@pytest.mark.parametrize(
    ("section", "theory"),
    [(Circle(0.01), circle(0.01, 0.3)), (Tube(0.02, 0.002), tube(0.02, 0.002, 0.3))],
    ids=["rod", "tube"],
)
def test_round_beams(section, theory):
    """Every mode comes twice, and one of the two has all the bending along z; 0.5 %."""
    supports = ("clamped", "free")
    beam = Beam(LENGTH, section, steel(), supports)
    modes, frequency, shape = solved(beam, Timoshenko(LENGTH, theory, steel(), supports, MASSES), MASSES, 3)
    assert_same(modes, frequency, shape, 5e-3)
    assert np.max(np.abs(modes.shape[:, :, 1])) < 1e-6 * np.max(np.abs(modes.shape))


def test_round_sections_have_the_right_moments():
    """Curved sides are parabolas: scaled to the exact area, second moments are right to their fourth order, 1e-6."""
    for section, inner in ((Circle(0.01), 0.0), (Tube(0.02, 0.002), 0.016)):
        of = moments(section.basis())
        exact = math.pi / 64 * (section.diameter**4 - inner**4)
        assert 4 * of.area == pytest.approx(math.pi / 4 * (section.diameter**2 - inner**2), rel=1e-12)
        assert 4 * of.through == pytest.approx(exact, rel=1e-6)
        assert 4 * of.across == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize(("width", "thickness"), [(20, 4), (6, 6)], ids=["strip", "square"])
def test_a_section_may_be_a_mesh(width, thickness, tmp_path):
    """Off centre, in millimetres, as triangles: the modes of the rectangle to the triangles' own 0.05 %.

    Of the square every mode comes twice, all but, since its triangles are not symmetric; one has all the bending.
    """
    pytest.importorskip("meshio")
    from skfem import MeshTri

    MeshTri.init_tensor(np.linspace(0, width, 5), np.linspace(0, thickness, 3)).save(tmp_path / "section.msh")
    mesh, exact = (
        beam_modes(Beam(0.1, section, steel(), ("clamped", "free")), PointMass(0.01, 0.1), highest=2)
        for section in (MeshedSection(tmp_path / "section.msh", 1e-3), Rectangle(1e-3 * width, 1e-3 * thickness))
    )
    np.testing.assert_allclose(mesh.frequency, exact.frequency, rtol=5e-4)
    np.testing.assert_allclose(mesh.amplitude, exact.amplitude, rtol=5e-4)


def test_a_section_that_stands_askew_is_refused(tmp_path):
    pytest.importorskip("meshio")
    from skfem import MeshQuad

    turn = np.array([[math.cos(0.3), -math.sin(0.3)], [math.sin(0.3), math.cos(0.3)]])
    mesh = MeshQuad.init_tensor(np.linspace(0, 20, 3), np.linspace(0, 4, 3))
    MeshQuad(turn @ mesh.p, mesh.t).save(tmp_path / "section.msh")
    with pytest.raises(ValueError, match=r"principal axes are turned by 17\.2 degrees"):
        MeshedSection(tmp_path / "section.msh", 1e-3).basis()


def test_a_damper_may_sit_at_the_free_end_of_a_thin_beam():
    """Cantilever with a tip mass M >> its own: f = sqrt(3 EI / L^3 / (M + 0.2357 m)) / (2 pi); 0.5 %."""
    beam = Beam(LENGTH, Rectangle(WIDTH, 0.0006), steel(0.0), ("clamped", "free"))
    stiffness = 3 * 210e9 * WIDTH * 0.0006**3 / 12 / LENGTH**3
    expected = math.sqrt(stiffness / (1.0 + 0.2357 * 7800 * WIDTH * 0.0006 * LENGTH)) / (2 * math.pi)
    assert beam_modes(beam, PointMass(1.0, LENGTH), highest=1).frequency[0] == pytest.approx(expected, rel=5e-3)


def test_modes_are_found_by_shape():
    """A square-ish section puts lateral modes between: those picked still have 0, 1, 2 ... nodes inside."""
    modes = beam_modes(Beam(LENGTH, Rectangle(0.006, 0.004), steel()), PointMass(0.2, 0.29), highest=4)
    for number, shape in zip(modes.number, modes.shape[:, :, 2], strict=True):
        inside = shape[np.abs(shape) > 0.02 * np.abs(shape).max()]
        assert np.sum(np.diff(np.sign(inside)) != 0) == number - 1


def test_the_damper_may_sit_anywhere():
    """Moved along the beam its mass moves, too: mirrored places give the same modes, 1e-6 for the solver."""
    beam = Beam(0.2, Rectangle(WIDTH, THICKNESS), steel())
    left, right = (beam_modes(beam, PointMass(0.1, x), highest=2) for x in (0.07, 0.13))
    np.testing.assert_allclose(left.frequency, right.frequency, rtol=1e-6)
    np.testing.assert_allclose(left.amplitude, right.amplitude, rtol=1e-6)
    with pytest.raises(ValueError, match=r"beyond the ends of the beam, 0 and 0\.2 m"):
        beam_modes(beam, PointMass(0.1, 0.3), highest=2)


def test_graded_stations_hold_every_point_and_never_jump():
    stations = graded([0.0, 0.1, 0.58], 0.0005, 0.006)
    assert {0.0, 0.1, 0.58} <= set(stations.tolist())
    lengths = np.diff(stations)
    assert lengths.min() > 0
    assert lengths.max() < 0.0061
    assert np.max(np.abs(np.diff(np.log(lengths)))) < math.log(1.5)
