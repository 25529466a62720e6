"""The ``coupled`` section of the configuration: a force on the structure, the motion of its base, or its release."""

from __future__ import annotations

import itertools
import re
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field, StrictInt, WithJsonSchema, model_validator

from ..scene.gravity import STANDARD_GRAVITY
from .base import POSITIVE, Model
from .messages import suggestion
from .quantities import Frequency, Number, Time, quantity, to_si
from .spectra import SPECTRA, WITHOUT_BREAKPOINTS

Newtons = Annotated[quantity("N"), POSITIVE]
Hertz = Annotated[Frequency, POSITIVE]
Gamma = Annotated[Number, POSITIVE]
Seed = Annotated[StrictInt, Field(ge=0)]

_IN_G = re.compile(r"^(.*?)\s*[gG](?:\^2|\*\*2|²|2)\s*/\s*Hz\s*$")


def _acceleration_density(value: Any) -> float:
    """A density in g^2/Hz (g, not gram), or as any other quantity, in (m/s^2)^2/Hz."""
    in_g = _IN_G.match(value) if isinstance(value, str) else None
    if in_g:
        return to_si(in_g[1], "") * STANDARD_GRAVITY**2
    try:
        return to_si(value, "m^2/s^3")
    except ValueError as error:
        raise ValueError(f"{error}, which is (m/s^2)^2/Hz, or in g^2/Hz") from None


AccelerationDensity = Annotated[
    float,
    BeforeValidator(_acceleration_density),
    POSITIVE,
    WithJsonSchema({"type": ["number", "string"], "description": "'0.04 g^2/Hz', or a number in (m/s^2)^2/Hz"}),
]
ForceDensity = Annotated[quantity("N^2/Hz"), POSITIVE]
Breakpoints = list[tuple[Hertz, AccelerationDensity]]


def _named(value: Any) -> Any:
    """Breakpoints of a spectrum that is called by its name."""
    if not isinstance(value, str):
        return value
    for name, said in WITHOUT_BREAKPOINTS.items():
        if name.fullmatch(value.strip()) and value not in SPECTRA:
            raise ValueError(f"'{value}': {said} copy another one from the standard: give {_SHOWN}")
    if value not in SPECTRA:
        raise ValueError(f"there is no spectrum '{value}'{suggestion(value, SPECTRA)}; or give {_SHOWN}")
    return [[frequency, f"{density} g^2/Hz"] for frequency, density in SPECTRA[value].breakpoints]


def _no_name(value: Any) -> Any:
    if isinstance(value, str):
        raise ValueError(f"'{value}' is of no force: named spectra are of a base's acceleration (base); {_OF_FORCE}")
    return value


_SHOWN = "its breakpoints, as [[20 Hz, 0.01 g^2/Hz], [80 Hz, 0.04 g^2/Hz]]"
_OF_FORCE = "give breakpoints, as [[20 Hz, 0.01 N^2/Hz], [80 Hz, 0.04 N^2/Hz]]"


def _rising(table: list[tuple[float, float]]) -> None:
    if any(low >= high for (low, _), (high, _) in itertools.pairwise(table)):
        raise ValueError("spectrum: give its breakpoints in the order of their frequencies, each once")


class Band(Model):
    """Frequency band [Hz]."""

    model_config = ConfigDict(populate_by_name=True)

    from_: Hertz = Field(alias="from")
    """Frequency at its start."""
    to: Hertz
    """Frequency at its end."""


class HarmonicConfig(Model):
    """Harmonic force A sin(2 pi f t)."""

    amplitude: Newtons
    """Amplitude of the force."""
    frequency: Hertz
    """Frequency of the force."""


class SweptConfig(Band):
    """Swept sine: its frequency changes at a constant rate, up or down, over the whole run."""

    amplitude: Newtons
    """Amplitude of the force."""


class RandomConfig(Model):
    """Random force: normal noise, equal for equal seeds, flat in a band or of a power spectral density [N^2/Hz]."""

    model_config = ConfigDict(populate_by_name=True)

    rms: Newtons | None = None
    """Root mean square of the force, flat from ``from`` to ``to``."""
    from_: Hertz | None = Field(None, alias="from")
    """Lowest frequency of the band."""
    to: Hertz | None = None
    """Highest frequency of the band."""
    spectrum: Annotated[list[tuple[Hertz, ForceDensity]], BeforeValidator(_no_name), Field(min_length=2)] | None = None
    """Breakpoints of a power spectral density, [frequency, density], straight on logarithmic scales."""
    seed: Seed = 1
    """Seed of the noise."""

    @model_validator(mode="after")
    def _one_kind(self):
        given = [name for name in ("rms", "from", "to") if getattr(self, "from_" if name == "from" else name)]
        if self.spectrum and given:
            raise ValueError(f"spectrum: says all that {' and '.join(given)} would: give one of the two")
        if not self.spectrum and len(given) < 3:
            raise ValueError("give rms, from and to, or a spectrum")
        if self.spectrum:
            _rising(self.spectrum)
        elif self.to <= self.from_:
            raise ValueError("to: must be above from")
        return self


