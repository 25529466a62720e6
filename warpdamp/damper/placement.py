"""Random placement of particles in a closed cavity, without overlap."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from ..errors import PackingError
from ..scene.particles import UPRIGHT, Grains
from ..scene.scene import Cylinder
from ..scene.shape import SPHERES, aspects, shape_of
from ..scene.sphere import sphere_volume
from .case import GROWN
from .fire import minimised
from .turning import FEW, MOST, random_start, turned_apart


def fill(radius, enclosure: Cylinder) -> float:
    """Fill of the cavity: volume of the particles over the cavity's [-]."""
    return float(np.sum(sphere_volume(np.asarray(radius)))) / enclosure.volume


def separate(radius, enclosure: Cylinder, seed: int) -> np.ndarray:
    """Positions of particles in the closed cavity, random and without any overlap, (n, 3) [m].

    Random points are pushed apart as slightly grown soft spheres, see ``fire``.

    Raises
    ------
    PackingError
        If they do not fit; names the largest fill that was reached.
    """
    radius = np.asarray(radius, float)
    rng = np.random.default_rng(seed)
    _check_fit(radius, enclosure)
    reach = enclosure.diameter / 2 - radius
    rho = reach * np.sqrt(rng.random(len(radius)))
    angle = 2 * np.pi * rng.random(len(radius))
    z = radius + (enclosure.height - 2 * radius) * rng.random(len(radius))
    start = np.stack([rho * np.cos(angle), rho * np.sin(angle), z], axis=1)

    position, fits = _push_apart(start, GROWN * radius, enclosure)
    if fits:
        return position
    raise _too_many(radius, enclosure, lambda scale: _push_apart(start, scale * GROWN * radius, enclosure)[1])


def place(grains: Grains, enclosure: Cylinder, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions [m] and axes of particles in the closed cavity, random and without any overlap, two of (n, 3).

    Other shapes than spheres start at random points with random axes, and are pushed apart as those are, and turned.

    Raises
    ------
    PackingError
        As ``separate``; also if contacts of such a shape would be missed.
    """
    shape, radius, aspect = shape_of(grains), np.asarray(grains.radius, float), aspects(grains)
    if shape is SPHERES:
        return separate(radius, enclosure, seed), np.tile(UPRIGHT, (len(radius), 1))
    _check_fit(shape.bounding_radius(radius, aspect), enclosure)
    if refusal := shape.refused(radius, aspect, enclosure.diameter / 2):
        raise PackingError(refusal)
    start = random_start(shape, radius, aspect, enclosure, seed)
    position, axis, fits = turned_apart(shape, *start, GROWN * radius, aspect, enclosure, most=MOST)
    if fits:
        return position, axis

    def fits_at(scale: float) -> bool:
        return turned_apart(shape, *start, scale * GROWN * radius, aspect, enclosure, most=FEW)[2]

    raise _too_many(radius, enclosure, fits_at)


def _check_fit(bound: np.ndarray, enclosure: Cylinder) -> None:
    """Refuse particles that the cavity cannot hold."""
    if np.any(2 * bound >= min(enclosure.diameter, enclosure.height)):
        raise PackingError(
            f"a particle of diameter {2e3 * bound.max():g} mm does not fit a cavity of "
            f"{1e3 * enclosure.diameter:g} x {1e3 * enclosure.height:g} mm"
        )


def _too_many(radius: np.ndarray, enclosure: Cylinder, fits: Callable[[float], bool]) -> PackingError:
    """Refusal with the largest fill that random packing reached, found by smaller particles."""
    low, high = 0.0, 1.0  # scale of the radii
    for _ in range(7):
        middle = (low + high) / 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    asked = fill(radius, enclosure)
    return PackingError(
        f"too many particles: they would fill {asked:.3f} of the cavity, and random packing reached "
        f"{asked * low**3:.3f}; take at most {math.floor(len(radius) * low**3)} of them, or a larger cavity"
    )


def _push_apart(position, radius, enclosure):
    """Minimise the overlaps, in units of the mean radius; returns positions and whether the true spheres are apart."""
    unit = float(np.mean(radius))
    x, r = position / unit, radius / unit
    half, height = enclosure.diameter / 2 / unit, enclosure.height / unit
    x, apart = minimised(x, lambda x: _overlap_forces(x, r, half, height), lambda x, way: x + way)
    return x * unit, apart


def _overlap_forces(x, r, half, height):
    """Repulsion equal to the overlaps, and the largest overlap over the smaller radius (walls: twice)."""
    force = np.zeros_like(x)
    worst = 0.0
    pairs = cKDTree(x).query_pairs(2 * r.max(), output_type="ndarray")
    if len(pairs):
        i, j = pairs.T
        branch = x[i] - x[j]
        distance = np.maximum(np.linalg.norm(branch, axis=1), 1e-12)
        overlap = np.maximum(r[i] + r[j] - distance, 0)
        push = branch * (overlap / distance)[:, None]
        for axis in range(3):
            force[:, axis] += np.bincount(i, push[:, axis], len(x)) - np.bincount(j, push[:, axis], len(x))
        worst = np.max(overlap / (r[i] + r[j]))
    rho = np.maximum(np.hypot(x[:, 0], x[:, 1]), 1e-12)
    side = np.maximum(rho + r - half, 0)
    force[:, :2] -= (side / rho)[:, None] * x[:, :2]
    floor, lid = np.maximum(r - x[:, 2], 0), np.maximum(x[:, 2] + r - height, 0)
    force[:, 2] += floor - lid
    return force, max(worst, np.max(np.maximum(np.maximum(side, floor), lid) / r))
