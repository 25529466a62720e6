"""Beds: particles that fit the closed cavity, settled, and prepared in a stated way.

``loose``
    Made inside the closed cavity without overlap, then settled under gravity with the friction of the scene.
``compacted``
    The same positions settled without friction and shaken along gravity (up and down) at six times the scene's gravity
    until the clearance no longer rises.  A block is 12 cycles without friction, with an amplitude of 0.22 of a
    particle's diameter (30 Hz in the paper's damper); 4 cycles with the friction of the scene and 0.1 of a diameter
    (46 Hz), which leave the bed with contacts that it keeps; rest; and the clearance.  Done, after at most 20 blocks,
    when the mean clearance of the last two is no more than two percent of a diameter above that of the two before (one
    clearance scatters by that much); the bed is the one of the last two with the larger clearance.  Without floor or
    lid, twice the depth of the centre of mass, as of a block's top, stands for the clearance.
    With friction, beds compact by the logarithm of the cycles, as glasses do, and each seems to end elsewhere.  To
    choose a packing's density by the friction while it is made is usual (Silbert, arXiv:1108.0012).
``compacted`` to a ``clearance`` or ``packing_fraction``
    The loose bed shaken in such blocks until it has the clearance asked for, to 0.05 mm: with fewer cycles, and then
    with friction alone, whenever a block leads beyond it; or the nearest of 60 blocks.

While beds are compacted and clearances measured, contacts have half the steps and the lower modulus at which the
fastest impact expected overlaps by two percent of the reduced radius; a bed's last rest is with the scene's own.

A part of either that gains energy from nowhere is repeated at half the step.  Dashpots act on predicted velocities,
which is stable while the rate at which they damp a motion is below 1 / dt; in a jam the contacts of one sphere add up.

Every bed is reproducible from its inputs, and is kept on disk under their hash.
"""

from __future__ import annotations

import io
import logging
import math
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from ..engine.batch import Batch, Case
from ..engine.checks import LARGEST_RESIDUAL, residual_share
from ..engine.ledger import Ledger
from ..errors import PackingError
from ..files import cache_folder, keep, locked
from ..kernels.columns import KernelStatus
from ..numerics.timestep import Numerics, contact_step, expected_speed, steps_per_cycle
from ..scene.contact import softening
from ..scene.effects import Effects
from ..scene.particles import State
from ..scene.scene import STANDARD_GRAVITY, Cylinder, Drive, Scene, Surface
from .case import (
    KEEPING_AMPLITUDE,
    KEEPING_CYCLES,
    MILDER,
    MILDEST,
    MOST_BLOCKS,
    MOST_TRIES,
    REACHED,
    SHAKING_AMPLITUDE,
    SHAKING_CYCLES,
    SHAKING_GAMMA,
    SOFT_OVERLAP,
    STILL,
    WINDOW,
    Request,
)
from .placement import fill, separate

HALVINGS = 2
"""How often the step is halved at the most."""

_USUAL = Numerics()

