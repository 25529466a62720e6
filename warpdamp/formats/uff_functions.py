"""Functions in universal files: dataset 58 as text, or with binary values (58b), field by field."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ..errors import ModalError
from .uff_records import Dataset

KINDS = (
    "general or unknown function", "time response", "auto spectrum", "cross spectrum", "FRF", "transmissibility",
    "coherence", "auto correlation", "cross correlation", "power spectral density", "energy spectral density",
    "probability density", "spectrum", "cumulative frequency distribution", "peaks and valleys", "stress cycles",
    "strain cycles", "orbit", "mode indicator function", "force pattern", "partial power", "partial coherence",
    "eigenvalue", "eigenvector", "shock response spectrum", "finite impulse response filter", "multiple coherence",
    "order function",
)  # fmt: skip
DIRECTIONS = {0: "", 1: "x", 2: "y", 3: "z", 4: "rx", 5: "ry", 6: "rz"}
COMPLEX, DOUBLE = (5, 6), (4, 6)
DATA_TYPES = (2, 4, 5, 6)
IEEE = 2
ORDERS = {1: "<", 2: ">"}
_REAL = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?")


@dataclass(frozen=True)
class Axis:
    """Axis of a function: data type, exponents of length, force and temperature, and unit label, empty if none."""

    code: int
    exponents: tuple[int, int, int]
    unit: str


@dataclass(frozen=True)
class Function:
    """Function of a dataset 58, its values not yet read.

    Parameters
    ----------
    number : its place among the file's functions, from 1
    kind : type of function
    response, reference : node and direction, as "2z" or "1-x"
    load_case : 0 for a single reference
    data_type : 2 and 4 real, 5 and 6 complex; 4 and 6 double precision
    count : of its values
    even : whether they are evenly spaced, from ``span[0]`` in steps of ``span[1]``
    z : value of the z-axis, as the speed at which it was measured
    abscissa, numerator, denominator : axes
    dataset : that it is in
    """

    number: int
    kind: int
    response: str
    reference: str
    load_case: int
    data_type: int
    count: int
    even: bool
    span: tuple[float, float]
    z: float
    abscissa: Axis
    numerator: Axis
    denominator: Axis
    dataset: Dataset

    def __str__(self) -> str:
        name = KINDS[self.kind] if 0 <= self.kind < len(KINDS) else f"function of type {self.kind}"
        more = f", z {self.z:g}" if self.z else ""
        return f"{self.number}: {name} {self.response}/{self.reference}{more}"

    def error(self, what: str) -> ModalError:
        """Error in this function, with its place."""
        return ModalError(f"{self.dataset.file}:{self.dataset.line}: function {self}: {what}")


def function(number: int, dataset: Dataset) -> Function:
    """Function from the head of a dataset 58.

    Raises
    ------
    ModalError
        If a field is no number, or the form of the values is none that there is.
    """
    for _ in range(5):  # remarks
        dataset.text()
    kind, _, _, load_case, _, response, response_way, _, reference, reference_way = _fields(
        dataset, (5, 10, 5, 10, 11, 10, 4, 11, 10, 4), "iiiisiisii"
    )
    data_type, count, even, first, step, z = _fields(dataset, (10, 10, 10, 13, 13, 13), "iiifff")
    if data_type not in DATA_TYPES or even not in (0, 1) or count < 1:
        raise dataset.error(f"values of type {data_type}, {count} of them, spacing {even}: there is no such form")
    axes = [_axis(dataset) for _ in range(4)]
    return Function(
        number, kind, _freedom(response, response_way), _freedom(reference, reference_way), load_case, data_type,
        count, bool(even), (first, step), z, *axes[:3], dataset,
    )  # fmt: skip


def values(function: Function) -> tuple[np.ndarray, np.ndarray]:
    """Abscissa and values, both (n,), as they are in the file.

    Raises
    ------
    ModalError
        If there are fewer than the dataset says, or one is no number.
    """
    parts = 2 if function.data_type in COMPLEX else 1
    width = parts + (not function.even)
    numbers = _binary(function) if function.dataset.layout else _text(function)
    if len(numbers) < function.count * width:
        raise function.error(f"has {len(numbers) // width} values where it says {function.count}: export it again")
    table = numbers[: function.count * width].reshape(function.count, width)
    data = table[:, -parts] + (1j * table[:, -1] if parts == 2 else 0)
    if not function.even:
        return table[:, 0], data
    first, step = function.span
    if not step > 0:
        raise function.error(f"steps of {step:g}: must be above 0")
    return first + step * np.arange(function.count), data


def _binary(function: Function) -> np.ndarray:
    order, kind = function.dataset.layout
    if order not in ORDERS or kind != IEEE:
        raise function.error(f"byte order {order} and format {kind}: expected 1 or 2, and 2 for IEEE 754")
    kind = np.dtype(f"{ORDERS[order]}f{8 if function.data_type in DOUBLE else 4}")
    data = function.dataset.data
    return np.frombuffer(data[: len(data) // kind.itemsize * kind.itemsize], kind).astype(float)


def _text(function: Function) -> np.ndarray:
    """Numbers on the lines of text, in their fields or with blanks between."""
    double, paired = function.data_type in DOUBLE, function.data_type in COMPLEX
    widths = (20,) if double else (13,)
    if double and not function.even:  # the abscissa is single
        widths = (13, 20, 20) if paired else (13, 20, 13, 20)
    dataset, numbers = function.dataset, []
    while not dataset.finished:
        record = dataset.text()
        cells = [cell for cell in _cut(record, widths) if cell]
        if not all(map(_REAL.fullmatch, cells)):
            cells = record.split()
        if not all(map(_REAL.fullmatch, cells)):
            raise dataset.error(f"expected numbers, got '{record.strip()[:40]}'")
        numbers += [float(cell.replace("D", "e").replace("d", "e")) for cell in cells]
    return np.array(numbers)


def _cut(record: str, widths):
    end, k = 0, 0
    while end < len(record):
        width = widths[k % len(widths)]
        yield record[end : end + width].strip()
        end, k = end + width, k + 1


def _fields(dataset: Dataset, widths, kinds: str) -> list:
    """Fields of the next record: whole numbers, real ones, and text; what is blank is 0."""
    record, end, found = dataset.text(), 0, []
    for width, kind in zip(widths, kinds, strict=True):
        cell, end = record[end : end + width].strip(), end + width
        if kind == "s":
            found.append(cell)
            continue
        if not re.fullmatch(r"[-+]?\d*" if kind == "i" else rf"({_REAL.pattern})?", cell) or cell in ("-", "+"):
            raise dataset.error(f"expected a number, got '{cell}' in '{record.strip()[:60]}'")
        number = float(cell.lower().replace("d", "e") or 0)
        found.append(int(number) if kind == "i" else number)
    return found


def _axis(dataset: Dataset) -> Axis:
    code, *exponents, _, unit = _fields(dataset, (10, 5, 5, 5, 21, 21), "iiiiss")
    return Axis(code, tuple(exponents), "" if unit.upper() == "NONE" else unit)


def _freedom(node: int, direction: int) -> str:
    """Node and direction, as 2z or 1-x."""
    way = DIRECTIONS.get(abs(direction), f"?{abs(direction)}")
    return f"{node}{'-' if direction < 0 else ''}{way}"
