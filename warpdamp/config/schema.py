"""JSON schema of the configuration, for editors and for the reference."""

from __future__ import annotations

from typing import Any

from .study import Config

_LIMITS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
"""JSON schema's words for limits behind a validator, which pydantic leaves in its own."""


def json_schema() -> dict[str, Any]:
    """JSON schema of a configuration, each key with its description, default, range and SI unit."""
    return _respelt(Config.model_json_schema())


def _respelt(node: Any) -> Any:
    if isinstance(node, list):
        return [_respelt(part) for part in node]
    if not isinstance(node, dict):
        return node
    return {
        _LIMITS.get(key, key) if isinstance(value, int | float) else key: _respelt(value) for key, value in node.items()
    }
