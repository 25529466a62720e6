"""Normal modes that Nastran printed (.f06) or punched (.pch): real eigenvectors in SORT1.

Shapes are in the displacement coordinate systems of the grid points; these, their places and the masses come from bulk
data: the echo in the .f06, or an input file of the same name beside it (.bdf, .dat, .nas).  Modal masses are the
generalised masses of the .f06; a .pch has none.  Shapes are checked against the mass matrix: a DMIG that was punched,
or the CONM2.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import ModalError
from ..modes import Modes, mass_normalised
from . import orthonormal
from .nastran_bulk import Bulk, Card, cards, geometry, real
from .text_file import read_text
from .uff_geometry import UNITS, Nodes

SUFFIXES = (".f06", ".pch")
BULK = (".bdf", ".dat", ".nas", ".bulk")
REMEDY = "give modal_mass, that of the shapes as they are printed: 1 kg where they are normalised by mass"
UNCHECKED = "shapes not checked: neither a DMIG with the mass matrix nor CONM2 in the bulk data"
_TABLE = "R E A L   E I G E N V A L U E S"
_VECTOR = re.compile(r"R E A L   E I G E N V E C T O R   N O \.\s+(\d+)")
_COMPLEX = re.compile(r"C O M P L E X   E I G E N V E C T O R")
_ECHO = re.compile(r"\s+\d+-\s{8}(.*)")
_ROW = re.compile(r"\s+(\d+)\s+([A-Z])\s+(\S.*)")


@dataclass
class _Output:
    """Modes of an output file.

    Parameters
    ----------
    eigenvalue, mass : by the modes' numbers
    shape : six values by nodes, by the modes' numbers
    bulk : numbered lines of the bulk data's echo, or of DMIG cards
    """

    eigenvalue: dict[int, float] = field(default_factory=dict)
    mass: dict[int, float] = field(default_factory=dict)
    shape: dict[int, dict[int, list[float]]] = field(default_factory=dict)
    bulk: list[tuple[int, str]] = field(default_factory=list)


def read_nastran(path, *, modal_mass=None, units=None) -> Modes:
    """Read the normal modes of an .f06 or a .pch, as a damper at the first grid point sees them along z.

    Parameters
    ----------
    path : of the file
    modal_mass : one, or one for each mode [kg], where the file has no generalised masses
    units : of the model, as "SI" or "MM-N": millimetre, newton, tonne

    Raises
    ------
    ModalError
        If there are no modes, no coordinates or no masses, if ``units`` is missing, if something in the file cannot be
        applied, or if the shapes are not orthonormal with respect to the masses.
    """
    path = Path(path)
    if units is None:
        raise ModalError(
            f"{path} does not say its units, as no file of Nastran does: give units, one of {', '.join(UNITS)}"
        )
    lines = list(enumerate(read_text(path).splitlines(), 1))
    output = (_printed if path.suffix.lower() == ".f06" else _punched)(path, lines)
    if not output.shape:
        raise ModalError(
            f"{path} holds no real eigenvectors: ask for DISPLACEMENT(PRINT, PUNCH, REAL) = ALL in SOL 103"
        )
    bulk = _bulk(path, output)
    number = sorted(output.shape)
    label = _measured(path, output, bulk)
    length, force = UNITS[units]
    masses = np.array([output.mass.get(n, 0.0) for n in number])
    if modal_mass is not None and np.any(masses):
        raise ModalError(f"{path} says the generalised masses, and modal_mass says them again: leave modal_mass out")
    given = masses * length / force if modal_mass is None else modal_mass
    remark = _check_shapes(path, output, bulk, np.broadcast_to(np.asarray(given, float) * force / length, len(number)))
    row = {node: k for k, node in enumerate(bulk.label)}
    rows = np.array([row[node] for node in label])
    nodes = Nodes(bulk.label, bulk.point, bulk.system, bulk.systems)
    shape = [nodes.vectors(rows, np.array([output.shape[n][node][:3] for node in label])) for n in number]
    modes = Modes(
        number=np.array(number),
        frequency=np.array([math.sqrt(max(output.eigenvalue[n], 0.0)) / (2 * math.pi) for n in number]),
        point=bulk.point[rows] / length,
        shape=mass_normalised(number, np.array(shape), given, f"{path}: ", REMEDY),
        inherent_damping=np.zeros(len(number)),
        label=label,
        unmeasured=np.setdiff1d(bulk.label, label),
        remark=remark,
    )
    return modes.seen_from(0, (0, 0, 1))


def _printed(file: Path, lines) -> _Output:
    """Eigenvalues, eigenvectors and echo of an .f06."""
    output, mode, in_table = _Output(), None, False
    for number, line in lines:
        if "FATAL" in line and "MESSAGE" in line:
            raise ModalError(f"{file}:{number}: the run ended in an error: '{line.strip()}'")
        if _COMPLEX.search(line):
            raise ModalError(f"{file}:{number}: complex eigenvectors: export real modes (SOL 103)")
        if vector := _VECTOR.search(line):
            mode, in_table = int(vector[1]), False
            output.shape.setdefault(mode, {})
        elif _TABLE in line:
            mode, in_table = None, True
        elif echo := _ECHO.fullmatch(line):
            output.bulk.append((number, echo[1]))
        elif line.startswith("1") or "(BEFORE AUGMENTATION" in line:  # a new page, or the table that another replaces
            mode, in_table = None, False
        elif in_table and line.split()[:1] and line.split()[0].isdigit():
            _eigenvalue(file, number, line, output)
        elif mode is not None and (row := _ROW.fullmatch(line)):
            _add(file, number, output.shape[mode], row[1], row[2], row[3].split())
    for mode in output.shape:
        if mode not in output.eigenvalue:
            raise ModalError(f"{file}: eigenvector {mode} is not in the table of real eigenvalues: print the whole run")
    return output


def _eigenvalue(file: Path, number: int, line: str, output: _Output) -> None:
    """A row of the table: mode, order of extraction, eigenvalue, radians, cycles, generalised mass and stiffness."""
    try:
        mode, (value, cycles, mass, stiffness) = int(line.split()[0]), (real(line.split()[k]) for k in (2, 4, 5, 6))
    except (ValueError, IndexError):
        raise ModalError(f"{file}:{number}: is no row of the table of real eigenvalues: '{line.strip()}'") from None
    if mode in output.eigenvalue:
        raise ModalError(f"{file}:{number}: mode {mode} is there already: print one subcase")
    own = (2 * math.pi * cycles) ** 2
    if abs(abs(value) - own) > 1e-3 * own or abs(value * mass - stiffness) > 1e-3 * abs(stiffness):
        raise ModalError(
            f"{file}:{number}: mode {mode}: eigenvalue {value:g}, {cycles:g} cycles, generalised mass {mass:g} and "
            f"stiffness {stiffness:g} contradict each other: print the run again"
        )
    output.eigenvalue[mode], output.mass[mode] = value, mass


def _punched(file: Path, lines) -> _Output:
    """Eigenvectors of a .pch, and what it holds of bulk data."""
    output, mode, vectors, node = _Output(), None, False, None
    for number, line in lines:
        body = line[:72].rstrip()
        if body.startswith("$"):
            title = body[1:].strip()
            if title.startswith(("TITLE", "SUBTITLE", "LABEL")):
                mode, vectors = None, False
            elif title == "EIGENVECTOR":
                vectors = True
            elif vectors and ("IMAGINARY" in title or "MAGNITUDE" in title):
                raise ModalError(f"{file}:{number}: complex eigenvectors: export real modes (SOL 103)")
            elif vectors and title.startswith("POINT ID"):
                raise ModalError(f"{file}:{number}: eigenvectors in SORT2: ask for SORT1")
            elif vectors and (head := re.fullmatch(r"EIGENVALUE\s*=\s*(\S+)\s+MODE\s*=\s*(\d+).*", title)):
                mode = int(head[2])
                if mode in output.shape:
                    raise ModalError(f"{file}:{number}: mode {mode} is there already: punch one subcase")
                output.shape[mode], output.eigenvalue[mode] = {}, _number(file, number, head[1])
        elif mode is not None and body.startswith("-CONT-"):
            if node is None:
                raise ModalError(f"{file}:{number}: continues no grid point")
            _extend(file, number, node, body[6:])
        elif mode is not None and (row := re.match(r" *(\d+) +([GS]) ", body)):
            node = _add(file, number, output.shape[mode], row[1], row[2], [])
            _extend(file, number, node, body[row.end() :])
        elif body.strip():
            output.bulk.append((number, body))
    for mode, shape in output.shape.items():
        for label, values in shape.items():
            if len(values) != 6:
                raise ModalError(f"{file}: mode {mode} has {len(values)} values at grid point {label}: expected 6")
    return output


def _extend(file: Path, number: int, node: list[float], text: str) -> None:
    node += [_number(file, number, part) for part in re.findall(r"[-+]?[^-+\s]+(?:(?<=[eEdD])[-+]\d+)?", text)]


def _add(
    file: Path, number: int, shape: dict[int, list[float]], label: str, kind: str, values: list[str]
) -> list[float]:
    """Values of a grid point; a scalar point has no direction and is left aside."""
    if kind != "G":
        return []
    if int(label) in shape:
        raise ModalError(f"{file}:{number}: grid point {label} is there already: print one subcase")
    shape[int(label)] = [_number(file, number, value) for value in values]
    if values and len(values) != 6:
        raise ModalError(f"{file}:{number}: {len(values)} values at grid point {label}: expected 6")
    return shape[int(label)]


def _number(file: Path, number: int, text: str) -> float:
    try:
        return real(text)
    except ValueError as error:
        raise ModalError(f"{file}:{number}: {error}") from None


def _bulk(file: Path, output: _Output) -> Bulk:
    """Bulk data: the echo, or the input file beside the output, with the matrices that were punched."""
    own = cards(file, output.bulk)
    if any(card.name == "GRID" for card in own):
        return geometry(file, own)
    beside = [file.with_suffix(suffix) for suffix in BULK if file.with_suffix(suffix).is_file()]
    if not beside:
        raise ModalError(
            f"{file} holds no coordinates: ask for ECHO = SORT in an .f06, or put the input file beside it as "
            f"{file.with_suffix('.bdf').name}"
        )
    return geometry(beside[0], [*_input_cards(beside[0]), *(card for card in own if card.name == "DMIG")])


def _input_cards(file: Path) -> list[Card]:
    """Cards between BEGIN BULK and ENDDATA, or all of them."""
    lines = list(enumerate(read_text(file).splitlines(), 1))
    begin = [k for k, (_, line) in enumerate(lines) if line.strip().upper().startswith("BEGIN BULK")]
    return cards(file, lines[begin[0] + 1 if begin else 0 :])


def _measured(file: Path, output: _Output, bulk: Bulk) -> np.ndarray:
    """Grid points that have values in every mode, in the order of the bulk data."""
    for mode, shape in output.shape.items():
        unknown = sorted(set(shape) - set(bulk.label.tolist()))
        if unknown:
            raise ModalError(f"{file}: mode {mode} moves grid point {unknown[0]}, which has no coordinates (GRID)")
        if not np.any([values[:3] for values in shape.values()]):
            raise ModalError(f"{file}: mode {mode} moves no grid point: ask for more of them")
    shared = set.intersection(*(set(shape) for shape in output.shape.values()))
    if not shared:
        raise ModalError(f"{file}: no grid point has values in all of the modes")
    return np.array([node for node in bulk.label if node in shared])


def _check_shapes(file: Path, output: _Output, bulk: Bulk, mass: np.ndarray) -> str:
    """Check the shapes against the mass matrix; a remark where there is none."""
    number = sorted(output.shape)
    known = {
        pair: value for pair, value in bulk.mass.items() if all(node in output.shape[number[0]] for node, _ in pair)
    }
    if not known or not np.all(mass > 0):
        return UNCHECKED
    freedom = {dof: k for k, dof in enumerate(sorted({dof for pair in known for dof in pair}))}
    if any(not 1 <= component <= 6 for _, component in freedom):
        return UNCHECKED
    shape = np.array([[output.shape[n].get(node, [0.0] * 6)[c - 1] for n in number] for node, c in freedom])
    product = np.zeros((len(number), len(number)))
    for (one, other), value in known.items():
        part = value * np.outer(shape[freedom[one]], shape[freedom[other]])
        product += part if one == other else part + part.T
    orthonormal.check(file, number, product, mass, complete=bulk.complete and len(known) == len(bulk.mass))
    return ""
