"""Numbers that a file cannot mean: percents and units that were left out.

A number without a unit is SI.  One that is far from anything known is refused, and asked for with its unit: with it,
it is taken as it is.  What has no unit has one limit.  Only what stands in files is looked at: a number that was read
with its unit has none any more.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from .quantities import is_bare, to_si


@dataclass(frozen=True)
class _Ratio:
    """Limits of what has no unit, and of a number from which a per cent sign may be missing."""

    what: str
    most: float
    bare: float = float("inf")

    def refusal(self, given: Any) -> str:
        value = to_si(given, "")
        if value > self.most:
            asked = f": did you mean {value / 100:g}, which is {value:g} %?" if value <= 100 * self.most else ""
            return f"{value:g} is no {self.what} (at most {self.most:g}){asked}"
        if value >= self.bare and is_bare(given):
            return f"{value:g} is {100 * value:g} %: write '{value:g} %' if that is meant, or '{100 * value:g} %'"
        return ""


@dataclass(frozen=True)
class _Size:
    """Limits in SI of what has a unit: of a number without it, and of any."""

    unit: str
    others: tuple[str, ...]
    bare: tuple[float, float]
    possible: tuple[float, float] = (0.0, float("inf"))
    usual: tuple[float, float] | None = None

    def refusal(self, given: Any) -> str:
        value = to_si(given, self.unit)
        if value == 0:
            return ""
        if is_bare(given) and not self.bare[0] <= value <= self.bare[1]:
            asked = f"write its unit, as '{value:g} {self._meant(value)}', or '{value:g} {self.unit}' if that is meant"
            return f"{value:g} without a unit is {value:g} {self.unit}: {asked}"
        if not self.possible[0] <= value <= self.possible[1]:
            return f"'{given}' is {value:.3g} {self.unit}, which nothing has: check the unit"
        return ""

    def _meant(self, value: float) -> str:
        """The first unit in which a number is a usual one."""
        low, high = self.usual or self.bare
        if len(self.others) == 1:
            return self.others[0]
        fits = (unit for unit in self.others if low <= to_si(f"{value!r} {unit}", self.unit) <= high)
        return next(fits, self.others[0])


_NEVER = (float("inf"), float("inf"))
_LENGTH = _Size("m", ("mm",), (0.0, 10.0))
LIMITS = {
    # the largest that are known: 1 to 4 of rubber and of clean metals in vacuum
    "friction": _Ratio("coefficient of friction", 5.0),
    "rolling_friction": _Ratio("coefficient of rolling friction", 1.0),
    "lognormal.deviation": _Ratio("deviation of a logarithm of radii", 1.0),
    "standard_error": _Ratio("relative standard error", 1.0, 0.2),
    "tolerance": _Ratio("tolerance", 1.0, 0.2),
    "modes_given.damping": _Ratio("damping ratio", 1.0, 0.1),
    "inherent_damping": _Ratio("damping ratio", 1.0, 0.1),
    "density": _Size("kg/m^3", ("g/cm^3", "t/mm^3", "kg/mm^3", "g/m^3"), (25.0, 25e3), (0.1, 1e5)),
    "youngs_modulus": _Size("Pa", ("GPa", "MPa"), (1e6, 1e14), (1.0, 1e14), usual=(1e7, 1.3e12)),
    "gravity": _Size("m/s^2", ("mm/s^2", "standard_gravity"), (1.3, 200.0)),
    "base.random.spectrum.1": _Size("m^2/s^3", ("g^2/Hz",), _NEVER),  # tables of standards are in g^2/Hz
    "mass": _Size("kg", ("g",), (0.0, 100.0)),
    "limits.mass": _Size("kg", ("g",), (0.0, 5.0)),  # of the particles of one damper
    "modal_mass": _Size("kg", ("g",), (0.0, 100.0)),
    "duration": _Size("s", ("ms",), (0.0, 100.0)),
    "length": _Size("m", ("mm",), (0.0, 100.0)),
    "width": _LENGTH,
    "thickness": _Size("m", ("mm",), (0.0, 1.0)),
    "wall": _Size("m", ("mm",), (0.0, 1.0)),
    "diameter": _LENGTH,
    "height": _LENGTH,
    "radius": _Size("m", ("mm",), (0.0, 0.5)),
    "footprint": _Size("m", ("mm",), (0.0, 5.0)),
}
"""By the last key of a scalar, or its last ones; of lists in a list by the place in these."""

_INSIDE = ("from", "to", "log", "uniform", "each", "mean", "median")
"""Keys of a range or a distribution, below the key of the scalar."""


def refusal(key: str, given: Any) -> str:
    """What is wrong with a value that was written for a scalar, and the remedy; nothing if nothing is.

    Parameters
    ----------
    key : str
        Path with dots.
    given
        As it was written; what is no quantity of the scalar's is not looked at.
    """
    parts = key.split(".")
    ends = (".".join(parts[k:]) for k in range(len(parts)))
    limit = next((LIMITS[end] for end in ends if end in LIMITS), None)
    if limit is None or isinstance(given, bool) or not isinstance(given, int | float | str):
        return ""
    try:
        return limit.refusal(given)
    except ValueError:  # another kind of entry of the same name
        return ""


def refusals(data: Any) -> Iterator[tuple[tuple, str]]:
    """Place, as keys from the top, and what is wrong there, of all that a YAML tree holds."""
    for place, key, given in _written(data, (), ""):
        if said := refusal(key, given):
            yield place, said


def _written(node: Any, place: tuple, key: str) -> Iterator[tuple[tuple, str, Any]]:
    """Place, path of the scalar and value of every leaf."""
    if isinstance(node, dict):
        for name, below in node.items():
            yield from _written(below, (*place, name), key if name in _INSIDE else f"{key}.{name}")
    elif isinstance(node, list):
        for k, below in enumerate(node):
            inner = place and isinstance(place[-1], int)
            yield from _written(below, (*place, k), f"{key}.{k}" if inner else key)
    else:
        yield place, key, node
