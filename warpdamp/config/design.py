"""The ``design`` section of the configuration: a damper that is looked for."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, StrictInt, model_validator

from .base import POSITIVE, Model
from .quantities import Acceleration, Length, Mass, Number, quantity
from .structure import ModeNumber
from .sweep import Between, Quantity, Scalar

Force = quantity("N")
RANGES = ("gamma", "force", "base")


def _span(kind):
    return tuple[Annotated[kind, POSITIVE], Annotated[kind, POSITIVE]]


class TargetConfig(Model):
    """Performance wanted: a damping ratio of some modes over a range of exactly one of three.

    ``gamma``: acceleration amplitude over g at the damper; ``force``: amplitude of a force at the damper, at resonance;
    ``base``: acceleration amplitude of the structure's base, at resonance.
    """

    damping: Annotated[Number, Field(gt=0, lt=1)] | None = None
    """Damping ratio wanted, with what the bare structure has."""
    modes: Annotated[list[ModeNumber], Field(min_length=1)] | None = None
    """Numbers of the modes that must have it; all of the structure's unless given."""
    gamma: _span(Number) | None = None
    """Range of the acceleration amplitude over g at the damper."""
    force: _span(Force) | None = None
    """Range of the amplitude of a force at the damper, at resonance."""
    base: _span(Acceleration) | None = None
    """Range of the acceleration amplitude of the structure's base, at resonance."""

    @property
    def over(self) -> str:
        """Name of the range: gamma, force or base."""
        return next(name for name in RANGES if getattr(self, name) is not None)

    @model_validator(mode="after")
    def _one_range(self):
        given = [name for name in RANGES if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"give one of {', '.join(RANGES)}, as gamma: [2, 8]; got {' and '.join(given) or 'none'}")
        low, high = getattr(self, given[0])
        if not low < high:
            raise ValueError(f"{given[0]}: the range from {low:g} to {high:g} is empty: give the smaller end first")
        if self.modes and len(set(self.modes)) < len(self.modes):
            raise ValueError("modes: each mode once")
        return self


class Interval(Between):
    """Range of a variable; with ``step``, the values from its lower end on."""

    step: Quantity | None = None
    """Distance of the values, from the lower end on; none for a continuous range."""


class LimitsConfig(Model):
    """What the damper must not exceed.

    ``mass``: of the particles; ``diameter`` and ``height``: the envelope of the cavity; ``force``: amplitude, at the
    frequency of the vibration, of the force of the particles on the structure.
    """

    mass: Annotated[Mass, POSITIVE] | None = None
    """Mass of the particles, at the most."""
    diameter: Annotated[Length, POSITIVE] | None = None
    """Diameter of the cavity, at the most."""
    height: Annotated[Length, POSITIVE] | None = None
    """Height of the cavity, at the most."""
    force: Annotated[Force, POSITIVE] | None = None
    """Amplitude of the particles' force on the structure, at the frequency of the vibration, at the most."""


class BudgetConfig(Model):
    """Where the search ends: cases simulated, or minutes of this command.

    Simulating again what it found comes on top.
    """

    cases: Annotated[StrictInt, Field(ge=20)] | None = None
    """Cases of the search."""
    minutes: Annotated[float, POSITIVE] | None = None
    """Minutes of this command."""

    @model_validator(mode="after")
    def _some(self):
        if self.cases is None and self.minutes is None:
            raise ValueError("give cases: 300, or minutes: 20")
        return self


class DesignConfig(Model):
    """Damper that is looked for; the rest of the configuration says what is fixed, and where ranges begin.

    ``variables``: scalars of the configuration by their paths, as in a sweep; each a range or a list of choices.
    ``minimise``: the mass of the particles that meet the target, or the largest response (accelerance at resonance)
    over the range; ``maximise``: the least damping over the range, instead.
    """

    target: TargetConfig
    """Performance wanted."""
    variables: Annotated[dict[str, Annotated[list[Scalar], Field(min_length=2)] | Interval], Field(min_length=1)]
    """Scalars that are chosen, by their paths as in a sweep: ranges, or lists of choices."""
    limits: LimitsConfig = LimitsConfig()
    """What the damper must not exceed."""
    minimise: Literal["mass", "response"] | None = None
    """The mass of the particles, or the largest response over the range; mass unless given."""
    maximise: Literal["damping"] | None = None
    """The least damping over the range, in place of a mass."""
    confidence: Annotated[Number, Field(ge=0.5, lt=1)] = 0.95
    """Probability of meeting the target that a damper must have to be claimed."""
    budget: BudgetConfig = BudgetConfig(cases=400)
    """Where the search ends."""

    @property
    def goal(self) -> str:
        """What is sought: mass, response or damping."""
        return self.minimise or self.maximise or "mass"

    @model_validator(mode="after")
    def _consistent(self):
        if self.minimise and self.maximise:
            raise ValueError("maximise: one goal at a time: leave minimise or maximise out")
        if self.goal == "mass" and self.target.damping is None:
            raise ValueError("target.damping is missing: the least mass is sought for a damping ratio, as damping: 2 %")
        if self.goal != "mass" and self.target.over != "gamma":
            key = f"target.{self.target.over}"
            raise ValueError(f"{key}: {self.goal} is sought over a range of Gamma: give gamma: [2, 8] instead")
        return self
