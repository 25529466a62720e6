"""FRFs as text tables: columns by their names and units.

| column | names | units |
|---|---|---|
| frequency | f, frequency; omega, w where it is in rad/s | Hz, kHz, rad/s, rpm |
| real and imaginary part | real, re; imaginary, imag, im | of response over force: (m/s^2)/N, g/lbf, mm/N ... |
| or magnitude and phase | magnitude, amplitude, abs; phase, angle | the same, or dB; deg or rad |

A name may say what is given per force (accelerance, mobility, receptance), and the same in German or French.  What a
table does not say is taken to be Hz and accelerance in (m/s^2)/N, dB relative to 1; a table without names has the
columns frequency, real part, imaginary part.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

from ..errors import ModalError
from .frf_curve import Curve
from .frf_units import SI, Ordinate, agreed, hertz, ordinate
from .text_table import Column, TextTable, read_table


class Part(StrEnum):
    """Part of an FRF that a column holds."""

    FREQUENCY = "frequency"
    REAL = "real part"
    IMAGINARY = "imaginary part"
    MAGNITUDE = "magnitude"
    PHASE = "phase"


PARTS = {
    Part.FREQUENCY: "f freq freqs frequency frequencies frequenz fréquence omega w ω kreisfrequenz pulsation",
    Part.REAL: "re real realteil réel reel réelle",
    Part.IMAGINARY: "im img imag imaginary imaginärteil imaginaire",
    Part.MAGNITUDE: "mag magn magnitude abs absolute amp ampl amplitude betrag module modulus db",
    Part.PHASE: "phase phasenwinkel phi angle arg argument winkel",
}
GIVEN = {
    Ordinate.ACCELERANCE: "accelerance inertance accel acceleration beschleunigung akzeleranz accélérance",
    Ordinate.MOBILITY: "mobility velocity mobilität mobilité",
    Ordinate.RECEPTANCE: "receptance compliance displacement rezeptanz nachgiebigkeit réceptance",
}
ANGULAR = {"omega", "w", "ω", "kreisfrequenz", "pulsation", "angular", "circular"}
"""Names of a frequency that is in rad/s."""
FILLING = {
    "frf",
    "h",
    "h1",
    "h2",
    "hv",
    "a",
    "y",
    "part",
    "of",
    "the",
    "response",
    "transfer",
    "function",
    "per",
    "force",
}
UNITS_IN_NAMES = ("hz", "khz", "rpm", "deg", "rad", "db")
"""With which a name may end, as freq_Hz."""
DEGREES, RADIANS = ("deg", "degree", "degrees", "°"), ("rad", "radian", "radians")
CHOICES = ({Part.REAL, Part.IMAGINARY}, {Part.MAGNITUDE, Part.PHASE})
EXAMPLE = "'Frequency [Hz], Real [(m/s^2)/N], Imaginary [(m/s^2)/N]' or 'Frequency [Hz], Magnitude [dB], Phase [deg]'"
_PART, _GIVEN = ({word: key for key, words in table.items() for word in words.split()} for table in (PARTS, GIVEN))
_DECIBELS = re.compile(
    r"db(?:[\s,]*re(?:f|l|ference)?[.:]?\s*(?P<size>\d[\d.]*(?:e[-+]?\d+)?)?\s*(?P<unit>.*))?", re.IGNORECASE
)


@dataclass(frozen=True)
class Head:
    """Head of a column: the part of the FRF, its unit, and what it is given per force."""

    part: Part
    unit: str
    given: Ordinate | None
    where: str


@dataclass(frozen=True)
class Scale:
    """Scale of a column: its unit, empty where it names none, or dB relative to so many of it."""

    part: Part
    unit: str
    where: str
    decibels: bool = False
    size: float = 1.0

    def applied(self, column: np.ndarray, default: str) -> np.ndarray:
        """Values in SI; ``default`` is the unit where the column names none."""
        with np.errstate(over="ignore"):
            amount = 10 ** (column / 20) if self.decibels else column
            return self.size * amount * ordinate(self.unit or default)[1]

    def shown(self, default: str) -> str:
        """Name of the unit."""
        unit = self.unit or default
        return f"dB relative to {self.size:g} {unit}" if self.decibels else unit


def read_frf_table(file: Path, *, given: Ordinate | None = None, unit: str = "") -> Curve:
    """FRF from a text table.

    Parameters
    ----------
    file : path
    given : what the values are, where the table does not say
    unit : of the values, where the table does not say

    Raises
    ------
    ModalError
        If a column is none of an FRF's, a part of it is missing, or names, units and options contradict one another.
    TableError
        If the file is no table of numbers.
    """
    table = read_table(file)
    heads = {head.part: (head, table.values[:, k]) for k, head in enumerate(_heads(table))}
    head, frequency = heads[Part.FREQUENCY]
    frequency = frequency * _read(hertz, head.unit or "Hz", head.where)
    scales = [_scale(head) for part, (head, _) in heads.items() if part not in (Part.FREQUENCY, Part.PHASE)]
    kind, default = _kind_and_unit([(head.given, head.where) for head, _ in heads.values()], scales, given, unit)
    values = [scale.applied(heads[scale.part][1], default) for scale in scales]
    if Part.PHASE in heads:
        head, phase = heads[Part.PHASE]
        with np.errstate(invalid="ignore"):  # what is too large is refused with its line
            complex_values = values[0] * np.exp(1j * _radians(head) * phase)
    else:
        parts = dict(zip([scale.part for scale in scales], values, strict=True))
        complex_values = parts[Part.REAL] + 1j * parts[Part.IMAGINARY]
    curve = Curve.of(frequency, complex_values, kind, lambda k: f"{file}:{table.lines[k]}")
    return curve.described(f"{kind} in {scales[0].shown(default)}")


def _heads(table: TextTable) -> list[Head]:
    """Heads of the columns; every part of an FRF once."""
    line = table.header_line or int(table.lines[0])
    if not table.columns:
        if table.values.shape[1] != 3:
            raise ModalError(
                f"{table.file}:{line}: {table.values.shape[1]} columns without names: name them, as {EXAMPLE}"
            )
        return [Head(part, "", None, f"{table.file}:{line}") for part in (Part.FREQUENCY, Part.REAL, Part.IMAGINARY)]
    heads = [_head(column, f"{table.file}:{line}: column '{column}'") for column in table.columns]
    parts = [head.part for head in heads]
    for k, part in enumerate(parts):
        if part in parts[:k]:
            raise ModalError(f"{heads[k].where}: is a second {part}: write each FRF to its own file")
    if {*parts} - {Part.FREQUENCY} not in CHOICES or Part.FREQUENCY not in parts:
        found = ", ".join(parts)
        raise ModalError(
            f"{table.file}:{line}: an FRF has a frequency and two parts, real and imaginary or magnitude and phase; "
            f"there are {found}: name the columns as {EXAMPLE}"
        )
    return heads


def _head(column: Column, where: str) -> Head:
    words, unit = re.findall(r"[^\W\d_]+\d*", column.name.lower()), column.unit
    if unit.lower() in FILLING:  # Re(H)
        unit = ""
    if words[-2:] == ["rad", "s"]:
        words, unit = words[:-2], unit or "rad/s"
    if words and words[-1] in UNITS_IN_NAMES:
        unit = unit or words[-1]
        words = words[:-1] if len(words) > 1 else [_meant_by(words[0])]
    parts = {_PART[word] for word in words if word in _PART} | ({Part.MAGNITUDE} if "|" in column.name else set())
    given = {_GIVEN[word] for word in words if word in _GIVEN}
    unknown = [word for word in words if word not in {*_PART, *_GIVEN, *FILLING, *ANGULAR}]
    if unknown or len(parts) != 1 or len(given) > 1:
        raise ModalError(f"{where}: is no part of an FRF: leave it out, or name it as in {EXAMPLE}")
    (part,) = parts
    if part is Part.FREQUENCY and ANGULAR & {*words}:
        unit = unit or "rad/s"
        if "hz" in unit.lower():
            raise ModalError(f"{where}: says rad/s by its name and {unit} by its unit: mend one")
    return Head(part, unit, next(iter(given), None), where)


def _meant_by(unit: str) -> str:
    """The part that a column called by its unit alone holds, in a word."""
    return {"db": "magnitude", "deg": "phase", "rad": "phase"}.get(unit, "frequency")


def _radians(head: Head) -> float:
    if head.unit.lower() in DEGREES:
        return np.pi / 180
    if head.unit.lower() in RADIANS:
        return 1.0
    raise ModalError(f"{head.where}: say whether it is in deg or rad, as 'Phase [deg]'")


def _scale(head: Head) -> Scale:
    found = _DECIBELS.fullmatch(head.unit)
    if not found:
        return Scale(head.part, head.unit, head.where)
    if head.part is not Part.MAGNITUDE:
        raise ModalError(f"{head.where}: only a magnitude can be in dB")
    return Scale(head.part, found["unit"] or "", head.where, decibels=True, size=float(found["size"] or 1))


def _read(reader, unit: str, where: str):
    """Unit as read by ``reader``; an error names its place."""
    try:
        return reader(unit)
    except ValueError as error:
        raise ModalError(f"{where}: {error}") from None


def _kind_and_unit(named, scales: list[Scale], given: Ordinate | None, unit: str) -> tuple[Ordinate, str]:
    """Kind of the values by names, units and options, which must agree, and the unit where a column names none."""
    said = [*named, (given, "the option ordinate")]
    said += [(_read(ordinate, scale.unit, scale.where)[0], scale.where) for scale in scales if scale.unit]
    said += [(_read(ordinate, unit, "the option units")[0], "the option units")] if unit else []
    kind = agreed(said) or Ordinate.ACCELERANCE
    stated = next((scale for scale in scales if scale.unit), None)
    if stated and unit and not np.isclose(ordinate(unit)[1], ordinate(stated.unit)[1], rtol=1e-6):
        raise ModalError(f"{stated.where} says {stated.unit}, but the option units says {unit}: leave it out")
    return kind, stated.unit if stated else unit or SI[kind]