class RecordedConfig(Model):
    """Recorded signal: a text table, evenly spaced from time 0, with the column time_s, and force_N or an acceleration.

    The acceleration of a base is called acceleration_m_s2 or acceleration_g, of 9.80665 m/s^2.  Other units are written
    into the names or behind them, as time_ms or force [lbf].  After the record there is nothing more.
    """

    file: str
    """Text table beside the configuration, with units in its head."""


class BaseAmplitude(Model):
    """Acceleration amplitude gamma g of a base."""

    gamma: Gamma
    """Acceleration amplitude of the base over g."""

    @property
    def amplitude(self) -> float:
        """Amplitude of the acceleration [m/s^2]."""
        return self.gamma * STANDARD_GRAVITY


class BaseHarmonicConfig(BaseAmplitude):
    """Acceleration gamma g sin(2 pi f t) of the base."""

    frequency: Hertz
    """Frequency of the motion."""


class BaseSweptConfig(BaseAmplitude, Band):
    """A sine whose frequency goes from one to the other at a constant rate; acceleration amplitude gamma g."""


class BaseRandomConfig(Model):
    """Normal noise of a power spectral density: breakpoints in g^2/Hz, or the name of a standard's.

    Here and in gamma g is 9.81 m/s^2, as everywhere in the package; in files that have g as a unit it is standard
    gravity, 9.80665 m/s^2.
    """

    spectrum: Annotated[
        Breakpoints,
        BeforeValidator(_named, json_schema_input_type=Breakpoints | Literal[*SPECTRA]),
        Field(min_length=2),
    ]
    """Breakpoints of a power spectral density, [frequency, density], or the name of a standard's."""
    seed: Seed = 1
    """Seed of the noise."""

    @model_validator(mode="after")
    def _in_order(self):
        _rising(self.spectrum)
        return self


class ReleaseConfig(Model):
    """Release at rest from where free vibration of one mode would have the acceleration amplitude gamma g."""

    gamma: Gamma
    """Acceleration amplitude over g at the damper."""
    mode: Annotated[StrictInt, Field(ge=1)]
    """Number of the mode."""


SIGNALS = ("harmonic", "swept", "random", "recorded")


def _one_of(model: Model, names: tuple[str, ...]) -> None:
    given = [name for name in names if getattr(model, name) is not None]
    if len(given) != 1:
        said = f"{', '.join(names[:-1])} and {names[-1]}"
        raise ValueError(f"give exactly one of {said}; got {' and '.join(given) or 'none of them'}")


class BaseConfig(Model):
    """How the base that holds the structure moves, along the direction of the excitation."""

    harmonic: BaseHarmonicConfig | None = None
    """A sine."""
    swept: BaseSweptConfig | None = None
    """A sine of changing frequency."""
    random: BaseRandomConfig | None = None
    """Normal noise."""
    recorded: RecordedConfig | None = None
    """A signal from a file."""

    @model_validator(mode="after")
    def _one_signal(self):
        _one_of(self, SIGNALS)
        return self


class CoupledConfig(Model):
    """Coupled runs, in which the structure answers: exactly one force, the motion of its base, or a release.

    ``levels`` multiply the force, the base's acceleration, or the release: a run each.
    """

    duration: Annotated[Time, POSITIVE]
    """Length of each run."""
    harmonic: HarmonicConfig | None = None
    """Harmonic force at the damper."""
    swept: SweptConfig | None = None
    """Swept force at the damper."""
    random: RandomConfig | None = None
    """Random force at the damper."""
    recorded: RecordedConfig | None = None
    """Force at the damper from a file."""
    base: BaseConfig | None = None
    """Motion of the structure's base."""
    release: ReleaseConfig | None = None
    """Release at rest, deflected in one mode."""
    levels: Annotated[list[Annotated[Number, POSITIVE]], Field(min_length=1)] = [1.0]  # noqa: RUF012 - frozen
    """Multiples of the force, of the base's acceleration, or of the release; a run each."""

    @property
    def signals(self) -> CoupledConfig | BaseConfig:
        """Where the signal that moves the structure stands: beside ``base``, or in it."""
        return self.base or self

    @property
    def source(self) -> str:
        """Key that says what moves the structure, as ``release`` or ``base.harmonic``."""
        names = (*SIGNALS, "release") if self.base is None else SIGNALS
        key = next(name for name in names if getattr(self.signals, name) is not None)
        return key if self.base is None else f"base.{key}"

    @model_validator(mode="after")
    def _one_source(self):
        _one_of(self, (*SIGNALS, "base", "release"))
        if len(set(self.levels)) < len(self.levels):
            raise ValueError("levels: each level once")
        return self
