"""Regimes of motion, from recorded indicators: how the bed is carried, and whether its particles stay in place.

The change from one to the next is gradual; the limits below are conventions, chosen where the paper's bed changes its
motion.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

SOLID_BELOW = 0.02
"""Effectiveness under which a bed moves with its cavity."""

TWO_SIDED_ABOVE = 0.1
"""The smaller impulse, of lid and floor, over the larger.  Stray particles that reach the lid stay below 0.03."""

CONVECTING_BELOW = 1 / 3
"""Part of the particles' mass that the structure feels under which most of the bed has left its walls."""

RECORDED = ("floor_impulse", "lid_impulse", "apparent_mass", "cycle_displacement")


class Regime(IntEnum):
    """Regime of motion of a bed; the value is what ``regime`` returns."""

    UNKNOWN = 0
    SOLID = 1
    FLUIDISED = 2
    TWO_SIDED_COLLISION = 3
    CONVECTING = 4


def regime(dataset: xr.Dataset) -> xr.DataArray:
    """Regime of motion of every case.

    Solid: the effectiveness is below 2 %.  Two-sided collision: of lid and floor one gives at least a tenth of the
    other's impulse.  Unknown: the case failed, or the cavity moves across its axis.
    Convecting: the structure feels less than a third of the particles, and these end a cycle farther from where they
    began than the cavity moves.  Fluidised: none of it; particles part, and return.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results with the variables in ``RECORDED``.

    Returns
    -------
    xarray.DataArray
        Numbers of ``Regime``, on the dimensions of ``effectiveness``.

    Raises
    ------
    ValueError
        If a variable is missing: ``effects.indicators`` was off.
    """
    import xarray as xr

    missing = [name for name in RECORDED if name not in dataset]
    if missing:
        raise ValueError(f"the results have no {missing[0]}: run with effects.indicators on")
    carried = dataset["apparent_mass"] / dataset["particle_mass"]
    transported = dataset["cycle_displacement"] > dataset["displacement"]
    labels = xr.where((carried < CONVECTING_BELOW) & transported, int(Regime.CONVECTING), int(Regime.FLUIDISED))
    ends = [dataset["floor_impulse"], dataset["lid_impulse"]]
    two_sided = np.minimum(*ends) > TWO_SIDED_ABOVE * np.maximum(*ends)
    labels = xr.where(two_sided, int(Regime.TWO_SIDED_COLLISION), labels)
    labels = xr.where(dataset["effectiveness"] < SOLID_BELOW, int(Regime.SOLID), labels)
    known = np.isfinite(dataset["effectiveness"]) & np.isfinite(dataset["lid_impulse"])
    labels = xr.where(known, labels, int(Regime.UNKNOWN))
    labels = labels.transpose(*dataset["effectiveness"].dims).astype(np.int8)
    labels.attrs.update(
        units="1",
        long_name="regime of motion",
        flag_values=np.array([int(r) for r in Regime], np.int8),
        flag_meanings=" ".join(r.name.lower() for r in Regime),
    )
    return labels
