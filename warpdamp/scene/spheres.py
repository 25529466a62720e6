"""Spheres as a shape, see ``scene.shape``."""

from __future__ import annotations

import numpy as np

from .bodies import Bodies


class Spheres(Bodies):
    """Spheres about their centres; nothing depends on their axes."""

    def height(self, normal: np.ndarray) -> np.ndarray:
        """Radii, (n,)."""
        return self.across

    def point(self, normal: np.ndarray) -> np.ndarray:
        """Points that reach farthest along unit vectors, from the centres, (n, 3)."""
        return self.across[:, None] * normal

    def common_normal(self, apart, other: Spheres, *, to_the_end: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Unit vectors between the centres, zeros where they coincide, and gaps; see ``Bodies``."""
        distance = np.linalg.norm(apart, axis=1)
        return apart / np.where(distance > 0, distance, 1.0)[:, None], distance - self.across - other.across

    def farthest_from_axis(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance from the z axis of the farthest points, and the directions of these, (n,), (n, 3)."""
        rho = np.hypot(position[:, 0], position[:, 1])
        return rho + self.across, position * (1, 1, 0) / np.where(rho > 0, rho, 1.0)[:, None]
