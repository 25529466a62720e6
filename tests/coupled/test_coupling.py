"""Structures that answer: closed forms of oscillators, and one ledger over structure and particles."""

import math

import numpy as np
import pytest

from warpdamp import Batch, Case, Cylinder, Scene, State, Surface
from warpdamp.coupled.identify import from_decay, from_response
from warpdamp.damper.placement import place
from warpdamp.scene.host import Force, HostStructure
from warpdamp.scene.paper import PMMA, RADIUS
from warpdamp.scene.particles import Grains

MODE = {"frequency": (40.0,), "damping": (0.01,), "amplitude": (1.7,)}


@pytest.fixture
def empty(make_scene):
    """A cavity with one ball afloat that meets nothing."""
    return make_scene(enclosure=Cylinder(0.4, 0.4)), State.at_rest([[0, 0, 0.2]], RADIUS)


def run(scene, state, dt, steps, *, records=0, rows=1):
    batch = Batch([Case(scene, state, dt)], max_records=records, max_rows=rows)
    start = batch.read()[0][1]
    batch.advance(steps)
    return batch, start, batch.read()[0][1]


def test_an_empty_damper_rings_down_with_the_damping_given(empty):
    scene, state = empty
    host = HostStructure(**MODE, position=(1e-3,), record=20)
    batch, _, _ = run(scene.on_host(host), state, 1e-5, 60_000, records=3000)
    records = batch.records(0)
    w, zeta = 2 * math.pi * 40, 0.01
    wd = w * math.sqrt(1 - zeta**2)
    t = records[:, 0]
    exact = 1.7e-3 * np.exp(-zeta * w * t) * (np.cos(wd * t) + zeta * w / wd * np.sin(wd * t))
    np.testing.assert_allclose(records[:, 1], exact, atol=1e-5 * 1.7e-3)
    for swing in from_decay(records):
        assert swing.damping == pytest.approx(zeta, rel=1e-4)
        assert swing.frequency == pytest.approx(40, rel=1e-5)


def test_its_step_is_of_second_order(empty):
    scene, state = empty
    w, zeta = 2 * math.pi * 40, 0.01
    wd = w * math.sqrt(1 - zeta**2)
    steps, misses = np.array([4e-5, 2e-5, 1e-5]), []
    for dt in steps:
        batch, _, _ = run(
            scene.on_host(HostStructure(**MODE, position=(1e-3,), record=1)),
            state,
            dt,
            round(0.05 / dt) + 1,
            records=6000,
        )
        records = batch.records(0)
        t = records[:, 0]
        exact = 1.7e-3 * np.exp(-zeta * w * t) * (np.cos(wd * t) + zeta * w / wd * np.sin(wd * t))
        misses.append(np.abs(records[:, 1] - exact).max())
    assert np.polyfit(np.log(steps), np.log(misses), 1)[0] == pytest.approx(2, abs=0.1)


def test_a_harmonic_force_gives_the_receptance(empty):
    """Started on its steady response it stays there, and reads as the mode that it is."""
    scene, state = empty
    f, amplitude = 39.0, 0.3
    w, wn, zeta, phi = 2 * math.pi * f, 2 * math.pi * 40, 0.01, 1.7
    modal = phi * (-1j * amplitude) / (wn**2 - w**2 + 2j * zeta * wn * w)  # q = Re(modal exp(j w t))
    host = HostStructure(
        **MODE, force=Force(amplitude, f), position=(modal.real,), velocity=((1j * w * modal).real,), record=25
    )
    n = 2000
    batch, _start, now = run(scene.on_host(host), state, 1 / f / n, 20 * n, records=20 * 80 + 1, rows=21)
    for window in from_response(batch.records(0), host, 5):
        assert window.frequency == pytest.approx(40, rel=1e-6)
        assert window.damping == pytest.approx(zeta, rel=1e-3)
        assert window.gamma == pytest.approx(phi * abs(modal) * w**2 / 9.81, rel=1e-4)
    assert now["force_work"][0] == pytest.approx(now["structure_loss"][0], rel=1e-3)


def test_samples_of_a_force_are_followed(empty):
    """A constant force given by samples: the mode swings about F phi^2 / w^2; a ramp is met between samples, too."""
    scene, state = empty
    undamped = {"frequency": (40.0,), "damping": (0.0,), "amplitude": (1.7,)}
    push = HostStructure(**undamped, force=Force(samples=np.array([2.0, 2.0]), sample_step=0.01), record=10)
    batch, _, _ = run(scene.on_host(push), state, 1e-5, 10_000, records=1000)
    records = batch.records(0)
    w = 2 * math.pi * 40
    exact = 2.0 * 1.7**2 / w**2 * (1 - np.cos(w * records[:, 0]))
    np.testing.assert_allclose(records[:, 1], exact, atol=1e-5 * exact.max())
    ramp = HostStructure(**undamped, force=Force(samples=np.array([0.0, 1.0]), sample_step=0.1), record=10)
    batch, _, _ = run(scene.on_host(ramp), state, 1e-5, 9_000, records=1000)
    t, place = batch.records(0)[:, :2].T
    exact = 10 * 1.7**2 / w**2 * (t - np.sin(w * t) / w)
    np.testing.assert_allclose(place, exact, atol=1e-5 * exact.max())


