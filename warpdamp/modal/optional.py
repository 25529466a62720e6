"""Optional libraries, imported when a function needs them."""

from __future__ import annotations

import importlib.util

from ..errors import MissingLibrary


def needs(module: str, what: str) -> None:
    """Refuse to go on without a module of the ``modes`` extra.

    Parameters
    ----------
    module : str
    what : str
        Plural noun that begins the message: what needs it.

    Raises
    ------
    MissingLibrary
        With the line that installs it.
    """
    if importlib.util.find_spec(module) is None:
        raise MissingLibrary(f"{what} need {module}: pip install 'warpdamp[modes]'", name=module)
