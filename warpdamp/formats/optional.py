"""Optional libraries, imported when a function needs them."""

from __future__ import annotations

import importlib.util

from ..errors import MissingLibrary


def needs(module: str, what: str, extra: str = "modes") -> None:
    """Refuse to go on without a module of an extra, as ``modes``.

    Raises
    ------
    MissingLibrary
        With the line that installs it.
    """
    if not _there(module):
        raise MissingLibrary(f"{what} need {module}: pip install 'warpdamp[{extra}]'", name=module)


def _there(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:  # nor is the package that it lies in
        return False
