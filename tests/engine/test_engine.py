"""Time stepping, neighbours, batches, and what reading may not change."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from warpdamp import Batch, Case, Cylinder, Effects, Material, Simulation, SimulationError, State
from warpdamp.damper.placement import separate
from warpdamp.engine import batch as engine
from warpdamp.kernels.columns import KernelStatus
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene.paper import RADIUS


def bed_case(damper, positions, gamma=6.0, frequency=46.0):
    scene = damper(frequency, gamma)
    state = State.at_rest(positions, RADIUS)
    n = steps_per_cycle(scene, state)
    return Case(scene, state, 1 / (frequency * n), n)


def same(a: State, b: State):
    ours, theirs = a.arrays(), b.arrays()
    return all(np.array_equal(ours[name], theirs[name]) for name in ours)


def test_free_fall_is_exact(make_scene):
    """Leapfrog started by half a step has no error under constant acceleration."""
    state = State.at_rest([[0, 0, 0.1]], RADIUS)
    state.velocity[0] = [0.1, 0, 0.2]
    simulation = Simulation(make_scene(gravity=(0, 0, -9.81)), state, 1e-4)
    simulation.advance(500)
    after, ledger = simulation.read()
    t = 0.05
    np.testing.assert_allclose(after.position[0], [0.1 * t, 0, 0.1 + 0.2 * t - 9.81 * t**2 / 2], atol=1e-15)
    np.testing.assert_allclose(after.velocity[0], [0.1, 0, 0.2 - 9.81 * t], atol=1e-13)
    assert abs(ledger.residual[-1]) < 1e-17


def test_a_case_gives_the_same_bits_alone_and_in_company(damper, loose_positions):
    cases = [bed_case(damper, loose_positions(seed), gamma) for seed, gamma in ((1, 6.0), (2, 14.0), (3, 2.0))]
    together = Batch(cases, max_rows=3)
    together.advance([2 * case.steps_per_cycle for case in cases])
    for k, case in enumerate(cases):
        alone = Batch([case], max_rows=3)
        alone.advance(2 * case.steps_per_cycle)
        assert np.array_equal(alone.cycles(0).rows, together.cycles(k).rows)
        assert same(alone.read()[0][0], together.read()[k][0])


def test_runs_repeat_and_neither_stops_nor_readings_show(damper, loose_positions):
    case = bed_case(damper, loose_positions(1))
    straight = Batch([case], max_rows=2)
    straight.advance(case.steps_per_cycle)
    halting = Batch([case], max_rows=2)
    for steps in (1, 7, 1000, 1001, case.steps_per_cycle):
        halting.advance(steps)
        halting.read()
    assert np.array_equal(straight.cycles(0).rows, halting.cycles(0).rows)
    assert same(straight.read()[0][0], halting.read()[0][0])


@pytest.mark.parametrize("skin", [0.02, 0.5])
def test_the_neighbour_skin_never_changes_a_bit(damper, loose_positions, skin):
    case = bed_case(damper, loose_positions(2))
    usual = Batch([case], max_rows=2)
    usual.advance(case.steps_per_cycle)
    other = Batch([case], max_rows=2, skin=skin)
    other.advance(case.steps_per_cycle)
    assert np.array_equal(usual.cycles(0).rows, other.cycles(0).rows)


def test_neighbour_lists_hold_every_near_pair_once(make_scene):
    radius = np.random.default_rng(3).uniform(0.5e-3, 4e-3, 400)
    states = [State.at_rest(separate(radius, Cylinder(0.05, 0.06), seed), radius) for seed in (1, 2)]
    batch = Batch([Case(make_scene(), state, 1e-9) for state in states])
    batch.advance(0)
    batch.read()
    start, partner = batch._contacts.start.numpy(), batch._contacts.partner.numpy()
    owner = np.repeat(np.arange(800), np.diff(start))
    got = list(zip(owner.tolist(), partner.tolist(), strict=True))
    assert got == sorted(set(got))
    skin = engine.SKIN * radius.min()
    expected = set()
    for k, state in enumerate(states):
        i, j = cKDTree(state.position).query_pairs(2 * radius.max() + skin, output_type="ndarray").T
        distance = np.linalg.norm(state.position[i] - state.position[j], axis=1)
        near = distance < radius[i] + radius[j] + skin
        low, high = np.minimum(i, j)[near] + 400 * k, np.maximum(i, j)[near] + 400 * k
        expected |= set(zip(low.tolist(), high.tolist(), strict=True))
    assert set(got) == expected


def test_a_state_read_and_started_again_goes_on(damper, loose_positions):
    """Contacts keep what they remember.

    The start from the whole step replaces one predicted velocity by the true one: a change of order dt^2 once.
    """
    scene = damper()
    dt = 1e-6
    fallen = Simulation(scene, State.at_rest(loose_positions(1), RADIUS), dt)
    fallen.advance(20_000)
    start, _ = fallen.read()
    assert len(start.pairs) == len(start.pair_history) > 100
    assert np.all(start.pair_history.radius > 0)
    through = Simulation(scene, start, dt)
    through.advance(400)
    halfway = Simulation(scene, start, dt)
    halfway.advance(200)
    again = Simulation(scene, halfway.read()[0], dt)
    again.advance(200)
    forgetful = Simulation(scene, State(*(getattr(start, n) for n in ("position", "velocity", "spin", "radius"))), dt)
    forgetful.advance(400)
    moved = np.abs(again.read()[0].position - through.read()[0].position).max()
    lost = np.abs(forgetful.read()[0].position - through.read()[0].position).max()
    assert moved < 1e-10
    assert moved < 1e-3 * lost


def test_float32_follows_float64_for_a_while(damper, loose_positions):
    case = bed_case(damper, loose_positions(1))
    rows = []
    for precision in ("float64", "float32"):
        batch = Batch([case], max_rows=2, effects=Effects(precision=precision))
        batch.advance(case.steps_per_cycle)
        rows.append(batch.cycles(0))
    assert rows[1].dissipated[-1] == pytest.approx(rows[0].dissipated[-1], rel=0.1)
    assert rows[1].rows.dtype == np.float64


def plant(batch, name, particle, value):
    """Put a value into the particles on the device."""
    particles = batch._particles.numpy().copy()
    particles[name][particle] = value
    batch._particles.assign(particles)


def plant_nan(batch, particle):
    plant(batch, "half_velocity", particle, np.nan)


def test_a_state_that_is_not_finite_stops_its_case_only(damper, loose_positions):
    good = bed_case(damper, loose_positions(1))
    batch = Batch([good, bed_case(damper, loose_positions(2))], max_rows=2)
    plant_nan(batch, 120 + 17)
    batch.advance(good.steps_per_cycle)
    assert batch.status.tolist() == [KernelStatus.OK, KernelStatus.NOT_FINITE]
    assert batch.steps[0] == good.steps_per_cycle
    alone = Batch([good], max_rows=2)
    alone.advance(good.steps_per_cycle)
    assert np.array_equal(batch.cycles(0).rows, alone.cycles(0).rows)


def test_a_particle_outside_the_cavity_stops_its_case(damper, loose_positions):
    batch = Batch([bed_case(damper, loose_positions(1))], max_rows=2)
    plant(batch, "position", 3, [0.0, 0.0, 0.06])
    batch.advance(100)
    assert batch.status.tolist() == [KernelStatus.ESCAPED]


def test_a_single_simulation_raises_when_it_goes_wrong(damper, loose_positions):
    simulation = Simulation(damper(), State.at_rest(loose_positions(1), RADIUS), 1e-6)
    plant_nan(simulation, 5)
    with pytest.raises(SimulationError, match=r"not finite by step .* take a step below 1e-06 s"):
        simulation.advance(10)


def test_a_contact_too_deep_for_hertz_is_an_error(make_scene, two_spheres):
    soft = Material(density=920, youngs_modulus=3.3e5, poissons_ratio=0.37)
    simulation = Simulation(make_scene(material=soft), two_spheres(2.0), 1e-5)
    with pytest.raises(SimulationError, match=r"of the reduced radius deep, and Hertz's theory ends at 0.1"):
        simulation.advance(100)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"position": [[0, 0, 0.01], [0, 0, 0.01]]}, "particles 0 and 1 overlap by 200 %"),
        ({"position": [[0, 0, 0.01], [0, 0, 0.0163]]}, "particles 0 and 1 overlap by 31.1 %"),
        ({"position": [[0, 0, 0.003], [0, 0, 0.02]]}, "particle 0 and the floor overlap by 19.6 %"),
        ({"position": [[0, 0, 0.01], [0, np.nan, 0.02]]}, "position of particle 1 is not finite"),
        ({"velocity": [[0, 0, np.inf], [0, 0, 0]]}, "velocity of particle 0 is not finite"),
        ({"radius": [RADIUS, 0.0]}, "radius of particle 1 is not positive"),
        ({"velocity": [[0, 0, 300.0], [0, 0, 0]]}, "does not resolve the shortest contact expected"),
    ],
)
def test_starts_that_cannot_be_right_are_refused(damper, change, message):
    given = {
        "position": [[0, 0, 0.01], [0, 0, 0.02]],
        "velocity": np.zeros((2, 3)),
        "radius": [RADIUS, RADIUS],
    } | change
    state = State(*(np.array(given[n], float) for n in ("position", "velocity", "velocity", "radius")))
    with pytest.raises(ValueError, match=message):
        Simulation(damper(), state, 2e-6)


def test_a_step_that_does_not_fit_the_drive_is_refused(damper):
    scene, ball = damper(46.0, 6.0), State.at_rest([[0, 0, 0.01]], RADIUS)
    assert Case(scene, ball, 1 / 46 / 10_000).steps_per_cycle == 10_000
    with pytest.raises(ValueError, match="does not divide the drive's period"):
        Case(scene, ball, 2.1e-6)
    with pytest.raises(ValueError, match="into 10000: leave it out"):
        Case(scene, ball, 1 / 46 / 10_000, 2000)
