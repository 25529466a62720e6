"""Spheroids as particles of the engine: bits, momentum, rotation, the ledger, rest and impacts.

One set of effects does for nearly all of it, in a cavity too wide to be met where none is wanted: kernels of spheroids
take their time to compile.
"""

import dataclasses

import numpy as np
import pytest

from verification.spheroids import WIDE, about_to_meet
from warpdamp import Batch, Case, Effects, Scene, State, Surface
from warpdamp.damper.placement import place
from warpdamp.numerics.timestep import shortest_contact
from warpdamp.scene.paper import PMMA, RADIUS
from warpdamp.scene.particles import Grains

FULL = Effects(spheroids=True)
EVERYTHING = dataclasses.replace(FULL, rolling=True, sizes=True, materials=True)


def free_scene(restitution=1.0, friction=0.0, rolling=0.0, *, material=PMMA, gravity=(0, 0, 0), cavity=WIDE):
    surface = Surface(restitution, friction, rolling)
    return Scene(material, material, surface, surface, cavity, gravity)


def bed_case(damper, aspect, gamma=6.0, steps=5435, count=120):
    scene = damper(46.0, gamma)
    position, axis = place(Grains.alike(RADIUS, count, aspect=aspect), scene.enclosure, 1)
    return Case(scene, State.at_rest(position, RADIUS, aspect=aspect, axis=axis), 1 / 46 / steps, steps)


def same(a, b):
    ours, theirs = a.arrays(), b.arrays()
    return ours.keys() == theirs.keys() and all(np.array_equal(ours[name], theirs[name]) for name in ours)


def angular_momentum(state, mass):
    """About the origin, (3,), of rigid bodies; and the momentum."""
    a, b = state.semi_axes
    transverse, axial = mass * (a**2 + b**2) / 5, 0.4 * mass * b**2
    along = np.einsum("ij,ij->i", state.spin, state.axis)
    own = transverse[:, None] * state.spin + ((axial - transverse) * along)[:, None] * state.axis
    momentum = mass[:, None] * state.velocity
    return (own + np.cross(state.position, momentum)).sum(axis=0), momentum.sum(axis=0)


# ---- bits ------------------------------------------------------------------------------------------------------------


