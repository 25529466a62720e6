"""Tables of numbers in text files, as spreadsheets, instruments and programs write them.

Separator: semicolon, tab, comma or blanks, whichever makes the most numbers.  Decimal mark: point or comma, one of the
two in a file.  Lines before the first number are the header: the names of the columns, with units in them or in a line
below.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from .text_file import TableError, read_text

SEPARATORS = (";", "\t", ",", None)
"""In the order in which a draw is decided; None stands for blanks."""
COMMENTS = ("#", "%")
SAMPLE = 200
"""Lines that the separator is judged by."""
NAMES = {";": "semicolons", "\t": "tabs", ",": "commas", None: "blanks"}
_NUMBER = re.compile(r"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eEdD][-+]?\d+)?|[-+]?(?:nan|inf(?:inity)?)", re.IGNORECASE)
_UNIT = (
    re.compile(r"(?P<name>.*?)\s*\[(?P<unit>.*)\]"),
    re.compile(r"(?P<name>.*?)\s*\((?P<unit>[^()]*(?:\([^()]*\)[^()]*)*)\)"),
    re.compile(r"(?P<name>.*?)\s+(?:/|in)\s+(?P<unit>\S.*)"),
)
_SPACES = str.maketrans({"\u00a0": " ", "\u2007": " ", "\u2009": " ", "\u202f": " ", "\u2212": "-"})


@dataclass(frozen=True)
class Row:
    """A line of a table: its number in the file, and its cells without blanks around them."""

    line: int
    cells: tuple[str, ...]


@dataclass(frozen=True)
class Column:
    """The head of a column: its name, and its unit as the file writes it, empty where it has none."""

    name: str
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True)
class TextTable:
    """A table of numbers.

    Parameters
    ----------
    file : path
    columns : heads of the columns; none where the file has no header
    values : (n, m) array, every one finite
    lines : (n,) numbers of the rows' lines in the file
    header_line : number of the line with the names; 0 where there is none
    """

    file: Path
    columns: tuple[Column, ...]
    values: np.ndarray
    lines: np.ndarray
    header_line: int = 0


def read_rows(file: Path, separators=SEPARATORS) -> list[Row]:
    """The cells of a table with text in it: lines that are neither empty nor comments, split at the separator found.

    Parameters
    ----------
    file : path
    separators : to choose from; without None where cells have blanks in them

    Raises
    ------
    TableError
        If the file cannot be read as text.
    """
    return _split(read_text(file), file, separators)[0]


def read_table(file: Path) -> TextTable:
    """A table of finite numbers.

    Raises
    ------
    TableError
        If the file cannot be read as text, has no rows of numbers, rows of different lengths, a cell that is no finite
        number, both decimal points and commas, or a line above the numbers that is neither names nor units.
    """
    file = Path(file)
    rows, separator, comments = _split(read_text(file), file)
    first = _first_of_numbers(rows)
    if first is None:
        raise TableError(f"{file}: holds no rows of numbers: expected a line of names and rows of numbers below it")
    head, body = rows[:first], without_empty_last(rows[first:])
    width = len(body[0].cells)
    named = _line_of_names(head, comments, body[0].line, width)
    columns, others = _header(head, named, width)
    if named and not columns:
        raise TableError(f"{file}:{named.line}: {len(named.cells)} names for {width} columns{_remedy(separator)}")
    if others:
        odd = " ".join(others[0].cells)
        raise TableError(f"{file}:{others[0].line}: '{odd}' is neither names nor units: begin remarks with #")
    return TextTable(
        file=file,
        columns=columns,
        values=_numbers(file, body, columns, separator),
        lines=np.array([row.line for row in body]),
        header_line=named.line if columns else 0,
    )


def is_number(cell: str) -> bool:
    """Whether a cell is written as a number, with a decimal point or comma, a D or an E before its exponent."""
    return _NUMBER.fullmatch(cell) is not None


def number(cell: str) -> float:
    """The number in a cell; a ValueError if it is none."""
    if not is_number(cell):
        raise ValueError(f"{cell!r} is no number")
    return float(cell.replace(",", ".").replace("d", "e").replace("D", "e"))


def column(text: str) -> Column:
    """Name and unit in the head of a column, as "Frequency [Hz]", "Frequency (Hz)" or "Frequency / Hz"."""
    for pattern in _UNIT:
        found = pattern.fullmatch(text)
        if found:
            return Column(found["name"].strip(), found["unit"].strip())
    return Column(text)


def _split(text: str, file, separators=SEPARATORS) -> tuple[list[Row], str | None, list[tuple[int, str]]]:
    """Rows, the separator between their cells, and comments with their lines."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").translate(_SPACES).split("\n")
    lines = [(k, line.strip(" \ufeff")) for k, line in enumerate(lines, 1)]
    lines = [(k, line) for k, line in lines if line.strip()]
    comments = [(k, line) for k, line in lines if line.startswith(COMMENTS)]
    lines = [(k, line) for k, line in lines if not line.startswith(COMMENTS)]
    if lines and re.fullmatch(r'"?sep=[;,\t]"?', lines[0][1], re.IGNORECASE):  # spreadsheets say it so
        separator = lines.pop(0)[1].strip('"')[4]
    else:
        separator = None
    try:
        separator = separator or _separator([line for _, line in islice(lines, SAMPLE)], separators)
        return [Row(k, _cells(line, separator)) for k, line in lines], separator, comments
    except csv.Error as error:
        raise TableError(f"{file}: is no table of cells: {error}") from None


