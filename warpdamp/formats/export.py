"""Export of modes to a file, in the format of its suffix."""

from __future__ import annotations

from pathlib import Path

from ..errors import ModalError
from ..modes import Modes
from .mode_csv import write_csv
from .mode_uff import SUFFIXES, write_uff

WRITTEN = (".csv", *SUFFIXES)
"""Suffixes of the files that modes are written to."""


def export(modes: Modes, path: Path) -> None:
    """Write modes as a table (.csv) or a universal file (.uff, .unv, .uf).

    Parameters
    ----------
    modes : Modes
    path : Path
        Replaced if it exists.

    Raises
    ------
    ModalError
        If the suffix is none of these.
    MissingLibrary
        If a universal file is wanted and pyuff is not installed.
    """
    suffix = path.suffix.lower()
    if suffix == ".csv":
        write_csv(path, modes)
    elif suffix in SUFFIXES:
        write_uff(path, modes)
    else:
        raise ModalError(f"{path}: name a file that ends in {', '.join(WRITTEN)}")
