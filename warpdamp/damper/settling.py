"""Rest of a bed under gravity, and the energy balance that every part of making one has to keep.

A part that gains energy from nowhere is repeated at half the step.  Dashpots act on predicted velocities, which is
stable while the rate at which they damp a motion is below 1 / dt; in a jam the contacts of one sphere add up.
Spheroids that rock long after the others rest are stopped.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from ..engine.batch import Batch, Case
from ..engine.checks import LARGEST_RESIDUAL, residual_share
from ..engine.ledger import Ledger
from ..errors import PackingError
from ..kernels.columns import KernelStatus
from ..numerics.timestep import Numerics, contact_step
from ..scene.particles import State
from ..scene.scene import Scene

HALVINGS = 2
"""How often the step is halved at the most."""

USUAL = Numerics()

RESTING_ENERGY = 1e-5
"""A bed is at rest when the kinetic energy of its motion along gravity is below this part of m g R in the mean (a
sphere may go on rolling: nothing stops it)."""
LONGEST_REST = 45.0
"""A bed that is not at rest after this many times sqrt(H / g), H the cavity's height, does not come to rest (2.9 s for
40 mm under standard gravity)."""

ROCKING = 15.0
"""Times sqrt(H / g) after which spheroids that still rock are stopped at every look: dashpots hardly damp them, and
without friction nothing else does.  At any phase half of the energy, in the mean, is that of motion.  Not a part of
``RECIPE``, which beds of spheres have in their keys, too: whoever changes it raises the version of the physics."""

_log = logging.getLogger(__name__)


class OutOfBalance(PackingError):
    """Bed whose ledger gained energy without work."""


def balanced(part: Callable[[Numerics], State], numerics: Numerics) -> State:
    """A part of making a bed, at the usual step or, where that gains energy, at a finer one.

    Raises
    ------
    PackingError
        If the finest gains energy, too.
    """
    for _ in range(HALVINGS):
        try:
            return part(numerics)
        except OutOfBalance:
            numerics = replace(numerics, steps_per_contact=2 * numerics.steps_per_contact)
            _log.info("a bed gained energy from nowhere: again with %g steps a contact", numerics.steps_per_contact)
    return part(numerics)


def settle(scene: Scene, state: State, numerics: Numerics = USUAL, *, time: float | None = None) -> State:
    """Let a bed come to rest (or fall for a fixed ``time`` [s]) under the scene's gravity, enclosure at rest."""
    return balanced(partial(_settled, scene, state, time), numerics)


def _settled(scene: Scene, state: State, time: float | None, numerics: Numerics) -> State:
    still = scene.driven(None)
    dt = contact_step(still, state, steps_per_contact=numerics.steps_per_contact)
    batch = Batch([Case(still, state, dt)], effects=numerics.effects(still, state))
    if time is not None:
        return advance(batch, math.ceil(time / dt))[0]
    gravity = float(np.linalg.norm(scene.gravity))
    mass, up = scene.masses(state), -np.array(scene.gravity) / gravity
    resting = RESTING_ENERGY * float(np.sum(mass * state.radius)) * gravity
    fall = math.sqrt(scene.enclosure.height / gravity)
    pause = math.ceil(fall / 2 / dt)
    before, ledger = 0, None  # steps of batches that ended, and where this one is
    for steps in range(pause, math.ceil(LONGEST_REST * fall / dt) + pause, pause):
        state, ledger = advance(batch, steps - before, ledger)
        kinetic = float(np.sum(mass * (state.velocity @ up) ** 2) / 2)
        if kinetic < resting:
            return state
        if np.any(state.aspect != 1) and steps * dt > ROCKING * fall:
            batch, before, ledger = _stopped(still, state, dt, numerics), steps, None
    raise PackingError(
        f"the bed does not come to rest within {LONGEST_REST * fall:.2g} s: kinetic energy {kinetic:.2g} J, at rest "
        f"below {resting:.2g} J; give the contacts a restitution below 1, or friction",
        "contact",
    )


def _stopped(scene: Scene, state: State, dt: float, numerics: Numerics) -> Batch:
    """The bed without its motion."""
    still = replace(state, velocity=np.zeros_like(state.velocity), spin=np.zeros_like(state.spin))
    return Batch([Case(scene, still, dt)], effects=numerics.effects(scene, still))


def advance(batch: Batch, steps: int, before: Ledger | None = None) -> tuple[State, Ledger]:
    """Advance a batch of one case to a step; returns what is read there, which costs as much as some hundred steps.

    Parameters
    ----------
    batch : Batch
    steps : int
    before : Ledger or None
        What was read where the batch is now.  None: it is read.

    Raises
    ------
    OutOfBalance
        If the ledger does not close.
    """
    before = before or batch.read()[0][1]
    batch.advance(steps)
    state, after = batch.read()[0]
    ledger = Ledger(np.concatenate([before.rows, after.rows]), before.effects)
    if batch.status[0] != KernelStatus.OK or residual_share(ledger) > LARGEST_RESIDUAL:
        raise OutOfBalance(
            "the bed gained energy from nowhere while it was prepared: raise numerics.steps_per_contact "
            "or take numerics.precision float64",
            "preparation",
        )
    return state, after
