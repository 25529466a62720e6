"""Quantities with units in YAML; SI floats inside.  A bare number is SI."""

from __future__ import annotations

import functools
import math
import re
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

_BARE = re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")


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
    if isinstance(value, str) and not _BARE.match(value.strip()):
        number = _parsed(value.strip(), unit, wanted)
    else:
        number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"expected {wanted}, got {value!r}, which is not finite")
    return number


def _parsed(text: str, unit: str, wanted: str) -> float:
    import pint

    registry = _registry()
    try:
        quantity = registry.Quantity(text)
        return float(quantity.to(registry.Unit(unit or "dimensionless")).magnitude)
    except pint.DimensionalityError as error:
        raise ValueError(f"'{text}' has the wrong unit: expected {wanted}") from error
    except (pint.UndefinedUnitError, pint.errors.DefinitionSyntaxError, AssertionError, TypeError, ValueError) as error:
        raise ValueError(f"cannot read '{text}': expected {wanted}, such as '{_example(unit)}'") from error
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
        WithJsonSchema({"type": ["number", "string"], "description": described}),
    ]


Length = quantity("m")
Mass = quantity("kg")
Time = quantity("s")
Frequency = quantity("Hz")
Density = quantity("kg/m^3")
Pressure = quantity("Pa")
Acceleration = quantity("m/s^2")
Number = quantity("")
