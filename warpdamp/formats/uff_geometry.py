"""Units, coordinate systems and nodes of universal files: datasets 164; 18 and 2420; 15, 781 and 2411."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import ModalError
from .coordinates import GLOBAL, Kind, System, through
from .uff_records import Dataset

UNITS = {  # name: what turns metres and newtons into the file's units; those of dataset 164 in the order of their codes
    "SI": (1.0, 1.0),
    "BG": (3.280839895, 0.2248089431),
    "MG": (1.0, 0.1019716213),
    "BA": (3.280839895, 7.233013851),
    "MM": (1e3, 1e3),
    "CM": (1e2, 1e2),
    "IN": (39.37007874, 0.2248089431),
    "GM": (1e3, 0.1019716213),
    "MM-N": (1e3, 1.0),
}
CODES = dict(enumerate(UNITS, 1)) | {9: None}  # 9 is defined by its factors
NODES, SYSTEMS = (15, 781, 2411), (18, 2420)


@dataclass(frozen=True)
class Nodes:
    """Nodes of a file, in its units and in global coordinates.

    Parameters
    ----------
    label : (p,) array of int
    point : (p, 3) array
    system : (p,) array of int, the coordinate systems of their displacements
    systems : coordinate systems by their numbers
    """

    label: np.ndarray
    point: np.ndarray
    system: np.ndarray
    systems: dict[int, System]

    def vectors(self, row: np.ndarray, local: np.ndarray) -> np.ndarray:
        """Global components of displacements (k, 3) of the nodes at some rows."""
        turned = np.empty_like(local)
        for number in np.unique(self.system[row]):
            of = self.system[row] == number
            turned[of] = self.systems[number].vector(local[of], self.point[row[of]])
        return turned


def units(file: Path, sets: list[Dataset], given: str | None) -> tuple[float, float]:
    """Factors that turn metres and newtons into the file's units.

    Raises
    ------
    ModalError
        If the file and ``given`` say nothing, both say something, or what the file says contradicts itself.
    """
    found = [(s.line, _factors(s)) for s in sets if s.number == 164]
    if not found:
        if given is None:
            raise ModalError(f"{file} does not say its units (dataset 164): give units, one of {', '.join(UNITS)}")
        return UNITS[given]
    if given is not None:
        raise ModalError(f"{file} says its units (dataset 164), and units says them again: leave units out")
    first, factors = found[0]
    for line, others in found[1:]:
        if not np.allclose(factors, others, rtol=1e-3):
            raise ModalError(f"{file}:{line}: dataset 164: other units than on line {first}: write a file for each")
    return factors


def _factors(dataset: Dataset) -> tuple[float, float]:
    head = dataset.text()
    try:
        code = int((head[:10].split() or [""])[0])
    except ValueError:
        raise dataset.error(f"expected the code of its units, got '{head.strip()}'") from None
    length, force = dataset.reals(2, or_more=True)[:2]
    if code not in CODES:
        raise dataset.error(f"unknown code of units {code}: expected 1 to 9")
    if not (length > 0 and force > 0):
        raise dataset.error(f"factors {length:g} and {force:g}: must be above 0")
    name = CODES[code]
    if name and code != 9 and not np.allclose((length, force), UNITS[name], rtol=1e-3):
        right = " and ".join(f"{factor:g}" for factor in UNITS[name])
        raise dataset.error(
            f"contradicts itself: units {code} ({name}) have the factors {right}, not {length:g} and {force:g}: mend it"
        )
    return length, force


def nodes(file: Path, sets: list[Dataset]) -> Nodes:
    """Nodes of a universal file, with their coordinate systems.

    Raises
    ------
    ModalError
        If there are none, one has two places, or one uses a coordinate system that the file does not define.
    """
    systems = _systems(sets)
    place: dict[int, tuple] = {}
    for dataset in (s for s in sets if s.number in NODES):
        while not dataset.finished:
            label, definition, displacement, point = _node(dataset)
            used = {definition, displacement} if dataset.number == 15 else {displacement}
            for number in used - systems.keys():
                raise dataset.error(
                    f"node {label} uses coordinate system {number}, which the file does not define (datasets 18, "
                    "2420): export in global coordinates, or with the coordinate systems"
                )
            if dataset.number == 15:  # the others are in the part's coordinates already
                point = systems[definition].place(np.array([point]))[0]
            if label in place and not (np.allclose(place[label][0], point) and place[label][1] == displacement):
                raise dataset.error(
                    f"node {label} is at two places or in two coordinate systems: number each node once"
                )
            place[label] = point, displacement
    if not place:
        raise ModalError(f"{file} has no nodes (dataset 15 or 2411)")
    points, system = zip(*place.values(), strict=True)
    return Nodes(np.array(list(place)), np.array(points, float), np.array(system), systems)


def _node(dataset: Dataset) -> tuple[int, int, int, list[float]]:
    """Label, definition and displacement system, coordinates."""
    if dataset.number != 15:
        return *dataset.integers(3)[:3], dataset.reals(3)
    record = dataset.text()
    fields = record.split()
    if len(fields) != 7:
        fields = [record[k : k + 10] for k in (0, 10, 20, 30)] + [record[k : k + 13] for k in (40, 53, 66)]
    try:
        point = [float(field.lower().replace("d", "e")) for field in fields[4:]]
        label, definition, displacement = (int(float(field)) for field in fields[:3])
    except (ValueError, OverflowError):
        point = [np.inf]
    if not np.all(np.abs(point) < 1e100):
        raise dataset.error(f"expected four integers and three coordinates, got '{record.strip()}'")
    return label, definition, displacement, point


def _systems(sets: list[Dataset]) -> dict[int, System]:
    """Coordinate systems by their numbers; 0 is the global one."""
    systems = {0: GLOBAL}
    defined = set()
    for dataset in (s for s in sets if s.number in SYSTEMS):
        if dataset.number == 2420:
            dataset.text(), dataset.text()  # the part
        while not dataset.finished:
            number, system = (_by_points if dataset.number == 18 else _by_matrix)(dataset, systems)
            if number in defined and not _same(system, systems[number]):
                raise dataset.error(f"coordinate system {number} is defined twice, differently: leave one out")
            defined.add(number)
            systems[number] = system
    return systems


def _kind(dataset: Dataset, number: int, kind: int) -> Kind:
    if kind not in list(Kind):
        raise dataset.error(f"coordinate system {number} is of the unknown type {kind}: expected 0, 1 or 2")
    return Kind(kind)


def _by_points(dataset: Dataset, systems) -> tuple[int, System]:
    number, kind, reference, _, method = dataset.integers(5)[:5]
    kind = _kind(dataset, number, kind)
    if method != 1:
        raise dataset.error(f"coordinate system {number} is defined by method {method}: only 1 (three points) is known")
    if reference not in systems:
        raise dataset.error(f"coordinate system {number} refers to {reference}, not defined above it: put that first")
    dataset.text()  # its name
    points = systems[reference].place(np.reshape(dataset.reals(9), (3, 3)))
    try:
        return number, through(kind, *points)
    except ValueError as error:
        raise dataset.error(f"coordinate system {number}: {error}") from None


def _by_matrix(dataset: Dataset, systems) -> tuple[int, System]:
    number, kind = dataset.integers(2)[:2]
    dataset.text()  # its name
    matrix = np.reshape([dataset.reals(3) for _ in range(4)], (4, 3))
    axes = matrix[:3]
    if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-3) or np.linalg.det(axes) < 0:
        raise dataset.error(f"coordinate system {number}: its axes are no right-handed unit vectors at right angles")
    return number, System(_kind(dataset, number, kind), axes, matrix[3])


def _same(one: System, other: System) -> bool:
    return one.kind == other.kind and np.allclose(one.axes, other.axes) and np.allclose(one.origin, other.origin)
