"""Time stepping, neighbours, batches, and what reading may not change."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from warpdamp import Batch, Case, Effects, Simulation, State, engine
from warpdamp.timestep import steps_per_cycle

RADIUS = 3.73e-3


def bed_case(damper, positions, gamma=6.0, frequency=46.0):
    scene = damper(frequency, gamma)
    state = State.at_rest(positions, RADIUS)
    n = steps_per_cycle(scene, state.radius)
    return Case(scene, state, 1 / (frequency * n), n)


def same(a: State, b: State):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in vars(a))


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
def test_the_neighbour_skin_never_changes_a_bit(damper, loose_positions, monkeypatch, skin):
    case = bed_case(damper, loose_positions(2))
    usual = Batch([case], max_rows=2)
    usual.advance(case.steps_per_cycle)
    monkeypatch.setattr(engine, "SKIN", skin)
    other = Batch([case], max_rows=2)
    other.advance(case.steps_per_cycle)
    assert np.array_equal(usual.cycles(0).rows, other.cycles(0).rows)


def test_neighbour_lists_hold_every_near_pair_once(make_scene):
    rng = np.random.default_rng(3)
    radius = rng.uniform(0.5e-3, 4e-3, 400)
    states = [State.at_rest(rng.uniform(-0.03, 0.03, (400, 3)), radius) for _ in range(2)]
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
    assert np.all(start.pair_history[:, 3] > 0)
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


def test_a_state_that_is_not_finite_stops_its_case_only(damper, loose_positions):
    good = bed_case(damper, loose_positions(1))
    bad = bed_case(damper, loose_positions(2))
    bad.state.velocity[17, 0] = np.nan
    batch = Batch([good, bad], max_rows=2)
    batch.advance(good.steps_per_cycle)
    assert batch.status.tolist() == [0, 1]
    assert batch.steps[0] == good.steps_per_cycle
    alone = Batch([good], max_rows=2)
    alone.advance(good.steps_per_cycle)
    assert np.array_equal(batch.cycles(0).rows, alone.cycles(0).rows)


def test_a_single_simulation_raises_when_it_is_not_finite(make_scene):
    state = State.at_rest([[0, 0, 0]], RADIUS)
    state.velocity[0, 0] = np.inf
    simulation = Simulation(make_scene(), state, 1e-6)
    with pytest.raises(FloatingPointError, match="smaller step"):
        simulation.advance(10)


def test_coincident_spheres_are_pushed_apart_and_stay_finite(make_scene):
    simulation = Simulation(make_scene(), State.at_rest([[0, 0, 0], [0, 0, 0]], RADIUS), 1e-9)
    simulation.advance(100)
    after, _ = simulation.read()
    assert np.isfinite(after.position).all()
    assert after.position[0, 2] > after.position[1, 2]
