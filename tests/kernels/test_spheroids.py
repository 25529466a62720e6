"""Spheroids as particles of the engine: bits, momentum, rotation, the ledger, rest and impacts.

One set of effects does for nearly all of it, in a cavity too wide to be met where none is wanted: kernels of spheroids
take their time to compile.
"""

import dataclasses

import numpy as np

from warpdamp import Batch, Case, Cylinder, Effects, Scene, State, Surface
from warpdamp.damper.placement import place
from warpdamp.scene.paper import PMMA, RADIUS
from warpdamp.scene.particles import Grains

FULL = Effects(spheroids=True)
EVERYTHING = dataclasses.replace(FULL, rolling=True, sizes=True, materials=True)
WIDE = Cylinder(10.0, 10.0)
MIDDLE = np.array([0.0, 0.0, 5.0])


def free_scene(restitution=1.0, friction=0.0, rolling=0.0, *, material=PMMA, gravity=(0, 0, 0), cavity=WIDE):
    surface = Surface(restitution, friction, rolling)
    return Scene(material, material, surface, surface, cavity, gravity)


def unit_vectors(rng, n):
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def about_to_meet(aspect, seed, *, spin=100.0, speed=0.5, radius=(RADIUS, RADIUS)):
    """Two spheroids 1 um from each other, that meet obliquely, and spin [rad/s]."""
    from warpdamp.scene.touch import common_normal, spheroids_of

    rng = np.random.default_rng(seed)
    axis, direction = unit_vectors(rng, 2), unit_vectors(rng, 1)[0]
    pair = np.array([[0]]), np.array([[1]])

    def at(distance):
        place = MIDDLE + np.outer([0.5, -0.5], distance * direction)
        return State.at_rest(place, radius, aspect=aspect, axis=axis)

    def nearest(state):
        both = spheroids_of(state)
        normal, gap = common_normal(state.position[:1] - state.position[1:], both[pair[0][0]], both[pair[1][0]])
        return normal[0], gap[0]

    low, high = 0.0, 2 * float(np.max(at(0.0).bounding_radius)) + 1e-5
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if nearest(at(middle))[1] > 1e-6 else (middle, high)
    state = at(high)
    state.velocity[:] = np.outer([-0.5, 0.5], speed * (nearest(state)[0] + 0.3 * rng.normal(size=3)))
    state.spin[:] = spin * rng.normal(size=(2, 3))
    return state


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
