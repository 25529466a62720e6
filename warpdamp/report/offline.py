"""Pages that open offline: one file, its data packed into it, nothing loaded from anywhere."""

from __future__ import annotations

import base64
import json
import zlib
from pathlib import Path

import numpy as np

from ..errors import MissingLibrary, UsageError
from ..files import whole_file

FOLDER = Path(__file__).with_name("page")

KINDS = {"f8": "<f8", "f4": "<f4", "u4": "<u4", "u2": "<u2", "i4": "<i4", "u1": "u1", "i1": "i1"}
"""Kinds of numbers that a page reads; the largest first, so that each array is aligned."""


def packed(arrays: dict[str, tuple[str, np.ndarray]]) -> dict:
    """Arrays as a page holds them: one deflate stream in base64, and kind, offset and length of each.

    Parameters
    ----------
    arrays : dict of (kind, array)
        By name; kinds are those of ``KINDS``.
    """
    stream, places = bytearray(), {}
    for name, (kind, array) in sorted(arrays.items(), key=lambda item: list(KINDS).index(item[1][0])):
        content = np.ascontiguousarray(array, KINDS[kind]).tobytes()
        places[name] = [kind, len(stream), int(np.size(array))]
        stream += content
    return {"data": base64.b64encode(zlib.compress(bytes(stream), 9)).decode(), "arrays": places}


def as_json(data: dict) -> str:
    """JSON that may stand in a script element: no ``<`` ends it, and what is not a number is null."""
    return json.dumps(_plain(data), ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


def _plain(value):
    if isinstance(value, dict):
        return {str(key): _plain(child) for key, child in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(child) for child in value]
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def page(template: str, scripts: tuple[str, ...], extra: str, **values) -> str:
    """Page of a template, with the style and scripts of ``FOLDER`` in it.

    Raises
    ------
    MissingLibrary
        If Jinja2 is not installed; names the ``extra`` that brings it.
    """
    try:
        from jinja2 import Environment, FileSystemLoader, StrictUndefined
        from markupsafe import Markup
    except ImportError:
        raise MissingLibrary(f"pages need jinja2: pip install 'warpdamp[{extra}]'", name="jinja2") from None
    environment = Environment(
        loader=FileSystemLoader(FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    safe = {name: Markup(text) for name, text in values.items() if name == "data"}
    style = Markup(asset("base.css"))
    script = Markup("\n".join(asset(name) for name in scripts))
    return environment.get_template(template).render(**values | safe, css=style, script=script)


def asset(name: str) -> str:
    """Text of a style or script."""
    return (FOLDER / name).read_text(encoding="utf-8")


def write_page(text: str, path: Path, most: int) -> None:
    """Write a page whole or not at all.

    Raises
    ------
    UsageError
        If it is larger than ``most`` bytes.
    """
    content = text.encode()
    if len(content) > most:
        raise UsageError(
            f"{path}: the page would have {len(content) / 1e6:.1f} MB, more than {most / 1e6:g}: take fewer frames"
        )
    with whole_file(path) as part:
        part.write_bytes(content)
