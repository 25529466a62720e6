"""Meshes from files that meshio reads."""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING

from .optional import needs

if TYPE_CHECKING:
    from skfem import Mesh


def load_mesh(file: Path, unit: float = 1.0) -> Mesh:
    """Mesh of a file, in metres.

    Parameters
    ----------
    file : any format of meshio
    unit : length of the file's unit [m]

    Raises
    ------
    OSError
        If there is no such file.
    ValueError
        If it holds no mesh that scikit-fem reads.
    """
    needs("meshio", "mesh files")
    from skfem import Mesh

    if not Path(file).is_file():
        raise FileNotFoundError(f"there is no file {file}")
    said = io.StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):  # meshio prints what is wrong, and then exits
            mesh = Mesh.load(str(file))
    except (Exception, SystemExit) as error:  # its readers let through whatever they meet
        reason = " ".join(f"{said.getvalue()} {'' if isinstance(error, SystemExit) else error}".split())
        raise ValueError(f"{file} holds no mesh that scikit-fem reads: {reason}") from None
    return mesh.scaled(unit)
