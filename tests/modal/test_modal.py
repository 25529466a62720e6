"""Modes as a damper sees them, and the chain of eqs 4-11 to modal damping."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from warpdamp import Drive
from warpdamp.engine.ledger import maximum_energy
from warpdamp.modal.damping import damping_ratio, normalised_damping, several_dampers
from warpdamp.modes import Modes

MASS = 0.024


def pinned_string(count=6, mass=2.0, points=201):
    """Modes sqrt(2 / M) sin(k pi x / L) of a pinned uniform beam of mass M and length 1, f_k = 10 k^2 Hz."""
    k, x = np.arange(1, count + 1), np.linspace(0, 1, points)
    shape = np.zeros((count, points, 3))
    shape[:, :, 2] = math.sqrt(2 / mass) * np.sin(math.pi * np.outer(k, x))
    return Modes(k, 10.0 * k**2, np.stack([x, 0 * x, 0 * x], 1), shape, 0.001 * k)


def test_a_damper_sees_the_modes_from_its_own_point():
    modes = pinned_string().at((0.25, 0, 0))
    np.testing.assert_allclose(modes.amplitude, np.abs(np.sin(np.pi / 4 * np.arange(1, 7))), atol=1e-12)
    np.testing.assert_allclose(modes.modal_mass[:2], [2.0, 1.0])
    across = modes.at((0.5, 0, 0), (0.0, 3.0, 4.0))
    assert across.amplitude[0] == pytest.approx(0.8)


def test_modes_that_cannot_be_had_are_refused():
    modes = pinned_string(3).at((0.5, 0, 0))
    with pytest.raises(ValueError, match="no mode 7: choose from 1, 2, 3"):
        modes.pick([7])
    with pytest.raises(ValueError, match="mode 2 has a node where the damper sits"):
        modes.pick([1, 2])
    with pytest.raises(ValueError, match="there is no node 12"):
        modes.at_label(12)
    picked = modes.pick([3, 1])
    assert list(picked.number) == [3, 1]
    np.testing.assert_allclose(picked.inherent_damping, [0.003, 0.001])


def test_a_mass_is_added_in_the_space_of_the_modes():
    """A central mass m on the pinned beam: 1 = m w^2 sum_k phi_k^2 / (w_k^2 - w^2), the same modes summed; 1e-9."""
    modes = pinned_string(40).at((0.5, 0, 0))
    loaded = modes.with_mass(0.7)
    squares = (2 * np.pi * modes.frequency) ** 2
    for f in loaded.pick([1, 3, 5]).frequency:
        w2 = (2 * np.pi * f) ** 2
        assert 0.7 * np.sum(w2 * modes.amplitude**2 / (squares - w2)) == pytest.approx(1.0, rel=1e-9)
    np.testing.assert_allclose(loaded.frequency[1::2], modes.frequency[1::2], rtol=1e-9)  # those with a node there
    # mass-normalised with the mass in: its own share, and that of the beam, add up to one
    beam = np.trapezoid(2.0 * loaded.shape[:, :, 2] ** 2, modes.point[:, 0], axis=1)
    np.testing.assert_allclose((beam + 0.7 * loaded.amplitude**2)[:9], 1.0, rtol=1e-6)


def test_added_mass_leaves_the_dashpots_as_they_are():
    """One mode: c = 2 zeta w stays, so zeta w / (1 + m phi^2) = zeta' w'; exact."""
    one = replace(pinned_string(1), damper=100)
    loaded = one.with_mass(0.5)
    factor = 1 + 0.5 * one.amplitude[0] ** 2
    assert loaded.frequency[0] == pytest.approx(10 / math.sqrt(factor), rel=1e-12)
    assert loaded.inherent_damping[0] == pytest.approx(0.001 / math.sqrt(factor), rel=1e-12)


def study(modes, effectiveness, gamma=(0.0, 1.0, 2.0, 4.0, 8.0)):
    """A made-up study at the modes' frequencies: its effectiveness is a function of Gamma."""
    gamma = np.array(gamma)
    omega = 2 * np.pi * modes.frequency[:, None]
    energy = effectiveness(gamma) * 4 * (gamma * 9.81 / omega) ** 2 * MASS
    two = energy[..., None] * np.array([0.9, 1.1])  # two seeds
    data = xr.Dataset(
        {
            "energy_dissipated": (("frequency", "gamma", "seed"), two),
            "energy_dissipated_standard_error": (("frequency", "gamma", "seed"), 0.02 * two),
            "displacement": (("frequency", "gamma"), gamma * 9.81 / omega**2),
        },
        {"frequency": modes.frequency, "gamma": gamma, "seed": [1, 2]},
    )
    return data.isel(gamma=slice(1, None))


