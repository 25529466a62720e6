"""The whole configuration as one validated model, whose errors name file, line and column."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    PrivateAttr,
    StrictInt,
    ValidationError,
    field_validator,
    model_validator,
)

from ..errors import ConfigError, printable
from ..numerics.limits import FEWEST_PACKINGS, FEWEST_STEPS_PER_CONTACT, STEPS_PER_CONTACT
from ..scene.effects import Device
from ..scene.materials import LIBRARY
from .base import POSITIVE as _positive
from .base import Model
from .coupled import CoupledConfig
from .damper import WALLS, ContactConfig, DamperConfig, EffectsConfig, ExcitationConfig, MaterialConfig, between
from .design import DesignConfig
from .library import COMMAND, written_out
from .messages import closest, is_union_name, keys, place, suggestion
from .preparation import (
    PreparationConfig,
    Word,
    carried_path,
    check_preparation,
    made_with,
    read_preparation,
    while_made,
)
from .quantities import Number, Time
from .structure import FurtherDamperConfig, StructureConfig, check_further
from .sweep import SweepConfig


class SteadyConfig(Model):
    """End of a case.  ``paper``: fixed times, 0.2 s of settling and 0.3 s of shaking, for comparison."""

    recipe: Literal["detect", "paper"] = "detect"
    """``detect``: until steady; ``paper``: 0.2 s of settling and 0.3 s of shaking, for comparison."""
    standard_error: Annotated[Number, _positive] = 0.02
    """Relative standard error of the energy per cycle at which a case may end."""
    fewest_cycles: Annotated[StrictInt, Field(ge=8)] = 30
    """Cycles that a case runs at least."""
    most_cycles: Annotated[StrictInt, Field(ge=8)] = 1000
    """Cycles after which a case ends, whether it is steady or not; its status says which."""

    @model_validator(mode="after")
    def _ordered(self):
        if self.most_cycles < self.fewest_cycles:
            raise ValueError(f"most_cycles: is below fewest_cycles ({self.fewest_cycles})")
        return self


class AccuracyConfig(Model):
    """Accuracy asked for; the step, the length of each case and the packings of a point follow from it.

    ``tolerance`` is the standard error of the energy per cycle with all its parts.
    """

    tolerance: Annotated[Number, Field(gt=0, le=0.5)]
    """Relative standard error wanted of the energy per cycle, all its parts together."""
    most_packings: Annotated[StrictInt, Field(ge=FEWEST_PACKINGS, le=100)] = 32
    """Packings that a point may be given, at most."""

    @model_validator(mode="before")
    @classmethod
    def _preset(cls, value):
        if not isinstance(value, str):
            return value
        if value not in PRESETS:
            raise ValueError(f"'{value}' is not one of {', '.join(PRESETS)}; or give tolerance: 2 %")
        return dict(PRESETS[value])


class NumericsConfig(Model):
    """Precision and step of the motion, and the device that computes it."""

    device: Device = "cpu"
    """Device that simulates; one that this machine lacks is refused."""
    precision: Literal["float64", "float32"] = "float64"
    """Of the motion; the ledger is always of float64."""
    steps_per_contact: Annotated[Number, Field(ge=FEWEST_STEPS_PER_CONTACT)] = float(STEPS_PER_CONTACT)
    """Steps in the shortest contact expected; the step divides the period."""
    step: Literal["auto"] | Annotated[Time, _positive] = "auto"
    """Length of a step; ``auto``: from ``steps_per_contact``."""


class Config(Model):
    """Study: a damper, its excitation, and the structure it sits on."""

    title: str = "Granular damper"
    """Title of pictures and results."""
    structure: StructureConfig | None = None
    """The structure that the damper sits on; without it there is effectiveness, but no modal damping."""
    damper: DamperConfig
    """The damper: a cavity and what is in it."""
    dampers: list[FurtherDamperConfig] = Field([])
    """Further dampers on the same structure."""
    materials: Annotated[
        dict[Annotated[str, Field(pattern="^[A-Za-z][A-Za-z0-9_-]*$")], MaterialConfig], Field(min_length=1)
    ]
    """Materials by names of your own; names of the library (``warpdamp materials``) need not be here."""
    contact: ContactConfig
    """What happens where particles touch each other and the walls; what the library knows may be left out."""
    excitation: ExcitationConfig
    """How the cavity is shaken."""
    preparation: Word | PreparationConfig = "compacted"
    """State of the bed before a case: ``loose`` as poured, ``compacted``, ``carried``, or a state asked for."""
    steady_state: SteadyConfig = SteadyConfig()
    """When a case ends."""
    accuracy: AccuracyConfig | None = None
    """Accuracy asked for, in a word or as a tolerance: step, length of cases and packings follow from it."""
    effects: EffectsConfig = EffectsConfig()
    """Effects forced on or off."""
    numerics: NumericsConfig = NumericsConfig()
    """Precision and step."""
    seeds: list[Annotated[StrictInt, Field(ge=0)]] = Field([1], min_length=1)
    """A random packing for each."""

    sweep: SweepConfig | None = None
    """Scalars, by their paths, that take several values."""
    coupled: CoupledConfig | None = None
    """Runs in which the structure answers, of ``warpdamp coupled``."""
    design: DesignConfig | None = None
    """What a damper is to be designed for, of ``warpdamp design``."""

    _source: tuple[Path, Any] | None = PrivateAttr(default=None)

    @model_validator(mode="before")
    @classmethod
    def _from_the_library(cls, values):
        return written_out(values) if isinstance(values, dict) else values

    @field_validator("preparation", mode="wrap")
    @classmethod
    def _word_or_state(cls, value, _):
        return read_preparation(value)

    def error(self, key: str | tuple, message: str) -> ConfigError:
        """Error at a key (dotted, or as a tuple), with file, line and column if the configuration has a file."""
        parts = tuple(key.split(".")) if isinstance(key, str) else key
        text = f"{'.'.join(map(str, parts))}: {message}"
        if self._source is None:
            return ConfigError(text)
        path, data = self._source
        return ConfigError(printable(f"{path}:{place(data, parts)}: {text}"))

    @property
    def folder(self) -> Path:
        """Folder in which files that the configuration names are looked for: its own."""
        return self._source[0].parent if self._source else Path()

    def line(self, key: str) -> int | None:
        """Line of a dotted key in the configuration's file; None if the file does not contain it."""
        if self._source is None:
            return None
        data, parts = self._source[1], key.split(".")
        return int(place(data, parts).split(":")[0]) if len(keys(data, parts)) == len(parts) else None

    @model_validator(mode="after")
    def _consistent(self):
        named = self.damper.materials()
        for k, damper in enumerate(self.dampers):
            named |= damper.materials(f"dampers.{k}")
        material = self.structure.material if self.structure else None
        if material:
            named[f"structure.{self.structure.source}.material"] = material
        for where, name in named.items():
            if name not in self.materials:
                known = [*self.materials, *LIBRARY]
                close = suggestion(name, known) if closest(name, known) else f": define it under materials; {COMMAND}"
                raise ValueError(f"{where}: there is no material '{name}'{close}")
        for name in self.materials:
            if name not in named.values():
                raise ValueError(f"materials.{name}: is not used by anything: leave it out")
        if material and any(isinstance(value, list) for value in vars(self.materials[material]).values()):
            raise ValueError(f"structure.{self.structure.source}.material: the structure's material cannot be swept")
        if self.excitation.frequency == "modes" and not self.structure:
            raise ValueError("excitation.frequency: 'modes' needs a structure; give frequencies, as [46 Hz, 100 Hz]")
        gravities = self.excitation.gravity if isinstance(self.excitation.gravity, list) else [self.excitation.gravity]
        if len(set(self.seeds)) < len(self.seeds):
            raise ValueError("seeds: each seed once")
        self._check_dampers()
        self._check_design()
        self._check_rotation()
        grains = [p.material for damper in (self.damper, *self.dampers) for p in damper.mixture]
        for key in self.contact.pairs:
            for name in between(key):
                if name != WALLS and name not in grains:
                    raise ValueError(f"contact.pairs.{key}: there are no particles of '{name}'")
        cavities = {"damper": self.damper} | {f"dampers.{k}": damper for k, damper in enumerate(self.dampers)}
        for cavity, damper in cavities.items():
            for name, missing in damper.enclosure.open_towards(self.excitation.gravity_direction).items():
                if missing and 0 not in gravities:
                    raise ValueError(
                        f"{cavity}.enclosure.{name}: gravity draws the particles out where there is no {name}"
                    )
        check_preparation(self.preparation, cavities, gravities)
        if made_with(self.preparation):
            self.while_made()
        if self.steady_state.recipe == "paper" and self.preparation != "loose":
            raise ValueError("steady_state.recipe: the paper's recipe starts from a loose bed; set preparation: loose")
        return self

    def while_made(self) -> Config:
        """The configuration that beds are made with: this one, but for what ``preparation.made_with`` says."""
        if not made_with(self.preparation):
            return self
        try:
            return Config.model_validate(while_made(self.model_dump(), self.preparation))
        except ValidationError as error:
            first = error.errors()[0]
            key = ".".join(("preparation.made_with", *(str(part) for part in first["loc"] if not is_union_name(part))))
            message = first["msg"].removeprefix("Value error, ")
            raise ValueError(f"{key}: {message[:1].lower()}{message[1:]}") from None

    def _check_design(self):
        """One damper, on a structure, is looked for at the structure's modes."""
        if not self.design:
            return
        if not self.structure:
            raise ValueError("design: a damper is designed for a structure: say which, under structure")
        for other in ("dampers", "sweep"):
            if getattr(self, other):
                raise ValueError(f"{other}: is not for a design, which has one damper and variables of its own")
        if self.excitation.frequency != "modes":
            raise ValueError("excitation.frequency: a design is for the structure's modes: leave it out")
        if self.preparation == "carried" or carried_path(self.preparation):
            raise ValueError("preparation: a design takes loose or compacted beds, not carried ones")
        wanted, there = self.design.target.modes, self.structure.modes
        if wanted and there and not set(wanted) <= set(there):
            raise ValueError(f"design.target.modes: are not all among structure.modes ({', '.join(map(str, there))})")

    def _check_rotation(self):
        """Spheroids turn: without it their contacts would do work that no energy knows of."""
        if self.effects.rotation is False and any(damper.spheroids for damper in (self.damper, *self.dampers)):
            raise ValueError("effects.rotation: spheroids turn whatever they touch: leave it out, or take spheres")

    def _check_dampers(self):
        """Several dampers sit on one structure, and are shaken at its modes as hard as each one's place moves."""
        if not self.dampers:
            return
        if not self.structure:
            raise ValueError("dampers: several dampers need a structure that they sit on")
        for k, damper in enumerate(self.dampers):
            check_further(self.structure, f"dampers.{k}", damper)
        if self.excitation.frequency != "modes":
            raise ValueError("excitation.frequency: several dampers are shaken at the structure's modes: leave it out")
        if self.sweep:
            raise ValueError("sweep: is for one damper: run one combination of several dampers at a time")
        if carried_path(self.preparation):
            raise ValueError("preparation: 'carried' is for one damper: several take loose or compacted beds")


PRESETS = {
    "fast": {"tolerance": 0.05},
    "balanced": {"tolerance": 0.02, "most_packings": 48},
    "reference": {"tolerance": 0.01, "most_packings": 100},
}
"""Accuracies by name; their settings and errors are in docs/accuracy.md.  Single packings of the paper's damper differ
by 8.5 % in mode 1 (root mean square over Gamma 1.5 to 14, docs/two_optima.md): 18 packings for 2 %, 72 for 1 %."""
