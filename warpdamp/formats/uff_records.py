"""Universal files as datasets of fixed-format records, with the line of the file that each came from.

A dataset lies between two lines of -1 in columns 5 and 6; its number stands on the line after the first.  Integers are
in fields of 10 columns, reals in E13.5, D25.16 or E20.12.  Specification: https://www.ceas3.uc.edu/sdrluff/.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

from ..errors import ModalError
from .text_file import decode

INTEGER_WIDTH = 10
LARGEST = 1e100
"""Of numbers that are meant: squares and products of larger ones overflow."""
_MARK = re.compile(rb" {0,5}-1[ \t]*")
_NUMBER = re.compile(rb" *(\d+)(b?)((?: +\d+)*) *")
_REAL = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?")
MARKED = (b"\xff\xfe", b"\xfe\xff", b"\xef\xbb\xbf")
"""Marks of UTF-16 and UTF-8."""


@dataclass
class Dataset:
    """A dataset, read record by record.

    Parameters
    ----------
    file : path, for messages
    number : of the dataset, as 55
    line : number of the line with its number
    records : its lines after that one; of a binary dataset (58b) those before its bytes
    data : bytes of a binary dataset
    layout : byte order (1: little end first, 2: big end first) and format of numbers (2: IEEE 754) of these bytes
    """

    file: Path
    number: int
    line: int
    records: list[str]
    done: int = 0
    data: bytes = b""
    layout: tuple[int, int] | None = None

    @property
    def finished(self) -> bool:
        """Whether no record is left."""
        return self.done == len(self.records)

    def error(self, what: str) -> ModalError:
        """An error at the record read last."""
        return ModalError(f"{self.file}:{self.line + self.done}: dataset {self.number}: {what}")

    def text(self) -> str:
        """The next record."""
        if self.done == len(self.records):
            raise self.error("is cut short: export the file again")
        self.done += 1
        return self.records[self.done - 1]

    def integers(self, count: int) -> list[int]:
        """The first ``count`` integers of the next record."""
        record = self.text()
        fields = record.split()
        if len(fields) < count:  # ten digits in a field of ten touch those before them
            fields = [record[k : k + INTEGER_WIDTH] for k in range(0, len(record.rstrip()), INTEGER_WIDTH)]
        try:
            found = [int(field) for field in fields]
        except ValueError:
            raise self.error(f"expected {count} integers, got '{record.strip()}'") from None
        if len(found) < count:
            raise self.error(f"expected {count} integers, got '{record.strip()}'")
        return found

    def reals(self, count: int, *, or_more: bool = False) -> list[float]:
        """The next ``count`` reals, on as many records as they take; the last of these may hold more if it is said."""
        found: list[float] = []
        while len(found) < count:
            numbers = _numbers(self.text())
            lone = count > 1 and self.records[self.done - 1].strip().isdigit()  # the next node's number
            if not numbers or lone:
                raise self.error(f"expected {count} numbers, got '{self.records[self.done - 1].strip()}'")
            found += numbers
        if len(found) > count and not or_more:
            raise self.error(f"expected {count} numbers, got {len(found)}")
        if not all(abs(number) < LARGEST for number in found):
            raise self.error("a number is too large")
        return found


def _numbers(record: str) -> list[float]:
    """Numbers of a record, which may touch; none if there is anything else."""
    try:
        numbers = [float(part) for part in record.split()]
    except ValueError:
        numbers = []
    if numbers and "_" not in record and all(map(math.isfinite, numbers)):
        return numbers
    if re.search(r"\S", _REAL.sub("", record)):
        return []
    return [float(number.lower().replace("d", "e")) for number in _REAL.findall(record)]


def datasets(file: Path) -> list[Dataset]:
    """Datasets of a universal file, in their order.

    Raises
    ------
    ModalError
        If there is no such file, it holds no dataset, or one does not end.
    """
    file = Path(file)
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        raise ModalError(f"there is no file {file}") from None
    except OSError as error:
        raise ModalError(f"{file}: cannot be read: {error.strerror or error}") from None
    if content.startswith(MARKED):
        content = decode(content, file).encode()
    if b"\n" not in content:
        content = content.replace(b"\r", b"\n")
    found = list(_scan(file, _Lines(content)))
    if not found:
        raise ModalError(f"{file}: is no universal file: no line holds the -1 that a dataset begins with")
    return found


class _Lines:
    """The lines of some bytes, one after the other, and how many there were."""

    def __init__(self, content: bytes):
        self.content, self.at, self.count = content, 0, 0

    def next(self) -> bytes | None:
        if self.at >= len(self.content):
            return None
        end = self.content.find(b"\n", self.at)
        end = len(self.content) if end < 0 else end
        line, self.at, self.count = self.content[self.at : end], end + 1, self.count + 1
        return line.rstrip(b"\r")

    def skip(self, length: int) -> None:
        self.count += self.content.count(b"\n", self.at, self.at + length)
        self.at += length


def _scan(file: Path, lines: _Lines):
    while (line := lines.next()) is not None:
        if not _MARK.fullmatch(line):
            continue
        head = lines.next()
        if head is None or not head.strip():  # a mark too many at the end
            continue
        start = lines.count
        number = _NUMBER.fullmatch(head[:80].rstrip())
        if number is None:
            raise ModalError(f"{file}:{start}: expected the number of a dataset, got '{_shown(head)}'")
        if number[2]:
            yield _binary(file, lines, int(number[1]), number[3].split())
            continue
        yield Dataset(file, int(number[1]), start, _records(file, lines, start, int(number[1])))


def _records(file: Path, lines: _Lines, start: int, number: int) -> list[str]:
    records = []
    while (line := lines.next()) is not None:
        if _MARK.fullmatch(line):
            while records and not records[-1].strip():
                records.pop()
            return records
        records.append(line.decode("latin-1"))
    raise ModalError(
        f"{file}:{start}: dataset {number} does not end: the file is cut short or damaged: export it again"
    )


def _binary(file: Path, lines: _Lines, number: int, fields) -> Dataset:
    """A dataset 58b: lines of text, and bytes as many as its first line says."""
    start = lines.count
    if len(fields) < 4:
        raise ModalError(f"{file}:{start}: dataset {number}b does not say how many bytes it has: export it again")
    order, kind, text, length = map(int, fields[:4])
    records = [(lines.next() or b"").decode("latin-1") for _ in range(min(text, 100))]
    data = lines.content[lines.at : lines.at + length]
    lines.skip(length)
    rest = lines.next()  # of the line that the last byte is on
    if rest is not None and not _MARK.fullmatch(rest):
        rest = lines.next() if not rest.strip() else rest
    if len(data) < length or rest is None or not _MARK.fullmatch(rest):
        raise ModalError(
            f"{file}:{start}: dataset {number}b does not end after its {length} bytes: the file is cut short or damaged"
        )
    return Dataset(file, number, start, records, data=data, layout=(order, kind))


def _shown(line: bytes) -> str:
    return line[:40].decode("latin-1").strip()
