"""One case of a study, chosen by the values that it is known by."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..errors import UsageError
from .axes import CASE, LEG, OWN
from .cases import Cases

MOST_LISTED = 12
"""Values that an error lists."""

SAME = 1e-3
"""A number asked for is a value of the study if it is within this part of it, as 39.5 Hz is 39.4987 Hz."""


@dataclass(frozen=True)
class Choice:
    """What a case is chosen by; what is not given has to have one value, or is left to the results.

    Parameters
    ----------
    gamma : [-]
    mode : number of a mode
    frequency : [Hz]
    seed : of the packing (default: the first)
    at : values of swept scalars by name, as text
    """

    gamma: float | None = None
    mode: int | None = None
    frequency: float | None = None
    seed: int | None = None
    at: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, at: list[str] = [], **given) -> Choice:  # noqa: B006 - not changed
        """Choice with swept scalars as ``friction=0.5``.

        Raises
        ------
        UsageError
            If one of them is not of that form.
        """
        pairs = [text.partition("=") for text in at]
        for (name, sign, value), text in zip(pairs, at, strict=True):
            if not (name and sign and value):
                raise UsageError(f"--at {text}: write as friction=0.5")
        return cls(at={name: value for name, _, value in pairs}, **given)

    def wanted(self) -> dict[str, str]:
        """What is asked for by name, as text."""
        own = {name: getattr(self, name) for name in ("gamma", "mode", "frequency", "seed")}
        return {name: f"{value:.10g}" for name, value in own.items() if value is not None} | self.at


def candidates(cases: Cases, choice: Choice) -> np.ndarray:
    """Numbers of the cases of a study that a choice leaves.

    Raises
    ------
    UsageError
        If the study has no such value, naming those that it has; or no case with all of them.
    """
    known, left = coordinates(cases), np.ones(cases.shape, bool)
    for name, text in choice.wanted().items():
        if name not in known:
            raise UsageError(f"there is no {name} to choose by: the cases differ in {', '.join(known)}")
        dim, values = known[name]
        fits = np.array([same(value, text) for value in values])
        if not fits.any():
            raise UsageError(f"there is no case with {name} {text}: there is {_listed(values)}")
        shape = [1] * left.ndim
        shape[dim] = -1
        left &= fits.reshape(shape)
    if not left.any():
        raise UsageError("there is no case with all of the values asked for")
    return np.flatnonzero(left)


def coordinates(cases: Cases) -> dict[str, tuple[int, list]]:
    """Dimension (its place in ``Cases.shape``) and values of all that cases can be chosen by, by name."""
    first = next((point for point in cases.points() if not point.refused), None)
    known: dict[str, tuple[int, list]] = {}
    if first and cases.modal:
        known["mode"] = 0, [int(number) for number in first.modes.number]
    frequencies = list(first.frequencies) if first else [math.nan]
    own = {"frequency": (0, frequencies), "gamma": (1, cases.gammas), "seed": (len(cases.shape) - 1, cases.seeds)}
    carried = {OWN[path] for path in cases.carried}
    known |= {name: place for name, place in own.items() if name not in carried}
    names = cases.names()
    for k, axis in enumerate(cases.axes, 2):
        known |= {names[path]: (k, values) for path, values in axis.columns().items()}
        if axis.name in (CASE, LEG):
            known[axis.name] = k, list(range(axis.name == LEG, len(axis) + (axis.name == LEG)))
    return known


def undecided(cases: Cases, numbers: np.ndarray) -> dict[str, list]:
    """Coordinates in which some cases differ, and the values that they have, but for the seed."""
    places = np.unravel_index(numbers, cases.shape)
    found = {}
    for name, (dim, values) in coordinates(cases).items():
        here = np.unique(places[dim])
        if len(here) > 1 and name != "seed":
            found[name] = [values[k] for k in here]
    return found


def only(cases: Cases, numbers: np.ndarray) -> int:
    """Number of the one case of some that differ in nothing but the seed, of which the first is taken.

    Raises
    ------
    UsageError
        If they differ in something else.
    """
    if differ := undecided(cases, numbers):
        name, values = next(iter(differ.items()))
        raise UsageError(f"there are {len(numbers)} such cases: choose by {name} as well: {_listed(values)}")
    return int(numbers[0])


def label(cases: Cases, number: int) -> str:
    """Name of a case: all that it is known by."""
    place = np.unravel_index(number, cases.shape)
    words = []
    for name, (dim, values) in coordinates(cases).items():
        if name != "seed" or len(cases.seeds) > 1:
            words.append(f"{name} {_shown(values[place[dim]])}" + (" Hz" if name == "frequency" else ""))
    return ", ".join(words).replace("gamma", "Γ")


def same(value, text: str) -> bool:
    """Whether a value is the one asked for."""
    try:
        return math.isclose(float(value), float(text), rel_tol=SAME)
    except (TypeError, ValueError):
        return str(value) == text


def _shown(value) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _listed(values: list) -> str:
    some = [_shown(value) for value in values[:MOST_LISTED]]
    return ", ".join(some) + (f" and {len(values) - MOST_LISTED} more" if len(values) > MOST_LISTED else "")
