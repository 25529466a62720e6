"""The ``coupled`` section of the configuration: a force on the structure, or its release."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field, StrictInt, model_validator

from .base import POSITIVE, Model
from .quantities import Frequency, Number, Time, quantity

Newtons = Annotated[quantity("N"), POSITIVE]
Hertz = Annotated[Frequency, POSITIVE]


class Band(Model):
    """Frequency band [Hz]."""

    model_config = ConfigDict(populate_by_name=True)

    from_: Hertz = Field(alias="from")
    to: Hertz


class HarmonicConfig(Model):
    """Harmonic force A sin(2 pi f t)."""

    amplitude: Newtons
    frequency: Hertz


class SweptConfig(Band):
    """Swept sine: its frequency changes at a constant rate, up or down, over the whole run."""

    amplitude: Newtons


class RandomConfig(Band):
    """Random force: normal noise with a flat spectrum in a band; equal for equal seeds."""

    rms: Newtons
    seed: Annotated[StrictInt, Field(ge=0)] = 1

    @model_validator(mode="after")
    def _rising(self):
        if self.to <= self.from_:
            raise ValueError("to: must be above from")
        return self


class RecordedConfig(Model):
    """Recorded force: a CSV file with the columns time_s and force_N, evenly spaced from time 0."""

    file: str


class ReleaseConfig(Model):
    """Release at rest from where free vibration of one mode would have the acceleration amplitude gamma g."""

    gamma: Annotated[Number, POSITIVE]
    mode: Annotated[StrictInt, Field(ge=1)]


FORCES = ("harmonic", "swept", "random", "recorded")


class CoupledConfig(Model):
    """Coupled runs, in which the structure answers: exactly one force, or a release.

    ``levels`` multiply the force, or the release: a run each.
    """

    duration: Annotated[Time, POSITIVE]
    harmonic: HarmonicConfig | None = None
    swept: SweptConfig | None = None
    random: RandomConfig | None = None
    recorded: RecordedConfig | None = None
    release: ReleaseConfig | None = None
    levels: Annotated[list[Annotated[Number, POSITIVE]], Field(min_length=1)] = [1.0]  # noqa: RUF012 - frozen

    @property
    def source(self) -> str:
        """Key that says what moves the structure."""
        return next(name for name in (*FORCES, "release") if getattr(self, name) is not None)

    @model_validator(mode="after")
    def _one_source(self):
        given = [name for name in (*FORCES, "release") if getattr(self, name) is not None]
        if len(given) != 1:
            names = f"{', '.join(FORCES)} and release"
            raise ValueError(f"give exactly one of {names}; got {' and '.join(given) or 'none of them'}")
        if len(set(self.levels)) < len(self.levels):
            raise ValueError("levels: each level once")
        return self
