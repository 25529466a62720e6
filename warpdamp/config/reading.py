"""Reading and validation of a YAML file, and YAML of a configuration."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ..errors import ConfigError, printable
from .messages import decimal_commas, explained, place, relevant
from .plausible import refusals
from .study import Config

IN_SI = "# Written by warpdamp: every default is filled in, and numbers without a unit are in SI.\n"
"""First line of a configuration that a program wrote: its numbers have lost their units, and are not asked for them."""


def read(path) -> Config:
    """Read and validate a YAML file.

    Raises
    ------
    ConfigError
        One line for every error: file:line:column: key: what is wrong.
    """
    path = Path(path)
    data = _read(path)
    asked = [] if path.read_text(encoding="utf-8").startswith(IN_SI) else refusals(data)
    wrong = {place(data, keys): f"{'.'.join(map(str, keys))}: {said}" for keys, said in asked}
    config = None
    try:
        config = Config.model_validate(_plain(data))
    except ValidationError as error:
        for one in relevant(error.errors(), data, Config):
            where = place(data, one["loc"])
            if where not in wrong or one["type"] != "value_error":  # else it may follow from what cannot be meant
                wrong[where] = explained(one, Config)
    if wrong or config is None:
        raise ConfigError("\n".join(printable(f"{path}:{where}: {said}") for where, said in wrong.items()))
    config._source = (path, data)
    return config


def resolved_yaml(config: Config) -> str:
    """YAML of a configuration with every default filled in, in SI."""
    from ruamel.yaml import YAML

    text = io.StringIO()
    yaml = YAML()
    yaml.dump(config.model_dump(mode="json", by_alias=True), text)
    return text.getvalue()


def _read(path: Path):
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: not YAML: no UTF-8 text (byte {error.start}): save it as UTF-8") from None
    try:
        data = YAML(typ="rt").load(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem = error.problem
        if found := re.match(r'found duplicate key "(\d+)" with value "None"', problem or ""):
            problem += f"; if {found[1]} stands behind a decimal comma, write a decimal point"
        if r"'\t'" in (problem or ""):
            problem += "; indent with blanks, not with tabs"
        raise ConfigError(printable(f"{path}:{mark.line + 1}:{mark.column + 1}: not YAML: {problem}")) from None
    except (YAMLError, ValueError) as error:
        raise ConfigError(printable(f"{path}: not YAML: {' '.join(str(error).split())}")) from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path}:1:1: not a warpdamp configuration: expected keys such as 'damper:' at the top level")
    if found := decimal_commas(text):
        line, column, listed = found
        said = f"{listed} has decimal commas, which separate values in YAML: write decimal points"
        raise ConfigError(printable(f"{path}:{line}:{column}: {said}"))
    return data


def _plain(node: Any) -> Any:
    """The YAML tree as plain dicts, lists and scalars."""
    if isinstance(node, dict):
        return {str(key): _plain(value) for key, value in node.items()}
    if isinstance(node, list):
        return [_plain(value) for value in node]
    if isinstance(node, bool) or node is None:
        return node
    for kind in (int, float, str):
        if isinstance(node, kind):
            return kind(node)
    return str(node)
