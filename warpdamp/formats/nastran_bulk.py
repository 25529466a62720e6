"""Nastran bulk data: grid points, coordinate systems and masses, from an input file or its echo in an .f06.

Cards in small fields (8 columns), large fields (16 columns, GRID*) and free format (commas), with their continuations.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import ModalError
from .coordinates import GLOBAL, Kind, System, through

SYSTEMS = {"CORD2R": Kind.CARTESIAN, "CORD2C": Kind.CYLINDRICAL, "CORD2S": Kind.SPHERICAL}
REFUSED = ("INCLUDE", "GRDSET", "CORD1R", "CORD1C", "CORD1S", "GRIDB", "BEGIN SUPER", "SEBULK")
"""What places nodes in ways that are not read."""
MASSLESS = (
    "GRID", "SPC", "SPC1", "SPCADD", "CONM2", "CELAS1", "CELAS2", "CBUSH", "PELAS", "PBUSH", "EIGRL", "EIGR", "PARAM",
    "ENDDATA", "CORD2R", "CORD2C", "CORD2S", "SPOINT", "DMIG",
)  # fmt: skip
"""Cards of models whose whole mass lies in their CONM2."""
_REAL = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+))(?:[eEdD]([-+]?\d+)|([-+]\d+))?")


@dataclass(frozen=True)
class Card:
    """Card of bulk data: the number of its line, its name and its fields, empty where they are blank."""

    line: int
    name: str
    fields: tuple[str, ...]


@dataclass(frozen=True)
class Bulk:
    """Nodes and masses of bulk data.

    Parameters
    ----------
    label : (p,) array of int
    point : (p, 3) array, global coordinates in the model's units
    system : (p,) array of int, coordinate systems of displacements
    systems : coordinate systems by their numbers
    mass : {(node, component), (node, component): value}, of one triangle of the mass matrix
    complete : whether that is all the mass of the model
    """

    label: np.ndarray
    point: np.ndarray
    system: np.ndarray
    systems: dict[int, System]
    mass: dict[tuple, float] = field(default_factory=dict)
    complete: bool = False


def cards(file: Path, lines) -> list[Card]:
    """Cards in numbered lines of bulk data.

    Raises
    ------
    ModalError
        If something in them would move nodes and is not read.
    """
    found: list[list] = []
    for number, line in lines:
        text = line.split("$")[0].rstrip().expandtabs(8)
        if not text.strip():
            continue
        fields = _fields(text)
        if not fields[0] or fields[0].startswith(("+", "*")):
            if found:
                found[-1][2].extend(fields[1:])
            continue
        name = fields[0].rstrip("*").upper()
        if name.startswith(REFUSED):
            raise ModalError(f"{file}:{number}: {name} is not read: write the bulk data out flat")
        found.append([number, name, fields[1:]])
    return [Card(number, name, tuple(fields)) for number, name, fields in found]


def _fields(text: str) -> list[str]:
    """Name and data of a line, without its continuation mark; eight of them, or four wide ones."""
    if "," in text:
        parts = [part.strip() for part in text.split(",")]
        wide = parts[0].endswith("*") or parts[0] == "*"
        return (parts + [""] * 9)[: 5 if wide else 9]
    wide = "*" in text[:8]
    width, count = (16, 4) if wide else (8, 8)
    return [text[:8].strip(), *(text[8 + k * width : 8 + (k + 1) * width].strip() for k in range(count))]


def real(text: str) -> float:
    """Number as Nastran writes it: 1.5, 1.5E+3, 1.5D3 or 1.5+3."""
    found = _REAL.fullmatch(text)
    if not found:
        raise ValueError(f"'{text}' is no number")
    value = float(f"{found[1]}e{found[2] or found[3] or '0'}")
    if not abs(value) < 1e100:
        raise ValueError(f"'{text}' is too large")
    return value


class _Place:
    """Reads the fields of a card; errors name its line."""

    def __init__(self, file: Path, card: Card):
        self.file, self.card = file, card

    def get(self, index: int, kind=real, default=None):
        text = self.card.fields[index - 1] if index <= len(self.card.fields) else ""
        if not text and default is not None:
            return default
        try:
            return kind(text)
        except ValueError:
            raise self.error(f"field {index + 1}: '{text}' is no number") from None

    def error(self, what: str) -> ModalError:
        return ModalError(f"{self.file}:{self.card.line}: {self.card.name}: {what}")


def geometry(file: Path, found: list[Card]) -> Bulk:
    """Nodes, their coordinate systems and the masses among some cards.

    Raises
    ------
    ModalError
        If there are no GRID cards, one is damaged, or one refers to what is not there.
    """
    systems = _systems(file, [card for card in found if card.name in SYSTEMS])
    place: dict[int, tuple] = {}
    for card in (card for card in found if card.name == "GRID"):
        of = _Place(file, card)
        label, own, out = of.get(1, int), of.get(2, int, 0), of.get(6, int, 0)
        for number in {own, out} - systems.keys():
            raise of.error(
                f"grid point {label} uses coordinate system {number}, which no CORD2R, CORD2C or CORD2S defines"
            )
        point = systems[own].place(np.array([[of.get(k, default=0.0) for k in (3, 4, 5)]]))[0]
        if label in place and not np.allclose(place[label][0], point):
            raise of.error(f"grid point {label} is at two places")
        place[label] = point, out
    if not place:
        raise ModalError(f"{file} holds no grid points (GRID)")
    points, system = zip(*place.values(), strict=True)
    mass, complete = _masses(file, found)
    return Bulk(np.array(list(place)), np.array(points), np.array(system), systems, mass, complete)


def _systems(file: Path, found: list[Card]) -> dict[int, System]:
    """Coordinate systems; those that refer to others after these."""
    systems = {0: GLOBAL}
    waiting = list(found)
    while waiting:
        ready = [card for card in waiting if _Place(file, card).get(2, int, 0) in systems]
        if not ready:
            of = _Place(file, waiting[0])
            raise of.error(f"refers to coordinate system {of.get(2, int, 0)}, which is not defined, or to itself")
        for card in ready:
            of = _Place(file, card)
            given = np.reshape([of.get(k, default=0.0) for k in range(3, 12)], (3, 3))
            origin, on_z, on_xz = systems[of.get(2, int, 0)].place(given)
            try:
                systems[of.get(1, int)] = _from_z(SYSTEMS[card.name], origin, on_z, on_xz)
            except ValueError as error:
                raise of.error(str(error)) from None
        waiting = [card for card in waiting if card not in ready]
    return systems


def _from_z(kind: Kind, origin, on_z, on_xz) -> System:
    """The system with a point on its z axis and one in its half plane x > 0, y = 0."""
    turned = through(kind, origin, on_z, on_xz)  # its x is z, its z is x
    z, y, x = turned.axes
    return System(kind, np.array([x, -y, z]), turned.origin)


def _masses(file: Path, found: list[Card]) -> tuple[dict[tuple, float], bool]:
    """The mass matrix: the DMIG of that name, or the CONM2 on their grid points; and whether it is all the mass."""
    matrix = _matrix(file, [card for card in found if card.name == "DMIG" and card.fields[0].upper().startswith("M")])
    if matrix:
        return matrix, True
    mass: dict[tuple, float] = {}
    scale, whole = 1.0, {card.name for card in found} <= set(MASSLESS)
    for card in found:
        of = _Place(file, card)
        if card.name == "PARAM" and card.fields[0].upper() == "WTMASS":
            scale = of.get(2)
        if card.name != "CONM2":
            continue
        node, value = of.get(2, int), of.get(4)
        if any(of.get(k, default=0.0) for k in (5, 6, 7, *range(9, 15))):
            whole = False  # off its point, or with inertia: the point's own mass is the least of it
            if any(of.get(k, default=0.0) for k in (5, 6, 7)):
                continue
        for component in (1, 2, 3):
            key = ((node, component), (node, component))
            mass[key] = mass.get(key, 0.0) + value
    return {key: scale * value for key, value in mass.items()}, whole and bool(mass)


def _matrix(file: Path, found: list[Card]) -> dict[tuple, float]:
    """A symmetric DMIG, by pairs of degrees of freedom, each pair once."""
    matrix: dict[tuple, float] = {}
    for card in found:
        of = _Place(file, card)
        if of.get(2, int) == 0:
            if of.get(3, int) not in (1, 6):
                raise of.error("is no square or symmetric matrix")
            continue
        column = (of.get(2, int), of.get(3, int, 0))
        for first in range(5, len(card.fields), 4):
            if card.fields[first - 1]:
                row = (of.get(first, int), of.get(first + 1, int, 0))
                matrix[tuple(sorted((row, column)))] = of.get(first + 2)
    return matrix
