"""Shapes: semi-axes, inertia, curvature, and what a cavity allows; states of spheroids and their files."""

import math

import numpy as np
import pytest

from warpdamp.scene.aspect import (
    allowed_aspects,
    flattest_radius,
    semi_axes,
    spheroid_inertia,
    too_flat_or_long,
    two_ends_at_the_side,
)
from warpdamp.scene.particles import ContactHistory, Grains, State
from warpdamp.scene.shape import SPHEROIDS, aspects
from warpdamp.scene.sphere import inverse_sphere_inertia, sphere_volume

ASPECTS = np.array([0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 2.5, 4.0])


def test_spheroids_keep_the_volume_of_the_sphere():
    a, b = semi_axes(3.73e-3, ASPECTS)
    assert np.allclose(a * b**2, 3.73e-3**3, rtol=1e-14)
    assert np.allclose(a / b, ASPECTS, rtol=1e-14)


def test_inertia_is_the_integral_over_the_volume():
    """I_a = int (x^2 + y^2) dm, I_t = int (y^2 + z^2) dm, by Gauss-Legendre over discs across the axis."""
    nodes, weights = np.polynomial.legendre.leggauss(3)  # exact: polynomials of degree 4
    for aspect in ASPECTS:
        a, b = semi_axes(2.0, aspect)
        z, disc = a * nodes, b**2 * (1 - nodes**2)  # heights of the discs, squares of their radii
        dm = math.pi * disc * a * weights  # density 1
        transverse, axial = spheroid_inertia(float(sphere_volume(2.0)), 2.0, aspect)
        assert axial == pytest.approx(np.sum(dm * disc / 2), rel=1e-13)
        assert transverse == pytest.approx(np.sum(dm * (disc / 4 + z**2)), rel=1e-13)
    assert spheroid_inertia(2.0, 0.3, 1.0) == pytest.approx((1 / inverse_sphere_inertia(2.0, 0.3),) * 2)


def test_flattest_radius_is_that_of_the_curve():
    """Of the ellipse (b cos t, a sin t) in a plane through the axis: (b^2 sin^2 t + a^2 cos^2 t)^(3/2) / (a b)."""
    t = np.linspace(0, math.pi / 2, 1001)
    for aspect in ASPECTS:
        a, b = semi_axes(1.0, aspect)
        meridian = (b**2 * np.sin(t) ** 2 + a**2 * np.cos(t) ** 2) ** 1.5 / (a * b)
        assert flattest_radius(1.0, aspect) == pytest.approx(max(meridian), rel=1e-12)


def test_what_the_cavity_allows():
    low, high = allowed_aspects(3.73e-3, 0.02)
    assert (low, high) == pytest.approx((0.2837, 2.739), rel=1e-3)
    for limit in (low, high):
        assert flattest_radius(3.73e-3, limit) == pytest.approx(0.02, rel=1e-12)
    assert not two_ends_at_the_side([3.73e-3] * 3, [1.01 * low, 1.0, 0.99 * high], 0.02)
    assert "above 0.284 and below 2.739" in two_ends_at_the_side([3.73e-3] * 3, [1.0, 0.99 * low, 2.0], 0.02)
    assert "aspect 3 might" in two_ends_at_the_side([3.73e-3], [3.0], 0.02)
    assert not two_ends_at_the_side([0.03], [1.0], 0.02)  # of spheres it says nothing


def test_shapes_whose_normals_may_be_missed():
    assert not too_flat_or_long([0.25, 1.0, 4.0])
    assert "from 0.25 to 4, not at 5:" in too_flat_or_long([1.0, 5.0, 0.1])
    assert "not at 0.2:" in too_flat_or_long(0.2)


def test_states_without_shape_are_spheres():
    state = State.at_rest([[0, 0, 1], [0, 0, 3]], [0.5, 0.7])
    assert np.array_equal(state.aspect, [1, 1])
    assert np.array_equal(state.axis, [[0, 0, 1]] * 2)
    assert np.array_equal(state.bounding_radius, state.radius)
    assert Grains.alike(0.5, 2).aspect == ()
    assert np.array_equal(aspects(Grains.alike(0.5, 2)), [1, 1])
    assert np.array_equal(aspects(Grains.alike(0.5, 2, aspect=2.0)), [2, 2])
    assert not {"axis", "aspect", "pair_history_normal", "wall_history_arm"} & state.arrays().keys()


def test_bounds():
    state = State.at_rest([[0, 0, 1]] * 3, 1.0, aspect=[0.5, 1.0, 2.0])
    a, b = state.semi_axes
    assert np.array_equal(state.bounding_radius, [b[0], 1.0, a[2]])
    assert np.array_equal(SPHEROIDS.bounding_radius(1.0, [0.5, 2.0]), [b[0], a[2]])
    assert np.array_equal(SPHEROIDS.inscribed_radius(1.0, [0.5, 2.0]), [a[0], b[2]])


def test_an_axis_that_is_no_unit_vector_is_refused():
    with pytest.raises(ValueError, match="axis of particle 1 has length 2"):
        State.at_rest([[0, 0, 1], [0, 0, 4]], 1.0, aspect=2.0, axis=[[0, 0, 1], [0, 2, 0]])


def test_states_of_spheroids_come_back_from_their_arrays():
    rng = np.random.default_rng(1)
    axis = rng.normal(size=(4, 3))
    state = State.at_rest(rng.random((4, 3)), 0.1, aspect=2.0, axis=axis / np.linalg.norm(axis, axis=1)[:, None])
    state.pairs = np.array([[0, 1], [1, 3]])
    state.pair_history = ContactHistory(*(rng.random(shape) for shape in ((2, 3), 2, (2, 3), (2, 3), (2, 3))))
    again = State.from_arrays(state.arrays())
    for name in ("axis", "aspect", "position", "pairs"):
        assert np.array_equal(getattr(again, name), getattr(state, name))
    for name, array in vars(state.pair_history).items():
        assert np.array_equal(getattr(again.pair_history, name), array)
    assert not again.wall_history.normal.any()
    with pytest.raises(KeyError):
        State.from_arrays({name: array for name, array in state.arrays().items() if name != "pair_history_stretch"})


def test_a_contact_seen_from_the_other_has_the_opposite_normal_and_the_other_arm():
    """A point of contact p: arm_i = p - x_i and arm_j = p - x_j, so arm_j = arm_i + x_i - x_j."""
    x = np.array([[1.0, 2, 3], [2, 0, 5]])
    point, normal = np.array([1.5, 1, 4]), np.array([[-1 / 3, 2 / 3, -2 / 3]])
    history = ContactHistory(np.ones((1, 3)), np.ones(1), np.ones((1, 3)), normal, (point - x[0])[None])
    other = history.seen_from_the_other(np.array([True]), (x[0] - x[1])[None])
    assert np.array_equal(other.normal, -normal)
    assert np.allclose(other.arm, point - x[1])
    back = other.seen_from_the_other(np.array([True]), (x[1] - x[0])[None])
    assert all(np.allclose(a, b) for a, b in zip(vars(back).values(), vars(history).values(), strict=True))
    same = history.seen_from_the_other(np.array([False]), (x[0] - x[1])[None])
    assert np.array_equal(same.arm, history.arm)
    assert np.array_equal(same.normal, normal)
