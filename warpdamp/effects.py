"""What a scene calls for: the frozen choice that kernels are compiled for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import warp as wp


@dataclass(frozen=True)
class Effects:
    """Effects that are compiled into the kernels; one that is off costs nothing.

    Parameters
    ----------
    precision : "float64" or "float32"
        Of the motion; the ledger is always float64.
    enclosure : bool
        Whether the particles are in a cavity.
    guards : bool
        Whether every step checks that the state is finite, and every launch that all particles are in the cavity.
    """

    precision: Literal["float64", "float32"] = "float64"
    enclosure: bool = True
    guards: bool = True

    @property
    def real(self):
        """The Warp scalar type of the motion."""
        return wp.float64 if self.precision == "float64" else wp.float32
