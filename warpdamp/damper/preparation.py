"""Beds: particles that fit the closed cavity, settled, and prepared in a stated way.

``loose``
    Made inside the closed cavity without overlap, then settled under gravity with the friction of the scene.
``compacted``
    The loose bed shaken along gravity (up and down) at six times the scene's gravity with an amplitude of a tenth of a
    particle's diameter, in blocks of 20 cycles, each followed by rest; done, after 30 blocks at the least and 60 at
    most, when the mean height at rest over the last ten blocks is no more than a quarter of a percent of a diameter
    below that over the ten blocks before.  Half the steps a contact of the study are enough for that.  A bed that has
    been shaken for some time, as any damper in service has.

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
from ..numerics.timestep import Numerics, contact_step, steps_per_cycle
from ..scene.effects import Effects
from ..scene.particles import State
from ..scene.scene import STANDARD_GRAVITY, Drive, Scene
from .case import BLOCK, FEWEST_BLOCKS, MOST_BLOCKS, SHAKING_AMPLITUDE, SHAKING_GAMMA, STILL, WINDOW, Request
from .placement import separate

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
    """

    state: State
    clearance: float
    blocks: int


def prepare(request: Request) -> Packing:
    """Bed of a request, from disk if it was made before.

    Raises
    ------
    PackingError
        If the particles do not fit (with the fill asked for and the fill reached) or do not come to rest.

    Examples
    --------
    >>> from warpdamp import Cylinder, Grains, Material, Request, Scene, Surface, prepare
    >>> pmma, surface = Material(920, 3.3e9, 0.37), Surface(0.52, 0.86)
    >>> scene = Scene(pmma, pmma, surface, surface, Cylinder(0.04, 0.04))
    >>> bed = prepare(Request(scene, Grains.alike(3.73e-3, 10), seed=1, preparation="loose"))
    >>> round(1e3 * bed.clearance, 1)  # one layer: the height less a diameter, 40 - 7.46 [mm]
    32.5
    """
    path = cache_folder("beds") / f"{request.key()}.npz"
    if (stored := _stored(path)) is not None:
        return stored
    with locked(path.parent / f".lock-{path.name[:2]}", wait=True):  # another process may be making it
        if (stored := _stored(path)) is None:
            stored = _make(request)
            content = io.BytesIO()
            np.savez(content, clearance=stored.clearance, blocks=stored.blocks, **stored.state.arrays())
            keep(path, content.getvalue())
    return stored


def _stored(path: Path) -> Packing | None:
    """A bed from disk; None if there is none, or if the file is damaged (it is then made anew)."""
    try:
        with np.load(path) as file:
            values = dict(file)
        return Packing(
            clearance=float(values.pop("clearance")), blocks=int(values.pop("blocks")), state=State.from_arrays(values)
        )
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        _log.warning("%s is damaged (%s); making the bed anew", path, error)
        return None


def effects(request: Request) -> set[Effects]:
    """Sets of effects that kernels are compiled for while a bed is made."""
    scenes = [request.scene, *_upright(request.scene)]
    return {request.numerics.effects(scene, request.grains) for scene in scenes}


def _upright(scene: Scene) -> list[Scene]:
    """The scene under standard gravity along the axis, down and up."""
    return [replace(scene, gravity=(0.0, 0.0, pull)) for pull in (-STANDARD_GRAVITY, STANDARD_GRAVITY)]


def _make(request: Request) -> Packing:
    scene = request.scene
    position = separate(request.grains.radius, scene.enclosure, request.seed)
    state = State.at_rest(position, request.grains.radius, request.grains.species)
    if not any(scene.gravity):
        if request.preparation == "compacted":
            raise PackingError("a bed cannot be compacted without gravity: ask for preparation: loose", "preparation")
        return Packing(state, measured_clearance(scene, state, request.numerics), 0)

    state = settle(scene, state, request.numerics, time=request.settling_time)
    blocks = 0
    if request.preparation == "compacted":
        coarse = request.numerics.steps_per_contact / 2
        state, blocks = compact(scene, state, replace(request.numerics, steps_per_contact=coarse))
        state = settle(scene, state, request.numerics)
    return Packing(state, measured_clearance(scene, state, request.numerics), blocks)


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


def compact(scene: Scene, state: State, numerics: Numerics) -> tuple[State, int]:
    """Shake a settled bed until its height at rest no longer falls; see the head of this module."""
    diameter = 2 * float(np.mean(state.radius))
    gravity = float(np.linalg.norm(scene.gravity))
    acceleration = SHAKING_GAMMA * gravity
    frequency = math.sqrt(acceleration / (SHAKING_AMPLITUDE * diameter)) / (2 * math.pi)
    up = tuple(-component / gravity for component in scene.gravity)
    shaken = scene.driven(Drive(frequency, acceleration, up))
    heights = [_height(scene, state)]
    for block in range(1, MOST_BLOCKS + 1):
        state = settle(scene, _balanced(partial(_shaken, shaken, state), numerics), numerics)
        heights.append(_height(scene, state))
        if block >= FEWEST_BLOCKS and _fallen(heights) < STILL * diameter:
            return state, block
    _log.warning("bed still compacting after %d blocks of %d cycles of shaking", MOST_BLOCKS, BLOCK)
    return state, MOST_BLOCKS


def _shaken(scene: Scene, state: State, numerics: Numerics) -> State:
    """A bed after a block of cycles."""
    steps = steps_per_cycle(scene, state, steps_per_contact=numerics.steps_per_contact)
    case = Case(scene, state, 1 / (scene.drive.frequency * steps))
    batch = Batch([case], max_rows=BLOCK + 1, effects=numerics.effects(scene, state))
    _run(batch, BLOCK * steps)
    return batch.read()[0][0]


def _fallen(heights) -> float:
    """Fall of the mean height over the last blocks against that over as many before [m]."""
    return float(np.mean(heights[-2 * WINDOW : -WINDOW]) - np.mean(heights[-WINDOW:]))


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


def measured_clearance(scene: Scene, state: State, numerics: Numerics) -> float:
    """Travel of the centre of mass along the axis between rest on the floor and rest against the lid [m].

    Standard gravity along the axis, down and then up, whatever the scene's own; not a number without floor or lid.
    """
    if not (scene.enclosure.floor and scene.enclosure.lid):
        return math.nan
    heights = []
    for upright in _upright(scene):
        state = settle(upright, state, numerics)
        heights.append(float(np.average(state.position[:, 2], weights=scene.masses(state))))
    return heights[1] - heights[0]
