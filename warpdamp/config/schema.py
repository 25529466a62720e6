"""JSON schema of the configuration, for editors and for the reference."""

from __future__ import annotations

import ast
import inspect
import itertools
import sys
from functools import cache
from typing import Any

from pydantic import BaseModel

from ..scene.materials import ELASTIC, SURFACE
from .study import PRESETS, Config

_LIMITS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
"""JSON schema's words for limits behind a validator, which pydantic leaves in its own."""

FROM_THE_LIBRARY = {"Config": ("materials", "contact"), "MaterialConfig": ELASTIC, "ContactConfig": SURFACE}
"""Keys that the models need, and a file need not have: the library of materials stands for what is left out."""


def json_schema() -> dict[str, Any]:
    """JSON schema of a configuration, each key with its description, default, range and SI unit."""
    schema = _respelt(Config.model_json_schema())
    schema["properties"]["accuracy"]["anyOf"].insert(0, {"enum": list(PRESETS)})
    for name, keys in FROM_THE_LIBRARY.items():
        node = schema if name == Config.__name__ else schema["$defs"][name]
        node["required"] = [key for key in node.get("required", ()) if key not in keys]
    models = {model.__name__: model for model in _below(BaseModel) if model.__module__.startswith(f"{__package__}.")}
    for name, node in {Config.__name__: schema, **schema["$defs"]}.items():
        texts = _texts(models[name])
        for key, prop in node["properties"].items():
            if key in texts:
                prop["description"] = texts[key]
    return schema


def _respelt(node: Any) -> Any:
    if isinstance(node, list):
        return [_respelt(part) for part in node]
    if not isinstance(node, dict):
        return node
    return {
        _LIMITS.get(key, key) if isinstance(value, int | float) else key: _respelt(value) for key, value in node.items()
    }


def _below(model: type[BaseModel]) -> list[type[BaseModel]]:
    """A model and all that inherit from it."""
    return [model, *(other for child in model.__subclasses__() for other in _below(child))]


def _texts(model: type[BaseModel]) -> dict[str, str]:
    """Texts behind the fields of a model, by the keys of the schema; those of its bases among them."""
    found = {}
    for base in reversed(model.__mro__):
        if base.__module__.startswith(f"{__package__}."):
            found |= _classes(base.__module__).get(base.__name__, {})  # none of a model made by a function
    return {field.alias or name: found[name] for name, field in model.model_fields.items() if name in found}


@cache
def _classes(module: str) -> dict[str, dict[str, str]]:
    """Texts behind the annotated names of every class of a module."""
    found = {}
    for node in ast.parse(inspect.getsource(sys.modules[module])).body:
        if isinstance(node, ast.ClassDef):
            pairs = itertools.pairwise(node.body)
            found[node.name] = {
                field.target.id: inspect.cleandoc(text.value.value)
                for field, text in pairs
                if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr)
            }
    return found
