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
import faulthandler, pickle, sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path

with suppress(ImportError):  # not on Windows
    import resource
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # writing out what a crash leaves takes seconds

module, function, file, kept, library, seconds = sys.argv[1:]
import_module(library)
faulthandler.dump_traceback_later(float(seconds), exit=True)
try:
    result = getattr(import_module(module), function)(Path(file))
except Exception as error:  # raised again by the parent
    result = error
Path(kept).write_bytes(pickle.dumps(result))
"""


def seconds_for(file: Path) -> float:
    """Time after which a reader counts as lost in a file [s]; the example of Ansys's reader, 0.9 MB, takes 15 ms."""
    return 8 + file.stat().st_size / 1e6 if file.is_file() else 8.0


def apart(function: Callable, file: Path, library: str):
    """Result of a module's function of a file; what it raises is raised here.

    Parameters
    ----------
    function : of a module
    file : Path
    library : its name; imported before the time of the reader begins

    Raises
    ------
    ModalError
        If the process ends on the way, or comes to no end.
    """
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        kept = Path(folder) / "result"
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        command = [sys.executable, "-c", _CHILD, function.__module__, function.__name__, str(file), str(kept)]
        command += [library, str(seconds_for(file))]
        end = subprocess.run(command, env=environment, capture_output=True, check=False).returncode
        if not kept.is_file():
            raise ModalError(f"{file} is damaged: its reader crashed or came to no end ({end}): write it again")
        result = pickle.loads(kept.read_bytes())
    if isinstance(result, Exception):
        raise result
    return result
