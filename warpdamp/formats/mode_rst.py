"""Normal modes in result files of Ansys (.rst), by ansys-mapdl-reader.

Shapes are checked against the mass matrix in the .full file of the same run, which lies beside under the same name;
their modal masses are phi^T M phi.  Without it, modal_mass must say them.
"""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np

from ..errors import ModalError
from ..modes import Modes, mass_normalised
from . import orthonormal
from .apart import apart
from .optional import needs
from .uff_geometry import UNITS

SUFFIXES = (".rst",)
LIBRARY = "ansys.mapdl.reader"
MODAL = 2
"""Ansys's code of a modal analysis (ANTYPE)."""
REMEDY = "put the .full file of the run beside it, or give modal_mass, that of the shapes as they are: 1 kg by default"
UNCHECKED = "shapes not checked: no .full file with the mass matrix beside the .rst"


def read_rst(path, *, modal_mass=None, units=None) -> Modes:
    """Read the modes of a modal analysis, as a damper at the first node sees them along z.

    Parameters
    ----------
    path : of the file
    modal_mass : one, or one for each mode [kg], where no .full file lies beside it
    units : of the model, as "SI" or "MM-N": millimetre, newton, tonne

    Raises
    ------
    MissingLibrary
        If ansys-mapdl-reader is not installed.
    ModalError
        If there is no such file, it holds no modes of three displacements, ``units`` or the modal masses are missing,
        or if the shapes are not orthogonal with respect to the mass matrix.
    """
    path = Path(path)
    needs(LIBRARY, "result files of Ansys", "ansys")
    if units is None:
        raise ModalError(f"{path} does not say its units: give units, one of {', '.join(UNITS)}")
    length, force = UNITS[units]
    label, point, frequency, shape = apart(results, path, LIBRARY)
    number, full = np.arange(1, len(frequency) + 1), path.with_suffix(".full")
    remark = UNCHECKED
    if full.is_file():
        if modal_mass is not None:
            raise ModalError(f"{full} says the modal masses, and modal_mass says them again: leave modal_mass out")
        product = _products(full, label, shape)
        own = np.diag(product)
        if not np.all(own > 0):
            raise ModalError(f"{path}: mode {number[np.argmin(own)]} has no modal mass: the shapes are damaged")
        orthonormal.check(path, number, product, own)
        modal_mass, remark = own * length / force, ""
    modes = Modes(
        number=number,
        frequency=frequency,
        point=point / length,
        shape=mass_normalised(number, shape, 0.0 if modal_mass is None else modal_mass, f"{path}: ", REMEDY),
        inherent_damping=np.zeros(len(number)),
        label=label,
        remark=remark,
    )
    return modes.seen_from(0, (0, 0, 1))


def _open(file: Path):
    from ansys.mapdl import reader

    if not file.is_file():
        raise ModalError(f"there is no file {file}")
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            return reader.read_binary(str(file))
    except Exception as error:  # its readers let through whatever they meet
        raise ModalError(f"{file} is no file of Ansys that can be read: {type(error).__name__}: {error}") from None


def results(file: Path):
    """Labels, places and frequencies, and shapes (m, p, 3), of a file, by the compiled reader."""
    result = _open(file)
    try:
        kind = int(result._resultheader["kan"])
        frequency = np.asarray(result.time_values, float)
        every = [result.nodal_solution(k) for k in range(len(frequency))]
        freedoms = [str(name) for name in result.result_dof(0)]
        label, point = np.asarray(result.mesh.nnum), np.asarray(result.mesh.nodes, float)[:, :3]
    except Exception as error:
        raise ModalError(f"{file} is damaged: {type(error).__name__}: {error}") from None
    if kind != MODAL or not len(frequency):
        raise ModalError(f"{file} holds no modes (analysis type {kind}): run a modal analysis (ANTYPE, MODAL)")
    if freedoms[:3] != ["UX", "UY", "UZ"]:
        raise ModalError(f"{file} holds {', '.join(freedoms)} at its nodes: expected UX, UY, UZ")
    shape = np.array([values[:, :3] for _, values in every])
    if any(not np.array_equal(nodes, label) for nodes, _ in every) or not np.isfinite(shape).all():
        raise ModalError(f"{file}: not every node has a displacement in every mode: write all of them (OUTRES, ALL)")
    return label, point, frequency, shape


def mass_matrix(file: Path):
    """Degrees of freedom (node, axis) and the upper triangle of the mass matrix, of a file, by the compiled reader."""
    try:
        freedom, _, mass = _open(file).load_km(sort=True)
    except Exception as error:
        raise ModalError(f"{file}: its mass matrix cannot be read: {type(error).__name__}: {error}") from None
    return freedom, mass


def _products(file: Path, label: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """(m, m) products phi^T M phi with the mass matrix of a .full file, whose upper triangle is kept."""
    freedom, mass = apart(mass_matrix, file, LIBRARY)
    row = {node: k for k, node in enumerate(label)}
    if any(node not in row or axis > 2 for node, axis in freedom):
        raise ModalError(f"{file} has degrees of freedom that the results lack: is it of the same run?")
    vectors = np.array([shape[:, row[node], axis] for node, axis in freedom])
    half = vectors.T @ (mass @ vectors)
    return half + half.T - vectors.T @ (mass.diagonal()[:, None] * vectors)
