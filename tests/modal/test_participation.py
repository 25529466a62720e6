"""Participation factors of modes on a base that moves."""

import numpy as np
import pytest

from warpdamp.modal.beam import Beam, PointMass, beam_modes
from warpdamp.modal.section import Rectangle
from warpdamp.modes import Modes
from warpdamp.scene.scene import Material

STEEL = Material(7800, 210e9, 0.3)
BEAM = Beam(0.58, Rectangle(0.02, 0.004), STEEL)
BARE = STEEL.density * 0.58 * 0.02 * 0.004


def test_effective_masses_of_a_clamped_beam():
    """Euler's beam: 69.0, 13.2 and 5.4 % of its mass in modes 1, 3 and 5, none in 2; 1 % for shear and clamps in 3D."""
    modes = beam_modes(BEAM, PointMass(0.0, 0.29), highest=5)
    part = modes.participation[:, 2] ** 2 / BARE
    np.testing.assert_allclose(part[[0, 2, 4]], [0.690, 0.132, 0.0537], rtol=0.01)
    assert part[[1, 3]].max() < 1e-12
    assert np.abs(modes.participation[:, :2]).max() == 0


def test_a_rigid_motion_is_made_of_the_modes():
    """Sum phi Gamma = 1 at the damper as modes are added, from one side and the other."""
    modes = beam_modes(BEAM, PointMass(0.2, 0.29), highest=9)
    part = np.cumsum(modes.amplitude * modes.participation[:, 2])
    assert abs(part[-1] - 1) < abs(part[0] - 1) < 0.15
    assert part[-1] == pytest.approx(1, abs=0.02)


def test_a_mass_at_the_damper_takes_its_part():
    """Modes modified by a mass of 30 g, against modes computed with it."""
    light, heavy = (beam_modes(BEAM, PointMass(mass, 0.29), highest=9) for mass in (0.2, 0.23))
    np.testing.assert_allclose(light.with_mass(0.03).participation[[0, 2]], heavy.participation[[0, 2]], atol=1e-4)


def test_signs_follow_the_shapes():
    modes = Modes(
        number=np.array([1]),
        frequency=np.array([10.0]),
        point=np.zeros((2, 3)),
        shape=np.array([[[0, 0, 1.0], [0, 0, -2.0]]]),
        inherent_damping=np.zeros(1),
        participation=np.array([[0.0, 0.0, 0.5]]),
    )
    assert modes.seen_from(1, (0, 0, 1)).participation[0, 2] == -0.5
    assert modes.pick([1]).participation[0, 2] == 0.5
