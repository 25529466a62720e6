"""Particles as they lie: bodies that are round about an axis, of any shape, for placing, checking and drawing them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Bodies(ABC):
    """Bodies about their centres.

    Parameters
    ----------
    axis : (n, 3) array
        Unit vectors.
    along, across : (n,) arrays
        Half of the length along the axis and of the width across, in any one unit.
    """

    axis: np.ndarray
    along: np.ndarray
    across: np.ndarray

    def __getitem__(self, which) -> Bodies:
        """The bodies selected by ``which``."""
        return type(self)(self.axis[which], self.along[which], self.across[which])

    @property
    def inscribed(self) -> np.ndarray:
        """Smaller of length and width, (n,)."""
        return np.minimum(self.along, self.across)

    @property
    def bound(self) -> np.ndarray:
        """Larger of length and width, (n,)."""
        return np.maximum(self.along, self.across)

    @abstractmethod
    def height(self, normal: np.ndarray) -> np.ndarray:
        """How far they reach along unit vectors (n, 3) from their centres, (n,)."""

    @abstractmethod
    def point(self, normal: np.ndarray) -> np.ndarray:
        """Points that reach farthest along unit vectors (n, 3), from the centres, (n, 3)."""

    @abstractmethod
    def common_normal(
        self, apart: np.ndarray, other: Bodies, *, to_the_end: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Common normals with others, each with one, and the gaps along them.

        Parameters
        ----------
        apart : (n, 3) array
            From the centres of the others to these.
        other : Bodies
            n of them.
        to_the_end : bool
            False: any normal along which a pair is apart will do.

        Returns
        -------
        normal, gap : (n, 3), (n,) arrays
            Unit vectors from the others to these; overlaps are negative gaps.
        """

    @abstractmethod
    def farthest_from_axis(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance from the z axis of their farthest points, centres at ``position``, and the directions of these."""