def test_neither_skin_nor_company_nor_readings_nor_a_checkpoint_change_a_bit(damper):
    cases = [bed_case(damper, aspect) for aspect in (2.0, 0.5)]
    n = cases[0].steps_per_cycle
    alone = Batch([cases[0]], max_rows=2)
    alone.advance(n)
    state, rows = alone.read()[0][0], alone.cycles(0).rows
    for other in (Batch([cases[0]], max_rows=2, skin=0.6), Batch(cases, max_rows=2)):
        other.advance(n)
        assert np.array_equal(other.cycles(0).rows, rows)
        assert same(other.read()[0][0], state)
    halting, again = (Batch([cases[0]], max_rows=2) for _ in range(2))
    for steps in (1, 1000, n // 2):
        halting.advance(steps)
        halting.read()
    again.restore(halting.checkpoint())
    again.advance(n)
    assert np.array_equal(again.cycles(0).rows, rows)
    assert len(state.pairs) > 20


def test_a_state_read_and_started_again_goes_on(damper):
    """Contacts keep normals and arms, whichever of two particles comes first.

    1e-5: an overlap that has just begun is known to 1e-9 of itself, and beds multiply differences.
    """
    case = bed_case(damper, 2.0)
    batch = Batch([case], max_rows=2)
    batch.advance(2700)
    start = batch.read()[0][0]
    assert len(start.pairs) > 20
    assert np.allclose(np.linalg.norm(start.pair_history.normal, axis=1), 1)
    flipped = np.arange(120)[::-1]
    through, other = (Batch([dataclasses.replace(case, state=s)]) for s in (start, renumbered(start, flipped)))
    through.advance(200)
    other.advance(200)
    moved = other.read()[0][0]
    for name in ("position", "axis", "spin"):
        now = getattr(through.read()[0][0], name)
        np.testing.assert_allclose(getattr(moved, name)[flipped], now, atol=1e-5 * np.abs(now).max())


def renumbered(state, order):
    """The same state with particle ``order[k]`` as number k."""
    number = np.argsort(order)
    pairs = number[state.pairs]
    between = state.position[state.pairs[:, 0]] - state.position[state.pairs[:, 1]]
    history = state.pair_history.seen_from_the_other(pairs[:, 0] > pairs[:, 1], between)
    fields = {
        n: getattr(state, n)[order] for n in ("position", "velocity", "spin", "radius", "species", "axis", "aspect")
    }
    return State(pairs=np.sort(pairs, axis=1), pair_history=history, wall_history=state.wall_history[order], **fields)


# ---- the limit of spheres --------------------------------------------------------------------------------------------


def impacts(effects, friction, dt, steps, count=12):
    """Oblique impacts of two spinning spheres: states after, and energies lost."""
    scene = free_scene(0.52, friction)
    batch = Batch([Case(scene, about_to_meet(1.0, seed), dt) for seed in range(count)], effects=effects)
    batch.advance(steps)
    return batch.read()


def test_aspect_one_is_a_sphere():
    """Without friction to round-off.  With it to 1e-4, falling with the step: spheres take arms of the whole step."""
    spheres, spheroids = (impacts(e, 0.0, 1e-6, 300) for e in (Effects(), FULL))
    for (one, book), (other, ledger) in zip(spheres, spheroids, strict=True):
        np.testing.assert_allclose(other.velocity, one.velocity, atol=1e-12)
        np.testing.assert_allclose(other.spin, one.spin, atol=1e-12 * np.abs(one.spin).max())
        assert ledger.dissipated[-1] == pytest.approx(book.dissipated[-1], rel=1e-11)
    differences = []
    for dt in (1e-6, 0.5e-6):
        spheres, spheroids = (impacts(e, 0.5, dt, round(3e-4 / dt)) for e in (Effects(), FULL))
        differences.append(
            max(np.abs(a.velocity - b.velocity).max() for (a, _), (b, _) in zip(spheres, spheroids, strict=True))
        )
    assert differences[0] < 1e-4
    assert differences[1] < 0.6 * differences[0]


def test_a_bed_of_spheres_goes_on_in_kernels_of_spheroids(damper, loose_positions):
    """Spheres keep no normals; 1e-3 of what forgetting their contacts does."""
    scene, dt = damper(), 1e-6
    fallen = Batch([Case(scene, State.at_rest(loose_positions(1), RADIUS), dt)])
    fallen.advance(20_000)
    start = fallen.read()[0][0]
    assert len(start.pairs) > 100
    forgetful = State(*(getattr(start, name) for name in ("position", "velocity", "spin", "radius")))
    ends = []
    for state, effects in ((start, Effects()), (start, FULL), (forgetful, Effects())):
        batch = Batch([Case(scene, state, dt)], effects=effects)
        batch.advance(400)
        ends.append(batch.read()[0][0].position)
    assert np.abs(ends[1] - ends[0]).max() < 1e-3 * np.abs(ends[2] - ends[0]).max()


# ---- conservation and the ledger -------------------------------------------------------------------------------------


def test_momentum_and_angular_momentum_are_kept():
    """Of a mixture with friction, dashpots and rolling resistance, no walls met: forces are equal, on one line."""
    materials, surface = (PMMA, dataclasses.replace(PMMA, density=2000)), Surface(0.5, 0.5, 0.1)
    scene = Scene(materials, PMMA, ((surface,) * 2,) * 2, (surface,) * 2, WIDE, (0, 0, 0))
    cases = []
    for seed in range(16):
        state = about_to_meet((0.5, 2.0), seed, spin=600.0, radius=(RADIUS, 0.6 * RADIUS))
        state.species[:] = (0, 1)
        state.position -= state.position.mean(axis=0) - [0, 0, 5.0]
        cases.append(Case(scene, state, 1e-6))
    batch = Batch(cases, effects=EVERYTHING)
    batch.advance(400)
    lost = dict.fromkeys(
        ("particle_normal_dashpot", "particle_tangential_dashpot", "particle_slip", "particle_rolling"), 0.0
    )
    for case, (after, ledger) in zip(cases, batch.read(), strict=True):
        mass = scene.masses(case.state)
        for name, before, now in zip(
            ("angular", "linear"), angular_momentum(case.state, mass), angular_momentum(after, mass), strict=True
        ):
            scale = np.sum(mass * np.linalg.norm(case.state.velocity, axis=1)) * (RADIUS if name == "angular" else 1.0)
            assert np.abs(now - before).max() < 1e-9 * scale, name  # so far from the origin
        for name in lost:
            lost[name] += ledger[name][-1]
        assert min(ledger[name][-1] for name in ledger.losses) >= 0
    assert min(lost.values()) > 0


# ---- what is refused -------------------------------------------------------------------------------------------------


def test_what_spheroids_are_not_for(damper):
    scene = damper()
    long = State.at_rest([[0, 0, 0.02]], RADIUS, aspect=3.0)
    with pytest.raises(ValueError, match="both ends at once"):
        Batch([Case(scene, long, 1e-6)])
    with pytest.raises(ValueError, match="'rotation' cannot be forced off"):
        FULL.forced({"rotation": False})
    assert Effects(spheroids=True, rotation=False).rotation
    deep = State.at_rest([[0, 0, 0.02], [0, 0, 0.02 + 1.8 * RADIUS]], RADIUS, aspect=2.0)
    with pytest.raises(ValueError, match="particles 0 and 1 overlap by 1"):
        Batch([Case(scene, deep, 1e-6)])
    together = State.at_rest([[0, 0, 0.02]] * 2, RADIUS, aspect=2.0)
    with pytest.raises(ValueError, match="particles 0 and 1 overlap"):
        Batch([Case(scene, together, 1e-6)])
    for name, value, message in (
        ("aspect", 0.0, "aspect of particle 0 is not positive"),
        ("axis", np.nan, "not finite"),
    ):
        bad = State.at_rest([[0, 0, 0.02]], RADIUS, aspect=2.0)
        getattr(bad, name)[0] = value
        with pytest.raises(ValueError, match=message):
            Batch([Case(scene, bad, 1e-6)])


def test_steps_are_of_the_shortest_contact(damper):
    scene = damper(46.0, 6.0)
    spheres, long = (Grains.alike(RADIUS, 120, aspect=aspect) for aspect in (1.0, 2.0))
    shorter = shortest_contact(scene, long, 0.5) / shortest_contact(scene, spheres, 0.5)
    assert shorter == pytest.approx(0.77, abs=0.005)


def test_float32_follows_float64_for_a_while(damper):
    """A tenth of the first cycle's losses, as of spheres: beds multiply differences of rounding."""
    case = bed_case(damper, 2.0)
    rows = []
    for precision in ("float64", "float32"):
        batch = Batch([case], max_rows=2, effects=dataclasses.replace(FULL, precision=precision))
        batch.advance(case.steps_per_cycle)
        rows.append(batch.cycles(0))
    assert rows[1].dissipated[-1] == pytest.approx(rows[0].dissipated[-1], rel=0.1)
