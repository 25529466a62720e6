"""Local coordinate systems: where a point lies, and where a vector at it points, in global coordinates.

Cylindrical components are (r, theta, z), theta about z from x; spherical ones (r, theta, phi), theta from z and phi
about z from x.  Angles of positions are in degrees.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np


class Kind(IntEnum):
    """Kinds of coordinate systems, by their numbers in universal files."""

    CARTESIAN = 0
    CYLINDRICAL = 1
    SPHERICAL = 2


@dataclass(frozen=True)
class System:
    """A coordinate system.

    Parameters
    ----------
    kind : Kind
    axes : (3, 3) array, its x, y and z axes as rows, unit vectors
    origin : (3,) array
    """

    kind: Kind
    axes: np.ndarray
    origin: np.ndarray

    def place(self, local: np.ndarray) -> np.ndarray:
        """Global positions of points (p, 3) given in the system."""
        first, second, third = local.T
        if self.kind == Kind.CYLINDRICAL:
            theta = np.radians(second)
            local = np.stack([first * np.cos(theta), first * np.sin(theta), third], axis=1)
        elif self.kind == Kind.SPHERICAL:
            theta, phi = np.radians(second), np.radians(third)
            local = first[:, None] * _radial(theta, phi)
        return local @ self.axes + self.origin

    def directions(self, point: np.ndarray) -> np.ndarray:
        """Unit vectors (p, 3, 3), one a row, that the components of a vector at global points (p, 3) belong to."""
        x, y, z = ((point - self.origin) @ self.axes.T).T
        phi, theta, none = np.arctan2(y, x), np.arctan2(np.hypot(x, y), z), np.zeros(len(point))
        about = np.stack([-np.sin(phi), np.cos(phi), none], axis=1)
        if self.kind == Kind.CYLINDRICAL:
            rows = [_radial(none + np.pi / 2, phi), about, np.broadcast_to([0.0, 0.0, 1.0], point.shape)]
        elif self.kind == Kind.SPHERICAL:
            rows = [_radial(theta, phi), _radial(theta + np.pi / 2, phi), about]
        else:
            rows = [np.broadcast_to(axis, point.shape) for axis in np.eye(3)]
        return np.stack(rows, axis=1) @ self.axes

    def vector(self, local: np.ndarray, point: np.ndarray) -> np.ndarray:
        """Global components of vectors (p, 3), given in the system at global points (p, 3)."""
        return np.einsum("pi,pij->pj", local, self.directions(point))


GLOBAL = System(Kind.CARTESIAN, np.eye(3), np.zeros(3))


def through(kind: Kind, origin, on_x, on_xz) -> System:
    """The system with its origin at a point, its x axis through a second and a third in its half plane x > 0, y = 0.

    Raises
    ------
    ValueError
        If the three lie on a line.
    """
    along, towards = on_x - origin, on_xz - origin
    across = np.cross(towards, along)
    if np.linalg.norm(across) <= 1e-9 * np.linalg.norm(along) * np.linalg.norm(towards):
        raise ValueError("its three points lie on a line")
    x, y = along / np.linalg.norm(along), across / np.linalg.norm(across)
    return System(kind, np.array([x, y, np.cross(x, y)]), np.asarray(origin, float))


def _radial(theta, phi) -> np.ndarray:
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
