"""Modes written to a file, in the format of its suffix."""

from __future__ import annotations

from pathlib import Path

from .modes import Modes
from .table import write_csv
from .uff import SUFFIXES, write_uff

PICTURES = (".png", ".pdf", ".svg")


def export(modes: Modes, path: Path, *, title: str = "") -> None:
    """Write a picture (.png, .pdf, .svg), a table (.csv) or a universal file (.uff, .unv, .uf).

    Raises
    ------
    OSError
        If the suffix is none of these, or the file cannot be written.
    MissingLibrary
        If a universal file is wanted and pyuff is not installed.
    """
    suffix = path.suffix.lower()
    if suffix in PICTURES:
        from ..plot import save
        from .picture import shapes

        save(shapes(modes, title), path)
    elif suffix == ".csv":
        write_csv(path, modes)
    elif suffix in SUFFIXES:
        write_uff(path, modes)
    else:
        raise OSError(f"{path}: name a file that ends in {', '.join((*PICTURES, '.csv', *SUFFIXES))}")
