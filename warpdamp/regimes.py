"""Regimes of motion, as far as what is recorded tells them.

Whether a bed convects is not among it: that needs the displacement of particles over a cycle.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

SOLID_BELOW = 0.02
"""Effectiveness under which a bed moves with its cavity."""


class Regime(IntEnum):
    """How a bed moves."""

    UNKNOWN = 0
    SOLID = 1
    FLUIDISED = 2
    TWO_SIDED_COLLISION = 3


def flight_height(gamma) -> np.ndarray:
    """How far a plastic block rises above the floor of its cavity, over the amplitude X, with gravity along the axis.

    It lifts off at sin a = 1 / Gamma and flies freely: its height over X after a phase t is
    sin a + t cos a - sin(a + t) - t^2 / (2 Gamma).
    """
    gamma = np.asarray(gamma, float)[..., None]
    start = np.arcsin(1 / np.maximum(gamma, 1.0))
    t = np.linspace(0, 4 * np.pi, 2001)
    height = np.sin(start) + t * np.cos(start) - np.sin(start + t) - t**2 / (2 * gamma)
    landed = np.maximum.accumulate((height < 0) & (t > 1e-3), axis=-1)
    return np.where(gamma[..., 0] > 1, np.max(np.where(landed, 0.0, height), axis=-1), 0.0)


def regime(dataset: xr.Dataset, *, lid_impulse: xr.DataArray | None = None) -> xr.DataArray:
    """Label every case.

    Solid: the effectiveness is below 2 %.  Two-sided collision: the lid takes impulses or, where they are not
    recorded, a plastic block in this cavity would rise through the clearance measured.  Fluidised: neither.

    Parameters
    ----------
    lid_impulse : momentum that the lid gives per cycle, where it is recorded
    """
    import xarray as xr

    effectiveness, clearance = xr.broadcast(dataset["effectiveness"], dataset["clearance"])
    rise = dataset["displacement"] * xr.apply_ufunc(flight_height, dataset["gamma"])
    hits = rise > clearance if lid_impulse is None else lid_impulse > 0
    labels = xr.where(hits, int(Regime.TWO_SIDED_COLLISION), int(Regime.FLUIDISED))
    labels = xr.where(effectiveness < SOLID_BELOW, int(Regime.SOLID), labels)
    known = np.isfinite(effectiveness) & (np.isfinite(clearance) if lid_impulse is None else True)
    labels = xr.where(known, labels, int(Regime.UNKNOWN)).transpose(*effectiveness.dims).astype(np.int8)
    labels.attrs.update(
        units="1",
        long_name="regime of motion",
        flag_values=np.array([int(r) for r in Regime], np.int8),
        flag_meanings=" ".join(r.name.lower() for r in Regime),
    )
    return labels
