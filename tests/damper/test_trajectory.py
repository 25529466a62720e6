"""A case recorded: the same bits, and losses that add up to the ledger's."""

import numpy as np
import pytest

from warpdamp.damper.case import Criteria, Request, Spec
from warpdamp.damper.shake import shake
from warpdamp.damper.trajectory import record
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene.paper import RADIUS, damper
from warpdamp.scene.particles import Grains

CYCLES = 6


@pytest.fixture(scope="module")
def spec():
    scene = damper(200.0, 8.0)
    grains = Grains.alike(RADIUS, 40)
    bed = Request(scene.driven(None), grains, 1, "loose")
    return Spec((0, 0, 0), scene, steps_per_cycle(scene, grains), bed)


@pytest.fixture(scope="module")
def values(spec):
    ((_, values),) = shake([[spec]], Criteria(fewest=CYCLES, most=CYCLES, fixed=True))
    return values


@pytest.fixture(scope="module")
def trajectory(spec):
    return record([spec], [CYCLES], frames=8, shown=2)


def test_a_recorded_case_has_the_same_bits(values, trajectory):
    series = trajectory.ledger.per_cycle()
    assert np.mean(series[values["cycles_discarded"] :]) == values["energy_dissipated"]
    assert len(series) == CYCLES


def test_a_recorded_case_does_not_depend_on_its_frames(spec, trajectory):
    other = record([spec], [CYCLES], frames=3, shown=1)
    assert np.array_equal(other.ledger.rows, trajectory.ledger.rows)


def test_frames_are_evenly_spaced_over_the_last_cycles(spec, trajectory):
    cycle = [frame.cycle for frame in trajectory.frames]
    assert cycle == pytest.approx(4 + np.arange(8) / 4, abs=1 / spec.steps_per_cycle)
    amplitude = spec.scene.drive.displacement
    assert trajectory.displacement[1] == pytest.approx([0, 0, amplitude], abs=1e-3 * amplitude)  # a quarter of a cycle


def test_the_particles_losses_add_up_to_the_ledgers(spec, trajectory):
    """Sampled four times within the shortest contact: to 5 % over two cycles of 40 particles; the paper's damper: 2 %."""
    ends = record([spec], [CYCLES], frames=spec.steps_per_cycle // 40, shown=2)  # the last frame ends near the end
    lost = ends.frames[-1].lost.sum() / trajectory.ledger.per_cycle()[-2:].sum()
    assert lost == pytest.approx(1 - 1 / len(ends.frames), abs=0.05)
    assert (ends.frames[-1].lost >= 0).all()


def test_the_forces_of_a_bed_at_rest_carry_its_weight():
    """A drive of 1e-9 g hardly moves the bed: floor and lid carry what gravity pulls down, to the residual motion."""
    scene = damper(200.0, 1e-9)
    grains = Grains.alike(RADIUS, 20)
    spec = Spec((0, 0, 0), scene, steps_per_cycle(scene, grains), Request(scene.driven(None), grains, 1, "loose"))
    touching = record([spec], [4], frames=2, shown=1).frames[-1].touching
    walls = touching.pairs[:, 1] < 0
    weight = 9.81 * scene.masses(grains).sum()
    assert touching.force[walls, 2].sum() == pytest.approx(
        weight, rel=0.02
    )  # a bed counts as settled with some rattling
    assert set(touching.pairs[walls, 1]) <= {-1, -2, -3}
    assert (touching.pairs[~walls, 0] < touching.pairs[~walls, 1]).all()


def test_every_step_looked_at_gives_the_ledgers_losses_exactly(spec, monkeypatch):
    """The probe computes what the next step adds to the ledger: the same sums but for their order."""
    monkeypatch.setattr("warpdamp.damper.trajectory.SAMPLES_PER_CONTACT", 10_000)
    frames = record([spec], [2], frames=2, shown=2).frames  # the second frame is one cycle after the first
    series = record([spec], [2], frames=2, shown=1).ledger.per_cycle()
    assert frames[1].lost.sum() == pytest.approx(series[0], rel=1e-6)  # the ledger halves the first step of a run


def test_spheroids_lose_in_the_probe_what_they_lose_in_the_ledger(monkeypatch):
    """Twice as long as wide: contacts, losses and axes of spheroids."""
    monkeypatch.setattr("warpdamp.damper.trajectory.SAMPLES_PER_CONTACT", 10_000)
    scene = damper(400.0, 20.0)
    grains = Grains.alike(RADIUS, 12, aspect=2.0)
    spec = Spec((0, 0, 0), scene, steps_per_cycle(scene, grains), Request(scene.driven(None), grains, 1, "loose"))
    trajectory = record([spec], [2], frames=2, shown=2)
    first, second = trajectory.frames
    assert second.lost.sum() == pytest.approx(trajectory.ledger.per_cycle()[0], rel=1e-6)
    other = record([spec], [2], frames=5, shown=1)
    assert np.array_equal(other.ledger.rows, trajectory.ledger.rows)
    assert np.linalg.norm(second.state.axis, axis=1) == pytest.approx(1.0)
    assert not np.allclose(first.state.axis, second.state.axis, atol=1e-4)
