"""Models of the configuration: how beds are prepared, in a word or by what they are to have."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter, model_validator

from .base import POSITIVE as _positive
from .base import Model
from .damper import DamperConfig
from .quantities import Length, Number
from .sweep import swept

Word = Literal["loose", "compacted", "carried"]


class CarriedConfig(Model):
    """Amplitudes run one after the other, each from the bed that the one before left, in the directions of ``path``."""

    path: Annotated[list[Literal["up", "down"]], Field(min_length=1)]
    """Ways through the amplitudes, one after the other; each becomes a value of the dimension ``leg``."""


STATES = ("clearance", "packing_fraction")
"""Keys of the states that a bed can be brought to."""

MAKING = {"materials": None, "contact": None, "excitation": ("gravity", "gravity_direction")}
"""Sections, and those of their keys (all, if none are named), in which beds may be made with other values than they are
shaken with: what decides the forces, and not the room that particles and cavity take."""


class PreparationConfig(Model):
    """State that beds are brought to, or the path along which they are carried, and what they are made with.

    ``made_with`` has the parts of the configuration, as ``{contact: {friction: 0.86}}``, that differ while a bed is
    made: studies of friction, or without gravity, then start from the same beds.
    """

    clearance: swept(Length, _positive) | None = None
    """Travel of the bed's centre of mass between rest on the floor and rest against the lid."""
    packing_fraction: swept(Number, Field(gt=0, lt=1)) | None = None
    """Volume of the particles over that of the cavity less the clearance."""
    carried: CarriedConfig | None = None
    """Each amplitude starts from the bed that the one before left."""
    made_with: dict[str, dict[str, Any]] | None = None
    """Parts of the configuration, by section, that differ while beds are made."""

    @model_validator(mode="after")
    def _one(self):
        given = sum(getattr(self, name) is not None for name in (*STATES, "carried"))
        if given > 1 or (given == 0 and not self.made_with):
            raise ValueError("give one of clearance: 1.8 mm, packing_fraction: 0.54 and carried: {path: [up, down]}")
        if self.carried and self.made_with:
            raise ValueError("made_with: is for compacted beds, and carried ones begin loose: leave one of the two out")
        for section, values in (self.made_with or {}).items():
            if section not in MAKING:
                raise ValueError(f"made_with.{section}: is not one of {', '.join(MAKING)}")
            for key in values:
                if MAKING[section] and key not in MAKING[section]:
                    raise ValueError(f"made_with.{section}.{key}: is not one of {', '.join(MAKING[section])}")
        return self


_WORD = TypeAdapter(Word)


def read_preparation(value: Any) -> Word | PreparationConfig:
    """A word, or what beds are to have; an error names the words only where one was given."""
    if isinstance(value, dict | PreparationConfig):
        return PreparationConfig.model_validate(value)
    return _WORD.validate_python(value)


def state_asked(preparation: Word | PreparationConfig) -> dict[str, Any]:
    """``clearance`` [m] or ``packing_fraction`` that beds are brought to, by name; empty if neither."""
    if not isinstance(preparation, PreparationConfig):
        return {}
    return {name: getattr(preparation, name) for name in STATES if getattr(preparation, name) is not None}


def made_with(preparation: Word | PreparationConfig) -> dict[str, dict[str, Any]]:
    """Parts of the configuration that differ while beds are made; empty if none do."""
    return (preparation.made_with or {}) if isinstance(preparation, PreparationConfig) else {}


def while_made(values: dict[str, Any], preparation: Word | PreparationConfig) -> dict[str, Any]:
    """Values of a whole configuration, as of ``model_dump``, with those that its beds are made with in their place.

    Raises
    ------
    ValueError
        If ``made_with`` has a list where one value is needed; begins with its key.
    """

    def merged(own, other, place):
        if isinstance(other, dict):
            own = own if isinstance(own, dict) else {}
            return own | {key: merged(own.get(key), value, f"{place}.{key}") for key, value in other.items()}
        if isinstance(other, list) and not place.endswith("_direction"):
            raise ValueError(f"{place}: needs one value, got a list: what is swept stands outside made_with")
        return other

    asked = state_asked(preparation)
    kept = {key: value for key, value in values.items() if key not in ("sweep", "coupled", "accuracy", "design")}
    return merged(kept, made_with(preparation), "preparation.made_with") | {"preparation": asked or "compacted"}


def carried_path(preparation: Word | PreparationConfig) -> tuple[str, ...]:
    """Directions in which carried beds meet the amplitudes, ``up`` or ``down``; empty if beds are not carried."""
    if isinstance(preparation, PreparationConfig):
        return tuple(preparation.carried.path) if preparation.carried else ()
    return ("up",) if preparation == "carried" else ()


def preparation_word(preparation: Word | PreparationConfig) -> str:
    """Name of a preparation: loose, compacted, carried, given clearance or given packing fraction."""
    if asked := state_asked(preparation):
        return f"given {next(iter(asked)).replace('_', ' ')}"
    if made_with(preparation):
        return "compacted"
    return "carried" if carried_path(preparation) else str(preparation)


def check_preparation(preparation: Word | PreparationConfig, dampers: dict[str, DamperConfig], gravities: list) -> None:
    """Refuse to compact without gravity, to reach a clearance without floor or lid, and one that no bed can have.

    Raises
    ------
    ValueError
        Begins with the key to look at.
    """
    if made_with(preparation):  # the configuration that beds are made with is checked as a whole
        return
    asked = next(iter(state_asked(preparation)), None)
    key = f"preparation.{asked}" if asked else "preparation"
    if (asked or preparation == "compacted") and 0 in gravities:
        raise ValueError(f"{key}: a bed cannot be compacted without gravity; set preparation: loose")
    for cavity, damper in dampers.items() if asked else ():
        _check_room(key, state_asked(preparation), cavity, damper)
        for wall in ("floor", "lid"):
            if not getattr(damper.enclosure, wall):
                raise ValueError(
                    f"{key}: is defined between a floor and a lid only, and {cavity}.enclosure has no {wall}; "
                    "set preparation: compacted"
                )


def _check_room(key: str, asked: dict[str, Any], cavity: str, damper: DamperConfig) -> None:
    """Refuse a state in which the particles would lie denser than anything can, or fill more than the cavity."""
    ((name, values),) = asked.items()
    fill, densest, height = damper.fill, damper.densest, damper.enclosure.height
    for value in values if isinstance(values, list) else [values]:
        if name == "clearance" and value > height * (1 - fill / densest):
            most = 1e3 * height * (1 - fill / densest)
            raise ValueError(
                f"{key}: {1e3 * value:g} mm: the particles of {cavity} fill {fill:.3f} of it, and packed as densely as "
                f"can be ({densest:g}) they leave {most:.3g} mm: a bed has less"
            )
        if name == "packing_fraction" and not fill <= value <= densest:
            raise ValueError(
                f"{key}: {value:g}: the particles of {cavity} fill {fill:.3f} of it at least, and {densest:g} is the "
                "densest that they can be packed"
            )
