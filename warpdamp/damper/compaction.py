"""Compaction of a bed by shaking without friction, and the clearance that says when it is done.

The loose positions are settled without friction and shaken along gravity (up and down) at six times the scene's gravity
and an amplitude of 0.11 of a particle's diameter (43 Hz in the paper's damper).  A block is 24 cycles without friction;
4 cycles with the friction of the scene, which leave the bed with contacts that it keeps; rest; and the clearance.  It
rises by the logarithm of the cycles and scatters by two percent of a diameter from block to block, so that a rule on
its means ends too early.  Done, after at most 24 blocks, when five in a row bring no clearance that is one percent of a
diameter larger than the largest before; the bed is the one with the largest.  Without floor or lid, twice the depth of
the centre of mass, as of a block's top, stands for the clearance.

With friction, beds compact by the logarithm of the cycles, as glasses do, and each seems to end elsewhere.  To choose a
packing's density by the friction while it is made is usual (Silbert, arXiv:1108.0012).

While beds are compacted and clearances measured, contacts have half the steps and the lower modulus at which the
fastest impact expected overlaps by two percent of the reduced radius; a bed's last rest is with the scene's own.
"""

from __future__ import annotations

import logging
import math
from dataclasses import replace
from functools import partial

import numpy as np

from ..engine.batch import Batch, Case
from ..numerics.timestep import Numerics, expected_speed, steps_per_cycle
from ..scene.contact import softening
from ..scene.particles import State
from ..scene.scene import Cylinder, Drive, Scene
from .case import (
    KEEPING_CYCLES,
    MOST_BLOCKS,
    PATIENCE,
    SHAKING_AMPLITUDE,
    SHAKING_CYCLES,
    SHAKING_GAMMA,
    SOFT_OVERLAP,
    STILL,
)
from .placement import fill
from .scenes import frictionless, upright_scenes
from .settling import USUAL, advance, balanced, settle

_log = logging.getLogger(__name__)


def compact(scene: Scene, state: State, numerics: Numerics) -> tuple[State, list[float], bool]:
    """Shake a bed until its clearance no longer rises; see the head of this module.

    Returns
    -------
    state, clearances, settled
        The bed, its clearance after each block of shaking [m], and whether that no longer rises.
    """
    least = STILL * 2 * float(np.mean(state.radius))
    soft, coarse = soft_contacts(scene, state), _coarse(numerics)
    densest = state = settle(frictionless(soft), state, coarse)
    clearances: list[float] = []
    while len(clearances) < MOST_BLOCKS and not no_longer_rises(clearances, least):
        state = settle(soft, block(scene, state, numerics, SHAKING_CYCLES), coarse)
        clearance = _free_height(scene, state, numerics)
        if clearance > max(clearances, default=-math.inf):
            densest = state
        clearances.append(clearance)
    settled = no_longer_rises(clearances, least)
    if not settled:
        _log.warning("bed still compacting after %d blocks of %d cycles of shaking", MOST_BLOCKS, SHAKING_CYCLES)
    return densest, clearances, settled


def block(scene: Scene, state: State, numerics: Numerics, cycles: int, gamma: float = SHAKING_GAMMA) -> State:
    """A bed after ``cycles`` without friction and a few with it."""
    soft, coarse = soft_contacts(scene, state), _coarse(numerics)
    parts = [(frictionless(soft), cycles), (soft, KEEPING_CYCLES)]
    for part, number in parts[0 if cycles else 1 :]:
        shaken = part.driven(shaking(scene, state.radius, gamma))
        state = balanced(partial(_shaken, shaken, state, number), coarse)
    return state


def _shaken(scene: Scene, state: State, cycles: int, numerics: Numerics) -> State:
    """A bed after some cycles of the scene's drive."""
    steps = steps_per_cycle(scene, state, steps_per_contact=numerics.steps_per_contact)
    case = Case(scene, state, 1 / (scene.drive.frequency * steps))
    batch = Batch([case], max_rows=cycles + 1, effects=numerics.effects(scene, state))
    return advance(batch, cycles * steps)[0]


def no_longer_rises(clearances, least: float) -> bool:
    """Whether none of the last ``PATIENCE`` is more than ``least`` above the largest before them [m]."""
    if len(clearances) <= PATIENCE:
        return False
    return max(clearances[-PATIENCE:]) - max(clearances[:-PATIENCE]) <= least


def shaking(scene: Scene, radius, gamma: float = SHAKING_GAMMA) -> Drive:
    """Along gravity, with ``gamma`` times its acceleration, at the frequency of compaction."""
    gravity = float(np.linalg.norm(scene.gravity))
    diameter = 2 * float(np.mean(radius))
    frequency = math.sqrt(SHAKING_GAMMA * gravity / (SHAKING_AMPLITUDE * diameter)) / (2 * math.pi)
    return Drive(frequency, gamma * gravity, tuple(-component / gravity for component in scene.gravity))


def soft_contacts(scene: Scene, state: State) -> Scene:
    """The scene with moduli so low that the fastest impact of compaction overlaps by ``SOFT_OVERLAP``; never higher."""
    speed = expected_speed(scene.driven(shaking(scene, state.radius)), state.radius)
    return scene.softened(softening(scene, speed, SOFT_OVERLAP))


def _coarse(numerics: Numerics) -> Numerics:
    """Half the steps a contact, enough where only the bed matters."""
    return replace(numerics, steps_per_contact=numerics.steps_per_contact / 2)


def measured_clearance(scene: Scene, state: State, numerics: Numerics = USUAL) -> float:
    """Travel of the centre of mass along the axis between rest on the floor and rest against the lid [m].

    Standard gravity along the axis, down and then up, whatever the scene's own; not a number without floor or lid.
    """
    if not (scene.enclosure.floor and scene.enclosure.lid):
        return math.nan
    heights = []
    for upright in upright_scenes(scene):
        state = settle(soft_contacts(upright, state), state, _coarse(numerics))
        heights.append(float(np.average(state.position[:, 2], weights=scene.masses(state))))
    return heights[1] - heights[0]


def packing_fraction(radius, enclosure: Cylinder, clearance: float) -> float:
    """Volume of the particles over that of the part of the cavity that they keep to, v / (1 - h / L) (eq. 2).

    Parameters
    ----------
    radius : (n,) [m]
    clearance : h [m]; see ``measured_clearance``
    """
    return fill(radius, enclosure) / (1 - clearance / enclosure.height)


def _free_height(scene: Scene, state: State, numerics: Numerics) -> float:
    """Clearance of a bed [m] or, without floor or lid, twice the depth of its centre of mass (of a block's top)."""
    clearance = measured_clearance(scene, state, numerics)
    return clearance if math.isfinite(clearance) else -2 * _height(scene, state)


def _height(scene: Scene, state: State) -> float:
    """Height of the centre of mass against gravity [m]."""
    up = -np.array(scene.gravity) / np.linalg.norm(scene.gravity)
    return float(np.average(state.position @ up, weights=scene.masses(state)))
