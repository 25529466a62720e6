"""Libraries that only some users need."""

from __future__ import annotations

import importlib.util


def needs(module: str, what: str) -> None:
    """Ask for a module of the ``modes`` extra.

    Raises
    ------
    ModuleNotFoundError
        With the line that installs it.
    """
    if importlib.util.find_spec(module) is None:
        raise ModuleNotFoundError(f"{what} need {module}: pip install 'warpdamp[modes]'", name=module)
