"""Mode shapes in datasets 55 and 2414 of universal files, as the nodes' own coordinate systems see them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .phase import LEAST, collinearity, turned_real
from .uff_records import Dataset

NORMAL_MODE, COMPLEX_FIRST, COMPLEX_SECOND = 2, 3, 7
ANALYSES = {0: "unknown", 1: "static", 2: "normal modes", 3: "complex modes", 4: "transient", 5: "frequency responses",
            6: "buckling", 7: "complex modes", 9: "static, non-linear"}  # fmt: skip
LOCATIONS = {1: "at nodes", 2: "on elements", 3: "at nodes on elements", 5: "at points"}
DISPLACEMENT = (0, 1, 8)
"""Unknown, general, displacement."""
REAL, COMPLEX = (1, 2, 4), (5, 6)
VALUES = {2: (3,), 3: (6,), 0: (3, 6)}
"""Values a node by the data's characteristic: translations, translations and rotations, unknown."""
CHARACTERISTICS = {1: "a scalar", 4: "a symmetric tensor", 5: "a tensor", 6: "stress resultants"}


@dataclass(frozen=True)
class Mode:
    """A mode as a dataset says it; the shape (k, 3) at the nodes of ``label``, in their coordinate systems."""

    line: int
    number: int
    frequency: float
    mass: float
    damping: float
    label: list[int]
    shape: np.ndarray


@dataclass(frozen=True)
class Head:
    """Head of a dataset 55 or 2414: the records before its data."""

    analysis: int
    characteristic: int
    content: int
    storage: int
    values: int
    number: int
    location: int
    reals: list[float]

    @property
    def is_mode(self) -> bool:
        """Whether its data are those of a mode at nodes."""
        return self.analysis in (NORMAL_MODE, COMPLEX_FIRST, COMPLEX_SECOND) and self.location == 1

    @property
    def kind(self) -> str:
        """Kind of the data, as text."""
        where = "" if self.location == 1 else f", data {LOCATIONS.get(self.location, 'elsewhere')}"
        return ANALYSES.get(self.analysis, "other data") + where


def _head_55(dataset: Dataset) -> Head:
    for _ in range(5):
        dataset.text()
    _, analysis, characteristic, content, storage, values = dataset.integers(6)[:6]
    is_mode = analysis in (NORMAL_MODE, COMPLEX_FIRST, COMPLEX_SECOND)
    integers = dataset.integers(4 if is_mode else 1)
    reals = dataset.reals(min(max(integers[1], 2), 12), or_more=True) if is_mode else []
    return Head(analysis, characteristic, content, storage, values, integers[3] if is_mode else 0, 1, reals)


def _head_2414(dataset: Dataset) -> Head:
    dataset.text(), dataset.text()
    (location, *_) = dataset.integers(1)
    for _ in range(5):
        dataset.text()
    _, analysis, characteristic, content, storage, values = dataset.integers(6)[:6]
    if analysis not in (NORMAL_MODE, COMPLEX_FIRST, COMPLEX_SECOND):
        return Head(analysis, characteristic, content, storage, values, 0, location, [])
    number = dataset.integers(6)[5]
    dataset.text()
    _, frequency, eigenvalue, mass, viscous, hysteretic = dataset.reals(6)
    complex_ones = dataset.reals(6)
    if frequency == 0 and eigenvalue > 0:
        frequency = math.sqrt(eigenvalue) / (2 * math.pi)
    reals = [frequency, mass, viscous, hysteretic] if analysis == NORMAL_MODE else complex_ones
    return Head(analysis, characteristic, content, storage, values, number, location, reals)


HEADS = {55: _head_55, 2414: _head_2414}


def mode_of(dataset: Dataset, head: Head) -> Mode:
    """The mode of a dataset whose head was read.

    Raises
    ------
    ModalError
        If something that it says cannot be applied, or is nothing that a mode can have.
    """
    label, shape = _data(dataset, head)
    real, phase = _turned(dataset, head.number, shape)
    if head.analysis == NORMAL_MODE:
        frequency, mass, viscous, hysteretic = (*head.reals, 0.0, 0.0, 0.0)[:4]
        damping = _damping(dataset, head.number, viscous, hysteretic)
    else:
        frequency, damping, mass = _from_eigenvalue(dataset, head, phase)
    if frequency < 0:
        raise dataset.error(f"mode {head.number} has the frequency {frequency:g} Hz: correct it")
    if not 0 <= damping < 1:
        raise dataset.error(
            f"mode {head.number} has the damping ratio {damping:g}: expected one of at least 0 and below 1: correct it"
        )
    return Mode(dataset.line, head.number, frequency, mass, damping, label, real)


