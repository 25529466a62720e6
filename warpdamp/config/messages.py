"""Messages of configuration errors, each with its place in the file."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from typing import get_args

from pydantic import BaseModel

DECIMALS = re.compile(r"\d+(?:[eE][-+]?\d+)?(?:\s*[^\W\d].*)?")
"""What is left of a number behind its comma, with its unit: 52, 73 mm."""
_WITH_COMMA = r"-?\d+,\d+(?:\s*[^\W\d][^,\[\]{}\n]*)?"
_LISTED = re.compile(rf"\[\s*{_WITH_COMMA}(?:,\s+{_WITH_COMMA})+\s*\]")


_RANKS = {"decimal_comma": -2, "too_short": -1, "literal_error": 1, "list_type": 2, "tuple_type": 2}
"""Which branch of a union an error is told of: the lowest, 0 where nothing is said."""

_WORDS = {
    "bool_type": "expected on or off",
    "bool_parsing": "expected on or off",
    "int_type": "expected a whole number",
    "int_from_float": "expected a whole number",
    "string_type": "expected text",
}
_PATTERNS = {
    r"^\S+ with \S+$": "expected two materials, as 'steel with pmma', or 'steel with walls'",
    "^[A-Za-z][A-Za-z0-9_-]*$": "a name begins with a letter, and goes on with letters, digits, _ and -",
}
"""What the patterns of keys ask for."""


def keys(data, loc) -> list:
    """Part of a pydantic location that exists in the YAML tree (unions add names of their own)."""
    keys, node = [], data
    for part in loc:
        if isinstance(node, dict) and part in node:
            node = node[part]
            keys.append(part)
        elif isinstance(node, list) and isinstance(part, int) and part < len(node):
            node = node[part]
            keys.append(part)
    return keys


def place(data, loc) -> str:
    """Place of the innermost key of a location, as line:column."""
    node, place = data, (0, 0)
    for key in keys(data, loc):
        place = node.lc.item(key) if isinstance(key, int) else node.lc.key(key)
        node = node[key]
    return f"{place[0] + 1}:{place[1] + 1}"


def decimal_commas(text: str) -> tuple[int, int, str] | None:
    """Line, column and text of the first list whose every number has a decimal comma, as [0,5, 1,7]."""
    for number, line in enumerate(text.split("\n"), 1):
        if found := _LISTED.search(line.partition("#")[0]):
            return number, found.start() + 1, found[0]
    return None


def relevant(errors, data, root):
    """Errors worth a line: one a place, the most specific branch of a union, no echo of a misspelt key."""
    best: dict = {}
    for error in map(lambda error: _decimal_comma(error, data), errors):
        ours = len(error["loc"]) - (error["type"] == "extra_forbidden")  # an unknown key may look like a union's name
        loc = tuple(part for k, part in enumerate(error["loc"]) if k >= ours or not is_union_name(part))
        loc, message = _pointed(loc, error["msg"].removeprefix("Value error, "), data)
        rank = _RANKS.get(error["type"], 0)
        if loc not in best or rank < best[loc][0]:
            best[loc] = (rank, error | {"loc": loc, "msg": message})
    misspelt = {
        (*loc[:-1], closest(loc[-1], _known_keys(root, loc[:-1])))
        for loc, (_, error) in best.items()
        if error["type"] == "extra_forbidden"
    }
    return [
        error
        for loc, (_, error) in best.items()
        if not (error["type"] == "missing" and loc in misspelt)
        and not (loc and any(other != loc and other[: len(loc)] == loc for other in best))
    ]


def _decimal_comma(error, data):
    """The error in its own words where YAML made two entries of a decimal comma: {restitution: 0,52, friction: 1}."""
    *above, last = error["loc"] or ("",)
    if error["type"] != "extra_forbidden" or not DECIMALS.fullmatch(str(last)):
        return error
    parent = data
    for key in keys(data, above):
        parent = parent[key]
    names = [str(key) for key in parent] if isinstance(parent, dict) else []
    place = names.index(last) if last in names else 0
    before = parent[list(parent)[place - 1]] if place else None
    if not isinstance(before, int) or list(parent.values())[place] is not None:
        return error
    said = f"'{before}' and then '{last}': YAML reads a comma as the next entry: write a decimal point"
    return error | {"type": "decimal_comma", "loc": (*above, names[place - 1]), "msg": said}


def _pointed(loc, message, data):
    """A model's error that starts with a key of its own ("modes: each mode once") is placed at that key."""
    head, _, rest = message.partition(": ")
    target = (*loc, *(int(key) if key.isdecimal() else key for key in head.split(".")))
    if rest and len(keys(data, target)) == len(target):
        return target, rest
    return loc, message


def is_union_name(part) -> bool:
    """Whether a part of a pydantic location names a branch of a union, and no key of the file."""
    return isinstance(part, str) and ("[" in part or part in ("float", "int", "list"))


def explained(error, root) -> str:
    """Message of a pydantic error in this project's words."""
    key = ".".join(str(part) for part in error["loc"])
    kind, given = error["type"], error.get("input")
    if kind == "extra_forbidden":
        return f"{key}: unknown key{suggestion(error['loc'][-1], _known_keys(root, error['loc'][:-1]))}"
    if kind == "missing":
        return f"{key}: missing"
    message = error["msg"]
    if kind == "literal_error":
        message = f"'{given}' is not one of {error['ctx']['expected']}"
    elif kind in ("model_type", "dict_type"):
        message = f"expected keys below it, got {given!r}"
    elif kind in ("tuple_type", "list_type"):
        message = f"expected a list, as [a, b], got {given!r}"
    elif kind == "too_short":
        least = error["ctx"]["min_length"]
        message = f"needs at least {least} value{'s' * (least > 1)}, got {given!r}"
    elif kind == "string_pattern_mismatch":
        message = f"{_PATTERNS.get(error['ctx']['pattern'], message)}; got {given!r}"
    elif kind in _WORDS:
        message = f"{_WORDS[kind]}, got {given!r}"
    elif kind not in ("value_error", "decimal_comma"):
        message = f"{message[0].lower()}{message[1:]}, got {given!r}{per_cent(error)}"
    return f"{key}: {message}" if key else message


def per_cent(error) -> str:
    """A question about a number that is within its limit, of one at most, in per cent."""
    given, limits = error["input"], error.get("ctx", {})
    limit = limits.get("le", limits.get("lt", 2))
    if isinstance(given, bool) or not isinstance(given, int | float) or limit > 1 or not 1 < given < 100 * limit:
        return ""
    return f"; did you mean {given / 100:g}, which is {given:g} %?"


def _known_keys(root: type[BaseModel], loc) -> list[str]:
    """Keys allowed at a location, from the fields of the ``root`` model."""
    model = root
    for part in loc:
        field = {f.alias or name: f for name, f in model.model_fields.items()}.get(part)
        if field:  # otherwise an item of a list, or a name of the user's own
            model = next(_models(field.annotation), model)
    return [field.alias or name for name, field in model.model_fields.items()]


def _models(annotation) -> Iterator[type[BaseModel]]:
    """Models that an annotation refers to."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models(part)


def closest(name, known) -> str | None:
    """The known name that is most like a given one, None if none is."""
    return next(iter(difflib.get_close_matches(str(name), list(known), n=1)), None)


def suggestion(name, known) -> str:
    """End of a sentence about an unknown name: the closest known one, or all of them."""
    close = closest(name, known)
    return f"; did you mean '{close}'?" if close else f"; choose from {', '.join(known)}"
