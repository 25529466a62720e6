"""The contact law against closed forms: one and two spheres."""

import math

import numpy as np
import pytest

from warpdamp import Simulation, State
from warpdamp.scene.contact import contact_constants, contact_time
from warpdamp.scene.paper import RADIUS


def reduced_modulus(scene):
    return contact_constants(scene.particle, scene.particle, scene.particle_contact)["modulus"]


def run(scene, state, dt, time):
    simulation = Simulation(scene, state, dt)
    simulation.advance(math.ceil(time / dt))
    return simulation.read()


@pytest.mark.parametrize("ratio", [1, 3, 10])
@pytest.mark.parametrize("restitution", [0.05, 0.2, 0.52, 0.9, 1.0])
def test_two_spheres_part_at_the_restitution_asked_for(make_scene, two_spheres, restitution, ratio):
    """Second-order law: at 500 steps a contact the error is well under 1e-3; a clipped dashpot would miss by 0.05."""
    radius = (RADIUS, RADIUS / ratio)
    scene = make_scene(restitution)
    state = two_spheres(1.0, radius)
    mass = scene.mass(state.radius)
    reduced = mass[0] * mass[1] / mass.sum()
    tc = contact_time(reduced_modulus(scene), RADIUS / (1 + ratio), reduced, 1.0)
    after, ledger = run(scene, state, tc / 500, 4 * tc + 1e-5)
    parting = after.velocity[1, 0] - after.velocity[0, 0]
    assert parting == pytest.approx(restitution, abs=1e-3)
    lost = 0.5 * reduced * (1 - restitution**2)
    assert ledger.dissipated[-1] == pytest.approx(lost, rel=2e-3, abs=1e-12)


@pytest.mark.parametrize("restitution", [0.2, 0.52, 0.9])
def test_a_sphere_leaves_the_floor_at_the_restitution_asked_for(make_scene, restitution):
    from warpdamp import Cylinder

    scene = make_scene(restitution, enclosure=Cylinder(0.04, 0.04))
    state = State.at_rest([[0, 0, RADIUS + 1e-5]], RADIUS)
    state.velocity[0, 2] = -0.5
    after, _ = run(scene, state, 1e-7, 4e-4)
    assert after.velocity[0, 2] == pytest.approx(0.5 * restitution, rel=2e-3)


def test_hertz_impact_peak_and_duration(make_scene, two_spheres):
    """d_max = (15 m* v^2 / (16 E* sqrt R*))^(2/5) = 16.7 um, tc = 2.943 d_max / v = 49.1 us, F = 7.50 N."""
    scene, dt = make_scene(1.0, 0.0), 2e-8
    state = two_spheres(1.0)
    simulation = Simulation(scene, state, dt)
    deepest, touching = 0.0, 0
    for _ in range(1200):
        simulation.advance(5)
        now, _ = simulation.read()
        overlap = 2 * RADIUS - (now.position[1, 0] - now.position[0, 0])
        deepest = max(deepest, overlap)
        touching += overlap > 0
    mass, effective = float(scene.mass(RADIUS)) / 2, RADIUS / 2
    modulus = reduced_modulus(scene)
    d_max = (15 * mass / (16 * modulus * math.sqrt(effective))) ** 0.4
    assert d_max == pytest.approx(16.7e-6, rel=2e-3)
    assert deepest == pytest.approx(d_max, rel=1e-4)
    assert touching * 5 * dt == pytest.approx(contact_time(modulus, effective, mass, 1.0), abs=1e-7 + 5 * dt)
    assert 4 / 3 * modulus * math.sqrt(effective) * deepest**1.5 == pytest.approx(7.50, rel=2e-3)


@pytest.mark.parametrize("angle", [65, 75, 85])
def test_gross_sliding_on_the_floor(make_scene, angle):
    """Beyond tan = 7/2 mu (1 + e), 62 deg: v_t' = v_t - mu (1 + e) v_n, spin = 5/2 mu (1 + e) v_n / R."""
    from warpdamp import Cylinder

    friction, restitution, speed = 0.3, 0.8, 0.5
    scene = make_scene(restitution, friction, enclosure=Cylinder(0.4, 0.04))
    state = State.at_rest([[0, 0, RADIUS + 1e-6]], RADIUS)
    vn, vt = speed * math.cos(math.radians(angle)), speed * math.sin(math.radians(angle))
    state.velocity[0] = [vt, 0, -vn]
    after, _ = run(scene, state, 1e-7, 1.5e-4 + 1e-6 / vn)
    # the contact point lies at R - d, d / R = 0.2 % here: that is the tolerance of the spin
    assert after.velocity[0, 0] == pytest.approx(vt - friction * (1 + restitution) * vn, rel=2e-3)
    assert after.spin[0, 1] == pytest.approx(2.5 * friction * (1 + restitution) * vn / RADIUS, rel=5e-3)


