"""Checks of a start and of a run: refused before a run where possible, detected during it otherwise."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..errors import SimulationError
from ..scene.effects import WALLS, Effects
from ..scene.particles import State
from ..scene.scene import Scene
from ..scene.shape import shape_of
from ..scene.touch import pair_overlaps, wall_overlaps
from .ledger import Ledger

DEEPEST_START = 0.05
"""Largest overlap of a given state, over the smaller semi-axis: more would be released as energy from nowhere."""

DEEPEST = 0.1
"""Largest overlap over the reduced radius: at a = 0.3 R* Hertz's theory ends."""

LARGEST_RESIDUAL = 0.02
"""Ledger residual, over the energy turned over, beyond which figures are not to be trusted."""


def check_walls(scene: Scene, effects: Effects) -> None:
    """Refuse an open cavity among closed ones: kernels have a wall for all cases of a batch or for none.

    Raises
    ------
    ValueError
        Names the wall.
    """
    for wall in WALLS if scene.enclosure else ():
        if getattr(effects, wall) and not getattr(scene.enclosure, wall):
            raise ValueError(
                f"a cavity without a {wall} cannot be in one batch with cavities that have one: make a batch of each"
            )


def check_values(state: State) -> None:
    """Refuse a state that is not finite.

    Raises
    ------
    ValueError
        Names the quantity and the particle.
    """
    for name in ("position", "velocity", "spin", "radius", "axis", "aspect"):
        good = np.isfinite(getattr(state, name)).reshape(len(state), -1).all(axis=1)
        if not good.all():
            raise ValueError(f"the {name} of particle {int(np.argmin(good))} is not finite")
    for name in ("radius", "aspect"):
        if np.any(getattr(state, name) <= 0):
            raise ValueError(f"the {name} of particle {int(np.argmin(getattr(state, name)))} is not positive")


def check_shapes(scene: Scene, state: State) -> None:
    """Refuse particles that may touch a wall in two places at once, or whose contacts may not be found.

    Raises
    ------
    ValueError
        Names the aspects that are allowed.
    """
    side = scene.enclosure.diameter / 2 if scene.enclosure and scene.enclosure.side else None
    if refusal := shape_of(state).refused(state.radius, state.aspect, side):
        raise ValueError(refusal)


def check_overlaps(scene: Scene, state: State, parts: Iterable[np.ndarray]) -> None:
    """Refuse a start whose overlaps would release energy that is no work of the drive.

    Parameters
    ----------
    parts : (m, 2) arrays
        All pairs that are near each other, some at a time.

    Raises
    ------
    ValueError
        If a pair, or a particle and a wall, overlap by more than ``DEEPEST_START``; says which, and what to do.
    """
    smallest = shape_of(state).inscribed_radius(state.radius, state.aspect)
    deepest, where = 0.0, ""
    for pairs in parts:
        if not len(pairs):
            continue
        i, j = pairs.T
        relative = pair_overlaps(state, pairs) / np.minimum(smallest[i], smallest[j])
        k = int(np.argmax(relative))
        deepest, where = max((deepest, where), (float(relative[k]), f"particles {i[k]} and {j[k]}"))
    if scene.enclosure:
        wall, which = _deepest_wall(scene, state, smallest)
        deepest, where = max((deepest, where), (wall, which))
    if deepest > DEEPEST_START:
        raise ValueError(
            f"{where} overlap by {100 * deepest:.3g} % of the radius at the start, at most {100 * DEEPEST_START:g} % "
            "are allowed: move them apart, or let warpdamp.damper.placement.separate place them"
        )


def _deepest_wall(scene: Scene, state: State, smallest: np.ndarray) -> tuple[float, str]:
    relative = {name: overlap / smallest for name, overlap in wall_overlaps(state, scene.enclosure).items()}
    deepest = {name: (float(np.max(d)), int(np.argmax(d))) for name, d in relative.items()}
    if not deepest:
        return 0.0, ""
    name = max(deepest, key=lambda n: deepest[n])
    return deepest[name][0], f"particle {deepest[name][1]} and the {name}"


def check_run(ledger: Ledger, dt: float) -> None:
    """Refuse to go on with a run whose contacts are too deep or whose ledger does not close.

    Raises
    ------
    SimulationError
    """
    deepest = float(ledger["largest_overlap"][-1])
    if deepest > DEEPEST:
        raise SimulationError(
            f"a contact is {deepest:.2g} of the reduced radius deep, and Hertz's theory ends at {DEEPEST:g}: "
            "take a stiffer material or lower speeds"
        )
    share = residual_share(ledger)
    if share > LARGEST_RESIDUAL:
        raise SimulationError(
            f"the energy ledger is {100 * share:.2g} % of the energy turned over out of balance, "
            f"more than {100 * LARGEST_RESIDUAL:g} %: take a step below {dt:.3g} s"
        )


def residual_share(ledger: Ledger) -> float:
    """Ledger residual over the energy turned over: what was lost, and the largest store seen [-]."""
    turned_over = ledger.dissipated[-1] - ledger.dissipated[0] + np.max(np.abs(ledger.stored - ledger["gravity"]))
    return float(abs(ledger.residual[-1]) / turned_over) if turned_over > 0 else 0.0
