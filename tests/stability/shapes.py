"""Hard cases of spheroids; with the others of ``cases``."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from stability.cases import (
    CAVITY,
    PMMA,
    RADIUS,
    Outcome,
    attempt,
    hard,
    judge,
    scaled,
    scene,
    shaken,
)
from warpdamp import Batch, Case, Cylinder, Effects, Grains, State
from warpdamp.damper.placement import place
from warpdamp.damper.settling import settle
from warpdamp.engine.ledger import Ledger
from warpdamp.numerics.timestep import contact_step

COMMON = Effects(spheroids=True)
"""One set of effects, so that the tests compile few kernels: a dashpot of strength 0 does nothing."""


def shaped(aspect, count, *, radius=RADIUS, cavity=CAVITY, seed=1) -> State:
    """Spheroids in the cavity, apart."""
    radii = np.broadcast_to(radius, count).copy()
    position, axis = place(Grains(tuple(radii), (0,) * count, (aspect,) * count), cavity, seed)
    return State.at_rest(position, radii, aspect=aspect, axis=axis)


def tried(s, state, **options) -> Outcome:
    return attempt(s, state, effects=COMMON, **options)


@functools.cache
def jam() -> State:
    """As many prolate spheroids as random packing brings into the paper's cavity."""
    return shaped(2.0, 138)


WIDE = Cylinder(0.08, 0.04)


@hard("needles: spheroids of aspect 4")
def needles(fine):
    return tried(
        shaken(cavity=WIDE), shaped(4.0, 200 if fine else 30, radius=1.2e-3, cavity=WIDE), cycles=2 if fine else 1
    )


@hard("discs: spheroids of aspect 1/4")
def discs(fine):
    return tried(
        shaken(cavity=WIDE), shaped(0.25, 200 if fine else 30, radius=2e-3, cavity=WIDE), cycles=2 if fine else 1
    )


@hard("spheroids in a row along their common axis")
def in_a_row(fine):
    """Tip on tip, parallel and exactly on the axis of the cavity: no contact has an arm."""
    a = float(RADIUS * 1.4 ** (2 / 3))
    state = State.at_rest([[0, 0, (2 * k + 1.01) * a] for k in range(3)], RADIUS, aspect=1.4)
    return tried(shaken(), state, cycles=10 if fine else 4)


@hard("a jam of spheroids (0.597 of the cavity)")
def jammed(fine):
    return tried(shaken(), jam(), cycles=4 if fine else 1)


@hard("a spheroid that might touch the side at both ends", "refused")
def two_ends(fine):
    return tried(shaken(), State.at_rest([[0, 0, 0.02]], RADIUS, aspect=3.0))


@hard("discs of aspect 1/8, whose common normals Newton's method may miss", "refused")
def too_flat(fine):
    return tried(shaken(cavity=WIDE), State.at_rest([[0, 0, 0.02]], 2e-3, aspect=0.125))


@hard("spheroids whose centres coincide", "refused")
def coincident(fine):
    state = State.at_rest([[0, 0, 0.02]] * 2, RADIUS, aspect=2.0, axis=[[0, 0, 1], [1, 0, 0]])
    return tried(shaken(), state)


@hard("spheroids of sizes 1:20")
def sizes(fine):
    radius = np.concatenate([np.full(4, 6e-3), np.full(700 if fine else 200, 0.3e-3)])
    tight = Cylinder(0.034, 0.017)
    state = shaped(1.4, len(radius), radius=radius, cavity=tight)
    return attempt(shaken(gamma=60.0, cavity=tight), state, steps=20_000 if fine else 6000)


hard("spheroids, modulus x 1000")(
    lambda fine: tried(shaken(material=scaled(PMMA, 1e3)), jam(), steps=100_000 if fine else 20_000)
)
for e in (0.0, 1.0):
    hard(f"spheroids, restitution {e:g}")(
        lambda fine, e=e: tried(shaken(restitution=e), shaped(0.5, 120 if fine else 30), cycles=4 if fine else 1)
    )


@hard("a bed of spheroids at rest for ten million steps")
def resting(fine):
    """No drift and no heating; rolling resistance, for a spheroid on its side rolls on at no cost."""
    s = scene(cavity=Cylinder(0.024, 0.024), rolling=0.05)
    state = settle(s, shaped(2.0, 8, cavity=s.enclosure))
    batch = Batch([Case(s, state, contact_step(s, state))], effects=dataclasses.replace(COMMON, rolling=True))
    batch.advance(200_000)  # what is left of the settling dies away
    before, start = batch.read()[0]
    batch.advance(10_000_000 if fine else 300_000)
    after, ledger = batch.read()[0]
    moved = float(np.abs(after.position - before.position)[:, 2].max()) / RADIUS
    turned = float(np.linalg.norm(after.axis - before.axis, axis=1).max())
    gained = float(ledger.stored[0] - start.stored[0])  # what rolls and rocks goes on for long
    outcome = judge(batch.status[0], Ledger(np.concatenate([start.rows, ledger.rows])), after, s)
    said = f"moved by {moved:.1g} R, turned by {turned:.1g} rad, energy changed by {gained:.1g} J"
    if moved > 1e-3 or gained > 1e-15:
        return dataclasses.replace(outcome, flagged=said.upper())
    return dataclasses.replace(outcome, message=said)


def _nan(batch):
    particles = batch._particles.numpy().copy()
    particles["axis"][3, 1] = np.nan
    batch._particles.assign(particles)


hard("NaN planted in an axis", "flagged")(lambda fine: tried(shaken(), shaped(2.0, 30), cycles=1, plant=_nan))


@hard("NaN in the axis given", "refused")
def nan_given(fine):
    state = shaped(2.0, 30)
    state.axis[3, 1] = np.nan
    return tried(shaken(), state)
