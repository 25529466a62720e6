"""The reference of the YAML, written from the JSON schema of the configuration."""

from __future__ import annotations

import json
import re
from typing import Any

from warpdamp.config.schema import json_schema

INTRODUCTION = """# The YAML, key by key

Written from the schema that `warpdamp schema` prints, with which editors complete and check a file. A quantity is a
number with its unit, as `40 mm`; a bare number is in the SI unit named here; `2 %` is 0.02. A bare number that no one
means (a density of 0.92, a spectrum of 0.04) is asked back for with its unit, and a coefficient of friction of 86 for
its per cent; with a unit, extremes are taken. Keys in **bold** must be given. Where the value may be *swept*, a list,
`{from: a, to: b, n: 5}` or `{log: [a, b], n: 5}` makes an axis of the results; any other scalar is swept by its path in
the section [sweep](#yaml-sweep). An unknown key is refused with the nearest known one, and whatever is wrong comes back
as file, line, column, key and remedy.
"""
LIMITS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}


def page() -> str:
    """The page as Markdown."""
    schema = json_schema()
    return "\n".join([INTRODUCTION, *Sections(schema).of("", schema)])


class Sections:
    """Sections of the page, one for each model, below the path at which it is met first."""

    def __init__(self, schema: dict[str, Any]):
        self.models = schema["$defs"]
        self.anchors: dict[str, str] = {}

    def of(self, path: str, model: dict[str, Any]) -> list[str]:
        """Heading, table and what is below it."""
        below = self._new_models(path, model)
        title = f"## `{path}`" if path else "## The whole file"
        rows = [self._row(name, prop, name in model.get("required", ())) for name, prop in model["properties"].items()]
        text = plain(model["description"])
        lines = [
            f"({anchor(path)})=",
            title,
            "",
            text,
            "",
            *table(("key", "value", "default", "what it does"), rows),
        ]
        for place, name in below:
            lines += ["", *self.of(place, self.models[name])]
        return lines

    def _new_models(self, path: str, model: dict[str, Any]) -> list[tuple[str, str]]:
        """Models met first below this one, with their paths."""
        found = []
        for name, prop in model["properties"].items():
            for other in dict.fromkeys(re.findall(r'"#/\$defs/(\w+)"', json.dumps(prop))):
                place = ".".join(filter(None, (path, name)))
                if other != "Range" and other not in self.anchors:
                    several = sum(1 for at, _ in found if at == place or at.startswith(f"{place} "))
                    place = f"{place} ({self.models[other]['title']})" if several else place
                    self.anchors[other] = place
                    found.append((place, other))
        if not path:
            self.anchors["Range"] = "a range"
            found.append(("a range", "Range"))
        return found

    def _row(self, name: str, prop: dict[str, Any], required: bool) -> tuple[str, ...]:
        default = "" if required or prop.get("default") is None else f"`{shown(prop['default'])}`"
        if "auto: as the scene calls for" in prop["description"]:
            default = "`auto`"
        limits = dict.fromkeys(limit for part in parts(prop) for limit in range_of(part))
        return (
            f"**`{name}`**" if required else f"`{name}`",
            ", ".join((self._value(prop), *limits)),
            default,
            plain(prop["description"]),
        )

    def _value(self, prop: dict[str, Any]) -> str:
        """What may be written, in words."""
        swept = "#/$defs/Range" in [part.get("$ref") for part in prop.get("anyOf", ())]
        words = dict.fromkeys(self._word(part) for part in prop.get("anyOf", [prop]) if part.get("type") != "null")
        if "number" in words:
            words.pop("whole number", None)
        if swept:
            one = [word for word in words if not word.startswith("list of") and "#yaml-a-range" not in word]
            return f"{' or '.join(one)}, *swept*" if one else "list of values, or [a range](#yaml-a-range)"
        return " or ".join(words)

    def _word(self, part: dict[str, Any]) -> str:
        if "$ref" in part:
            name = part["$ref"].rpartition("/")[2]
            return f"[{self.anchors[name]}](#{anchor(self.anchors[name])})"
        if "enum" in part:
            return " / ".join(f"`{value}`" for value in part["enum"])
        if "const" in part:
            return f"`{part['const']}`"
        if "unit" in part:
            return f"quantity in {part['unit']}" if part["unit"] else "number or %"
        if part["type"] == "array":
            if "prefixItems" in part:
                items = [self._value(item) for item in part["prefixItems"]]
                return f"list of {len(items)}: {items[0]}" if len(set(items)) == 1 else f"[{', '.join(items)}]"
            return f"list of {self._value(part['items'])}"
        if part["type"] == "object":
            values = list(part.get("patternProperties", {}).values()) or [part["additionalProperties"]]
            return f"{{name: {'value' if values[0] is True else self._value(values[0])}}}"
        if isinstance(part["type"], list):
            return part["description"]
        return {"string": "text", "integer": "whole number", "boolean": "true or false"}.get(part["type"], part["type"])


def parts(prop: dict[str, Any]) -> list[dict[str, Any]]:
    """A property's schema and those of its alternatives, items and values, but not of other models."""
    below = [*prop.get("anyOf", ()), *prop.get("prefixItems", ())]
    below += [prop[key] for key in ("items", "additionalProperties") if isinstance(prop.get(key), dict)]
    below += prop.get("patternProperties", {}).values()
    return [prop, *(part for other in below for part in parts(other))]


def range_of(part: dict[str, Any]) -> list[str]:
    """Limits of a number."""
    return [f"{sign} {part[name]:g}" for name, sign in LIMITS.items() if name in part]


def shown(value: Any) -> str:
    """A default as it would be written in YAML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "as below" if value else "{}"
    if isinstance(value, list):
        return f"[{', '.join(map(shown, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)


def plain(text: str) -> str:
    """A docstring's paragraphs as Markdown."""
    return re.sub(r"\s*\n\s*", " ", text.replace("``", "`")).replace("|", "\\|")


def anchor(path: str) -> str:
    """Target of a section."""
    return f"yaml-{re.sub(r'[^a-z0-9]+', '-', path.lower()).strip('-')}" if path else "yaml-root"


def table(heading: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    """A Markdown table."""
    return [f"| {' | '.join(row)} |" for row in (heading, ("---",) * len(heading), *rows)]
