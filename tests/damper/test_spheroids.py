"""Beds of spheroids: placed without overlap, denser than spheres, at rest, kept with their axes."""

import numpy as np
import pytest

from warpdamp import Cylinder, Grains, PackingError, Request, State, prepare
from warpdamp.damper import placement, settling
from warpdamp.damper.placement import fill, place, separate
from warpdamp.files import cache_folder
from warpdamp.scene.paper import RADIUS
from warpdamp.scene.touch import pair_overlaps, wall_overlaps

CAVITY = Cylinder(0.04, 0.04)


def placed(grains, cavity=CAVITY, seed=1) -> State:
    position, axis = place(grains, cavity, seed)
    return State.at_rest(position, grains.radius, aspect=grains.aspect, axis=axis)


def assert_apart(state, cavity):
    assert pair_overlaps(state, np.stack(np.triu_indices(len(state), 1), axis=1)).max() < 0
    assert all(overlap.max() < 0 for overlap in wall_overlaps(state, cavity).values())
    assert np.allclose(np.linalg.norm(state.axis, axis=1), 1, atol=1e-12)


@pytest.mark.parametrize("aspect", [0.5, 2.5])
def test_the_papers_number_of_spheroids_fits_without_overlap(aspect):
    state = placed(Grains.alike(RADIUS, 120, aspect=aspect))
    assert_apart(state, CAVITY)
    again = placed(Grains.alike(RADIUS, 120, aspect=aspect))
    assert np.array_equal(state.position, again.position)
    assert np.array_equal(state.axis, again.axis)


def test_shapes_and_sizes_fit_together():
    rng = np.random.default_rng(0)
    radius, aspect = rng.uniform(1e-3, 4e-3, 150), rng.uniform(0.5, 2.0, 150)
    aspect[::3] = 1.0
    assert_apart(placed(Grains(tuple(radius), (0,) * 150, tuple(aspect))), CAVITY)


def test_axes_point_every_way():
    """The mean of (u.z)^2 is 1/3 of random axes; its standard error over 120 is 0.027.  Walls turn some."""
    squares = placed(Grains.alike(RADIUS, 120, aspect=2.0)).axis[:, 2] ** 2
    assert squares.mean() == pytest.approx(1 / 3, abs=0.12)


def test_spheroids_are_packed_denser_than_spheres():
    """Random frictionless packings of this cavity end at 0.53 for spheres (``test_packing``), at 0.61 for these."""
    many = 136
    assert fill((RADIUS,) * many, CAVITY) == pytest.approx(0.588, abs=1e-3)
    for aspect in (0.5, 2.0):
        assert_apart(placed(Grains.alike(RADIUS, many, aspect=aspect)), CAVITY)


def test_spheres_are_placed_as_ever():
    position, axis = place(Grains.alike(RADIUS, 60), CAVITY, 3)
    assert np.array_equal(position, separate((RADIUS,) * 60, CAVITY, 3))
    assert np.array_equal(axis, np.tile([0, 0, 1], (60, 1)))


def test_too_many_spheroids_are_refused_with_both_fills(monkeypatch):
    monkeypatch.setattr(placement, "MOST", 40)  # a real refusal takes ten seconds
    monkeypatch.setattr(placement, "FEW", 40)
    with pytest.raises(
        PackingError, match=r"would fill 0\.692 of the cavity, and random packing reached 0\.\d\d\d; take"
    ):
        place(Grains.alike(RADIUS, 160, aspect=2.0), CAVITY, 1)


def test_a_spheroid_that_the_cavity_does_not_allow_is_refused():
    with pytest.raises(PackingError, match="at both ends at once"):
        place(Grains.alike(RADIUS, 2, aspect=3.0), CAVITY, 1)
    with pytest.raises(PackingError, match=r"diameter 13\.7\d* mm does not fit"):
        place(Grains.alike(RADIUS, 2, aspect=2.5), Cylinder(0.04, 0.013), 1)


SMALL = Grains.alike(RADIUS, 12, aspect=1.4)


@pytest.fixture
def small(make_scene):
    return make_scene(enclosure=Cylinder(0.02, 0.025), gravity=(0, 0, -9.81))


def test_a_loose_bed_of_spheroids_rests_and_is_kept_with_its_axes(small):
    request = Request(small, SMALL, 1, "loose")
    bed = prepare(request)
    assert np.abs(bed.state.velocity[:, 2]).max() < 0.02
    assert np.array_equal(bed.state.aspect, [1.4] * 12)
    assert np.allclose(np.linalg.norm(bed.state.axis, axis=1), 1, atol=1e-9)
    assert bed.clearance > 0
    stored = prepare(request)
    for name, array in bed.state.arrays().items():
        assert np.array_equal(array, stored.state.arrays()[name])
    assert {"axis", "aspect", "pair_history_normal", "pair_history_arm"} <= bed.state.arrays().keys()
    (cache_folder("beds") / f"{request.key()}.npz").unlink()
    again = prepare(request)
    assert np.array_equal(bed.state.axis, again.state.axis)


def test_spheroids_that_rock_are_stopped(small, monkeypatch):
    """Frictionless, a bed of aspect 0.7 in the paper's cavity still rocked after 2.9 s; stopped at once, this rests too."""
    monkeypatch.setattr(settling, "ROCKING", 0.0)
    position, axis = place(SMALL, small.enclosure, 2)
    start = State.at_rest(position, SMALL.radius, aspect=SMALL.aspect, axis=axis)
    rest = settling.settle(small, start)
    assert np.abs(rest.velocity[:, 2]).max() < 0.02
    assert rest.position[:, 2].mean() < start.position[:, 2].mean()


def test_the_aspect_is_part_of_a_beds_key(small):
    keys = {Request(small, Grains.alike(RADIUS, 12, aspect=aspect), 1).key() for aspect in (0.5, 1.0, 2.0)}
    assert len(keys) == 3
    assert Request(small, Grains.alike(RADIUS, 12), 1).key() in keys


@pytest.mark.slow
def test_spheroids_are_compacted_and_brought_to_a_clearance(small):
    loose, dense = (prepare(Request(small, SMALL, 1, how)) for how in ("loose", "compacted"))
    assert dense.settled
    assert dense.clearance > loose.clearance
    asked = (loose.clearance + dense.clearance) / 2
    assert prepare(Request(small, SMALL, 1, clearance=asked)).clearance == pytest.approx(asked, abs=2e-4)