def alone(modes, effectiveness, gamma):
    """zeta = (2 / pi) eps m phi^2 of one damper."""
    return 2 / math.pi * MASS * modes.amplitude[:, None] ** 2 * effectiveness(gamma)


def constant(gamma):
    return 0.5 + 0 * gamma


def rising(gamma):
    return 0.1 * gamma  # a straight line, which interpolation between Gammas meets exactly


def test_two_dampers_at_one_point_damp_twice():
    modes = pinned_string(3).at((0.3, 0, 0))
    both = several_dampers(study(modes, rising), [modes, modes])
    expected = 2 * alone(modes, rising, both["gamma"].values) + modes.inherent_damping[:, None]
    np.testing.assert_allclose(both["damping_ratio"].transpose("mode", "gamma"), expected, rtol=1e-12)


def test_dampers_at_mirrored_points_damp_alike():
    left, right = (pinned_string(3).at((x, 0, 0)) for x in (0.3, 0.7))
    share = several_dampers(study(left, rising), [left, right])["damper_share"]
    np.testing.assert_allclose(share.isel(damper=0), share.isel(damper=1), rtol=1e-12)


def test_two_dampers_are_the_sum_where_they_must_be():
    """Constant effectiveness: what each adds is its own, however hard it is shaken."""
    here, there = (pinned_string(3).at((x, 0, 0)) for x in (0.5, 0.25))
    here, there = here.pick([1, 3]), there.pick([1, 3])
    both = several_dampers(study(here, constant), [here, there])["damping_ratio"]
    gamma = np.array([2.0, 4.0, 8.0])
    expected = alone(here, constant, gamma) + alone(there, constant, gamma) + here.inherent_damping[:, None]
    np.testing.assert_allclose(both.sel(gamma=gamma).transpose("mode", "gamma"), expected, rtol=1e-12)


def test_each_damper_is_shaken_as_hard_as_its_place_moves():
    """Effectiveness a Gamma: zeta = (2 / pi) m a Gamma (phi_1^2 + |phi_2|^3 / phi_1)."""
    here, there = (pinned_string(1).at((x, 0, 0)) for x in (0.5, 0.25))
    both = several_dampers(study(here, rising), [here, there])["damping_ratio"].sel(mode=1)
    phi, other = here.amplitude[0], there.amplitude[0]
    expected = 2 / math.pi * MASS * 0.1 * both["gamma"] * (phi**2 + other**3 / phi) + 0.001
    np.testing.assert_allclose(both.sel(gamma=[2, 4, 8]), expected.sel(gamma=[2, 4, 8]), rtol=1e-12)
    assert np.isnan(both.sel(gamma=1))  # the other damper is at 0.71 there, below what was run


def test_a_damper_on_a_node_adds_nothing():
    here, node = (pinned_string(2).at((x, 0, 0)) for x in (0.25, 0.5))
    both = several_dampers(study(here, rising), [here, node])
    assert (both["damper_share"].sel(mode=2).isel(damper=1) == 0).all()
    with pytest.raises(ValueError, match="mode 2 has a node at the reference damper"):
        several_dampers(study(here, rising), [here, node], reference=1)


def test_different_dampers_bring_a_study_each():
    modes = pinned_string(1).at((0.5, 0, 0))
    both = several_dampers([study(modes, rising), study(modes, constant)], [modes, modes])
    gamma = both["gamma"].values
    expected = alone(modes, rising, gamma) + alone(modes, constant, gamma) + 0.001
    np.testing.assert_allclose(both["damping_ratio"], expected, rtol=1e-12)
    # two seeds 10 % off their mean either way, which is more than their own 2 %; added: equal dampers share their beds
    error = 0.1 * (expected - 0.001)
    np.testing.assert_allclose(both["damping_ratio_standard_error"], error, rtol=1e-12)


def test_a_study_at_other_frequencies_is_refused():
    modes = pinned_string(2).at((0.3, 0, 0))
    other = replace(modes, frequency=modes.frequency * 1.05)
    with pytest.raises(ValueError, match=r"run at 10, 40 Hz, the modes lie at 10\.5, 42 Hz: run it with"):
        several_dampers(study(modes, rising), [other, other])


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
    phi = np.array([1.6627, 0.7692, 0.5458])
    np.testing.assert_allclose(2 / math.pi * 0.0239985 * phi**2, [0.0423, 0.00903, 0.00455], rtol=3e-3)


def test_normalised_damping_has_no_unit():
    """Eq. 19 with the square on the speed alone: twice eps times four times the particles' share of the mass."""
    drive = Drive(60.0, 30.0)
    energy = 0.5 * maximum_energy(drive, 0.024)
    assert normalised_damping(energy, drive.speed, 0.224) == pytest.approx(0.5 * 8 * 0.024 / 0.224)
