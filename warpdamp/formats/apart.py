"""Compiled readers of others, which a damaged file may take down, in a process of their own."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from ..errors import ModalError

_CHILD = """
import pickle, sys
from importlib import import_module
from pathlib import Path

module, function, file, kept = sys.argv[1:]
try:
    result = getattr(import_module(module), function)(Path(file))
except Exception as error:  # raised again by the parent
    result = error
Path(kept).write_bytes(pickle.dumps(result))
"""


def apart(function: Callable, file: Path):
    """Result of a module's function of a file; what it raises is raised here.

    Raises
    ------
    ModalError
        If the process ends on the way.
    """
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        kept = Path(folder) / "result"
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        command = [sys.executable, "-c", _CHILD, function.__module__, function.__name__, str(file), str(kept)]
        end = subprocess.run(command, env=environment, capture_output=True, check=False).returncode
        if not kept.is_file():
            raise ModalError(f"{file} is damaged: its reader crashed ({end}): write it again")
        result = pickle.loads(kept.read_bytes())
    if isinstance(result, Exception):
        raise result
    return result
