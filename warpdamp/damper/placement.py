"""Random placement of particles in a closed cavity, without overlap."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from ..errors import PackingError
from ..scene.particles import sphere_volume
from ..scene.scene import Cylinder
from .case import GROWN


def fill(radius, enclosure: Cylinder) -> float:
    """Fill of the cavity: volume of the particles over the cavity's [-]."""
    return float(np.sum(sphere_volume(radius))) / enclosure.volume


def separate(radius, enclosure: Cylinder, seed: int) -> np.ndarray:
    """Positions of particles in the closed cavity, random and without any overlap, (n, 3) [m].

    Random points are pushed apart as slightly grown soft spheres by the FIRE minimiser (Bitzek et al. 2006,
    doi:10.1103/PhysRevLett.97.170201).

    Raises
    ------
    PackingError
        If they do not fit; names the largest fill that was reached.
    """
    radius = np.asarray(radius, float)
    rng = np.random.default_rng(seed)
    reach = enclosure.diameter / 2 - radius
    if np.any(reach <= 0) or np.any(2 * radius >= enclosure.height):
        raise PackingError(
            f"a particle of diameter {2e3 * radius.max():g} mm does not fit a cavity of "
            f"{1e3 * enclosure.diameter:g} x {1e3 * enclosure.height:g} mm"
        )
    rho = reach * np.sqrt(rng.random(len(radius)))
    angle = 2 * np.pi * rng.random(len(radius))
    z = radius + (enclosure.height - 2 * radius) * rng.random(len(radius))
    start = np.stack([rho * np.cos(angle), rho * np.sin(angle), z], axis=1)

    position, fits = _push_apart(start, GROWN * radius, enclosure)
    if fits:
        return position
    low, high = 0.0, 1.0  # scale of the radii
    for _ in range(7):
        middle = (low + high) / 2
        _, fits = _push_apart(start, middle * GROWN * radius, enclosure)
        low, high = (middle, high) if fits else (low, middle)
    asked = fill(radius, enclosure)
    raise PackingError(
        f"too many particles: they would fill {asked:.3f} of the cavity, and random packing reached "
        f"{asked * low**3:.3f}; take at most {math.floor(len(radius) * low**3)} of them, or a larger cavity"
    )


def _push_apart(position, radius, enclosure, most: int = 6000):
    """Minimise the overlaps, in units of the mean radius; returns positions and whether the true spheres are apart."""
    unit = float(np.mean(radius))
    x, r = position / unit, radius / unit
    half, height = enclosure.diameter / 2 / unit, enclosure.height / unit
    allowed = 0.9 * (1 - 1 / GROWN)  # overlap of the grown spheres that leaves the true ones apart
    v, dt, mixing, downhill = np.zeros_like(x), 0.1, 0.1, 0
    for _ in range(most):
        force, worst = _overlap_forces(x, r, half, height)
        if worst < allowed:
            return x * unit, True
        if np.vdot(force, v) > 0:
            downhill += 1
            v = (1 - mixing) * v + mixing * force * np.linalg.norm(v) / np.linalg.norm(force)
            if downhill > 5:
                dt, mixing = min(1.1 * dt, 0.5), 0.99 * mixing
        else:
            v, dt, mixing, downhill = np.zeros_like(x), 0.5 * dt, 0.1, 0
        v = v + dt * force
        x = x + dt * v
    return x * unit, False


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
