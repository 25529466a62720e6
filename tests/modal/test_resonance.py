"""A mode with dampers on it: the same as one damper's complex modes, closed forms, and where nothing is known."""

import numpy as np
import pytest

from warpdamp.errors import ModalError
from warpdamp.modal.apparent_mass import ComplexMass
from warpdamp.modal.frf import ModalModel
from warpdamp.modal.resonance import LoadedMode

GAMMA = np.array([0.5, 1.0, 2.0, 4.0])


def felt(scale: float = 1.0, band=None) -> ComplexMass:
    """Complex mass that changes with Gamma and frequency [kg]."""
    mass = scale * np.array([0.02 - 0.001j, 0.018 - 0.004j, 0.01 - 0.012j, 0.006 - 0.008j])
    return ComplexMass(np.array([30.0, 50.0]), GAMMA, np.array([mass, 0.8 * mass]), of_modes=False, band=band)


def test_one_damper_is_that_of_the_complex_modes():
    mode = LoadedMode(40.0, 0.002, np.array([1.5]), [felt()])
    model = ModalModel(np.array([40.0]), np.array([1.5]), np.array([0.002]), 0.0)
    frequency, damping = mode.at(GAMMA)
    for k, gamma in enumerate(GAMMA):
        expected = model.resonances(felt(), gamma)
        assert frequency[k] == pytest.approx(expected[0][0], rel=1e-9)
        assert damping[k] == pytest.approx(expected[1][0], rel=1e-9)


def test_two_like_dampers_are_one_of_twice_the_mass_whatever_the_sign():
    two = LoadedMode(40.0, 0.002, np.array([1.5, -1.5]), [felt(), felt()])
    one = LoadedMode(40.0, 0.002, np.array([1.5]), [felt(2.0)])
    np.testing.assert_allclose(two.at(GAMMA), one.at(GAMMA), rtol=1e-12)


def test_each_damper_is_at_the_gamma_of_its_own_place():
    """At half the shape: the mass at half of Gamma, and a quarter of it counts."""
    mode = LoadedMode(40.0, 0.0, np.array([2.0, 1.0]), [felt(), felt()])
    frequency, damping = mode.at(2.0)
    masses = felt()(float(frequency), [2.0, 1.0])
    square = 40**2 / (1 + 4 * masses[0] + masses[1])
    assert float(frequency) == pytest.approx(np.sqrt(square.real), rel=1e-9)
    assert float(damping) == pytest.approx(square.imag / square.real / 2, rel=1e-9)


def test_nothing_is_extrapolated():
    mode = LoadedMode(40.0, 0.0, np.array([2.0, 1.0]), [felt(), felt()])
    assert np.isfinite(mode.at([0.9, 1.0, 4.0, 4.1, np.nan])).tolist() == [[False, True, True, False, False]] * 2
    on_node = LoadedMode(40.0, 0.0, np.array([2.0, 0.0]), [felt(), felt()])
    alone = LoadedMode(40.0, 0.0, np.array([2.0]), [felt()])
    np.testing.assert_array_equal(on_node.at(GAMMA), alone.at(GAMMA))
    with pytest.raises(ModalError, match="outside the range of the card, 45 to 50 Hz"):
        LoadedMode(40.0, 0.0, np.array([2.0]), [felt(band=(45.0, 50.0))]).at(1.0)