RESTING_ENERGY = 1e-5
"""A bed is at rest when the kinetic energy of its motion along gravity is below this part of m g R in the mean (a
sphere may go on rolling: nothing stops it)."""
LONGEST_REST = 45.0
"""A bed that is not at rest after this many times sqrt(H / g), H the cavity's height, does not come to rest (2.9 s for
40 mm under standard gravity)."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Packing:
    """Prepared bed at rest.

    Parameters
    ----------
    state : State
    clearance : float [m]
        How far its centre of mass travels between rest on the floor and rest against the lid.
    blocks : int
        Blocks of shaking that it took (0: loose).
    settled : bool
        Whether the rule that ends its preparation was met; false if it was still compacting after the last block.
    """

    state: State
    clearance: float
    blocks: int
    settled: bool = True


def prepare(request: Request) -> Packing:
    """Bed of a request, from disk if it was made before.

    Raises
    ------
    PackingError
        If the particles do not fit (with the fill asked for and the fill reached), do not come to rest or fall out of
        the cavity, or if a clearance or packing fraction asked for cannot be reached (with those that can).

    Examples
    --------
    >>> from warpdamp import Cylinder, Grains, Material, Request, Scene, Surface, prepare
    >>> pmma, surface = Material(920, 3.3e9, 0.37), Surface(0.52, 0.86)
    >>> scene = Scene(pmma, pmma, surface, surface, Cylinder(0.04, 0.04))
    >>> bed = prepare(Request(scene, Grains.alike(3.73e-3, 10), seed=1, preparation="loose"))
    >>> round(1e3 * bed.clearance, 1)  # one layer: the height less a diameter, 40 - 7.46 [mm]
    32.5
    """
    ends = _ends(request) if request.asked else ()
    path = cache_folder("beds") / f"{request.key()}.npz"
    if (stored := _stored(path)) is not None:
        return stored
    with locked(path.parent / f".lock-{path.name[:2]}", wait=True):  # another process may be making it
        if (stored := _stored(path)) is None:
            stored = _brought(request, *ends) if ends else _make(request)
            content = io.BytesIO()
            values = {name: value for name, value in vars(stored).items() if name != "state"}
            np.savez(content, **values, **stored.state.arrays())
            keep(path, content.getvalue())
    return stored


def _stored(path: Path) -> Packing | None:
    """A bed from disk; None if there is none, or if the file is damaged (it is then made anew)."""
    try:
        with np.load(path) as file:
            values = dict(file)
        own = {"clearance": float, "blocks": int, "settled": bool}
        return Packing(**{name: kind(values.pop(name)) for name, kind in own.items()}, state=State.from_arrays(values))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        _log.warning("%s is damaged (%s); making the bed anew", path, error)
        return None


def effects(request: Request) -> set[Effects]:
    """Sets of effects that kernels are compiled for while a bed is made."""
    scenes = [request.scene, *_upright(request.scene)]
    if request.preparation == "compacted":
        bare = frictionless(request.scene)
        scenes += [bare.driven(None), *(scene.driven(Drive(1.0, 1.0)) for scene in (request.scene, bare))]
    return {request.numerics.effects(scene, request.grains) for scene in scenes}


def _upright(scene: Scene) -> list[Scene]:
    """The scene under standard gravity along the axis, down and up."""
    return [replace(scene, gravity=(0.0, 0.0, pull)) for pull in (-STANDARD_GRAVITY, STANDARD_GRAVITY)]


def _make(request: Request) -> Packing:
    scene, numerics = request.scene, request.numerics
    _check_walls(scene)
    position = separate(request.grains.radius, scene.enclosure, request.seed)
    state = State.at_rest(position, request.grains.radius, request.grains.species)
    if request.preparation == "compacted":
        if not any(scene.gravity):
            raise PackingError("a bed cannot be compacted without gravity: ask for preparation: loose", "preparation")
        state, clearances, settled = compact(scene, state, numerics)
        state = settle(scene, state, numerics)
        return Packing(state, measured_clearance(scene, state, numerics), len(clearances), settled)
    if any(scene.gravity):
        state = settle(scene, state, numerics, time=request.settling_time)
    return Packing(state, measured_clearance(scene, state, numerics), 0)


def _check_walls(scene: Scene) -> None:
    """Refuse a cavity that gravity empties."""
    x, y, z = scene.gravity
    cavity = scene.enclosure
    walls = {"floor": z < 0 and not cavity.floor, "lid": z > 0 and not cavity.lid, "side": (x or y) and not cavity.side}
    for wall, missing in walls.items():
        if missing:
            raise PackingError(
                f"the particles fall out of a cavity without a {wall}: give it one, or set gravity to 0 and ask for "
                "preparation: loose",
                f"damper.enclosure.{wall}",
            )


def packing_fraction(radius, enclosure: Cylinder, clearance: float) -> float:
    """Volume of the particles over that of the part of the cavity that they keep to, v / (1 - h / L) (eq. 2).

    Parameters
    ----------
    radius : (n,) [m]
    clearance : h [m]; see ``measured_clearance``
    """
    return fill(radius, enclosure) / (1 - clearance / enclosure.height)


def _ends(request: Request) -> tuple[Packing, Packing]:
    """The loosest and the densest bed that a request with a state asked for lies between."""
    cavity = request.scene.enclosure
    if not (cavity.floor and cavity.lid):
        raise PackingError("a bed has a clearance only between a floor and a lid: give the cavity both", "preparation")
    own = replace(request, clearance=None, packing_fraction=None)
    return prepare(replace(own, preparation="loose")), prepare(own)


def _brought(request: Request, loose: Packing, dense: Packing) -> Packing:
    """The bed with the clearance or the packing fraction asked for; see the head of this module."""
    scene = request.scene
    ((name, asked),) = request.asked.items()
    own = fill(request.grains.radius, scene.enclosure)
    clearance = asked if name == "clearance" else scene.enclosure.height * (1 - own / asked)
    if not loose.clearance - REACHED <= clearance <= dense.clearance + REACHED:
        raise PackingError(_out_of_reach(scene, name, asked, loose, dense), "preparation")
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

    Whenever a part of shaking leads beyond the clearance, the next one starts from the bed before, with half the cycles
    without friction; once none are left, with a milder part with friction, which changes a bed least.
    """
    nearest = below = start
    cycles, gamma = SHAKING_CYCLES, SHAKING_GAMMA
    for tries in range(1, MOST_TRIES + 1):
        state = settle(scene, _block(scene, below.state, numerics, cycles, gamma), numerics)
        bed = Packing(state, measured_clearance(scene, state, numerics), tries)
        nearest = min(nearest, bed, key=lambda bed: abs(bed.clearance - clearance))
        if abs(nearest.clearance - clearance) <= REACHED:
            return nearest
        if bed.clearance < clearance:
            below = bed
        elif cycles:
            cycles //= 2
        else:
            gamma = MILDER * gamma if gamma > MILDEST else SHAKING_GAMMA
    return replace(nearest, settled=False)


