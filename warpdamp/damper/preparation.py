"""Beds: particles that fit the closed cavity, settled, and prepared in a stated way.

``loose``
    Made inside the closed cavity without overlap, then settled under gravity with the friction of the scene.
``compacted``
    The same positions shaken without friction until the clearance no longer rises: see ``compaction``.
``compacted`` to a ``clearance`` or ``packing_fraction``
    The loose bed shaken until it has the state asked for: see ``asked``.

Every bed is reproducible from its inputs, and is kept on disk under their hash.
"""

from __future__ import annotations

import io
import logging
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..engine.device import check_device
from ..errors import PackingError
from ..files import cache_folder, keep, locked
from ..scene.effects import Effects
from ..scene.particles import State
from ..scene.scene import Drive, Scene
from .asked import brought
from .case import Packing, Request
from .compaction import compact, frictionless, measured_clearance, upright_scenes
from .placement import place
from .settling import settle

_log = logging.getLogger(__name__)


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
    check_device(request.numerics.device)
    path = cache_folder("beds") / f"{request.key()}.npz"
    if (stored := _stored(path)) is not None:
        return stored
    ends = _ends(request) if request.asked else ()  # before the lock, which they may need themselves
    with locked(path.parent / f".lock-{path.name[:2]}", wait=True):  # another process may be making it
        if (stored := _stored(path)) is None:
            stored = brought(request, *ends) if ends else _make(request)
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
    scenes = [request.scene, *upright_scenes(request.scene)]
    if request.preparation == "compacted":
        bare = frictionless(request.scene)
        scenes += [bare.driven(None), *(scene.driven(Drive(1.0, 1.0)) for scene in (request.scene, bare))]
    return {request.numerics.effects(scene, request.grains) for scene in scenes}


def _make(request: Request) -> Packing:
    scene, numerics = request.scene, request.numerics
    _check_walls(scene)
    grains = request.grains
    position, axis = place(grains, scene.enclosure, request.seed)
    state = State.of(grains, position, axis)
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


def _ends(request: Request) -> tuple[Packing, Packing]:
    """The loosest and the densest bed that a request with a state asked for lies between."""
    cavity = request.scene.enclosure
    if not (cavity.floor and cavity.lid):
        raise PackingError("a bed has a clearance only between a floor and a lid: give the cavity both", "preparation")
    own = replace(request, clearance=None, packing_fraction=None)
    return prepare(replace(own, preparation="loose")), prepare(own)
