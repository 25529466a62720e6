"""Modes from a file, by the reader of its suffix."""

from __future__ import annotations

from pathlib import Path

from ..errors import ModalError
from ..modes import Modes
from . import mode_csv, mode_nastran, mode_rst, mode_uff


def read_modes(file: Path, *, modal_mass: float | None = None, units: str | None = None) -> Modes:
    """Modes from a file.

    Parameters
    ----------
    file : Path
        A table (.csv), a universal file, or a file of Nastran or Ansys.
    modal_mass : float, optional
        Modal mass of the shapes as they are written [kg], where the file does not say it.
    units : str, optional
        System of units of the file, where it does not say it.

    Raises
    ------
    ModalError
        If the suffix is none of these, or the file cannot be used; names file, line and remedy.
    """
    suffix = file.suffix.lower()
    if suffix in mode_uff.SUFFIXES:
        return mode_uff.read_uff(file, modal_mass=modal_mass, units=units)
    if suffix in mode_nastran.SUFFIXES:
        return mode_nastran.read_nastran(file, modal_mass=modal_mass, units=units)
    if suffix in mode_rst.SUFFIXES:
        return mode_rst.read_rst(file, modal_mass=modal_mass, units=units)
    if suffix != ".csv":
        every = (".csv", *mode_uff.SUFFIXES, *mode_nastran.SUFFIXES, *mode_rst.SUFFIXES)
        raise ModalError(f"{file}: modes are read from {', '.join(every[:-1])} or {every[-1]}")
    if units is not None:
        raise ModalError(f"{file}: units are those of the table's columns, as x_m: leave units out")
    return mode_csv.read_csv(file, modal_mass=modal_mass)
