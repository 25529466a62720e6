"""Cards of dampers as CSV tables: a row for each frequency and Gamma, to the last digit.

Lines that begin with # hold what is known of the card, each a name and a value in JSON, as

    # particle_mass_kg: 0.0239985

Below them a line of names with units in brackets, and the rows.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import ModalError, printable
from ..files import whole_file
from ..formats.text_file import TableError, read_text
from ..formats.text_table import Column, TextTable, read_table
from ..variables import INTEGERS, VARIABLES

AXES = {"frequency": "Hz", "gamma": "1"}
NEEDED = ("card", "frequencies", "frequency_range", "gamma_range")
"""Attributes that a card cannot do without."""
MASS = "particle_mass_kg"
_LINE = re.compile(r"#\s*(\w+):\s*(.+)")


@dataclass(frozen=True)
class CardTable:
    """What a card holds.

    Parameters
    ----------
    frequency : (k,) array [Hz]
    gamma : (n,) array, increasing [-]
    values : (k, n) arrays by their names in ``VARIABLES``
    particle_mass : float [kg]
    attributes : dict
        Range and provenance.
    """

    frequency: np.ndarray
    gamma: np.ndarray
    values: dict[str, np.ndarray]
    particle_mass: float
    attributes: dict


def write_csv(file: Path, table: CardTable) -> None:
    """Write a card as a table that reads back to the same bits."""
    with whole_file(file) as part, part.open("w", newline="", encoding="utf-8") as text:
        for name, value in {**table.attributes, MASS: table.particle_mass}.items():
            plain = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
            text.write(f"# {name}: {json.dumps(plain)}\n")
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow([str(column) for column in _columns(table.values)])
        for i, frequency in enumerate(table.frequency):
            for k, gamma in enumerate(table.gamma):
                row = (frequency, gamma, *(values[i, k] for values in table.values.values()))
                rows.writerow([repr(value.item()) for value in row])


def _columns(names) -> list[Column]:
    units = AXES | {name: VARIABLES[name][0] for name in names}
    return [Column(name, unit) for name, unit in units.items()]


def read_csv(file: Path, names: Sequence[str], version: int) -> CardTable:
    """Read a card from a table.

    Parameters
    ----------
    file : Path
    names : of the variables that a card holds
    version : of the card that is read

    Raises
    ------
    ModalError
        If there is no such file, it is no card or one of another version, its columns are not those of a card, or a
        frequency and Gamma are missing or there twice.
    """
    try:
        return _read(file, names, version)
    except (ModalError, TableError) as error:
        raise ModalError(printable(str(error))) from None


def _read(file: Path, names: Sequence[str], version: int) -> CardTable:
    attributes, table = _read_attributes(file, version), read_table(file)
    columns = _read_columns(table, names)
    frequency, gamma = (np.unique(columns[name]) for name in AXES)
    order = np.lexsort((columns["gamma"], columns["frequency"]))
    grid = np.stack([columns[name][order] for name in AXES])
    if not np.array_equal(grid, [np.repeat(frequency, len(gamma)), np.tile(gamma, len(frequency))]):
        raise ModalError(f"{file}: expected one row for every frequency and Gamma, {len(frequency)} times {len(gamma)}")
    _check(file, table.lines, columns)
    values = {name: columns[name][order].reshape(len(frequency), len(gamma)) for name in names}
    values |= {name: values[name].astype(np.int64) for name in names if name in INTEGERS}
    mass = attributes.pop(MASS)
    check_range(file, attributes, mass, frequency, gamma)
    return CardTable(frequency, gamma, values, float(mass), attributes)


def _read_attributes(file: Path, version: int) -> dict:
    found = {}
    for number, line in enumerate(read_text(file).splitlines(), 1):
        if not (named := _LINE.fullmatch(line.strip())):
            continue
        where = f"{file}:{number}: {named[1]}"
        try:
            found[named[1]] = json.loads(named[2])
        except (ValueError, RecursionError):
            raise ModalError(f"{where}: expected a value in JSON, as text in double quotes") from None
        if not _is_plain(found[named[1]]):
            raise ModalError(f"{where}: expected text, a number or a list of either")
    if missing := [name for name in (*NEEDED, MASS) if name not in found]:
        raise ModalError(f"{file}: is no card of a damper: it has no line '# {missing[0]}: ...'")
    if found["card"] != version:
        raise ModalError(f"{file}: is a card of version {found['card']}, read is {version}: write it again")
    return found


def _is_plain(value) -> bool:
    """Whether a value can be an attribute of a netCDF file."""
    values = value if isinstance(value, list) else [value]
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) and abs(v) < 1e15 for v in values)
    return numbers or all(isinstance(v, str) for v in values)


def _read_columns(table: TextTable, names: Sequence[str]) -> dict[str, np.ndarray]:
    expected = _columns(names)
    if set(table.columns) != set(expected) or len(table.columns) != len(expected):
        wrong = [f"unknown column {column}" for column in table.columns if column not in expected]
        wrong += [f"there is no column {column}" for column in expected if column not in table.columns]
        what = (wrong or ["a column is there twice"])[0]
        raise ModalError(
            f"{table.file}:{max(table.header_line, 1)}: {what}; a card has {', '.join(map(str, expected))}"
        )
    return {column.name: values for column, values in zip(table.columns, table.values.T, strict=True)}


def limits(names: Sequence[str]) -> dict[str, tuple[Callable, str]]:
    """What must hold of the numbers of a card by their names, as a function and in words."""
    found = {name: (np.isfinite, "a finite number") for name in names}
    found |= {
        name: (lambda x: np.isfinite(x) & (x >= 0), "at least 0")
        for name in names
        if name.endswith(("_error", "_interval"))
    }
    found |= {name: (lambda x: np.isfinite(x) & (x > 0), "above 0") for name in AXES}
    whole = (lambda x: (x >= 0) & (x == np.round(x)), "a whole number")
    return found | {name: whole for name in names if name in INTEGERS}


def _check(file: Path, lines: np.ndarray, columns: dict[str, np.ndarray]) -> None:
    """Refuses numbers that no card can have, each at its line."""
    for name, (holds, expected) in limits(list(columns)).items():
        bad = np.flatnonzero(~holds(columns[name]))
        if len(bad):
            raise ModalError(f"{file}:{lines[bad[0]]}: {name}: {columns[name][bad[0]]:g}: expected {expected}")


def check_range(file: Path, attributes: dict, mass, frequency: np.ndarray, gamma: np.ndarray) -> None:
    """Refuses a range that is not that of the rows."""
    if not isinstance(mass, int | float) or not 0 < mass < np.inf:
        raise ModalError(f"{file}: {MASS}: {mass!r}: expected a mass above 0")
    if attributes["frequencies"] not in ("modes", "list"):
        raise ModalError(f'{file}: frequencies: {attributes["frequencies"]!r}: expected "modes" or "list"')
    if attributes["gamma_range"] != [gamma[0], gamma[-1]]:
        raise ModalError(f"{file}: gamma_range: the rows reach from {gamma[0]:g} to {gamma[-1]:g}")
    band = attributes["frequency_range"]
    numbers = isinstance(band, list) and len(band) == 2 and not any(isinstance(f, str) for f in band)
    if not (numbers and 0 < band[0] <= frequency[0] and frequency[-1] <= band[1]):
        raise ModalError(f"{file}: frequency_range: expected the lowest and the highest frequency [Hz] about the rows'")