def _damping(dataset: Dataset, number: int, viscous: float, hysteretic: float) -> float:
    """Damping ratio; a loss factor is twice that."""
    if viscous and hysteretic and not math.isclose(viscous, hysteretic / 2, rel_tol=0.01):
        raise dataset.error(
            f"mode {number} has viscous damping {viscous:g} and hysteretic damping {hysteretic:g}, which is another "
            "damping ratio: leave one of them out"
        )
    return viscous or hysteretic / 2


def _from_eigenvalue(dataset: Dataset, head: Head, phase: complex) -> tuple[float, float, float]:
    """Frequency, damping ratio and modal mass of a complex mode.

    lambda = -zeta w0 + i w0 sqrt(1 - zeta^2); modal A = psi^T (C + 2 lambda M) psi = 2 i Im(lambda) m e^(2 i alpha) of
    a shape e^(i alpha) phi of modal mass m.  Of second-order analyses modal A is not defined so, and not used.
    """
    real, imaginary, a_real, a_imaginary = (*head.reals, 0.0, 0.0, 0.0, 0.0)[:4]
    size = math.hypot(real, imaginary)
    if not imaginary:
        raise dataset.error(f"mode {head.number} has the eigenvalue {real:g}, which is no vibration: leave it out")
    if imaginary < 0:  # of the conjugate pair the other one
        phase, a_imaginary, imaginary = phase.conjugate(), -a_imaginary, -imaginary
    mass = complex(a_real, a_imaginary) / (2j * imaginary * phase**2)
    if head.analysis == COMPLEX_SECOND or not mass:
        mass = 0j
    elif abs(mass.imag) > 0.2 * mass.real:
        raise dataset.error(
            f"mode {head.number}: modal A gives the modal mass {mass:.3g}, which is not real and positive: give "
            "modal_mass, and modal A as 0"
        )
    return size / (2 * math.pi), -real / size, mass.real


def _turned(dataset: Dataset, number: int, shape: np.ndarray) -> tuple[np.ndarray, complex]:
    """A shape as real numbers, and the phase it had."""
    if not shape.size or not np.abs(shape).max() > 0:
        raise dataset.error(f"mode {number} moves no node: leave it out")
    if not np.iscomplexobj(shape):
        return shape, 1.0 + 0j
    if (mpc := collinearity(shape)) < LEAST:
        raise dataset.error(
            f"mode {number} is complex: its modal phase collinearity is {mpc:.3g}, below {LEAST:g}: export real modes"
        )
    return turned_real(shape)


def _data(dataset: Dataset, head: Head) -> tuple[list[int], np.ndarray]:
    """Labels of nodes, and translations (k, 3) at them."""
    name = f"mode {head.number}"
    if head.characteristic not in VALUES:
        what = CHARACTERISTICS.get(head.characteristic, f"of the unknown characteristic {head.characteristic}")
        raise dataset.error(f"{name} is {what} a node: export displacements along x, y and z")
    if head.values not in VALUES[head.characteristic]:
        raise dataset.error(
            f"{name} has {head.values} values a node, and the data characteristic {head.characteristic}: expected "
            f"{' or '.join(map(str, VALUES[head.characteristic]))}: export displacements along x, y and z"
        )
    if head.storage not in (*REAL, *COMPLEX):
        known = ", ".join(map(str, (*REAL, *COMPLEX)))
        raise dataset.error(f"{name} is stored as the unknown data type {head.storage}: expected one of {known}")
    rows: dict[int, np.ndarray] = {}
    parts = 2 if head.storage in COMPLEX else 1
    while not dataset.finished:
        node = dataset.integers(1)
        if len(node) != 1:
            raise dataset.error(f"{name}: expected the number of a node, got {len(node)} numbers")
        values = np.array(dataset.reals(head.values * parts))
        if node[0] in rows:
            raise dataset.error(f"{name} has node {node[0]} twice: export each node once")
        rows[node[0]] = values if parts == 1 else values[::2] + 1j * values[1::2]
    return list(rows), np.array(list(rows.values())).reshape(-1, head.values)[:, :3]
