"""Random placement of particles other than spheres in a closed cavity: points and axes pushed apart and turned.

The energy is half the sum of the squares of the overlaps d: a pair is pushed by d along its common normal, with the
torque of that about each centre.  Masses are 1, moments of inertia those about the axes across.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..scene.bodies import Bodies
from ..scene.scene import Cylinder
from ..scene.shape import Shape
from .fire import minimised

MOST = 2000
"""Steps after which what still overlaps is taken not to fit: fills of 0.6 take some hundreds."""

FEW = 600
"""The same where it only matters about how many fit."""


def random_start(shape: Shape, radius, aspect, enclosure: Cylinder, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Random points [m] and axes of particles, which overlap, two of (n, 3)."""
    rng, n = np.random.default_rng(seed), len(radius)
    least = shape.inscribed_radius(radius, aspect)
    rho = (enclosure.diameter / 2 - least) * np.sqrt(rng.random(n))
    angle = 2 * np.pi * rng.random(n)
    z = least + (enclosure.height - 2 * least) * rng.random(n)
    axis = rng.normal(size=(n, 3))
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    return np.stack([rho * np.cos(angle), rho * np.sin(angle), z], axis=1), axis


def turned_apart(
    shape: Shape, position, axis, radius, aspect, enclosure: Cylinder, *, most: int
) -> tuple[np.ndarray, np.ndarray, bool]:
    """Minimise the overlaps in units of the mean radius, in ``most`` steps at the most.

    Returns
    -------
    position, axis, apart
        [m], unit vectors, and whether the particles are apart, were they not ``GROWN``.
    """
    unit = float(np.mean(radius))
    semi_axes = shape.semi_axes(radius / unit, aspect)
    half, height = enclosure.diameter / 2 / unit, enclosure.height / unit
    across, _ = shape.inertia(1.0, radius / unit, aspect)
    arm = np.sqrt(across)[:, None]  # of inertia: ways along it are lengths, as those of points are

    def forces(place):
        x, u = place
        force, torque, worst = _overlap_forces(x, shape.bodies(u, *semi_axes), half, height)
        return np.concatenate([force, torque / arm], axis=1), worst

    def moved(place, way):
        x, u = place
        return x + way[:, :3], _turned(u, way[:, 3:] / arm)

    (x, u), apart = minimised((position / unit, axis), forces, moved, most=most)
    return x * unit, u, apart


def _turned(u, angle):
    """Axes turned by vectors of angles, in the rotation of Cayley, which keeps their length."""
    g = angle / 2
    once = np.cross(g, u)
    turned = u + 2 / (1 + np.sum(g**2, axis=1, keepdims=True)) * (once + np.cross(g, once))
    return turned / np.linalg.norm(turned, axis=1)[:, None]


def _overlap_forces(x, bodies: Bodies, half: float, height: float):
    """Repulsion equal to the overlaps, its torques, and the largest overlap over the smaller semi-axes that meet."""
    force, torque = np.zeros_like(x), np.zeros_like(x)
    worst = _pairs(x, bodies, force, torque)
    distance, outward = bodies.farthest_from_axis(x)
    up = np.tile((0.0, 0.0, 1.0), (len(x), 1))
    rise = bodies.height(up)
    walls = ((distance - half, outward), (rise - x[:, 2], -up), (x[:, 2] + rise - height, up))
    for overlap, towards in walls:
        push = -np.maximum(overlap, 0)[:, None] * towards
        force += push
        torque += np.cross(bodies.point(towards), push)
        worst = max(worst, float(np.max(overlap / bodies.inscribed)))
    return force, torque, worst


def _pairs(x, bodies: Bodies, force, torque) -> float:
    """Add what pairs do to each other; the largest overlap over the sum of the smaller semi-axes."""
    pairs = cKDTree(x).query_pairs(2 * bodies.bound.max(), output_type="ndarray")
    if not len(pairs):
        return 0.0
    near = np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1) < bodies.bound[pairs].sum(axis=1)
    i, j = pairs[near].T
    normal, gap = bodies[i].common_normal(x[i] - x[j], bodies[j], to_the_end=False)
    meet = gap < 0
    if not meet.any():
        return 0.0
    i, j, normal, overlap = i[meet], j[meet], normal[meet], -gap[meet]
    push = overlap[:, None] * normal
    on_i, on_j = np.cross(-bodies[i].point(normal), push), np.cross(bodies[j].point(normal), -push)
    for axis in range(3):
        force[:, axis] += np.bincount(i, push[:, axis], len(x)) - np.bincount(j, push[:, axis], len(x))
        torque[:, axis] += np.bincount(i, on_i[:, axis], len(x)) + np.bincount(j, on_j[:, axis], len(x))
    return float(np.max(overlap / (bodies.inscribed[i] + bodies.inscribed[j])))