class _OutOfBalance(PackingError):
    """Bed whose ledger gained energy without work."""


def _balanced(part: Callable[[Numerics], State], numerics: Numerics) -> State:
    """A part of making a bed, at the usual step or, where that gains energy, at a finer one.

    Raises
    ------
    PackingError
        If the finest gains energy, too.
    """
    for _ in range(HALVINGS):
        try:
            return part(numerics)
        except _OutOfBalance:
            numerics = replace(numerics, steps_per_contact=2 * numerics.steps_per_contact)
            _log.info("a bed gained energy from nowhere: again with %g steps a contact", numerics.steps_per_contact)
    return part(numerics)


def settle(scene: Scene, state: State, numerics: Numerics = _USUAL, *, time: float | None = None) -> State:
    """Let a bed come to rest (or fall for a fixed ``time`` [s]) under the scene's gravity, enclosure at rest."""
    return _balanced(partial(_settled, scene, state, time), numerics)


def _settled(scene: Scene, state: State, time: float | None, numerics: Numerics) -> State:
    still = scene.driven(None)
    dt = contact_step(still, state, steps_per_contact=numerics.steps_per_contact)
    batch = Batch([Case(still, state, dt)], effects=numerics.effects(still, state))
    if time is not None:
        _run(batch, math.ceil(time / dt))
        return batch.read()[0][0]
    gravity = float(np.linalg.norm(scene.gravity))
    mass, up = scene.masses(state), -np.array(scene.gravity) / gravity
    resting = RESTING_ENERGY * float(np.sum(mass * state.radius)) * gravity
    fall = math.sqrt(scene.enclosure.height / gravity)
    pause = math.ceil(fall / 2 / dt)
    for steps in range(pause, math.ceil(LONGEST_REST * fall / dt) + pause, pause):
        _run(batch, steps)
        state = batch.read()[0][0]
        kinetic = float(np.sum(mass * (state.velocity @ up) ** 2) / 2)
        if kinetic < resting:
            return state
    raise PackingError(
        f"the bed does not come to rest within {LONGEST_REST * fall:.2g} s: kinetic energy {kinetic:.2g} J, at rest "
        f"below {resting:.2g} J; give the contacts a restitution below 1, or friction",
        "contact",
    )


def frictionless(scene: Scene) -> Scene:
    """Scene without sliding and rolling friction; restitutions stay."""

    def bare(surfaces):
        if isinstance(surfaces, Surface):
            return Surface(surfaces.restitution, 0.0)
        return tuple(bare(surface) for surface in surfaces)

    return replace(scene, particle_contact=bare(scene.particle_contact), wall_contact=bare(scene.wall_contact))


def shaking(scene: Scene, radius, amplitude: float, gamma: float = SHAKING_GAMMA) -> Drive:
    """Along gravity, with ``gamma`` times its acceleration and, at the usual Gamma, an ``amplitude`` in diameters."""
    gravity = float(np.linalg.norm(scene.gravity))
    diameter = 2 * float(np.mean(radius))
    frequency = math.sqrt(SHAKING_GAMMA * gravity / (amplitude * diameter)) / (2 * math.pi)
    return Drive(frequency, gamma * gravity, tuple(-component / gravity for component in scene.gravity))


def _soft(scene: Scene, state: State) -> Scene:
    """The scene with moduli so low that the fastest impact of compaction overlaps by ``SOFT_OVERLAP``; never higher."""
    speed = expected_speed(scene.driven(shaking(scene, state.radius, SHAKING_AMPLITUDE)), state.radius)
    return scene.softened(softening(scene, speed, SOFT_OVERLAP))


