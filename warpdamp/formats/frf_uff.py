"""FRFs in universal files: which of them, and what they are.

| field of dataset 58 | use |
|---|---|
| function type | 4 is an FRF, 0 where the option ordinate says what it is; others are left aside, which is said |
| response and reference, node and direction | choose one FRF of several; rotations are refused |
| load case, value of the z-axis | are said |
| number, spacing, type of values | used; real values are refused |
| data types of the axes | frequency; acceleration, velocity or displacement; force; others are refused by name |
| unit labels | used; where there is none, dataset 164; where there is no such dataset, Hz and SI, which is said |
| exponents of units | of general data: must be those of a length, and of a force |
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import numpy as np

from ..errors import ModalError
from .frf_curve import Curve
from .frf_units import SI, Ordinate, agreed, hertz, newtons, ordinate
from .uff_functions import COMPLEX, Axis, Function, function, values
from .uff_geometry import units as file_units
from .uff_records import datasets

GENERAL, FRF = 0, 4
QUANTITIES = {
    2: "stress", 3: "strain", 5: "temperature", 6: "heat flux", 8: "displacement", 9: "reaction force", 11: "velocity",
    12: "acceleration", 13: "force", 15: "pressure", 16: "mass", 17: "time", 18: "frequency", 19: "rpm", 20: "order",
}  # fmt: skip
UNSAID, FREQUENCY, RPM, FORCE = (0, 1), 18, 19, 13
GIVEN = {8: Ordinate.RECEPTANCE, 11: Ordinate.MOBILITY, 12: Ordinate.ACCELERANCE}
SHOWN = 12
"""Functions that a message lists."""
_FREEDOM = re.compile(r"0*(?P<node>\d+)\s*:?\s*\+?(?P<way>-?[xyz]?)", re.IGNORECASE)


def read_frf_uff(
    file: Path, *, response=None, reference=None, number=None, given: Ordinate | None = None, unit: str = ""
) -> list[Curve]:
    """FRFs of a universal file that are asked for, in their order.

    Parameters
    ----------
    file : path
    response, reference : node and direction, as "2z", or a node
    number : place among the functions of the file, from 1
    given : what the values are, where the file does not say
    unit : of the values, where the file does not say or contradicts itself

    Raises
    ------
    ModalError
        If there are none, or if something that the file says cannot be used.
    """
    sets = datasets(file)
    system = file_units(file, sets, None) if any(dataset.number == 164 for dataset in sets) else None
    functions = [function(k, dataset) for k, dataset in enumerate((s for s in sets if s.number == 58), 1)]
    frfs = [f for f in functions if f.kind == FRF or (f.kind == GENERAL and given)]
    if not frfs:
        raise ModalError(f"{file}: holds no FRF (dataset 58, function type 4), only {_contents(sets, functions)}")
    wanted = _choice(response, "response"), _choice(reference, "reference")
    chosen = [
        f
        for f in frfs
        if number in (None, f.number)
        and all(choice.fullmatch(own) for choice, own in zip(wanted, (f.response, f.reference), strict=True))
    ]
    if not chosen:
        raise ModalError(f"{file}: none of its FRFs is the one asked for; there are {listed(frfs)}")
    aside = len(functions) - len(frfs)
    remark = f"functions of the file that are left aside: {aside}" if aside else ""
    return [_curve(f, system, given, unit, remark) for f in chosen]


def listed(functions: list[Function] | list[str]) -> str:
    """Text that lists the first of some functions."""
    more = f" and {len(functions) - SHOWN} more" if len(functions) > SHOWN else ""
    return "; ".join(map(str, functions[:SHOWN])) + more


def _choice(asked, what: str) -> re.Pattern:
    """Pattern of the degrees of freedom that are asked for."""
    if asked is None:
        return re.compile(".*")
    found = _FREEDOM.fullmatch(str(asked).strip())
    if not found:
        raise ModalError(f"{what} '{asked}': write a node and its direction, as 2z or 2-z, or a node")
    return re.compile(rf"{found['node']}" + (re.escape(found["way"].lower()) if found["way"] else r"\D*"))


def _contents(sets, functions: list[Function]) -> str:
    kinds = Counter(str(f).partition(": ")[2].rpartition(" ")[0] for f in functions)
    others = Counter(f"dataset {s.number}" for s in sets if s.number != 58)
    return ", ".join(f"{count} x {name}" for name, count in (kinds | others).items())


def _curve(function: Function, system, given: Ordinate | None, unit: str, remark: str) -> Curve:
    if function.data_type not in COMPLEX:
        raise function.error("its values are real: export complex ones, or a table of magnitude and phase")
    if "r" in function.response + function.reference or "?" in function.response + function.reference:
        raise function.error("a rotation: only translations are read")
    kind, factor, unit_said = _scale(function, system, given, unit)
    hertz_each, abscissa_said = _abscissa(function)
    with np.errstate(invalid="ignore", over="ignore"):  # what is too large is refused with its place
        x, data = values(function)
        x, data = hertz_each * x, factor * data

    def place(k: int) -> str:
        return f"{function.dataset.file}:{function.dataset.line}: value {k + 1} of function {function.number}"

    load = f"load case {function.load_case}" if function.load_case else ""
    z = f"z-axis {function.z:g}" if function.z else ""
    curve = Curve.of(x, data, kind, place)
    return curve.described(
        f"{kind} in {unit_said}", abscissa_said, load, z, remark, name=f"{function.response}/{function.reference}"
    )


def _abscissa(function: Function) -> tuple[float, str]:
    """Hertz in one of the abscissa, and what is taken for granted."""
    axis = function.abscissa
    if axis.code not in (*UNSAID, FREQUENCY, RPM):
        raise function.error(f"is over {_quantity(axis)}, not over frequency")
    if not axis.unit:
        return (hertz("rpm"), "") if axis.code == RPM else (1.0, "frequency taken to be in Hz")
    try:
        return hertz(axis.unit), ""
    except ValueError as error:
        raise function.error(f"its abscissa: {error}") from None


def _scale(function: Function, system, given: Ordinate | None, unit: str) -> tuple[Ordinate, float, str]:
    """Kind of the values, the factor that turns them into SI, and the name of their unit."""
    _refuse_other_quantities(function)
    top, bottom = function.numerator, function.denominator
    label = " / ".join(axis.unit for axis in (top, bottom) if axis.unit)
    try:
        labelled = _labelled(top.unit, bottom.unit, system) if top.unit else None
        option = ordinate(unit) if unit else None
        kind = agreed(
            [
                (GIVEN.get(top.code), "its data type"),
                (labelled and labelled[0], f"its unit {label}"),
                (given, "the option ordinate"),
                (option and option[0], "the option units"),
            ]
        )
        own = labelled[1] if labelled else _unlabelled(bottom.unit, system)
    except ValueError as error:
        raise function.error(str(error)) from None
    if kind is None or (bottom.code in UNSAID and not (bottom.unit or labelled or given or option)):
        said = "what its response is" if kind is None else "what its response is divided by"
        raise function.error(f"does not say {said}: give the option ordinate: {', '.join(Ordinate)}")
    by_system = system[1] / system[0] if system else own
    if option:
        if (labelled or system) and not np.isclose(option[1], (own, by_system), rtol=0.01).any():
            raise function.error(f"the file says its units, {label or 'in dataset 164'}, and the option says {unit}")
        return kind, option[1], unit
    if labelled and not np.isclose(own, by_system, rtol=0.01):
        raise function.error(f"its units are {label}, but dataset 164 has others: give the option units, as '{label}'")
    return kind, own, label if labelled else "units of dataset 164" if system else f"{SI[kind]}: no unit is named"


def _labelled(top: str, bottom: str, system) -> tuple[Ordinate, float]:
    """Kind and factor of a response over force by its unit labels; the first may hold both."""
    try:
        whole = ordinate(top)
    except ValueError:
        force = newtons(bottom) if bottom else 1 / (system[1] if system else 1)
        kind, each = ordinate(f"({top})/N")
        return kind, each / force
    return whole


def _unlabelled(bottom: str, system) -> float:
    """Factor that turns a response without a unit into SI: the file's unit of length, over that of force."""
    length, force = system or (1.0, 1.0)
    return 1 / length / (newtons(bottom) if bottom else 1 / force)


def _refuse_other_quantities(function: Function) -> None:
    top, bottom = function.numerator, function.denominator
    if top.code not in (*GIVEN, *UNSAID) or bottom.code not in (FORCE, *UNSAID):
        raise function.error(f"is {_quantity(top)} over {_quantity(bottom)}: export response over force")
    for axis, expected in ((top, (1, 0, 0)), (bottom, (0, 1, 0))):
        if axis.code in UNSAID and axis.exponents not in ((0, 0, 0), expected):
            raise function.error(f"exponents {axis.exponents} of length, force and temperature: expected {expected}")


def _quantity(axis: Axis) -> str:
    return QUANTITIES.get(axis.code, f"a quantity of type {axis.code}")
