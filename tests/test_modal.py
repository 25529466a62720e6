"""Modes against beam theory, and the chain of eqs 4-11."""

import math

import numpy as np
import pytest

from warpdamp import Drive, Material
from warpdamp.ledger import maximum_energy
from warpdamp.modal.damping import damping_ratio, normalised_damping
from warpdamp.modal.fem import Beam, beam_modes, graded

TIMOSHENKO = {  # clamped steel beam 580 x 20 x 4 mm with a central mass: f [Hz], phi [kg^-0.5] of modes 1, 3, 5
    0.0: ((40.742, 1.7201), (281.12, 0.8300), (729.88, 0.5963)),
    0.0239985: ((39.367, 1.6627), (278.97, 0.7692), (727.03, 0.5458)),
}


def paper_beam(poissons_ratio=0.3, **change):
    steel = Material(density=7800, youngs_modulus=210e9, poissons_ratio=poissons_ratio)
    given = {"length": 0.58, "width": 0.02, "thickness": 0.004, "material": steel, "mass_position": 0.29, "mass": 0.2}
    return Beam(**(given | change))


@pytest.mark.parametrize("particles", TIMOSHENKO)
def test_the_papers_beam_agrees_with_beam_theory(particles):
    """0.5 %: the clamps stop Poisson's contraction, which beam theory leaves out."""
    modes = beam_modes(paper_beam(), particle_mass=particles).pick([1, 3, 5])
    for f, phi, (expected_f, expected_phi) in zip(modes.frequency, modes.amplitude, TIMOSHENKO[particles], strict=True):
        assert f == pytest.approx(expected_f, rel=5e-3)
        assert phi == pytest.approx(expected_phi, rel=5e-3)


def test_without_poissons_effect_it_agrees_closely():
    modes = beam_modes(paper_beam(0.0), particle_mass=0.0239985).pick([1, 3, 5])
    expected = np.array(TIMOSHENKO[0.0239985])
    np.testing.assert_allclose(modes.frequency, expected[:, 0], rtol=2e-3)
    np.testing.assert_allclose(modes.amplitude, expected[:, 1], rtol=2e-3)


def test_a_cantilever_agrees_with_euler_and_bernoulli():
    """f = 1.8751^2 sqrt(EI / rho A) / (2 pi L^2) for a slender cantilever, a tip mass of nothing; 0.5 %."""
    beam = paper_beam(0.0, supports=("clamped", "free"), mass=0.0)
    first = beam_modes(beam, highest=2)
    radius = 0.004 / math.sqrt(12)
    for k, root in enumerate((1.87510407, 4.69409113)):
        expected = root**2 * math.sqrt(210e9 / 7800) * radius / (2 * math.pi * 0.58**2)
        assert first.frequency[k] == pytest.approx(expected, rel=5e-3)


def test_a_damper_may_sit_at_the_free_end_of_a_thin_beam():
    """Cantilever with a tip mass M >> its own: f = sqrt(3 EI / L^3 / (M + 0.2357 m)) / (2 pi); 0.5 %."""
    beam = paper_beam(0.0, supports=("clamped", "free"), mass_position=0.58, thickness=0.0006, mass=1.0)
    stiffness = 3 * 210e9 * 0.02 * 0.0006**3 / 12 / 0.58**3
    expected = math.sqrt(stiffness / (1.0 + 0.2357 * 7800 * 0.02 * 0.0006 * 0.58)) / (2 * math.pi)
    assert beam_modes(beam, highest=1).frequency[0] == pytest.approx(expected, rel=5e-3)


def test_modes_are_found_by_shape():
    """A square-ish section puts lateral modes between: those picked still have 0, 1, 2 ... nodes inside."""
    modes = beam_modes(paper_beam(width=0.006), highest=4)
    for number, shape in zip(modes.number, modes.shape, strict=True):
        inside = shape[np.abs(shape) > 0.02 * np.abs(shape).max()]
        assert np.sum(np.diff(np.sign(inside)) != 0) == number - 1


def test_modes_that_cannot_be_had_are_refused():
    modes = beam_modes(paper_beam(), highest=2)
    with pytest.raises(ValueError, match="no mode 7: choose from 1, 2"):
        modes.pick([7])
    with pytest.raises(ValueError, match="node where the damper sits"):
        modes.pick([2])


def test_graded_stations_hold_every_point_and_never_jump():
    stations = graded([0.0, 0.1, 0.58], 0.0005, 0.006)
    assert {0.0, 0.1, 0.58} <= set(stations.tolist())
    lengths = np.diff(stations)
    assert lengths.min() > 0
    assert lengths.max() < 0.0061
    assert np.max(np.abs(np.diff(np.log(lengths)))) < math.log(1.5)


@pytest.mark.parametrize(("f", "phi"), [(39.367, 1.6627), (727.03, 0.5458)])
def test_the_chain_is_an_identity(f, phi):
    """Eps = 1 gives zeta = (2 / pi) m phi^2 exactly, at any Gamma."""
    mass = 0.0239985
    for gamma in (0.5, 14.0):
        drive = Drive(f, gamma * 9.81)
        zeta = damping_ratio(maximum_energy(drive, mass), drive.displacement, phi, f)
        assert zeta == pytest.approx(2 / math.pi * mass * phi**2, rel=1e-12)


def test_the_papers_largest_damping_ratios():
    """0.0423, 0.00903 and 0.00455 for eps = 1 in modes 1, 3 and 5."""
    phi = np.array([p for _, p in TIMOSHENKO[0.0239985]])
    np.testing.assert_allclose(2 / math.pi * 0.0239985 * phi**2, [0.0423, 0.00903, 0.00455], rtol=3e-3)


def test_normalised_damping_has_no_unit():
    """Eq. 19 with the square on the speed alone: twice eps times four times the particles' share of the mass."""
    drive = Drive(60.0, 30.0)
    energy = 0.5 * maximum_energy(drive, 0.024)
    assert normalised_damping(energy, drive.speed, 0.224) == pytest.approx(0.5 * 8 * 0.024 / 0.224)
