"""Beds brought to a state asked for, a clearance or a packing fraction, from a loose one.

The loose bed is shaken in the blocks of compaction until it has the clearance asked for, to 0.05 mm: with fewer cycles,
and then with friction alone, whenever a block leads beyond it, each with another Gamma; or the nearest of 60 blocks is
taken.
"""

from __future__ import annotations

import logging
from dataclasses import replace

from ..errors import PackingError
from ..numerics.timestep import Numerics
from ..scene.scene import Scene
from .case import GOLDEN, MILDEST, MOST_TRIES, REACHED, SHAKING_CYCLES, SHAKING_GAMMA, Packing, Request
from .compaction import block, measured_clearance, packing_fraction
from .placement import fill
from .settling import settle

_log = logging.getLogger(__name__)


def brought(request: Request, loose: Packing, dense: Packing) -> Packing:
    """The bed with the clearance or the packing fraction asked for; see the head of this module."""
    scene = request.scene
    ((name, asked),) = request.asked.items()
    own = fill(request.grains.radius, scene.enclosure)
    clearance = asked if name == "clearance" else scene.enclosure.height * (1 - own / asked)
    if not loose.clearance - REACHED <= clearance <= dense.clearance + REACHED:
        raise PackingError(_out_of_reach(scene, name, asked, loose, dense), f"preparation.{name}")
    nearest = min(loose, dense, key=lambda bed: abs(bed.clearance - clearance))
    if abs(nearest.clearance - clearance) > REACHED:
        nearest = _approach(scene, loose, clearance, request.numerics)
    if abs(nearest.clearance - clearance) > REACHED:
        _log.warning(
            "a clearance of %.3g mm was asked for, and %.3g mm reached in %d parts of shaking",
            *(1e3 * clearance, 1e3 * nearest.clearance, MOST_TRIES),
        )
    return nearest


def _out_of_reach(scene: Scene, name: str, asked: float, loose: Packing, dense: Packing) -> str:
    clearances = [bed.clearance for bed in (loose, dense)]
    wanted = f"{asked:.3f}"
    found = [f"{packing_fraction(loose.state.radius, scene.enclosure, clearance):.3f}" for clearance in clearances]
    if name == "clearance":
        wanted, *found = (f"{1e3 * clearance:.2f} mm" for clearance in (asked, *clearances))
    noun = name.replace("_", " ")
    return f"a {noun} of {wanted} cannot be reached: this bed has {found[0]} loose and {found[1]} compacted"


def _approach(scene: Scene, start: Packing, clearance: float, numerics: Numerics) -> Packing:
    """Shake a bed up to a clearance; the nearest bed that was met.

    Each part starts from the nearest bed below the clearance, and after one that leads beyond it has half the cycles
    without friction; those with friction alone, which loosen as well, start from the nearest of all.  Each has another
    Gamma: the same part from the same bed would end in the same bed.
    """
    nearest = below = start
    cycles = SHAKING_CYCLES
    for tries in range(1, MOST_TRIES + 1):
        gamma = MILDEST + (SHAKING_GAMMA - MILDEST) * (tries * GOLDEN % 1)
        origin = below if cycles else nearest
        state = settle(scene, block(scene, origin.state, numerics, cycles, gamma), numerics)
        bed = Packing(state, measured_clearance(scene, state, numerics), tries)
        nearest = min(nearest, bed, key=lambda bed: abs(bed.clearance - clearance))
        if abs(nearest.clearance - clearance) <= REACHED:
            return nearest
        if bed.clearance > clearance:
            cycles //= 2
        elif bed.clearance > below.clearance:
            below = bed
        elif cycles == 0:
            cycles = SHAKING_CYCLES // 2
    return replace(nearest, settled=False)
