"""Nouns of a scene that cannot be are refused where they are made, and not taken for something else."""

import math

import pytest

from warpdamp import Cylinder, Drive, Material, Surface


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: Material(-1.0, 1e9, 0.3), "a positive density"),
        (lambda: Material(920.0, 0.0, 0.3), "positive density and modulus"),
        (lambda: Material(920.0, 1e9, 0.5), "a Poisson's ratio from -1 to 0.5"),
        (lambda: Surface(1.2, 0.3), "a restitution from 0 to 1"),  # its dashpot would be that of an elastic contact
        (lambda: Surface(0.5, -0.3), "frictions that are not negative"),
        (lambda: Surface(0.5, 0.3, -0.1), "frictions that are not negative"),
        (lambda: Surface(math.nan, 0.3), "a restitution from 0 to 1"),
        (lambda: Cylinder(0.04, -0.04), "a positive diameter and height"),
        (lambda: Drive(0.0, 1.0), "a positive frequency"),
        (lambda: Drive(40.0, -1.0), "an amplitude that is not negative"),
        (lambda: Drive(40.0, 1.0, (0.0, 0.0, 0.0)), "a direction of length 1"),
    ],
)
def test_what_cannot_be_is_refused(made, message):
    with pytest.raises(ValueError, match=message):
        made()


def test_the_limits_themselves_are_taken():
    for surface in (Surface(0.0, 0.0), Surface(1.0, 5.0, 1.0)):
        assert 0 <= surface.restitution <= 1
    assert Material(1.0, 1.0, -0.5).shear_modulus == 1.0
    assert Drive(1e-3, 0.0).speed == 0.0
