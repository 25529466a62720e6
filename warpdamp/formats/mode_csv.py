"""Modes as a CSV table: one row for each mode at each point.

| column | holds |
|---|---|
| mode | number of the mode |
| frequency_Hz | natural frequency |
| modal_mass_kg | of the shape as it is written here; 1 where it is mass-normalised |
| damping_ratio | inherent damping; 0 where the column is left out |
| node | number of the point; its place in the table where the column is left out |
| x_m, y_m, z_m | position of the point |
| u_x, u_y, u_z | shape there; 0 where a column is left out |

Other units are written as frequency [rad/s], x [mm] or x_mm; encodings, separators and decimal marks are those of
``text_table``.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from ..errors import ModalError
from ..files import whole_file
from ..modes import Modes, mass_normalised
from .text_table import Column, TextTable, read_table

LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254, "inch": 0.0254, "ft": 0.3048}
PURE = {"": 1.0, "1": 1.0, "-": 1.0}
UNITS = {  # quantity: what turns its units into SI
    "mode": PURE,
    "frequency": {"hz": 1.0, "khz": 1e3, "rad/s": 1 / (2 * math.pi)},
    "modal_mass": {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.45359237, "lbm": 0.45359237},
    "damping_ratio": PURE | {"%": 0.01},
    "node": PURE,
    **dict.fromkeys(("x", "y", "z"), LENGTHS),
    **dict.fromkeys(("u_x", "u_y", "u_z"), PURE),
}
NEEDED = {"mode": "mode", "frequency": "frequency_Hz", "x": "x_m", "y": "y_m", "z": "z_m"}
PLACES, SHAPES = ("x", "y", "z"), ("u_x", "u_y", "u_z")
COLUMNS = ("mode", "frequency_Hz", "modal_mass_kg", "damping_ratio", "node", "x_m", "y_m", "z_m", *SHAPES)
REMEDY = (
    "add a column modal_mass_kg, or give modal_mass: the modal mass of the shapes as they are written, 1 kg if they "
    "are mass-normalised"
)


def read_csv(path, *, modal_mass=None) -> Modes:
    """Read modes, as a damper at the first point sees them along z; ``Modes.at`` puts it elsewhere.

    Parameters
    ----------
    path : of the table
    modal_mass : one, or one for each mode [kg], where the table has no column of it

    Raises
    ------
    TableError
        If there is no such file, or it is no table of numbers.
    ModalError
        If a column is missing or unknown or its unit is, a number is none that a mode can have, modes differ in their
        points, or if a mode has no modal mass.
    """
    table = read_table(Path(path))
    cells = _quantities(table)
    _check_numbers(table, cells)
    if ("modal_mass" in cells) == (modal_mass is not None):
        said = "says the modal mass, and modal_mass says it again" if modal_mass is not None else "has no modal mass"
        raise ModalError(f"{path} {said}: {'leave one out' if modal_mass is not None else REMEDY}")
    rows = _rows_of_modes(table, cells)
    heads, number = rows[:, 0], cells["mode"][rows[:, 0]].astype(int)
    given = cells["modal_mass"][heads] if modal_mass is None else modal_mass
    none = np.zeros(len(table.lines))
    shape = np.stack([cells.get(name, none)[rows] for name in SHAPES], axis=2)
    still = number[~np.any(shape, axis=(1, 2))]
    if len(still):
        raise ModalError(f"{path}: mode {still[0]} moves no point: leave it out")
    modes = Modes(
        number=number,
        frequency=cells["frequency"][heads],
        point=np.stack([cells[name][rows[0]] for name in PLACES], axis=1),
        shape=mass_normalised(number, shape, given, f"{path}: ", REMEDY),
        inherent_damping=cells.get("damping_ratio", none)[heads],
        label=cells.get("node", np.arange(len(none)) + 1)[rows[0]].astype(int),
    )
    return modes.seen_from(0, (0, 0, 1))


def write_csv(path, modes: Modes) -> None:
    """Write modes, mass-normalised (modal mass 1 kg), to full precision."""
    labels = np.arange(1, len(modes.point) + 1) if modes.label is None else modes.label
    with whole_file(Path(path)) as part, part.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for k, number in enumerate(modes.number):
            head = (number, repr(float(modes.frequency[k])), 1, repr(float(modes.inherent_damping[k])))
            for label, place, shape in zip(labels, modes.point, modes.shape[k], strict=True):
                table.writerow((*head, label, *(repr(float(x)) for x in (*place, *shape))))


def _quantities(table: TextTable) -> dict[str, np.ndarray]:
    """The columns in SI, by their quantities."""
    place = f"{table.file}:{max(table.header_line, 1)}"
    known = f"the columns are {', '.join(COLUMNS)}"
    if not table.columns:
        raise ModalError(f"{place}: has no line of names above the numbers; {known}")
    found, wrong = {}, []
    for column, values in zip(table.columns, table.values.T, strict=True):
        quantity, factor = _quantity(column)
        if factor is None:
            wrong.append(_unknown(column, quantity))
        elif quantity in found:
            wrong.append(f"two columns of {quantity}")
        else:
            found[quantity] = factor * values
    missing = [column for name, column in NEEDED.items() if name not in found]
    if not set(found) & set(SHAPES):
        missing.append("u_x, u_y or u_z")
    wrong = [f"there is no column {name}" for name in missing] + wrong
    if wrong:
        raise ModalError(f"{place}: {'; '.join(wrong)}; {known}")
    return found


def _quantity(column: Column) -> tuple[str | None, float | None]:
    """The quantity of a column, and what turns its unit into SI; None where they are not known."""
    name, unit = column.name.lower().replace(" ", "_"), column.unit.lower()
    for quantity, units in UNITS.items():
        if name == quantity:
            return quantity, units.get(unit)
        if not unit and name.startswith(f"{quantity}_") and name[len(quantity) + 1 :] in units:
            return quantity, units[name[len(quantity) + 1 :]]
    return None, None


def _unknown(column: Column, quantity: str | None) -> str:
    if quantity is None:
        return f"unknown column {column}"
    units = ", ".join(unit for unit in UNITS[quantity] if unit not in ("", "1"))
    said = f"the unknown unit {column.unit}" if column.unit else "no unit"
    return f"column {column.name} has {said}: expected {units or 'none'}"


def _check_numbers(table: TextTable, cells: dict[str, np.ndarray]) -> None:
    """Refuses numbers that no mode can have, each at its line."""
    whole = "expected a whole number of at least 1"
    limits = {
        "mode": (lambda x: (x >= 1) & (x == np.round(x)) & (x < 1e9), whole),
        "node": (lambda x: (np.abs(x) < 1e15) & (x == np.round(x)), "expected a whole number"),
        "frequency": (lambda x: x >= 0, "expected a frequency of at least 0"),
        "damping_ratio": (lambda x: (x >= 0) & (x < 1), "expected a ratio of at least 0 and below 1"),
    }
    for name, (holds, expected) in limits.items():
        bad = np.flatnonzero(~holds(cells[name])) if name in cells else ()
        if len(bad):
            raise ModalError(f"{table.file}:{table.lines[bad[0]]}: {name}: {cells[name][bad[0]]:g}: {expected}")


def _rows_of_modes(table: TextTable, cells: dict[str, np.ndarray]) -> np.ndarray:
    """(m, p) rows of the modes in the table, each at the points of the first, in their order."""
    mode = cells["mode"]
    numbers = mode[np.sort(np.unique(mode, return_index=True)[1])]
    blocks = [np.flatnonzero(mode == number) for number in numbers]
    point = [name for name in (*PLACES, "node") if name in cells]
    for number, block in zip(numbers, blocks, strict=True):
        same = len(block) == len(blocks[0]) and all(np.array_equal(cells[n][block], cells[n][blocks[0]]) for n in point)
        if not same:
            raise ModalError(
                f"{table.file}: mode {number:g} is not given at the points of the first mode, in their order"
            )
        for name in ("frequency", "modal_mass", "damping_ratio"):
            if name in cells and len(np.unique(cells[name][block])) > 1:
                raise ModalError(f"{table.file}: mode {number:g} has more than one {name}: number each mode once")
    if "node" in cells:
        label, times = np.unique(cells["node"][blocks[0]], return_counts=True)
        if np.any(times > 1):
            raise ModalError(
                f"{table.file}: node {label[times > 1][0]:g} is there twice in each mode: number each once"
            )
    return np.array(blocks)
