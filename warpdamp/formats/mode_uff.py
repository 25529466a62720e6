"""Modes in universal files: normal modes and complex modes that are real but for a phase (datasets 55, 2414).

What is used of every dataset, what is transformed and what is refused: docs/universal-files.md.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..errors import ModalError
from ..files import whole_file
from ..modes import Modes, mass_normalised
from .optional import needs
from .uff_geometry import Nodes, nodes
from .uff_geometry import units as units_of
from .uff_records import Dataset, datasets
from .uff_shapes import DISPLACEMENT, HEADS, NORMAL_MODE, Mode, mode_of

SUFFIXES = (".uff", ".unv", ".uf")
CONTENTS = {15: "nodes", 18: "coordinate systems", 58: "functions", 82: "trace lines", 151: "header", 164: "units",
            781: "nodes", 2411: "nodes", 2412: "elements", 2420: "coordinate systems"}  # fmt: skip
REMEDY = (
    "export the modes with their modal mass, or give modal_mass: that of the shapes as they are in the file, 1 kg if "
    "they are mass-normalised"
)


def read_uff(path, *, modal_mass=None, units=None) -> Modes:
    """Read the modes of a universal file, as a damper at its first node sees them along z.

    ``Modes.at`` and ``Modes.at_label`` put the damper elsewhere.  Mass units follow from force and length, F s^2 / L.
    Points are the nodes that have data in every mode.

    Parameters
    ----------
    path : of the file
    modal_mass : one, or one for each mode [kg], where the file has none
    units : "SI", "MM", ..., as dataset 164 calls them, or "MM-N", where the file has no such dataset

    Raises
    ------
    ModalError
        If there is no such file, no nodes or modes in it, if its units are not known, if something in it cannot be
        applied, or if a mode has no modal mass, is complex, or its numbers are none that a mode can have.
    """
    path = Path(path)
    sets = datasets(path)
    length, force = units_of(path, sets, units)
    every = nodes(path, sets)
    modes = _modes(path, sets)
    label = _measured(path, every, modes)
    if modal_mass is None:
        modal_mass = [mode.mass * length / force for mode in modes]  # kg = N s^2 / m
    elif any(mode.mass for mode in modes):
        raise ModalError(f"{path} says the modal mass, and modal_mass says it again: leave modal_mass out")
    number = np.array([mode.number for mode in modes])
    row = {node: k for k, node in enumerate(every.label)}
    shape = np.array([_at(label, mode, every, row) for mode in modes])
    modes = Modes(
        number=number,
        frequency=np.array([mode.frequency for mode in modes]),
        point=every.point[[row[node] for node in label]] / length,
        shape=mass_normalised(number, shape, modal_mass, f"{path}: ", REMEDY),
        inherent_damping=np.array([mode.damping for mode in modes]),
        label=label,
        unmeasured=np.setdiff1d(every.label, label),
    )
    return modes.seen_from(0, (0, 0, 1))


def write_uff(path, modes: Modes) -> None:
    """Write modes as datasets 164, 2411 and 55, mass-normalised (modal mass 1 kg); the format keeps six digits."""
    needs("pyuff", "universal files")
    import pyuff

    label = np.arange(1, len(modes.point) + 1) if modes.label is None else modes.label
    none = np.zeros(len(label), int)
    x, y, z = modes.point.T
    nodes = {"type": 2411, "node_nums": label, "def_cs": none, "disp_cs": none, "color": none, "x": x, "y": y, "z": z}
    units = pyuff.prepare_164(1, "SI", 1, length=1.0, force=1.0, temp=1.0, temp_offset=273.15)
    shapes = [
        pyuff.prepare_55(
            model_type=1,
            analysis_type=NORMAL_MODE,
            data_ch=2,
            spec_data_type=8,
            load_case=1,
            mode_n=int(number),
            freq=float(modes.frequency[k]),
            modal_m=1.0,
            modal_damp_vis=float(modes.inherent_damping[k]),
            modal_damp_his=0.0,
            node_nums=label,
            r1=modes.shape[k, :, 0],
            r2=modes.shape[k, :, 1],
            r3=modes.shape[k, :, 2],
        )
        for k, number in enumerate(modes.number)
    ]
    with whole_file(Path(path)) as part:
        pyuff.UFF(str(part)).write_sets([units, nodes, *shapes], mode="overwrite")


def _modes(file: Path, sets: list[Dataset]) -> list[Mode]:
    """The modes of a file, with numbers of their own."""
    modes, others, said = [], {}, []
    for dataset in sets:
        if dataset.number not in HEADS:
            said.append(f"dataset {dataset.number} ({CONTENTS.get(dataset.number, 'other data')})")
            continue
        head = HEADS[dataset.number](dataset)
        if not head.is_mode:
            said.append(f"dataset {dataset.number} ({head.kind})")
        elif head.content not in DISPLACEMENT:
            others[head.number] = dataset.error(
                f"mode {head.number} is not a displacement (data type {head.content}): export displacements"
            )
        else:
            modes.append(mode_of(dataset, head))
    for number, error in others.items():  # stresses and energies may stand beside the displacements
        if number not in {mode.number for mode in modes}:
            raise error
    if not modes:
        raise ModalError(f"{file} holds no modes (datasets 55, 2414), only {', '.join(dict.fromkeys(said))}")
    return _numbered(file, modes)


def _numbered(file: Path, modes: list[Mode]) -> list[Mode]:
    """Modes without numbers are counted; numbers that repeat are refused."""
    if not any(mode.number for mode in modes):
        return [replace(mode, number=k) for k, mode in enumerate(modes, 1)]
    first: dict[int, Mode] = {}
    for mode in modes:
        if mode.number < 1:
            raise ModalError(f"{file}:{mode.line}: mode number {mode.number}: number the modes from 1 on")
        if mode.number in first:
            raise ModalError(
                f"{file}:{mode.line}: mode {mode.number} is there already, from line {first[mode.number].line} on: "
                "number each mode once"
            )
        first[mode.number] = mode
    return modes


def _measured(file: Path, every: Nodes, modes: list[Mode]) -> np.ndarray:
    """Labels of the nodes that have data in every mode, in the order of the nodes."""
    known = set(every.label)
    for mode in modes:
        for node in mode.label:
            if node not in known:
                raise ModalError(
                    f"{file}:{mode.line}: mode {mode.number} moves node {node}, which has no coordinates: export the "
                    "geometry along with the modes"
                )
    shared = set.intersection(*(set(mode.label) for mode in modes))
    if not shared:
        raise ModalError(f"{file}: no node has data in all of the modes: export the modes at the same nodes")
    return np.array([node for node in every.label if node in shared])


def _at(label: np.ndarray, mode: Mode, every: Nodes, row: dict[int, int]) -> np.ndarray:
    """Global displacements (p, 3) of a mode at the nodes of ``label``."""
    given = dict(zip(mode.label, mode.shape, strict=True))
    return every.vectors(np.array([row[node] for node in label]), np.array([given[node] for node in label]))
