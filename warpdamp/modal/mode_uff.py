"""Modes in universal files: nodes (datasets 15, 2411), normal modes (55, 2414), units (164), by pyuff.

The datasets' fields are those of the universal file's specification, https://www.ceas3.uc.edu/sdrluff/.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..files import whole_file
from .modes import Modes, mass_normalised
from .optional import needs

SUFFIXES = (".uff", ".unv", ".uf")
UNITS = {  # code, name: what turns metres and newtons into the file's units
    1: ("SI", 1.0, 1.0),
    2: ("BG", 3.280839895, 0.2248089431),
    3: ("MG", 1.0, 0.1019716213),
    4: ("BA", 3.280839895, 7.233013851),
    5: ("MM", 1e3, 1e3),
    6: ("CM", 1e2, 1e2),
    7: ("IN", 39.37007874, 0.2248089431),
    8: ("GM", 1e3, 0.1019716213),
}
NORMAL_MODE, DISPLACEMENT, CARTESIAN = 2, (0, 1, 8), 0
REMEDY = (
    "export the modes with their modal mass, or give modal_mass: that of the shapes as they are in the file, 1 kg if "
    "they are mass-normalised"
)


def read_uff(path, *, modal_mass=None, units=None) -> Modes:
    """Read the real normal modes of a universal file, as a damper at its first node sees them along z.

    ``Modes.at`` and ``Modes.at_label`` put the damper elsewhere.  Mass units follow from force and length, F s^2 / L.

    Parameters
    ----------
    path : of the file
    modal_mass : one, or one for each mode [kg], where the file has none
    units : "SI", "MM", ..., as dataset 164 calls them, where the file has no such dataset

    Raises
    ------
    OSError
        If there is no such file.
    ValueError
        If there are no nodes or normal modes in the file, if its units are not known, its displacements are not in
        global coordinates, or if a mode has no modal mass.
    """
    path = Path(path)
    sets = _sets(path)
    length, force = _units(path, sets, units)
    label, point = _nodes(path, sets)
    shapes = [_shape(path, s, label) for s in sets if _is_mode(s)]
    if not shapes:
        raise ValueError(f"{path} holds no real normal modes (datasets 55, 2414), only {_others(sets)}")
    number, frequency, file_mass, damping, shape = (np.array(column) for column in zip(*shapes, strict=True))
    if modal_mass is None:
        modal_mass = file_mass * length / force  # kg = N s^2 / m
    elif np.any(file_mass > 0):
        raise ValueError(f"{path} says the modal mass, and modal_mass says it again: leave modal_mass out")
    modes = Modes(
        number=number,
        frequency=frequency,
        point=point / length,
        shape=mass_normalised(number, shape, modal_mass, f"{path}: ", REMEDY),
        inherent_damping=damping,
        label=label,
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


def _sets(path: Path) -> list[dict]:
    needs("pyuff", "universal files")
    import pyuff

    if not path.is_file():
        raise FileNotFoundError(f"there is no file {path}")
    file = pyuff.UFF(str(path))
    sets = []
    for k, kind in enumerate(file.get_set_types()):
        if kind not in (15, 2411, 55, 2414, 164, 2420):
            sets.append({"type": int(kind)})
            continue
        try:
            sets.append(file.read_sets(k))
        except Exception:  # pyuff raises nothing more specific
            raise ValueError(f"{path}: dataset {kind}, the {k + 1}. of the file, cannot be read") from None
    return sets


def _units(path: Path, sets, given: str | None) -> tuple[float, float]:
    """Factors that turn metres and newtons into the file's units."""
    named = {name: factors for name, *factors in UNITS.values()}
    found = [s for s in sets if s["type"] == 164]
    if not found:
        if given is None:
            raise ValueError(f"{path} does not say its units (dataset 164): give units, one of {', '.join(named)}")
        return tuple(named[given])
    if given is not None:
        raise ValueError(f"{path} says its units (dataset 164), and units says them again: leave units out")
    code, length, force = (found[0][key] for key in ("units_code", "length", "force"))
    if code in UNITS and not np.allclose((length, force), UNITS[code][1:], rtol=1e-3):
        name, *right = UNITS[code]
        raise ValueError(
            f"{path}: dataset 164 contradicts itself: units {code} ({name}) have the factors {right[0]:g} and "
            f"{right[1]:g}, not {length:g} and {force:g}: correct it"
        )
    return length, force


def _nodes(path: Path, sets) -> tuple[np.ndarray, np.ndarray]:
    found = [s for s in sets if s["type"] in (15, 2411)]
    if not found:
        raise ValueError(f"{path} has no nodes (dataset 15 or 2411)")
    label = np.concatenate([np.asarray(s["node_nums"]).astype(int) for s in found])
    point = np.concatenate([np.array([s["x"], s["y"], s["z"]]).T for s in found])
    used = {int(system) for s in found for key in ("def_cs", "disp_cs") for system in s[key]}
    for systems in (s for s in sets if s["type"] == 2420):
        names = ("CS_sys_labels", "CS_types", "CS_matrices")
        for system, kind, matrix in zip(*(systems[name] for name in names), strict=True):
            if system in used and (kind != CARTESIAN or not np.allclose(matrix, np.eye(4)[:, :3])):
                raise ValueError(
                    f"{path}: nodes use the local coordinate system {system}: export in global coordinates"
                )
    return label, point


def _is_mode(dataset: dict) -> bool:
    if dataset["type"] not in (55, 2414) or dataset["analysis_type"] != NORMAL_MODE:
        return False
    return dataset["type"] == 55 or dataset["dataset_location"] == 1


def _shape(path: Path, dataset: dict, label) -> tuple:
    """Number, frequency [Hz], modal mass, damping ratio and shape (p, 3) of a dataset 55 or 2414."""
    if dataset["type"] == 55:
        kind, data = dataset["spec_data_type"], np.array([dataset["r1"], dataset["r2"], dataset["r3"]]).T
        number, frequency, mass = dataset["mode_n"], dataset["freq"], dataset["modal_m"]
        viscous, hysteretic = dataset["modal_damp_vis"], dataset["modal_damp_his"]
    else:
        kind, data = dataset["result_type"], np.array(dataset["data_at_node"])[:, :3]
        number = dataset["record10_field6"]
        frequency, mass, viscous, hysteretic = (dataset[f"record12_field{k}"] for k in (2, 4, 5, 6))
    if kind not in DISPLACEMENT:
        raise ValueError(f"{path}: mode {number} is not a displacement (data type {kind}): export displacements")
    if np.iscomplexobj(data):
        raise ValueError(f"{path}: mode {number} is complex: export real normal modes")
    shape = np.zeros((len(label), 3))  # nodes that do not move may be left out of the file
    rows = {node: row for row, node in enumerate(label)}
    unknown = [node for node in dataset["node_nums"] if node not in rows]
    if unknown:
        raise ValueError(f"{path}: mode {number} moves node {unknown[0]}, which has no coordinates")
    shape[[rows[node] for node in dataset["node_nums"]]] = data
    return number, frequency, mass, viscous or hysteretic / 2, shape


def _others(sets) -> str:
    kinds = {3: "complex modes", 7: "complex modes", 5: "frequency responses"}
    names = [
        f"dataset {s['type']}" + (f" ({kinds.get(s['analysis_type'], 'other data')})" if "analysis_type" in s else "")
        for s in sets
    ]
    return ", ".join(dict.fromkeys(names)) or "nothing"