def test_slip_turns_to_rolling(make_scene):
    """A sliding sphere rolls after 2 v0 / (7 mu g), at 5/7 v0."""
    from warpdamp import Cylinder

    friction, speed, g = 0.2, 0.1, 9.81
    scene = make_scene(0.5, friction, enclosure=Cylinder(0.4, 0.04), gravity=(0, 0, -g))
    rest = (float(scene.mass(RADIUS)) * g / (4 / 3 * 2 * reduced_modulus(scene) / 2 * math.sqrt(RADIUS))) ** (2 / 3)
    state = State.at_rest([[-0.01, 0, RADIUS - rest]], RADIUS)
    state.velocity[0, 0] = speed
    stop = 2 * speed / (7 * friction * g)
    sliding, _ = run(scene, state, 2e-6, 0.9 * stop)
    assert sliding.velocity[0, 0] == pytest.approx(speed - friction * g * 0.9 * stop, rel=2e-3)
    rolling, _ = run(scene, state, 2e-6, 1.5 * stop)
    assert rolling.velocity[0, 0] == pytest.approx(5 / 7 * speed, rel=2e-3)
    assert rolling.spin[0, 1] * RADIUS == pytest.approx(rolling.velocity[0, 0], rel=2e-3)


def test_spins_without_slip_feel_no_friction(make_scene, two_spheres):
    """Equal spins about one axis across the normal move both surfaces oppositely; opposite ones roll without slip."""
    state = two_spheres(1.0)
    state.spin[:, 2] = [40.0, -40.0]
    after, ledger = run(make_scene(0.5), state, 1e-6, 3e-4)
    assert after.spin[:, 2] == pytest.approx([40.0, -40.0], abs=1e-10)
    assert ledger["particle_slip"][-1] < 1e-30  # the rounding of a zero slip velocity


@pytest.mark.parametrize("friction", [0.1, 0.86])
@pytest.mark.parametrize("restitution", [0.52, 1.0])
def test_momentum_and_angular_momentum_are_kept(make_scene, two_spheres, friction, restitution):
    state = two_spheres(1.0, (RADIUS, RADIUS / 3))
    state.position[:, 1] = [-0.8e-3, 0.8e-3]
    state.velocity[:, 1] = [0.3, -0.4]
    state.spin[:] = [[10, 20, 30], [-100, 50, 200]]
    scene = make_scene(restitution, friction)
    mass = scene.mass(state.radius)[:, None]

    def momenta(s):
        inertia = 0.4 * mass * s.radius[:, None] ** 2
        return (mass * s.velocity).sum(0), (mass * np.cross(s.position, s.velocity) + inertia * s.spin).sum(0)

    after, ledger = run(scene, state, 1e-6, 5e-4)
    assert ledger.dissipated[-1] > 0 or restitution == 1.0  # they did meet
    assert not np.allclose(after.spin, state.spin)
    for got, expected in zip(momenta(after), momenta(state), strict=True):
        np.testing.assert_allclose(got, expected, atol=1e-13 * float(np.abs(mass * state.velocity).max()))


def test_no_impact_gains_energy(make_scene):
    """300 random oblique impacts with spin: no channel is negative, and no energy appears beyond the step's order."""
    rng = np.random.default_rng(7)
    for _ in range(300):
        ratio, friction, restitution = (
            10 ** rng.uniform(-0.5, 0.5),
            rng.uniform(0, 1.5),
            float(rng.choice([0.4, 0.6, 0.8, 0.9, 1.0])),
        )
        radius = np.array([RADIUS, RADIUS * ratio])
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        state = State.at_rest([[0, 0, 0], direction * (radius.sum() + 1e-6)], radius)
        angle = math.radians(rng.uniform(0, 89))
        aside = np.cross(direction, rng.normal(size=3))
        aside /= np.linalg.norm(aside)
        state.velocity[1] = -math.cos(angle) * direction + math.sin(angle) * aside
        state.spin[:] = rng.uniform(-100, 100, (2, 3))
        scene = make_scene(restitution, friction)
        mass = scene.mass(radius)
        reduced = mass.prod() / mass.sum()
        tc = contact_time(reduced_modulus(scene), radius.prod() / radius.sum(), reduced, math.cos(angle))
        _, ledger = run(scene, state, tc / 50, 3 * tc + 1e-6 / math.cos(angle))
        kinetic = ledger["kinetic_translation"] + ledger["kinetic_rotation"]
        assert kinetic[-1] <= kinetic[0] * (1 + 2e-3)  # at 50 steps a contact
        scale = 1e-15 * kinetic[0]
        for name in ("normal_dashpot", "tangential_dashpot", "slip", "history"):
            assert ledger[f"particle_{name}"][-1] >= -scale


def test_residual_falls_at_second_order(make_scene, two_spheres):
    """Leapfrog with predicted velocities: halving the step takes the ledger's residual down by four."""
    state = two_spheres(1.0)
    state.position[:, 1] = [-1.8e-3, 1.8e-3]
    state.velocity[:, 1] = [0.3, -0.3]
    state.spin[0] = [10, 20, 30]
    steps = np.array([2e-6, 1e-6, 0.5e-6, 0.25e-6, 0.125e-6])
    left = [abs(run(make_scene(), state, dt, 1.5e-3)[1].residual[-1]) for dt in steps]
    slope = np.polyfit(np.log(steps), np.log(left), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.2)
