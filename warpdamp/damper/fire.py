"""The FIRE minimiser, by which particles are pushed apart."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .case import GROWN

ALLOWED = 0.9 * (1 - 1 / GROWN)
"""Overlap of grown particles, over the sum of their smaller semi-axes, that leaves the true ones apart."""

MOST = 6000
"""Steps after which what still overlaps is taken not to fit."""


def minimised(place, forces: Callable, moved: Callable, *, most: int = MOST) -> tuple:
    """Follow forces downhill until overlaps are ``ALLOWED``; see Bitzek et al. 2006, doi:10.1103/PhysRevLett.97.170201.

    Parameters
    ----------
    place : where all particles are, as ``forces`` and ``moved`` know it
    forces : function of a place
        Forces over masses, an array, and the largest relative overlap.
    moved : function of (place, way)
        The place after a way, an array like the forces.
    most : int
        Steps.

    Returns
    -------
    place, apart
        And whether the true particles are apart.
    """
    v, dt, mixing, downhill = None, 0.1, 0.1, 0
    for _ in range(most):
        force, worst = forces(place)
        if worst < ALLOWED:
            return place, True
        v = np.zeros_like(force) if v is None else v
        if np.vdot(force, v) > 0:
            downhill += 1
            v = (1 - mixing) * v + mixing * force * np.linalg.norm(v) / np.linalg.norm(force)
            if downhill > 5:
                dt, mixing = min(1.1 * dt, 0.5), 0.99 * mixing
        else:
            v, dt, mixing, downhill = np.zeros_like(force), 0.5 * dt, 0.1, 0
        v = v + dt * force
        place = moved(place, dt * v)
    return place, False
