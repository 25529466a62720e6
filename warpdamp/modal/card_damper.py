"""Whether the damper of a card is the one that a study describes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import ValidationError

from ..config.study import Config

if TYPE_CHECKING:
    import xarray as xr

OF_THE_BED = ("gravity", "gravity_direction", "direction")
"""Keys of the excitation that what a damper does depends on, too."""


def difference(part: xr.Dataset, config: Config, number: int) -> str | None:
    """Sentence on where a card's damper differs from the one in its place, or None.

    Parameters
    ----------
    part : xarray.Dataset
        Card.
    config : Config
        Study that carries the damper.
    number : int
        Of the damper there, 1 the first.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        own = _leaves(_damper(_today(YAML(typ="safe").load(str(part.attrs["configuration"]))), 1))
    except (KeyError, TypeError, ValidationError, YAMLError):
        return f"damper {number}: the card does not say which damper it is of"
    there = _leaves(_damper(config.model_dump(mode="json", by_alias=True), number))
    differ = [
        f"{key} {_shown(own.get(key))} where the study has {_shown(there.get(key))}"
        for key in dict.fromkeys([*own, *there])
        if own.get(key) != there.get(key)
        and not isinstance(own.get(key), list)
        and not isinstance(there.get(key), list)
    ]
    if not differ:
        return None
    more = f", and {len(differ) - 1} more" if len(differ) > 1 else ""
    return (
        f"damper {number}: the card is of another damper than the study describes: {differ[0]}{more}; the card counts"
    )


def _today(study: dict) -> dict:
    """A study as it would be written today: keys that there were not when a card was made have their defaults."""
    return Config.model_validate(study).model_dump(mode="json", by_alias=True)


def _damper(study: dict, number: int) -> dict:
    """What a study says of one of its dampers, with the materials in place of their names."""
    damper = study["damper"] if number == 1 else study["dampers"][number - 2]
    parts = damper["particles"] if isinstance(damper["particles"], list) else [damper["particles"]]
    materials = study["materials"]
    found = {"enclosure": damper["enclosure"] | {"material": materials[damper["enclosure"]["material"]]}}
    for k, part in enumerate(parts):
        found[f"particles.{k}" if len(parts) > 1 else "particles"] = part | {"material": materials[part["material"]]}
    contact = {key: value for key, value in study["contact"].items() if key != "pairs"}
    return found | {"contact": contact} | {key: study["excitation"][key] for key in OF_THE_BED}


def _leaves(node, key: str = "") -> dict:
    """Scalars and lists by their dotted keys."""
    if not isinstance(node, dict):
        return {key: list(node) if isinstance(node, tuple) else node}
    return {name: leaf for k, v in node.items() for name, leaf in _leaves(v, f"{key}.{k}".lstrip(".")).items()}


def _shown(value) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
