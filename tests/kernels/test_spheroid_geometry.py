"""Contacts of spheroids one at a time: common normals, elliptical Hertz, and forces as the gradient of the energy."""

import dataclasses
import math

import numpy as np
import pytest
import warp as wp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from warpdamp import Effects, State
from warpdamp.kernels.contact import contact_law
from warpdamp.kernels.options import UNIQUE
from warpdamp.kernels.shape import shape
from warpdamp.kernels.structs import FLOOR, LID, SIDE, types
from warpdamp.kernels.tops import tops
from warpdamp.scene.aspect import LEAST_ASPECT, MOST_ASPECT
from warpdamp.scene.touch import pair_overlaps

effects = Effects(spheroids=True, sizes=True)
t = types(effects)
Case, Particle, Law, History = t.Case, t.Particle, t.Law, t.History
geometry = shape(effects)
pair_touch, pair_touch_back, pair_loads = geometry.pair_touch, geometry.pair_touch_back, geometry.pair_loads
wall_touch_back, wall_loads = geometry.wall_touch_back, geometry.wall_loads
turn, rotational_energy = tops(effects).turn, tops(effects).rotational_energy
_, _, elastic_energy, _ = contact_law(effects)

CAVITY = 20.0
MODULUS = 1.0
LAW = wp.constant(MODULUS)


@wp.struct
class Found:
    """What a contact is: geometry and loads without friction, each from the shape's own functions."""

    overlap: wp.float64
    normal: wp.vec3d
    energy: wp.float64
    radius: wp.float64
    mass: wp.float64
    force: wp.vec3d
    torque_i: wp.vec3d
    torque_j: wp.vec3d
    place_i: wp.vec3d
    again: wp.vec3d  # the normal found from one nearby


@wp.func
def found_of(law: Law, touch: t.Touch):
    found = Found()
    found.overlap = touch.overlap
    found.normal = touch.normal
    found.radius = touch.radius
    found.mass = touch.mass
    found.place_i = touch.place_i
    if touch.overlap > wp.float64(0.0):
        found.energy = elastic_energy(law, touch)
    return found


@wp.kernel(**UNIQUE)
def pairs(c: Case, law: Law, p: wp.array(dtype=Particle), nearby: wp.array(dtype=wp.vec3d), out: wp.array(dtype=Found)):
    n = wp.tid()
    i = 2 * n
    j = i + 1
    touch = pair_touch_back(c, p, i, j, p[i].position, wp.float64(0.0))
    found = found_of(law, touch)
    normal_force = wp.vec3d()
    if touch.overlap > wp.float64(0.0):
        normal_force = (wp.float64(2.5) * found.energy / touch.overlap) * touch.normal
    force, on_i, on_j = pair_loads(touch, law, normal_force, wp.vec3d())
    found.force = force
    found.torque_i = on_i
    found.torque_j = on_j
    old = History()
    old.normal = nearby[n]
    found.again = pair_touch(c, p, i, j, old).normal
    out[n] = found


@wp.kernel(**UNIQUE)
def walls(c: Case, law: Law, p: wp.array(dtype=Particle), wall: wp.array(dtype=wp.int32), out: wp.array(dtype=Found)):
    i = wp.tid()
    touch = wall_touch_back(c, p, i, wall[i], p[i].position, wp.float64(0.0))
    found = found_of(law, touch)
    normal_force = wp.vec3d()
    if touch.overlap > wp.float64(0.0):
        normal_force = (wp.float64(2.5) * found.energy / touch.overlap) * touch.normal
    force, on_i = wall_loads(touch, law, normal_force, wp.vec3d())
    found.force = force
    found.torque_i = on_i
    out[i] = found


@wp.kernel(**UNIQUE)
def spinning(c: Case, pull: wp.vec3d, steps: int, p: wp.array(dtype=Particle), energy: wp.array(dtype=wp.float64)):
    """A top in the potential pull.u: axis and angular momentum after so many steps, energies at whole ones."""
    half = wp.float64(0.5) * c.dt
    for n in range(steps):
        h = c.dt
        if n == 0:
            h = half
        p[0].torque = wp.cross(pull, p[0].axis)
        whole = p[0]
        whole_momentum = p[0].half_momentum + (h - half) * p[0].torque
        if n > 0:
            before = p[0].half_momentum
            p[0].half_momentum = whole_momentum
            energy[n] = rotational_energy(c, p, 0) + wp.dot(pull, whole.axis)
            p[0].half_momentum = before
        turn(c, p, 0, h)


