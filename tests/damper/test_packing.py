"""Beds that fit, rest, and are reproducible."""

import logging

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from conftest import ROOT
from warpdamp import Cylinder, Grains, PackingError, Request, State, prepare
from warpdamp.damper import preparation as packing
from warpdamp.damper.placement import fill, separate
from warpdamp.damper.preparation import settle
from warpdamp.files import cache_folder
from warpdamp.numerics.timestep import Numerics
from warpdamp.scene.paper import RADIUS

PAPER = Grains.alike(RADIUS, 120)
CAVITY = Cylinder(0.04, 0.04)
DATA = ROOT / "tests" / "data"


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_papers_bed_fits_without_overlap(seed):
    assert fill(PAPER.radius, CAVITY) == pytest.approx(0.519, abs=1e-3)
    x = separate(PAPER.radius, CAVITY, seed)
    assert pdist(x).min() >= 2 * RADIUS
    assert np.hypot(x[:, 0], x[:, 1]).max() + RADIUS <= 0.02
    assert x[:, 2].min() >= RADIUS
    assert x[:, 2].max() <= 0.04 - RADIUS


def test_mixed_sizes_fit_without_overlap():
    radius = np.random.default_rng(0).uniform(1e-3, 5e-3, 150)
    x = separate(tuple(radius), Cylinder(0.05, 0.05), 1)
    i, j = np.triu_indices(150, 1)
    assert np.all(np.linalg.norm(x[i] - x[j], axis=1) >= radius[i] + radius[j])


def test_too_many_particles_are_refused_with_both_fills():
    with pytest.raises(PackingError, match=r"would fill 0\.605 of the cavity, and random packing reached 0\.5\d\d"):
        separate((RADIUS,) * 140, CAVITY, 1)


def test_a_particle_larger_than_the_cavity_is_refused():
    with pytest.raises(PackingError, match="does not fit"):
        separate((0.021,), CAVITY, 1)


def test_a_loose_bed_rests_holds_together_and_repeats(damper):
    scene = damper()
    bed = prepare(Request(scene, PAPER, 5, "loose"))
    path = cache_folder("beds") / f"{Request(scene, PAPER, 5, 'loose').key()}.npz"
    assert path.exists()
    assert np.abs(bed.state.velocity).max() < 0.02
    assert 0.2e-3 < bed.clearance < 1.5e-3  # a loose bed leaves 0.4 mm (docs/acceptance.md)
    path.unlink()
    again = prepare(Request(scene, PAPER, 5, "loose"))
    stored = prepare(Request(scene, PAPER, 5, "loose"))
    for name, array in bed.state.arrays().items():
        assert np.array_equal(array, again.state.arrays()[name])
        assert np.array_equal(array, stored.state.arrays()[name])
    assert again.clearance == stored.clearance == bed.clearance


def test_a_jam_that_gains_energy_is_settled_at_a_finer_step(damper, caplog, monkeypatch):
    """Of 64 beds of the paper one met this on its way: spheres 30 and 89, each in many deep contacts."""
    with np.load(DATA / "jam.npz") as file:
        jam = State.from_arrays(dict(file))
    scene, coarse = damper(), Numerics(steps_per_contact=12.0)
    with caplog.at_level(logging.INFO, "warpdamp.damper.preparation"):
        rested = settle(scene, jam, coarse)
    assert "again with 24 steps a contact" in caplog.text
    assert np.abs(rested.velocity).max() < 0.02
    monkeypatch.setattr(packing, "HALVINGS", 0)
    with pytest.raises(PackingError, match="the bed gained energy from nowhere"):
        settle(scene, jam, coarse)


def test_settling_releases_no_energy(damper):
    """What the bed has at rest, and what it lost on the way, is what gravity gave."""
    scene = damper()
    state = State.at_rest(separate(PAPER.radius, CAVITY, 4), RADIUS)
    rest = settle(scene, state)
    assert np.mean(rest.position[:, 2]) < np.mean(state.position[:, 2])
    assert np.abs(rest.velocity).max() < 0.02


def test_every_input_changes_the_key(damper):
    base = Request(damper(), PAPER, 1)
    others = [
        Request(damper(), PAPER, 2),
        Request(damper(), Grains.alike(RADIUS, 119), 1),
        Request(damper(), PAPER, 1, "loose"),
        Request(damper(), PAPER, 1, settling_time=0.2),
        Request(damper(), PAPER, 1, numerics=Numerics("float32")),
    ]
    assert len({request.key() for request in [base, *others]}) == 6
    assert Request(damper(46, 3), PAPER, 1).key() == base.key()  # the drive does not matter to a bed


def test_a_bed_cannot_be_compacted_without_gravity(make_scene):
    scene = make_scene(enclosure=CAVITY)
    with pytest.raises(PackingError, match="without gravity"):
        prepare(Request(scene, Grains.alike(RADIUS, 20), 1, "compacted"))


def test_a_bed_without_gravity_floats_where_it_was_made(make_scene):
    scene = make_scene(enclosure=CAVITY)
    bed = prepare(Request(scene, Grains.alike(RADIUS, 20), 1, "loose"))
    assert np.array_equal(bed.state.position, separate((RADIUS,) * 20, CAVITY, 1))
    assert bed.clearance > 0.02


@pytest.mark.slow
def test_a_compacted_bed_is_lower_than_a_loose_one(damper):
    loose, compacted = (prepare(Request(damper(), PAPER, 1, how)) for how in ("loose", "compacted"))
    assert compacted.blocks >= 30
    assert np.mean(compacted.state.position[:, 2]) < np.mean(loose.state.position[:, 2]) - 0.2e-3
    assert compacted.clearance > 1.2e-3
