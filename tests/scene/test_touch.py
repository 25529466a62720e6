"""Where spheroids touch, on the host: against closed forms and many directions."""

import math

import numpy as np
import pytest

from warpdamp import Cylinder, State
from warpdamp.scene.shape import bodies_of
from warpdamp.scene.spheres import Spheres
from warpdamp.scene.spheroids import Spheroids, dot
from warpdamp.scene.touch import pair_overlaps, wall_overlaps


def unit(rng, n):
    vectors = rng.normal(size=(n, 3))
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def random_pairs(rng, n):
    """Pairs of any shapes and sizes near each other, and the vectors between their centres."""
    one, other = (Spheroids(unit(rng, n), *rng.uniform(0.4, 2.0, (2, n))) for _ in range(2))
    direction = unit(rng, n)
    near = (one.height(direction) + other.height(direction)) * rng.uniform(0.75, 1.1, n)
    return near[:, None] * direction, one, other


def test_no_direction_has_a_larger_gap_than_the_common_normal():
    rng = np.random.default_rng(1)
    apart, one, other = random_pairs(rng, 300)
    normal, gap = one.common_normal(apart, other)
    assert np.allclose(np.linalg.norm(normal, axis=1), 1, atol=1e-14)
    for direction in unit(rng, 2000):
        n = np.tile(direction, (len(gap), 1))
        assert np.all(dot(n, apart) - one.height(n) - other.height(n) <= gap + 1e-12)


def test_surface_points_lie_on_one_line_along_the_normal():
    """x_i - s_i and x_j + s_j are the gap apart, along n."""
    apart, one, other = random_pairs(np.random.default_rng(2), 300)
    normal, gap = one.common_normal(apart, other)
    between = apart - one.point(normal) - other.point(normal)
    assert np.allclose(between, gap[:, None] * normal, atol=1e-10)


def test_exchange_and_opposite_axes():
    apart, one, other = random_pairs(np.random.default_rng(3), 300)
    normal, gap = one.common_normal(apart, other)
    back, same = other.common_normal(-apart, Spheroids(-one.axis, one.along, one.across))
    assert np.allclose(back, -normal, atol=1e-10)
    assert np.allclose(same, gap, atol=1e-12)


def test_a_pair_that_is_apart_is_known_by_any_normal():
    apart, one, other = random_pairs(np.random.default_rng(4), 300)
    _, gap = one.common_normal(apart, other)
    _, some = one.common_normal(apart, other, to_the_end=False)
    assert np.array_equal(some > 0, gap > 0)
    assert np.allclose(some[gap < 0], gap[gap < 0], atol=1e-12)


def test_spheres_and_spheroids_in_a_row_are_exact():
    state = State.at_rest([[0, 0, 0], [1, 2, 2], [0, 0, 9]], [1.0, 1.5, 1.0])
    assert pair_overlaps(state, [[0, 1]]) == pytest.approx(2.5 - 3)
    needles = State.at_rest([[0, 0, 0], [0, 0, 3], [0.5, 0, 0]], 1.0, aspect=2.0)
    a, b = (axis[0] for axis in needles.semi_axes)
    assert pair_overlaps(needles, [[0, 1], [0, 2]]) == pytest.approx([2 * a - 3, 2 * b - 0.5])


def test_centres_that_coincide_overlap():
    state = State.at_rest([[0, 0, 0]] * 2, 1.0, aspect=2.0, axis=[[0, 0, 1], [1, 0, 0]])
    assert pair_overlaps(state, [[0, 1]])[0] >= 2 * 2.0 ** (-1 / 3)


@pytest.mark.parametrize(("axis", "reach"), [([0, 0, 1], "b"), ([1, 0, 0], "a"), ([0, 1, 0], None)])
def test_the_farthest_point_from_the_axis(axis, reach):
    """Upright and radial axes: x + b, x + a.  Tangential: of the ellipse (x + b cos t, a sin t) by brute force."""
    state = State.at_rest([[3.0, 0, 0]], 1.0, aspect=2.0, axis=axis)
    a, b = (float(value[0]) for value in state.semi_axes)
    distance, outward = bodies_of(state).farthest_from_axis(state.position)
    if reach:
        assert distance[0] == pytest.approx(3 + {"a": a, "b": b}[reach], rel=1e-12)
        assert outward[0] == pytest.approx([1, 0, 0], abs=1e-12)
    else:
        t = np.linspace(0, math.pi, 100_001)
        assert distance[0] == pytest.approx(np.max(np.hypot(3 + b * np.cos(t), a * np.sin(t))), rel=1e-9)


def test_overlaps_with_walls():
    state = State.at_rest([[0, 0, 1.0], [0, 0, 5.0]], 1.0, aspect=2.0, axis=[[0, 0, 1], [0.6, 0, 0.8]])
    a, b = (float(value[0]) for value in state.semi_axes)
    height = math.sqrt(0.64 * a**2 + 0.36 * b**2)
    overlaps = wall_overlaps(state, Cylinder(4.0, 6.0, lid=False))
    assert overlaps.keys() == {"side", "floor"}
    assert overlaps["floor"] == pytest.approx([a - 1, height - 5])
    assert overlaps["side"] == pytest.approx([b - 2, math.sqrt(0.36 * a**2 + 0.64 * b**2) - 2])


def test_spheres_are_bodies_like_spheroids_of_aspect_one():
    rng = np.random.default_rng(5)
    position, axis, radius = rng.uniform(-2, 2, (40, 3)), unit(rng, 40), rng.uniform(0.2, 1.0, 40)
    spheres, spheroids = (bodies(axis, radius, radius) for bodies in (Spheres, Spheroids))
    directions, others = unit(rng, 40), np.roll(np.arange(40), 1)
    assert np.allclose(spheres.height(directions), spheroids.height(directions), rtol=1e-14)
    assert np.allclose(spheres.point(directions), spheroids.point(directions), rtol=1e-14)
    apart = position - position[others]
    ours, theirs = (one.common_normal(apart, one[others]) for one in (spheres, spheroids))
    assert np.allclose(ours[0], theirs[0], atol=1e-12)
    assert np.allclose(ours[1], theirs[1], atol=1e-12)
    ours, theirs = (one.farthest_from_axis(position) for one in (spheres, spheroids))
    assert np.allclose(ours[0], theirs[0], atol=1e-12)
    assert np.allclose(ours[1], theirs[1], atol=1e-12)