def a_case(dt=1.0):
    case = Case()
    case.radius, case.height, case.dt = CAVITY, CAVITY, dt
    return case


def a_law():
    law = Law()
    law.modulus = MODULUS
    return law


def particles(state, mass=None):
    mass = np.ones(len(state)) if mass is None else mass
    values = np.zeros(len(state), Particle.numpy_dtype())
    constants = state.constants(mass)
    for name in values.dtype.names:
        if name in constants:
            values[name] = constants[name]
        elif hasattr(state, name):
            values[name] = getattr(state, name)
    return wp.array(values, dtype=Particle, device="cpu")


def look(state, kernel, second):
    n = len(state) // 2 if kernel is pairs else len(state)
    out = wp.zeros(n, dtype=Found, device="cpu")
    wp.launch(kernel, n, [a_case(), a_law(), particles(state), second, out], device="cpu")
    return out.numpy()


def look_at_pairs(state, nearby=None):
    nearby = np.tile([1.0, 0, 0], (len(state) // 2, 1)) if nearby is None else nearby
    return look(state, pairs, wp.array(nearby, dtype=wp.vec3d, device="cpu"))


def look_at_walls(state, wall):
    return look(state, walls, wp.array(np.full(len(state), wall), dtype=wp.int32, device="cpu"))


def unit_vectors(rng, n):
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def touching_pairs(n, seed, aspects=(0.5, 2.5), depth=0.02):
    """Pairs of different shapes and sizes, each overlapping by ``depth`` of about a radius."""
    rng = np.random.default_rng(seed)
    radius, aspect = rng.uniform(0.5, 1.5, 2 * n), rng.uniform(*aspects, 2 * n)
    axis, direction = unit_vectors(rng, 2 * n), unit_vectors(rng, n)

    def at(distance):
        place = np.zeros((2 * n, 3))
        place[::2] = distance[:, None] * direction
        return State.at_rest(place, radius, aspect=aspect, axis=axis)

    low, high = np.full(n, 0.01), np.full(n, 8.0)
    for _ in range(50):
        middle = (low + high) / 2
        deep = look_at_pairs(at(middle))["overlap"] > depth
        low, high = np.where(deep, middle, low), np.where(deep, high, middle)
    return at(high)


def gap_along(state, n):
    """Gaps of pairs along unit vectors (k, pairs, 3) or (pairs, 3)."""
    a, b = state.semi_axes
    h = np.sqrt(b**2 + (a**2 - b**2) * np.einsum("...ij,ij->...i", np.repeat(n, 2, axis=-2), state.axis) ** 2)
    r = state.position[::2] - state.position[1::2]
    return np.einsum("...ij,ij->...i", n, r) - h[..., ::2] - h[..., 1::2]


def turned(state, k, angle):
    """The state with every particle's axis turned about the k-th axis."""
    z = np.eye(3)[k]
    u = state.axis
    axis = u * math.cos(angle) + np.cross(z, u) * math.sin(angle) + np.outer(u @ z, z) * (1 - math.cos(angle))
    return dataclasses.replace(state, axis=axis)


# ---- common normal ---------------------------------------------------------------------------------------------------


def test_the_common_normal_has_the_largest_gap():
    """Against 2,000 directions each, all over the sphere and close by; one step from nearby finds the same."""
    state = touching_pairs(60, 1)
    rng = np.random.default_rng(2)
    found = look_at_pairs(state)
    anywhere = unit_vectors(rng, 1000 * 60).reshape(1000, 60, 3)
    close = found["normal"] + 0.03 * rng.normal(size=(1000, 60, 3))
    close /= np.linalg.norm(close, axis=-1, keepdims=True)
    for n in (anywhere, close):
        assert np.all(gap_along(state, n).max(axis=0) <= -found["overlap"] + 1e-12)
    np.testing.assert_allclose(gap_along(state, found["normal"]), -found["overlap"], atol=1e-13)

    nearby = found["normal"] + 1e-4 * rng.normal(size=(60, 3))
    nearby /= np.linalg.norm(nearby, axis=-1, keepdims=True)
    again = look_at_pairs(state, nearby)["again"]
    assert np.abs(again - found["normal"]).max() < 1e-6  # the square of 1e-4, times what a curvature makes of it


@pytest.mark.parametrize("aspect", [LEAST_ASPECT, MOST_ASPECT])
def test_no_pair_of_the_flattest_or_longest_shapes_is_mistaken(aspect):
    """Against the steps on the host, which never lead to a smaller gap: the same overlaps, and none where pairs are apart.

    1e-8 of a radius: a normal known to 1e-7 errs by the square of it in the gap.
    """
    n, rng = 20_000, np.random.default_rng(6)
    place = np.zeros((2 * n, 3))
    place[::2] = rng.uniform(0.5, 4.0, (n, 1)) * unit_vectors(rng, n)
    state = State.at_rest(place, 1.0, aspect=aspect, axis=unit_vectors(rng, 2 * n))
    overlap = pair_overlaps(state, np.arange(2 * n).reshape(n, 2))
    found = look_at_pairs(state)["overlap"]
    shallow = (overlap > 0) & (overlap < 0.1)
    assert np.sum(shallow) > 500
    np.testing.assert_allclose(found[shallow], overlap[shallow], atol=1e-8)
    assert np.all(found[overlap < -1e-8] < 0)


def test_it_turns_with_the_pair_and_does_not_know_which_end_is_up():
    state = touching_pairs(60, 3)
    found = look_at_pairs(state)
    swapped = np.arange(120) ^ 1
    other = look_at_pairs(
        State.at_rest(
            state.position[swapped], state.radius[swapped], aspect=state.aspect[swapped], axis=-state.axis[swapped]
        )
    )
    np.testing.assert_allclose(other["overlap"], found["overlap"], rtol=1e-9)
    np.testing.assert_allclose(other["normal"], -found["normal"], atol=1e-7)
    np.testing.assert_allclose(other["force"], -found["force"], atol=1e-7 * np.abs(found["force"]).max())


def test_spheres_are_exact():
    state = touching_pairs(40, 4, aspects=(1.0, 1.0))
    found = look_at_pairs(state)
    r = state.position[::2] - state.position[1::2]
    distance = np.linalg.norm(r, axis=1)
    a, b = state.radius[::2], state.radius[1::2]
    np.testing.assert_allclose(found["overlap"], a + b - distance, rtol=1e-12)
    np.testing.assert_allclose(found["radius"], a * b / (a + b), rtol=1e-12)
    np.testing.assert_allclose(found["normal"], r / distance[:, None], atol=1e-14)
    np.testing.assert_allclose(found["place_i"], -(a / (a + b))[:, None] * r, atol=1e-14)


# ---- elliptical Hertz ------------------------------------------------------------------------------------------------


def hertz(ratio):
    """Force over that of a sphere of radius 1 / sqrt(A B) / 2 at one overlap, curvatures in a ratio; Johnson (1985)."""
    if ratio == 1:
        return 1.0

    def curvatures(y):
        m = 1 - math.exp(-2 * y)
        return (ellipe(m) / (1 - m) - ellipk(m)) / (ellipk(m) - ellipe(m))

    m = 1 - math.exp(-2 * brentq(lambda y: curvatures(y) - ratio, 1e-6, 12))
    stiffness = 2 * math.pi / 3 * math.sqrt((ellipk(m) - ellipe(m)) / m) / ellipk(m) ** 1.5
    return stiffness / (4 / 3 * math.sqrt(1 / (2 * math.sqrt(ratio))))


@pytest.mark.parametrize("aspect", [0.5, 0.7, 1.4, 2.0, 2.5])
def test_a_plane_feels_the_elliptical_contact(aspect):
    """At the tip a sphere of radius b^2 / a; at the side curvatures 1 / b and b / a^2, within the fit's 0.013 %."""
    a, b = aspect ** (2 / 3), aspect ** (-1 / 3)
    for axis, reach, curved in (((0, 0, 1), a, (a / b**2, a / b**2)), ((1, 0, 0), b, (1 / b, b / a**2))):
        found = look_at_walls(State.at_rest([[0, 0, reach - 0.01]], 1.0, aspect=aspect, axis=axis), FLOOR)[0]
        assert found["overlap"] == pytest.approx(0.01, rel=1e-12)
        high, low = max(curved), min(curved)
        expected = 4 / 3 * MODULUS * math.sqrt(1 / math.sqrt(high * low)) * 0.01**1.5 * hertz(high / low)
        assert found["force"][2] == pytest.approx(expected, rel=1.5e-4)
        assert found["force"][2] == pytest.approx(4 / 3 * math.sqrt(found["radius"]) * 0.01**1.5, rel=1e-12)


def test_crossed_cylinders_are_a_sphere():
    """Two prolate bodies side by side, axes crossed at a right angle: both curvatures of the sum are equal."""
    axis = np.array([[1.0, 0, 0], [0, 1.0, 0]])
    a, b = 2.0 ** (2 / 3), 2.0 ** (-1 / 3)
    state = State.at_rest([[0, 0, 2 * b - 0.01], [0, 0, 0]], 1.0, aspect=2.0, axis=axis)
    assert look_at_pairs(state)[0]["radius"] == pytest.approx(1 / (1 / b + b / a**2), rel=1e-12)


# ---- forces are the gradient of the energy ---------------------------------------------------------------------------

STEP = 1e-5


def slopes(energy_at, n):
    """Central differences of energies with each particle's place and turn: (6, n), by ``energy_at(which, k, step)``."""
    return np.array(
        [
            (energy_at(kind, k, STEP) - energy_at(kind, k, -STEP)) / (2 * STEP)
            for kind in ("move", "turn")
            for k in range(3)
        ]
    )


def test_pair_loads_are_the_gradient():
    """1e-7 of the largest: what central differences at 1e-5 leave; and momentum and angular momentum to round-off."""
    state = touching_pairs(50, 5)
    found = look_at_pairs(state)
    for side, torque, sign in ((0, "torque_i", 1), (1, "torque_j", -1)):

        def energy_at(kind, k, step, side=side):
            changed = dataclasses.replace(state, position=state.position.copy(), axis=state.axis.copy())
            if kind == "move":
                changed.position[side::2, k] += step
            else:
                changed.axis[side::2] = turned(state, k, step).axis[side::2]
            return look_at_pairs(changed)["energy"]

        gradient = slopes(energy_at, 50)
        force, turning = sign * found["force"].T, found[torque].T
        np.testing.assert_allclose(-gradient[:3], force, atol=1e-7 * np.abs(force).max())
        np.testing.assert_allclose(-gradient[3:], turning, atol=1e-7 * np.abs(force).max())
    r = state.position[::2] - state.position[1::2]
    balance = found["torque_i"] + found["torque_j"] + np.cross(r, found["force"])
    assert np.abs(balance).max() < 1e-14 * np.abs(found["force"]).max() * np.abs(r).max()


@pytest.mark.parametrize("wall", [SIDE, FLOOR, LID])
def test_wall_loads_are_the_gradient(wall):
    rng = np.random.default_rng(6)
    n, depth = 50, 0.02
    radius, aspect, axis = rng.uniform(0.5, 1.5, n), rng.uniform(0.5, 2.5, n), unit_vectors(rng, n)
    outward = np.tile([0, 0, -1.0 if wall == FLOOR else 1.0], (n, 1))
    if wall == SIDE:
        angle = rng.uniform(0, 2 * np.pi, n)
        outward = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
    low, high = np.full(n, CAVITY / 2 - 4), np.full(n, CAVITY)
    origin = np.array([0, 0, 0.0 if wall == SIDE else CAVITY / 2])
    for _ in range(50):
        middle = (low + high) / 2
        scale = middle if wall == SIDE else middle - CAVITY / 2
        state = State.at_rest(origin + scale[:, None] * outward, radius, aspect=aspect, axis=axis)
        deep = look_at_walls(state, wall)["overlap"] > depth
        low, high = np.where(deep, low, middle), np.where(deep, middle, high)
    found = look_at_walls(state, wall)
    np.testing.assert_allclose(found["overlap"], depth, rtol=1e-6)

    def energy_at(kind, k, step):
        changed = (
            turned(state, k, step) if kind == "turn" else dataclasses.replace(state, position=state.position.copy())
        )
        if kind == "move":
            changed.position[:, k] += step
        return look_at_walls(changed, wall)["energy"]

    gradient = slopes(energy_at, n)
    scale = np.abs(found["force"]).max()
    np.testing.assert_allclose(-gradient[:3], found["force"].T, atol=1e-7 * scale)
    np.testing.assert_allclose(-gradient[3:], found["torque_i"].T, atol=1e-7 * scale)


def test_the_farthest_point_from_the_axis():
    """Axis up: the radius across; radial: along; tangential: from the shadow's ellipse, x^2 + s^2 largest."""
    a, b, x = 2.0 ** (2 / 3), 2.0 ** (-1 / 3), CAVITY - 1.7
    state = State.at_rest([[x, 0, 5.0]] * 3, 1.0, aspect=2.0, axis=np.eye(3)[[2, 0, 1]])
    found = look_at_walls(state, SIDE)
    s = np.linspace(0, np.pi / 2, 200_001)
    tangential = np.max(np.hypot(x + b * np.cos(s), a * np.sin(s)))
    np.testing.assert_allclose(found["overlap"] + CAVITY, [x + b, x + a, tangential], rtol=1e-9)


# ---- tops ------------------------------------------------------------------------------------------------------------


def a_top(aspect, spin):
    axis = unit_vectors(np.random.default_rng(7), 1)
    state = State.at_rest([[0, 0, 0]], 1.0, aspect=aspect, axis=axis)
    state.spin[:] = spin
    return state


def spun(state, pull, dt, steps):
    p, energy = particles(state), wp.zeros(steps, dtype=wp.float64, device="cpu")
    wp.launch(spinning, 1, [a_case(dt), wp.vec3d(*pull), steps, p, energy], device="cpu")
    return p.numpy()[0], energy.numpy()


@pytest.mark.parametrize("aspect", [0.5, 2.0])
def test_a_free_top_turns_about_its_angular_momentum(aspect):
    """u turns about L by |L| t / I_t; the error falls with the square of the step; |u| and L.u stay to round-off."""
    state = a_top(aspect, (1.0, -2.0, 1.5))
    start = particles(state).numpy()[0]
    momentum, u = start["half_momentum"], state.axis[0]
    z = momentum / np.linalg.norm(momentum)
    errors = []
    for steps in (1000, 2000, 4000):
        now, _ = spun(state, (0, 0, 0), 10 / steps, steps)
        angle = 10 * np.linalg.norm(momentum) * start["inverse_transverse"]
        exact = u * math.cos(angle) + np.cross(z, u) * math.sin(angle) + z * (z @ u) * (1 - math.cos(angle))
        errors.append(np.linalg.norm(now["axis"] - exact))
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.01)
    now, _ = spun(state, (0, 0, 0), 1e-3, 100_000)
    assert abs(np.linalg.norm(now["axis"]) - 1) < 1e-13
    assert abs(now["axis"] @ momentum - u @ momentum) < 1e-13 * np.linalg.norm(momentum)


def test_a_heavy_top_neither_gains_nor_loses():
    """Energy within an error that falls with the square of the step, and the same early and late in 100,000 steps."""
    state, pull = a_top(2.0, (1.0, 5.0, 2.0)), (0, 0, 3.0)
    errors = []
    for dt in (0.02, 0.01, 0.005):
        _, energy = spun(state, pull, dt, 100_000)
        away = np.abs(energy[1:] - energy[1])
        errors.append(away.max())
        assert away[-10_000:].max() < 1.02 * away[:10_000].max()
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.05)
