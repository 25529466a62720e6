"""Overlaps of particles with each other and with walls, on the host, whatever their shape."""

from __future__ import annotations

import numpy as np

from .particles import UPRIGHT, State
from .scene import Cylinder
from .shape import bodies_of


def pair_overlaps(state: State, pairs: np.ndarray) -> np.ndarray:
    """Overlaps of pairs of a state's particles, negative where they are apart, (m,) [m].

    Parameters
    ----------
    state : State
    pairs : (m, 2) array of ints
    """
    i, j = np.asarray(pairs).reshape(-1, 2).T
    bodies = bodies_of(state)
    return -bodies[i].common_normal(state.position[i] - state.position[j], bodies[j])[1]


def wall_overlaps(state: State, enclosure: Cylinder) -> dict[str, np.ndarray]:
    """Overlaps of a state's particles with the walls that are there, by wall, negative where apart, (n,) [m].

    Parameters
    ----------
    state : State
    enclosure : Cylinder
    """
    z, bodies = state.position[:, 2], bodies_of(state)
    rise = bodies.height(np.broadcast_to(UPRIGHT, state.position.shape))
    farthest, _ = bodies.farthest_from_axis(state.position)
    overlaps = {
        "side": farthest - enclosure.diameter / 2,
        "floor": rise - z,
        "lid": z + rise - enclosure.height,
    }
    return {name: overlap for name, overlap in overlaps.items() if getattr(enclosure, name)}