def _coarse(numerics: Numerics) -> Numerics:
    """Half the steps a contact, enough where only the bed matters."""
    return replace(numerics, steps_per_contact=numerics.steps_per_contact / 2)


def compact(scene: Scene, state: State, numerics: Numerics) -> tuple[State, list[float], bool]:
    """Shake a bed until its clearance no longer rises; see the head of this module.

    Returns
    -------
    state, clearances, settled
        The bed, its clearance after each block of shaking [m], and whether that no longer rises.
    """
    least = STILL * 2 * float(np.mean(state.radius))
    soft, coarse = _soft(scene, state), _coarse(numerics)
    state = settle(frictionless(soft), state, coarse)
    states, clearances = [], []
    for _ in range(MOST_BLOCKS):
        state = settle(soft, _block(scene, state, numerics, SHAKING_CYCLES), coarse)
        states = [*states[1 - WINDOW :], state]
        clearances.append(_free_height(scene, state, numerics))
        if no_longer_rises(clearances, least):
            return states[int(np.argmax(clearances[-WINDOW:]))], clearances, True
    _log.warning("bed still compacting after %d blocks of %d cycles of shaking", MOST_BLOCKS, SHAKING_CYCLES)
    return states[int(np.argmax(clearances[-WINDOW:]))], clearances, False


def _block(scene: Scene, state: State, numerics: Numerics, cycles: int, gamma: float = SHAKING_GAMMA) -> State:
    """A bed after ``cycles`` without friction and a few with it."""
    soft, coarse = _soft(scene, state), _coarse(numerics)
    parts = [(frictionless(soft), SHAKING_AMPLITUDE, cycles), (soft, KEEPING_AMPLITUDE, KEEPING_CYCLES)]
    for part, amplitude, number in parts[0 if cycles else 1 :]:
        shaken = part.driven(shaking(scene, state.radius, amplitude, gamma))
        state = _balanced(partial(_shaken, shaken, state, number), coarse)
    return state


def _shaken(scene: Scene, state: State, cycles: int, numerics: Numerics) -> State:
    """A bed after some cycles of the scene's drive."""
    steps = steps_per_cycle(scene, state, steps_per_contact=numerics.steps_per_contact)
    case = Case(scene, state, 1 / (scene.drive.frequency * steps))
    batch = Batch([case], max_rows=cycles + 1, effects=numerics.effects(scene, state))
    _run(batch, cycles * steps)
    return batch.read()[0][0]


def no_longer_rises(clearances, least: float) -> bool:
    """Whether the mean over the last ``WINDOW`` is at most ``least`` above that over as many before [m]."""
    if len(clearances) < 2 * WINDOW:
        return False
    return float(np.mean(clearances[-WINDOW:]) - np.mean(clearances[-2 * WINDOW : -WINDOW])) <= least


def _run(batch: Batch, steps: int) -> None:
    before = batch.read()[0][1]
    batch.advance(steps)
    ledger = Ledger(np.concatenate([before.rows, batch.read()[0][1].rows]), before.effects)
    if batch.status[0] != KernelStatus.OK or residual_share(ledger) > LARGEST_RESIDUAL:
        raise _OutOfBalance(
            "the bed gained energy from nowhere while it was prepared: raise numerics.steps_per_contact "
            "or take numerics.precision float64",
            "preparation",
        )


def _height(scene: Scene, state: State) -> float:
    """Height of the centre of mass against gravity [m]."""
    up = -np.array(scene.gravity) / np.linalg.norm(scene.gravity)
    return float(np.average(state.position @ up, weights=scene.masses(state)))


def _free_height(scene: Scene, state: State, numerics: Numerics) -> float:
    """Clearance of a bed [m] or, without floor or lid, twice the depth of its centre of mass (of a block's top)."""
    clearance = measured_clearance(scene, state, numerics)
    return clearance if math.isfinite(clearance) else -2 * _height(scene, state)


def measured_clearance(scene: Scene, state: State, numerics: Numerics = _USUAL) -> float:
    """Travel of the centre of mass along the axis between rest on the floor and rest against the lid [m].

    Standard gravity along the axis, down and then up, whatever the scene's own; not a number without floor or lid.
    """
    if not (scene.enclosure.floor and scene.enclosure.lid):
        return math.nan
    heights = []
    for upright in _upright(scene):
        state = settle(_soft(upright, state), state, _coarse(numerics))
        heights.append(float(np.average(state.position[:, 2], weights=scene.masses(state))))
    return heights[1] - heights[0]
