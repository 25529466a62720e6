"""Quantities with units in YAML; SI floats inside.  A bare number is SI."""

from __future__ import annotations

import functools
import math
import re
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BeforeValidator

_GROUPED = r"[1-9]\d{0,2}(?P<mark>[\s'\u2019])\d{3}(?:(?P=mark)\d{3})*(?!\d)(?:\.\d+)?"
_PLAIN = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_FRACTION = r"(?:(?P<whole>\d{1,9})\s+)?(?P<over>[1-9]\d{0,8})\s*/\s*(?P<under>\d{1,9})(?![\d.])"
_QUANTITY = re.compile(rf"\s*(?P<sign>[-+]?)(?:{_FRACTION}|(?P<decimal>{_GROUPED}|{_PLAIN}))\s*(?P<unit>.*?)\s*")
_EXPONENT = re.compile(r"(?:(?:\^|\*\*)\s*\(?|(?<=[^\W\d_]))[-+]?\d(?:\.\d{1,3})?(?![\d.])")  # ^3, **-3, m3, kg-0.5
_POWER = re.compile(r"(?<=[^\W\d_])([-+]?\d)")  # m3, m-3
_TURNS = ("rad", "turn", "rev", "rpm", "deg", "cycle")
COMMON = {
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "kg": {"kg": 1.0, "g": 1e-3},
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "Hz": {"Hz": 1.0, "kHz": 1e3},
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
    "N": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
    "kg/m^3": {"kg/m^3": 1.0},
    "m/s^2": {"m/s^2": 1.0},
    "": {"%": 1e-2},
}
"""Factors of the units that most files use, by SI unit: read without pint, whose import takes longer than all the rest
of reading a configuration; a test holds them to pint's, to the bit."""

_SPELLINGS = {name.lower(): name for units in COMMON.values() for name in (*units, "in")}


@functools.cache
def registry():
    """The units of pint, and per cent."""
    import pint

    units = pint.UnitRegistry(cache_folder=None)
    units.define("percent = 0.01 = %")
    return units


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
    try:
        number = _parsed(value, unit, wanted) if isinstance(value, str) else float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"expected {wanted}, got {_short(value)}, which is not finite")
    return number


def is_bare(value: Any) -> bool:
    """Whether a number is written without a unit."""
    parts = _QUANTITY.fullmatch(value) if isinstance(value, str) else None
    return parts is None or not parts["unit"]


def _parsed(text: str, unit: str, wanted: str) -> float:
    if "," in text:
        raise ValueError(f"cannot read '{text}': write a decimal point, not a comma")
    parts = _QUANTITY.fullmatch(text)
    if parts is None:
        raise ValueError(f"cannot read '{text}': expected {wanted}, such as '{_example(unit)}'")
    number, given = _number(parts, text), parts["unit"]
    if not given:
        return number
    if given in COMMON.get(unit, ()):
        return number * COMMON[unit][given]
    if any(turn in given.lower() for turn in _TURNS):
        raise ValueError(f"'{text}' counts angles: expected {wanted}, such as '{_example(unit)}'")
    rest = _EXPONENT.sub("", re.sub(r"^1\s*/", "/", given))
    if any(c.isdecimal() or c in "+-" for c in rest):
        raise ValueError(f"cannot read '{text}': expected one number and its unit, such as '{_example(unit)}'")
    return _by_pint(text, number, given, unit, wanted)


def _by_pint(text: str, number: float, given: str, unit: str, wanted: str) -> float:
    """The number in SI, whatever its unit."""
    import pint

    try:
        return _converted(number, given, unit)
    except pint.DimensionalityError as error:
        raise ValueError(f"'{text}' has the wrong unit: expected {wanted}{_respelt(given, unit)}") from error
    except Exception as error:  # pint lets its tokenizer's errors through under many names
        remedy = _respelt(given, unit).removeprefix("; ") or f"expected {wanted}, such as '{_example(unit)}'"
        raise ValueError(f"cannot read '{text}': {remedy}") from error


def _converted(number: float, given: str, unit: str) -> float:
    units = registry()
    powers = _POWER.sub(r"**\1", given)
    return float(units.Quantity(f"{number!r} {powers}").to(units.Unit(unit or "dimensionless")).magnitude)


def _number(parts: re.Match, text: str) -> float:
    """The number of a quantity: a decimal, its thousands apart or not, or a fraction, 1/4 or 1 1/4."""
    if parts["decimal"]:
        size = float(re.sub(r"[\s'\u2019]", "", parts["decimal"]))
    else:
        whole, over, under = (int(parts[name] or 0) for name in ("whole", "over", "under"))
        if under == 0 or (parts["whole"] and over >= under):
            raise ValueError(f"cannot read '{text}': {over}/{under} is no proper fraction: write a decimal number")
        size = whole + over / under
    return -size if parts["sign"] == "-" else size


def _respelt(given: str, unit: str) -> str:
    """What to write instead of a unit that is one but for capital letters, as hz, or g of an acceleration."""
    if unit == "m/s^2" and given in ("g", "G"):
        return "; g is gram: write standard_gravity, which is 9.80665 m/s^2"
    if given in ('"', "''", "\u2033", "\u201d"):
        return "; write in for inches"
    spelt = re.sub(r"[^\W\d_]+", lambda word: _SPELLINGS.get(word[0].lower(), word[0]), given)
    try:
        _converted(1.0, spelt, unit)
    except Exception:  # whatever pint raises: there is nothing to propose
        return ""
    return f"; did you mean {spelt}?"


def _short(value) -> str:
    text = repr(value) if isinstance(value, str | float) else "a whole number"
    return text if len(text) < 60 else f"{text[:57]}..."


def _example(unit: str) -> str:
    examples = {"m": "40 mm", "kg": "200 g", "Pa": "3.3 GPa", "s": "2 us", "Hz": "46 Hz", "": "2 %"}
    return examples.get(unit, f"1.5 {unit}")


@dataclass(frozen=True)
class _Described:
    """Adds to a number's JSON schema, which has its range, that it may be text with a unit."""

    unit: str

    def __get_pydantic_json_schema__(self, number, schema_of) -> dict[str, Any]:
        written = f"quantity in {self.unit}, as '{_example(self.unit)}', or a number in SI"
        return schema_of(number) | {
            "type": ["number", "string"],
            "description": written if self.unit else "number or percentage",
            "unit": self.unit,
        }


def quantity(unit: str) -> Any:
    """Annotated float that reads quantities of ``unit``."""
    return Annotated[float, BeforeValidator(lambda value: to_si(value, unit)), _Described(unit)]


Length = quantity("m")
Mass = quantity("kg")
Time = quantity("s")
Frequency = quantity("Hz")
Density = quantity("kg/m^3")
Pressure = quantity("Pa")
Acceleration = quantity("m/s^2")
Number = quantity("")
