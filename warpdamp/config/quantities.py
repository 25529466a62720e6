"""Quantities with units in YAML; SI floats inside.  A bare number is SI."""

from __future__ import annotations

import functools
import math
import re
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

_QUANTITY = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$")
_POWER = re.compile(r"(?<=[A-Za-z])(-?\d)")  # m3, m-3
_TURNS = ("rad", "turn", "rev", "rpm", "deg", "cycle")


@functools.cache
def _registry():
    import pint

    registry = pint.UnitRegistry(cache_folder=None)
    registry.define("percent = 0.01 = %")
    return registry


def to_si(value: Any, unit: str) -> float:
    """A number, or text such as ``"40 mm"``, in the SI ``unit``.

    Raises
    ------
    ValueError
        If it is no quantity, not finite, or of another dimension; says which unit is wanted.
    """
    wanted = f"a quantity in {unit}" if unit else "a plain number or a percentage"
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError(f"expected {wanted}, got {value!r}")
    number = _parsed(value, unit, wanted) if isinstance(value, str) else float(value)
    if not math.isfinite(number):
        raise ValueError(f"expected {wanted}, got {value!r}, which is not finite")
    return number


def _parsed(text: str, unit: str, wanted: str) -> float:
    import pint

    if "," in text:
        raise ValueError(f"cannot read '{text}': write a decimal point, not a comma")
    parts = _QUANTITY.match(text)
    if parts is None:
        raise ValueError(f"cannot read '{text}': expected {wanted}, such as '{_example(unit)}'")
    number, given = float(parts[1]), _POWER.sub(r"**\1", parts[2])
    if not given:
        return number
    if any(turn in given.lower() for turn in _TURNS):
        raise ValueError(f"'{text}' counts angles: expected {wanted}, such as '{_example(unit)}'")
    registry = _registry()
    try:
        return float(registry.Quantity(f"{number!r} {given}").to(registry.Unit(unit or "dimensionless")).magnitude)
    except pint.DimensionalityError as error:
        raise ValueError(f"'{text}' has the wrong unit: expected {wanted}") from error
    except Exception as error:  # pint lets its tokenizer's errors through under many names
        raise ValueError(f"cannot read '{text}': expected {wanted}, such as '{_example(unit)}'") from error


def _example(unit: str) -> str:
    examples = {"m": "40 mm", "kg": "200 g", "Pa": "3.3 GPa", "s": "2 us", "Hz": "46 Hz", "": "2 %"}
    return examples.get(unit, f"1.5 {unit}")


def quantity(unit: str) -> Any:
    """Annotated float that reads quantities of ``unit``."""
    described = f"quantity in {unit}, as '{_example(unit)}', or a number in SI" if unit else "number or percentage"
    return Annotated[
        float,
        BeforeValidator(lambda value: to_si(value, unit)),
        WithJsonSchema({"type": ["number", "string"], "description": described, "unit": unit}),
    ]


Length = quantity("m")
Mass = quantity("kg")
Time = quantity("s")
Frequency = quantity("Hz")
Density = quantity("kg/m^3")
Pressure = quantity("Pa")
Acceleration = quantity("m/s^2")
Number = quantity("")
