"""Modes as a CSV table: one row for each mode at each point, SI units.

| column | holds |
|---|---|
| mode | number of the mode |
| frequency_Hz | natural frequency |
| modal_mass_kg | of the shape as it is written here; 1 where it is mass-normalised |
| damping_ratio | inherent damping; 0 where the column is left out |
| node | number of the point; its place in the table where the column is left out |
| x_m, y_m, z_m | position of the point |
| u_x, u_y, u_z | shape there; 0 where a column is left out |
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from ..files import whole_file
from .modes import Modes, mass_normalised

NEEDED = ("mode", "frequency_Hz", "x_m", "y_m", "z_m")
SHAPES = ("u_x", "u_y", "u_z")
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
    OSError
        If there is no such file.
    ValueError
        If a column is missing or unknown, a cell is no number, modes differ in their points, or if a mode has no modal
        mass.
    """
    rows = _rows(Path(path))
    if ("modal_mass_kg" in rows[0]) == (modal_mass is not None):
        said = "says the modal mass, and modal_mass says it again" if modal_mass is not None else "has no modal mass"
        raise ValueError(f"{path} {said}: {'leave one out' if modal_mass is not None else REMEDY}")
    blocks: dict[float, list] = {}
    for row in rows:
        blocks.setdefault(row["mode"], []).append(row)
    first = next(iter(blocks.values()))
    point = _columns(first, ("x_m", "y_m", "z_m"))
    label = np.array([int(row.get("node", k)) for k, row in enumerate(first, 1)])
    for number, block in blocks.items():
        if len(block) != len(first) or not np.array_equal(_columns(block, ("x_m", "y_m", "z_m")), point):
            raise ValueError(f"{path}: mode {number:g} is not given at the points of the first mode, in their order")
        for name in ("frequency_Hz", "modal_mass_kg", "damping_ratio"):
            if len({row.get(name) for row in block}) > 1:
                raise ValueError(f"{path}: mode {number:g} has more than one {name}")
    heads = [block[0] for block in blocks.values()]
    masses = [row["modal_mass_kg"] for row in heads] if modal_mass is None else modal_mass
    number = np.array([int(row["mode"]) for row in heads])
    shape = np.array([_columns(block, SHAPES) for block in blocks.values()])
    modes = Modes(
        number=number,
        frequency=np.array([row["frequency_Hz"] for row in heads]),
        point=point,
        shape=mass_normalised(number, shape, masses, f"{path}: ", REMEDY),
        inherent_damping=np.array([row.get("damping_ratio", 0.0) for row in heads]),
        label=label,
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


def _rows(path: Path) -> list[dict[str, float]]:
    """The table's rows, each cell a number."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        table = csv.DictReader(file, skipinitialspace=True)
        names = [name.strip() for name in table.fieldnames or ()]
        table.fieldnames = names
        missing = [name for name in NEEDED if name not in names]
        if not set(names) & set(SHAPES):
            missing.append("u_x, u_y or u_z")
        unknown = [name for name in names if name not in COLUMNS]
        if missing or unknown:
            wrong = [f"there is no column {name}" for name in missing]
            wrong += [f"unknown column {name}" for name in unknown]
            raise ValueError(f"{path}:1: {'; '.join(wrong)}; the columns are {', '.join(COLUMNS)}")
        rows = [_numbers(row, f"{path}:{table.line_num}") for row in table]
    if not rows:
        raise ValueError(f"{path}: has no rows")
    return rows


def _numbers(row: dict, place: str) -> dict[str, float]:
    numbers = {}
    for name, cell in row.items():
        try:
            numbers[name] = float(cell)
        except (TypeError, ValueError):
            raise ValueError(f"{place}: {name or 'a cell too many'}: {cell!r} is no number") from None
        if not np.isfinite(numbers[name]):
            raise ValueError(f"{place}: {name}: {cell!r} is not finite")
    if numbers["frequency_Hz"] <= 0:
        raise ValueError(f"{place}: frequency_Hz: must be above 0; leave rigid-body modes out")
    return numbers


def _columns(rows, names) -> np.ndarray:
    return np.array([[row.get(name, 0.0) for name in names] for row in rows])
