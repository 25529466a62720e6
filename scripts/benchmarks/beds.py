"""Beds of many spheres at rest, for how the cost grows with their number."""

import math

import numpy as np

from warpdamp import Batch, Case, Cylinder, State
from warpdamp.damper.placement import separate
from warpdamp.files import cache_folder
from warpdamp.scene.paper import RADIUS

from .damper import cavity, damper

DENSE = 0.60
"""Part that random spheres fill far from walls; a layer at the walls is looser."""
SETTLING, SETTLING_STEP = 0.020, 6e-6  # [s]


def bed(count: int) -> State:
    """A settled bed in the cavity of ``count`` spheres, as State at rest without memory; kept beside the study's beds.

    Random spheres without overlap, as dense as they come easily, that then fall by what is left between them.
    """
    path = cache_folder("benchmark") / f"bed-{count}.npy"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(path, _settled(count))
    return State.at_rest(np.load(path), RADIUS)


def _settled(count: int) -> np.ndarray:
    own = cavity(count)
    fill = DENSE * (1 - 0.875 * 2 * RADIUS / own.diameter)
    volume = count * 4 / 3 * math.pi * RADIUS**3
    height = min(own.height, own.height * volume / (fill * own.volume))
    start = State.at_rest(separate((RADIUS,) * count, Cylinder(own.diameter, height), seed=1), RADIUS)
    batch = Batch([Case(damper(count, gamma=0), start, SETTLING_STEP)])
    batch.advance(math.ceil(SETTLING / SETTLING_STEP))
    return batch.read()[0][0].position


def lattice(count: int) -> State:
    """A body-centred lattice of touching spheres in the cavity of ``count``, numbered at random.

    Made in no time, and with eight contacts a particle dearer than a random bed.
    """
    own = cavity(count)
    side = 2 * RADIUS * (1 - 1e-5) * 2 / math.sqrt(3)
    across = np.arange(-math.ceil(own.diameter / 2 / side), math.ceil(own.diameter / 2 / side) + 1)
    cells = np.stack(np.meshgrid(across, across, np.arange(own.height // side), indexing="ij"), axis=-1).reshape(-1, 3)
    points = side * np.concatenate([cells, cells + 0.5]) + [0, 0, RADIUS]
    points = points[np.hypot(points[:, 0], points[:, 1]) < own.diameter / 2 - RADIUS]
    lowest = points[np.argsort(points[:, 2], kind="stable")[:count]]
    return State.at_rest(np.random.default_rng(1).permutation(lowest), RADIUS)
