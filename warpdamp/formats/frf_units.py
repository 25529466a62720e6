"""Units of an FRF's axes: frequency, and response over force.

Accelerance, mobility and receptance differ by powers of j w, A = j w Y = (j w)^2 H.  Their inverses (apparent mass,
impedance, dynamic stiffness) are refused: one element of an inverse is not the inverse of the element.

In units of FRFs g is standard gravity and lb a force, as test engineers write them.
"""

from __future__ import annotations

import functools
import re
from enum import StrEnum

import numpy as np

from ..config.quantities import registry
from ..errors import ModalError


class Ordinate(StrEnum):
    """Kind of an FRF's response per force: acceleration, velocity or displacement."""

    ACCELERANCE = "accelerance"
    MOBILITY = "mobility"
    RECEPTANCE = "receptance"


DERIVATIVES = {Ordinate.ACCELERANCE: 0, Ordinate.MOBILITY: 1, Ordinate.RECEPTANCE: 2}
"""To take until it is an accelerance."""
SI = {Ordinate.ACCELERANCE: "(m/s^2)/N", Ordinate.MOBILITY: "(m/s)/N", Ordinate.RECEPTANCE: "m/N"}
HERTZ = {"hz": 1.0, "hertz": 1.0, "khz": 1e3, "cps": 1.0, "rpm": 1 / 60, "rad/s": 0.5 / np.pi, "krad/s": 500 / np.pi}
NEWTON = {"n": "N", "newton": "N", "newtons": "N", "kn": "kN", "mn": "mN", "dan": "daN", "kgf": "kgf", "kp": "kgf"}
NEWTON |= dict.fromkeys(("lb", "lbs", "lbf", "pound", "pounds"), "lbf")
LENGTH = {"m": "m", "cm": "cm", "mm": "mm", "um": "um", "micron": "um", "nm": "nm", "ft": "ft", "foot": "ft"}
LENGTH |= dict.fromkeys(("in", "inch", "inches"), "inch") | dict.fromkeys(("mil", "mils"), "thou")
TIME = {"s": "s", "sec": "s", "second": "s", "ms": "ms", "us": "us"}
OTHER = {"kg": "kg", "ips": "inch/s", "rad": "rad"} | dict.fromkeys(("g", "gn", "g0", "gs"), "g_0")
NAMES = NEWTON | LENGTH | TIME | OTHER
AMBIGUOUS = {"Mm", "MN", "Mn", "mG", "mg", "Ms", "gf"}  # which capitals would change, or a gram
KINDS = {  # powers of mass and time; lengths cancel
    (-1, 0): Ordinate.ACCELERANCE,
    (-1, 1): Ordinate.MOBILITY,
    (-1, 2): Ordinate.RECEPTANCE,
    (1, 0): "an apparent mass",
    (1, -1): "a mechanical impedance",
    (1, -2): "a dynamic stiffness",
    (0, 0): "a ratio, such as a transmissibility",
}
REMEDY = "export response over force: accelerance, mobility or receptance"
_TIDY = {
    "\u00b2": "^2",
    "\u00b3": "^3",
    "\u00b9": "^1",
    "\u207b": "^-",
    "^-^": "^-",
    "\u00b5": "u",
    "\u03bc": "u",
    "**": "^",
}
_TIDY |= dict.fromkeys("\u00b7\u22c5\u2219\u00d7", "*")
_TOKEN = re.compile(
    r"(?P<name>gn\b|g0\b|[A-Za-z]+)(?:\s*\^?\s*(?P<power>[-+]?\d)(?!\d))?|(?P<one>1\s*(?=/))|(?P<sign>[*/()\s])"
)


def one_of(kinds: type[StrEnum], name, what: str):
    """Member of an enumeration by its name.

    Raises
    ------
    ModalError
        If there is none; says which there are.
    """
    try:
        return kinds(str(name).lower())
    except ValueError:
        raise ModalError(f"{what} '{name}': is none of {', '.join(kinds)}") from None


def hertz(unit: str) -> float:
    """Factor that turns a unit of frequency into hertz.

    Raises
    ------
    ValueError
        If it is none that is known: 1/s is none, for it may be Hz or rad/s.
    """
    known = re.sub(r"[\s*]*s(ec)?\s*\^?\s*-1$|\s*/\s*s(ec)?$", "/s", _tidy(unit).strip().lower())
    if known not in HERTZ or unit.strip().startswith("M"):
        raise ValueError(f"{unit!r} is no unit of frequency: write Hz, kHz, rad/s or rpm")
    return HERTZ[known]


@functools.cache
def ordinate(unit: str) -> tuple[Ordinate, float]:
    """Kind of a response over force by its unit, and the factor that turns it into SI.

    Raises
    ------
    ValueError
        If it is a unit of something else, or none; says of what.
    """
    quantity = _quantity(unit)
    powers = dict(quantity.dimensionality)
    kind = KINDS.get((powers.pop("[mass]", 0), powers.pop("[time]", 0)), "another quantity")
    if powers or not isinstance(kind, Ordinate):
        kind = "no response over force" if powers else f"that of {kind}"
        raise ValueError(f"the unit {unit!r} is {kind}: {REMEDY}")
    return kind, float(quantity.magnitude)


def agreed(said) -> Ordinate | None:
    """Kind of an FRF on which all sources (kind or None, source) agree; None if no source names one.

    Raises
    ------
    ModalError
        If two contradict each other.
    """
    known = [(kind, who) for kind, who in said if kind]
    for kind, who in known:
        if kind is not known[0][0]:
            raise ModalError(f"{known[0][1]} says {known[0][0]}, but {who} says {kind}: mend one")
    return known[0][0] if known else None


def newtons(unit: str) -> float:
    """Factor that turns a unit of force into newtons; a ValueError if it is none."""
    return _one_of(unit, NEWTON, "force: write N or lbf")


def seconds(unit: str) -> float:
    """Factor that turns a unit of time into seconds; a ValueError if it is none."""
    return _one_of(unit, TIME, "time: write s or ms")


def _one_of(unit: str, units: dict[str, str], wanted: str) -> float:
    if unit.lower() not in units or unit in AMBIGUOUS:
        raise ValueError(f"{unit!r} is no unit of {wanted}")
    return float(_quantity(unit).magnitude)


def metres_per_second_squared(unit: str) -> float:
    """Factor that turns a unit of acceleration into m/s^2; a ValueError if it is none."""
    quantity = _quantity(unit)
    if dict(quantity.dimensionality) != {"[length]": 1, "[time]": -2}:
        raise ValueError(f"{unit!r} is no unit of acceleration: write m/s^2 or g")
    return float(quantity.magnitude)


def _quantity(unit: str):
    """Unit in SI, by pint; its names are those above."""
    text = _tidy(unit)
    tokens = list(_TOKEN.finditer(text))
    try:
        if "".join(token[0] for token in tokens) != text:
            raise ValueError("has other characters")
        return registry().Quantity(" ".join(map(_for_pint, tokens))).to_base_units()
    except Exception:  # pint lets its tokenizer's errors through under many names
        raise ValueError(f"cannot read the unit {unit!r}: write it as (m/s^2)/N or g/lbf") from None


def _tidy(unit: str) -> str:
    for written, meant in _TIDY.items():
        unit = unit.replace(written, meant)
    return unit


def _for_pint(token: re.Match) -> str:
    if not token["name"]:
        return token[0]
    if token["name"] in AMBIGUOUS:
        raise ValueError("is ambiguous")
    return f"{NAMES[token['name'].lower()]}**{token['power'] or 1}"