def test_two_modes_superpose(empty):
    scene, state = empty
    both = HostStructure((40.0, 90.0), (0.01, 0.005), (1.7, 0.8), position=(1e-3, 5e-4), record=50)
    batch, _, _ = run(scene.on_host(both), state, 1e-5, 20_000, records=400)
    records = batch.records(0)
    t, exact = records[:, 0], 0.0
    for f, zeta, phi, q in zip(both.frequency, both.damping, both.amplitude, both.position, strict=True):
        w = 2 * math.pi * f
        wd = w * math.sqrt(1 - zeta**2)
        exact = exact + phi * q * np.exp(-zeta * w * t) * (np.cos(wd * t) + zeta * w / wd * np.sin(wd * t))
    np.testing.assert_allclose(records[:, 1], exact, atol=3e-5 * 2.1e-3)


def test_particles_that_move_along_weigh_on_the_mode(make_scene, loose_positions):
    """A bed at rest under gravity, shaken well below Gamma 1: w_n = w0 / sqrt(1 + phi^2 m)."""
    from warpdamp.damper.settling import settle

    scene = make_scene(enclosure=Cylinder(0.04, 0.04), gravity=(0, 0, -9.81))
    bed = settle(scene, State.at_rest(loose_positions(1), RADIUS))
    mass = float(scene.masses(bed).sum())
    host = HostStructure((40.0,), (0.002,), (1.7,), position=(0.05 * 9.81 / (2 * math.pi * 40) ** 2 / 1.7,), record=40)
    batch, _start, _now = run(scene.on_host(host), bed, 2.5e-6, 80_000, records=2000)
    swings = from_decay(batch.records(0))
    expected = 40 / math.sqrt(1 + 1.7**2 * mass)
    assert np.mean([s.frequency for s in swings]) == pytest.approx(expected, rel=2e-4)
    sagging = 1.7**2 * mass  # where the particles rest the mode, over g: released from above that
    assert max(s.gamma for s in swings) == pytest.approx(0.05 + sagging, rel=0.1)


def test_one_ledger_over_structure_and_particles(make_scene, loose_positions):
    """Work of the force = losses of both + gain of both: within half a percent of what was lost."""
    scene = make_scene(enclosure=Cylinder(0.04, 0.04), gravity=(0, 0, -9.81))
    state = State.at_rest(loose_positions(2), RADIUS)
    host = HostStructure((41.0,), (0.003,), (1.7,), force=Force(4.0, 40.0), velocity=(0.2,))
    n = 12_000
    batch, _start, _now = run(scene.on_host(host), state, 1 / 40 / n, 5 * n, rows=6)
    ledger = batch.cycles(0)
    lost = ledger.dissipated[-1] + ledger["structure_loss"][-1]
    assert ledger.dissipated[-1] > ledger["structure_loss"][-1] > 0
    assert abs(ledger.coupled_residual[-1]) < 5e-3 * lost
    assert abs(ledger.residual[-1]) < 5e-3 * lost  # the particles' own, in the enclosure's frame
    again = Batch([Case(scene.on_host(host), state, 1 / 40 / n)], max_rows=6)
    for steps in (7, n, 2 * n + 5, 5 * n):
        again.advance(steps)
        again.read()
    assert np.array_equal(again.cycles(0).rows, ledger.rows)


def test_one_ledger_over_structure_and_spheroids(make_scene):
    """The same of needles and spheres that resist rolling; 5e-3 as of spheres."""
    cavity, count = Cylinder(0.04, 0.04), 60
    shapes = Grains((RADIUS,) * count, (0,) * count, (1.0, 1.8) * (count // 2))
    position, axis = place(shapes, cavity, 1)
    state = State.at_rest(position, RADIUS, aspect=shapes.aspect, axis=axis)
    surface = Surface(0.52, 0.86, 0.05)
    scene = Scene(PMMA, PMMA, surface, surface, cavity, (0, 0, -9.81))
    host = HostStructure((41.0,), (0.003,), (1.7,), force=Force(4.0, 40.0), velocity=(0.2,))
    n = 12_000
    batch, _start, _now = run(scene.on_host(host), state, 1 / 40 / n, 3 * n, rows=4)
    ledger = batch.cycles(0)
    assert {"spheroids", "rolling"} <= {name for name, on in vars(batch.effects).items() if on is True}
    lost = ledger.dissipated[-1] + ledger["structure_loss"][-1]
    assert ledger.dissipated[-1] > ledger["structure_loss"][-1] > 0
    assert abs(ledger.coupled_residual[-1]) < 5e-3 * lost
    assert abs(ledger.residual[-1]) < 5e-3 * lost


def test_what_cannot_be_fixed_to_a_structure_is_refused(make_scene):
    from warpdamp import Drive

    scene = make_scene(enclosure=Cylinder(0.04, 0.04), drive=Drive(40.0, 9.81))
    with pytest.raises(ValueError, match="not both"):
        type(scene)(**{**vars(scene), "host": HostStructure(**MODE)})
    with pytest.raises(ValueError, match="for each frequency"):
        HostStructure((40.0, 50.0), (0.01,), (1.7,))
    with pytest.raises(ValueError, match="positive frequency"):
        Force(1.0)
    with pytest.raises(ValueError, match="at least two samples"):
        Force(samples=np.array([1.0]), sample_step=0.1)
