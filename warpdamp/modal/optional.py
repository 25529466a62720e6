"""Libraries that only some users need."""

from __future__ import annotations

import importlib.util

from ..errors import MissingLibrary


def needs(module: str, what: str) -> None:
    """Ask for a module of the ``modes`` extra.

    Raises
    ------
    MissingLibrary
        With the line that installs it.
    """
    if importlib.util.find_spec(module) is None:
        raise MissingLibrary(f"{what} need {module}: pip install 'warpdamp[modes]'", name=module)
