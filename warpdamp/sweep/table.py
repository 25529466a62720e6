"""Table of a sweep: a CSV file, one scalar of the configuration a column, called by its path."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from ..formats.text_file import TableError
from ..formats.text_table import Column, Row, column, is_number, number, read_rows, without_empty_last


def read_table(file: Path) -> tuple[list[tuple[str, str]], Iterator[tuple[str, list]]]:
    """Columns of a table, and its rows one after the other.

    Returns
    -------
    heads : list of (place in the file, path)
    rows : iterator of (place in the file, values: numbers, quantities in the unit of their column, truth values, text)

    Raises
    ------
    TableError
        If the file cannot be read, has no rows, mixes decimal marks, or (while rows are read) one is of another length.
    """
    rows = read_rows(file, separators=(";", "\t", ","))
    if len(rows) < 2:
        raise TableError(f"{file} needs a line of paths and at least one line of values")
    (head,), lines = without_empty_last(rows[:1]), rows[1:]
    if not any(any(line.cells[len(head.cells) :]) for line in lines):  # a separator at the end of lines
        lines = [Row(line.line, line.cells[: len(head.cells)]) for line in lines]
    if mixed := _two_decimal_marks(lines):
        raise TableError(f"{file}:{mixed}: has decimal points and decimal commas: write one of them")
    columns = [column(cell) for cell in head.cells]
    heads = [(f"{file}:{head.line}: column '{title}'", title.name) for title in columns]
    return heads, (_values(f"{file}:{line.line}", line, columns) for line in lines)


def _values(where: str, line: Row, columns: list[Column]) -> tuple[str, list]:
    if len(line.cells) != len(columns):
        raise TableError(f"{where}: {len(line.cells)} values for {len(columns)} columns")
    return where, [_cell(cell, title.unit) for cell, title in zip(line.cells, columns, strict=True)]


def _two_decimal_marks(rows: list[Row]) -> int | None:
    """The first line by which numbers have been written with decimal points and with decimal commas."""
    marks: set[str] = set()
    for row in rows:
        marks |= {mark for cell in row.cells if is_number(cell) for mark in ",." if mark in cell}
        if len(marks) > 1:
            return row.line
    return None


def _cell(text: str, unit: str):
    """A number, a quantity in the unit of its column, a truth value, or text."""
    bare = unit in ("", "-", "1")
    if not is_number(text):
        return {"true": True, "false": False}.get(text.lower(), text if bare else f"{text} {unit}")
    if not bare:
        return f"{number(text)!r} {unit}"
    value = number(text)
    return int(text) if text.lstrip("+-").isdigit() else value if math.isfinite(value) else text
