"""Recorded signals, a force or the acceleration of a base over time, from text tables.

The columns are time_s, and force_N, acceleration_m_s2 or acceleration_g (g = 9.80665 m/s^2, that of units); other
units are written as time_ms, force [lbf] or acceleration (mm/s^2), as those of FRFs.
Encodings, separators and decimal marks are those of ``text_table``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import UsageError
from ..formats.frf_units import metres_per_second_squared, newtons, seconds
from ..formats.text_table import Column, TextTable, read_table

FACTORS = {"time": seconds, "force": newtons, "acceleration": metres_per_second_squared}
NAMES = {"time": "time_s", "force": "force_N", "acceleration": "acceleration_m_s2 or acceleration_g"}
LARGEST = 1e100
"""Of times and values: powers of larger ones overflow."""
UNEVEN = 0.05
"""Part of a step by which a time may be off: files keep few digits."""


def samples(path: Path, quantity: str) -> tuple[np.ndarray, float]:
    """Samples in SI of a record, and the step between them [s].

    A sample of zero follows the last: after its record a signal is at rest.

    Parameters
    ----------
    path : Path
    quantity : "force" or "acceleration"

    Raises
    ------
    UsageError
        If the file is no table of finite numbers, has other columns or units, or is not evenly spaced from time 0.
    """
    table = read_table(path)
    time, values = _columns(table, quantity)
    if len(values) < 2:
        raise UsageError(f"{path}: holds one sample: a record needs at least two rows")
    if not max(np.abs(time).max(), np.abs(values).max()) < LARGEST:
        raise UsageError(f"{path}: has a number above {LARGEST:g}: correct it")
    if not values.any():
        raise UsageError(f"{path}: the {quantity} is zero throughout")
    step = time[-1] / (len(time) - 1)
    if time[0] != 0 or step <= 0 or np.abs(time - step * np.arange(len(time))).max() > UNEVEN * step:
        line = table.lines[_odd(time)]
        raise UsageError(f"{path}:{line}: the time must start at 0 and be evenly spaced: resample the record")
    return np.append(values, 0.0), float(step)


def _odd(time: np.ndarray) -> int:
    """Row at which the time is odd: the first, or that after the step that is most unlike the usual one."""
    steps = np.diff(time)
    return 0 if time[0] != 0 else 1 + int(np.argmax(np.abs(steps - np.median(steps))))


def _columns(table: TextTable, quantity: str) -> tuple[np.ndarray, np.ndarray]:
    """Times and values in SI, by the names of their columns."""
    place = f"{table.file}:{table.header_line or table.lines[0]}"
    names = [column.name.lower().partition("_")[0].strip() for column in table.columns]
    if sorted(names) != sorted(("time", quantity)):
        got = ", ".join(map(str, table.columns)) or "no names"
        raise UsageError(f"{place}: the columns must be time_s and {NAMES[quantity]}, got {got}")
    with np.errstate(over="ignore"):  # refused by the caller
        found = {
            name: _factor(column, name, place) * values
            for name, column, values in zip(names, table.columns, table.values.T, strict=True)
        }
    return found["time"], found[quantity]


def _factor(column: Column, quantity: str, place: str) -> float:
    """What turns a column's unit into SI, written into its name, as in acceleration_m_s2, or behind it."""
    suffix = column.name.partition("_")[2].replace("_", "/")
    if suffix and column.unit:
        raise UsageError(f"{place}: column {column} says its unit twice: leave one out")
    unit = suffix or column.unit
    if not unit:
        raise UsageError(f"{place}: column {column} has no unit: write {NAMES[quantity]}, or its unit in brackets")
    try:
        return FACTORS[quantity](unit)
    except ValueError as error:
        said = str(error)
        if said.startswith("cannot read"):  # whose remedy is that of FRFs
            said = f"{said.partition(': write')[0]}: write {NAMES[quantity]}"
        raise UsageError(f"{place}: column {column}: {said}") from None