def _cells(line: str, separator: str | None) -> tuple[str, ...]:
    if separator is None:
        return tuple(line.split())
    cells = (
        next(csv.reader([line], delimiter=separator, skipinitialspace=True)) if '"' in line else line.split(separator)
    )
    return tuple(cell.strip() for cell in cells)


def _separator(lines: list[str], separators) -> str | None:
    """That which gives the most lines of one length, and the most numbers in them."""

    def merit(separator):
        rows = [_cells(line, separator) for line in lines]
        width, alike = Counter(map(len, rows)).most_common(1)[0]
        numbers = sum(is_number(cell) for row in rows for cell in row) / sum(map(len, rows))
        return (width > 1, alike * (1 + numbers))

    return max(separators, key=merit) if lines else ","


def _first_of_numbers(rows: list[Row]) -> int | None:
    """The first row that begins with a number, or has one and as many cells as most rows have."""
    usual = Counter(len(row.cells) for row in rows).most_common(1)[0][0] if rows else 0
    for k, row in enumerate(rows):
        if is_number(row.cells[0]) or (len(row.cells) == usual and any(map(is_number, row.cells))):
            return k
    return None


def without_empty_last(rows: list[Row]) -> list[Row]:
    """Rows without their last cell, where every line ends with a separator: that is no column."""
    if any(row.cells[-1] for row in rows):
        return rows
    return [Row(row.line, row.cells[:-1]) for row in rows]


def _line_of_names(head: list[Row], comments, first_line: int, width: int) -> Row | None:
    """The row with the columns' names; a comment right above the numbers is one if it has as many cells."""
    if head:
        units = len(head) > 1 and _fits(head[-2], width) and _fits(head[-1], width) and not _has_unit(*head[-2:])
        return head[-2] if units else head[-1]
    above = [(k, line.lstrip("".join(COMMENTS)).strip()) for k, line in comments if k < first_line]
    for separator in SEPARATORS if above else ():
        cells = _cells(above[-1][1], separator)
        if len(cells) == width:
            return Row(above[-1][0], cells)
    return None


def _has_unit(*rows: Row) -> bool:
    return any(column(cell).unit and column(cell).name for row in rows for cell in row.cells)


def _fits(row: Row, width: int) -> bool:
    """Whether a row has a cell for every column; a separator at the end of the line makes an empty one more."""
    return len(row.cells) == width or (len(row.cells) == width + 1 and not row.cells[-1])


def _header(head: list[Row], named: Row | None, width: int) -> tuple[tuple[Column, ...], tuple[Row, ...]]:
    """Columns, and the rows of the head that are neither names nor units."""
    if named is None or not _fits(named, width):
        return (), tuple(head)
    names = named.cells[:width]
    if head and named is not head[-1]:
        units = [re.sub(r"^[\[(](.*)[\])]$", r"\1", cell) for cell in head[-1].cells[:width]]
        columns = tuple(Column(name, unit) for name, unit in zip(names, units, strict=True))
    else:
        columns = tuple(column(name) for name in names)
    return columns, tuple(row for row in head[:-1] if row is not named)


def _remedy(separator: str | None) -> str:
    if separator == ",":
        return ": if the commas are decimal marks, separate the columns by semicolons"
    return f": columns are separated by {NAMES[separator]} here"


def _numbers(file: Path, rows: list[Row], columns, separator) -> np.ndarray:
    """(n, m) array of the rows' numbers."""
    width = len(rows[0].cells)
    marks: dict[str, int] = {}
    values = np.empty((len(rows), width))
    for k, row in enumerate(rows):
        if len(row.cells) != width:
            many = f"{len(row.cells)} cells where the rows above have {width}"
            raise TableError(f"{file}:{row.line}: {many}{_remedy(separator)}")
        for j, cell in enumerate(row.cells):
            where = f"{file}:{row.line}: {columns[j].name if columns else f'column {j + 1}'}"
            values[k, j] = _finite(cell, where)
            marks.update(dict.fromkeys(set(cell) & {",", "."}, row.line))
        if len(marks) > 1:
            raise TableError(f"{file}:{row.line}: has decimal points and decimal commas: write one of them throughout")
    return values


_THOUSANDS = re.compile(r"[-+]?\d{1,3}(?:([,.' ])\d{3})(?:\1\d{3})*(?:[.,]\d*)?(?:[eEdD][-+]?\d+)?")
_PART = r"[ij]?\s*[\d.,]+(?:[eEdD][-+]?\d+)?\s*[ij]?"
_COMPLEX = re.compile(rf"\(?\s*[-+]?{_PART}\s*[-+]\s*{_PART}\s*\)?", re.IGNORECASE)


def _no_number(cell: str) -> str:
    """What is wrong with a cell that holds no number, and what to do."""
    if grouped := _THOUSANDS.fullmatch(cell):
        return f"has its thousands apart: write {cell.replace(grouped[1], '')}"
    if _COMPLEX.fullmatch(cell) and set(cell.lower()) & {"i", "j"}:
        return "is a complex number: write its real and its imaginary part into two columns"
    return "is no number: correct the cell"


def _finite(cell: str, where: str) -> float:
    try:
        value = number(cell)
    except ValueError:
        raise TableError(f"{where}: {cell!r} {_no_number(cell)}") from None
    if not np.isfinite(value):
        raise TableError(f"{where}: {cell!r} is not finite: leave the row out or correct it")
    return value
