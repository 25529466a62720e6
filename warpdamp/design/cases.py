"""Cases of designs: run through the runner and its store, and kept as rows of a table."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from ..config.study import Config
from ..config.sweep import SweepConfig
from ..errors import ConfigError, SimulationError
from ..status import FIRST_UNFINISHED
from ..study.run import run
from ..sweep.axes import dotted
from .problem import Design, Problem

_log = logging.getLogger(__name__)

NOISE = ("energy_dissipated_standard_error", "memory_error", "discretisation_error")


@dataclass(frozen=True)
class Order:
    """Case that is wanted: a design, the row of a mode, Gamma, and a packing."""

    design: Design
    mode: int
    gamma: float
    seed: int


@dataclass(frozen=True)
class Row:
    """Finished case.

    Parameters
    ----------
    order : Order
    frequency : [Hz]
    effectiveness : NaN where the case failed
    error : relative standard error of a single packing: average, bed's state and step
    step_error : relative, of the step, which packings share
    packing : packing fraction of the bed
    """

    order: Order
    frequency: float
    effectiveness: float
    error: float
    step_error: float
    packing: float

    @property
    def known(self) -> bool:
        """Whether it says anything."""
        return bool(np.isfinite(self.effectiveness) and self.effectiveness > 0 and np.isfinite(self.error))


Report = Callable[[str, float], None]


def run_orders(problem: Problem, orders: list[Order], store: Path, *, workers: int | None, report: Report) -> list[Row]:
    """Run cases; those that the store has are not run again.

    Parameters
    ----------
    problem : Problem
    orders : list of Order
    store : Path
        Folder that all cases of a search are kept in.
    workers : int or None
    report : callable
        See ``warpdamp.run``.

    Returns
    -------
    list of Row
        One for each, in order.
    """
    rows: dict[int, Row] = {}
    groups: dict[tuple, list[int]] = {}
    for k, order in enumerate(orders):
        groups.setdefault(_apart(order.design), []).append(k)
    for members in groups.values():
        found = _run_group(problem, [orders[k] for k in members], store, workers, report)
        rows |= dict(zip(members, found, strict=True))
    return [rows[k] for k in range(len(orders))]


def _apart(design: Design) -> tuple:
    """Values that designs of one study share: words, as of a material."""
    return tuple(value for path, value in design.values.items() if isinstance(value, str) and path[0] != "structure")


def _run_group(problem: Problem, orders: list[Order], store: Path, workers: int | None, report: Report) -> list[Row]:
    frequencies = []
    for order in orders:
        found = problem.modes(order.design).frequency[order.mode]
        frequencies.append(round(float(found), 6))  # to a microhertz, as studies do
    study = _study(orders, frequencies)
    try:
        dataset = run(study, store=store, workers=workers, report=report)
    except (SimulationError, ConfigError) as error:  # none of these few could be run: the search learns of it
        _log.warning("none of %d cases of a design could be run: %s", len(orders), error)
        return [Row(order, f, *[np.nan] * 4) for order, f in zip(orders, frequencies, strict=True)]
    return [_row(dataset.isel(case=k), order, frequencies[k]) for k, order in enumerate(orders)]


def _study(orders: list[Order], frequencies: list[float]) -> Config:
    """Study of cases that change together: each a combination of the variables, a frequency, Gamma and a seed."""
    first = orders[0]
    base = first.design.config
    paths = [
        path for path, value in first.design.values.items() if path[0] != "structure" and not isinstance(value, str)
    ]
    together: dict[str, list] = {dotted(path): [order.design.values[path] for order in orders] for path in paths}
    together["excitation.frequency"] = list(frequencies)
    together["excitation.gamma"] = [float(f"{order.gamma:.6g}") for order in orders]
    together["seeds"] = [order.seed for order in orders]
    excitation = base.excitation.model_copy(update={"frequency": frequencies[0], "gamma": orders[0].gamma})
    used = set(base.damper.materials().values())
    return base.model_copy(
        update={
            "title": "Design search",
            "structure": None,
            "coupled": None,
            "materials": {name: value for name, value in base.materials.items() if name in used},
            "excitation": excitation,
            "sweep": SweepConfig(zip=[together]),
            "seeds": [1],
        }
    )


def _row(case: xr.Dataset, order: Order, frequency: float) -> Row:
    case = case.squeeze()
    status = int(case["status"])
    if status < 0 or status >= FIRST_UNFINISHED or "energy_dissipated" not in case:
        return Row(order, frequency, *[np.nan] * 4)
    energy = float(case["energy_dissipated"])
    parts = [float(case[name]) / energy if energy > 0 else np.nan for name in NOISE]
    packing = float(case["packing_fraction"]) if "packing_fraction" in case else np.nan
    return Row(
        order, frequency, float(case["effectiveness"]), float(np.sqrt(np.sum(np.square(parts)))), parts[-1], packing
    )
