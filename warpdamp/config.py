"""The configuration: YAML in, validated models out, and errors that name file, line and column."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    PrivateAttr,
    StrictInt,
    ValidationError,
    model_validator,
)

from .config_coupled import CoupledConfig
from .config_damper import (
    WALLS,
    ContactConfig,
    DamperConfig,
    EffectsConfig,
    ExcitationConfig,
    MaterialConfig,
    between,
)
from .config_errors import explained, keys, place, suggestion, telling
from .config_sweep import SweepConfig
from .fields import POSITIVE as _positive
from .fields import Model
from .structure import StructureConfig
from .tolerance import FEWEST_PACKINGS, PRESETS
from .units import Number, Time


class ConfigError(ValueError):
    """What is wrong with a configuration: one line an error, each with its place."""


class SteadyConfig(Model):
    """When a case is done.  ``paper``: fixed times, 0.2 s of settling and 0.3 s of shaking, for comparison."""

    recipe: Literal["detect", "paper"] = "detect"
    standard_error: Annotated[Number, _positive] = 0.02
    fewest_cycles: Annotated[StrictInt, Field(ge=8)] = 30
    most_cycles: Annotated[StrictInt, Field(ge=8)] = 1000

    @model_validator(mode="after")
    def _ordered(self):
        if self.most_cycles < self.fewest_cycles:
            raise ValueError(f"most_cycles: is below fewest_cycles ({self.fewest_cycles})")
        return self


class AccuracyConfig(Model):
    """Accuracy bought: the runner chooses the step, how long each case runs, and how many packings a point gets.

    ``tolerance`` is the standard error of the energy per cycle with all its parts.
    """

    tolerance: Annotated[Number, Field(gt=0, le=0.5)]
    most_packings: Annotated[StrictInt, Field(ge=FEWEST_PACKINGS, le=100)] = 32

    @model_validator(mode="before")
    @classmethod
    def _preset(cls, value):
        if not isinstance(value, str):
            return value
        if value not in PRESETS:
            raise ValueError(f"'{value}' is not one of {', '.join(PRESETS)}; or give tolerance: 2 %")
        return {"tolerance": PRESETS[value]}


class NumericsConfig(Model):
    """Precision and step of the motion."""

    precision: Literal["float64", "float32"] = "float64"
    steps_per_contact: Annotated[Number, Field(ge=10)] = 24.0
    step: Literal["auto"] | Annotated[Time, _positive] = "auto"


class Config(Model):
    """A study: a damper, how it is shaken, and the structure it sits on."""

    title: str = "Granular damper"
    structure: StructureConfig | None = None
    damper: DamperConfig
    materials: Annotated[
        dict[Annotated[str, Field(pattern="^[A-Za-z][A-Za-z0-9_-]*$")], MaterialConfig], Field(min_length=1)
    ]
    contact: ContactConfig
    excitation: ExcitationConfig
    preparation: Literal["loose", "compacted", "carried"] = "compacted"
    steady_state: SteadyConfig = SteadyConfig()
    accuracy: AccuracyConfig | None = None
    effects: EffectsConfig = EffectsConfig()
    numerics: NumericsConfig = NumericsConfig()
    seeds: list[Annotated[StrictInt, Field(ge=0)]] = Field([1], min_length=1)

    sweep: SweepConfig | None = None
    coupled: CoupledConfig | None = None

    _source: tuple[Path, Any] | None = PrivateAttr(default=None)

    def error(self, key: str | tuple, message: str) -> ConfigError:
        """An error at a key (dotted, or as a tuple), with file, line and column where the configuration has a file."""
        parts = tuple(key.split(".")) if isinstance(key, str) else key
        said = f"{'.'.join(map(str, parts))}: {message}"
        if self._source is None:
            return ConfigError(said)
        path, data = self._source
        return ConfigError(_printable(f"{path}:{place(data, parts)}: {said}"))

    @property
    def folder(self) -> Path:
        """Where files that the configuration names are looked for: its own folder."""
        return self._source[0].parent if self._source else Path()

    def line(self, key: str) -> int | None:
        """Line of a dotted key in the file that the configuration came from; None where it does not say it."""
        if self._source is None:
            return None
        data, parts = self._source[1], key.split(".")
        return int(place(data, parts).split(":")[0]) if len(keys(data, parts)) == len(parts) else None

    @model_validator(mode="after")
    def _consistent(self):
        named = self.damper.materials()
        own = self.structure.material if self.structure else None
        if own:
            named[f"structure.{self.structure.source}.material"] = own
        for where, name in named.items():
            if name not in self.materials:
                raise ValueError(f"{where}: there is no material '{name}'{suggestion(name, self.materials)}")
        for name in self.materials:
            if name not in named.values():
                raise ValueError(f"materials.{name}: is not used by anything")
        if own and any(isinstance(value, list) for value in vars(self.materials[own]).values()):
            raise ValueError(f"structure.{self.structure.source}.material: the structure's material cannot be swept")
        if self.excitation.frequency == "modes" and not self.structure:
            raise ValueError("excitation.frequency: 'modes' needs a structure; give frequencies, as [46 Hz, 100 Hz]")
        gravities = self.excitation.gravity if isinstance(self.excitation.gravity, list) else [self.excitation.gravity]
        if self.preparation == "compacted" and 0 in gravities:
            raise ValueError("preparation: a bed cannot be compacted without gravity; set preparation: loose")
        if len(set(self.seeds)) < len(self.seeds):
            raise ValueError("seeds: each seed once")
        grains = [p.material for p in self.damper.mixture]
        for key in self.contact.pairs:
            for name in between(key):
                if name != WALLS and name not in grains:
                    raise ValueError(f"contact.pairs.{key}: there are no particles of '{name}'")
        for name, missing in self.damper.enclosure.open_towards(self.excitation.gravity_direction).items():
            if missing and 0 not in gravities:
                raise ValueError(f"damper.enclosure.{name}: gravity draws the particles out where there is no {name}")
        if self.steady_state.recipe == "paper" and self.preparation != "loose":
            raise ValueError("steady_state.recipe: the paper's recipe starts from a loose bed; set preparation: loose")
        return self


def load(path) -> Config:
    """Read and validate a YAML file.

    Raises
    ------
    ConfigError
        One line for every error: file:line:column: key: what is wrong.
    """
    path = Path(path)
    data = _read(path)
    try:
        config = Config.model_validate(_plain(data))
    except ValidationError as error:
        errors = telling(error.errors(), data, Config)
        lines = [f"{path}:{place(data, e['loc'])}: {explained(e, Config)}" for e in errors]
        raise ConfigError("\n".join(map(_printable, lines))) from None
    config._source = (path, data)
    from .cases import Cases

    Cases(config)  # what is wrong with a sweep is said now
    return config


def resolved_yaml(config: Config) -> str:
    """The configuration with every default filled in, in SI, as YAML."""
    from ruamel.yaml import YAML

    text = io.StringIO()
    yaml = YAML()
    yaml.dump(config.model_dump(mode="json", by_alias=True), text)
    return text.getvalue()


def _printable(line: str) -> str:
    """The line with whatever would break it, or not show, spelt out."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in line)


def _read(path: Path):
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: not YAML: no UTF-8 text (byte {error.start})") from None
    try:
        data = YAML(typ="rt").load(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise ConfigError(_printable(f"{path}:{mark.line + 1}:{mark.column + 1}: not YAML: {error.problem}")) from None
    except (YAMLError, ValueError) as error:
        raise ConfigError(_printable(f"{path}: not YAML: {' '.join(str(error).split())}")) from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path}:1:1: not a warpdamp configuration: expected keys such as 'damper:' at the top level")
    return data


def _plain(node: Any) -> Any:
    """The YAML tree as plain dicts, lists and scalars."""
    if isinstance(node, dict):
        return {str(key): _plain(value) for key, value in node.items()}
    if isinstance(node, list):
        return [_plain(value) for value in node]
    if isinstance(node, bool) or node is None:
        return node
    for kind in (int, float, str):
        if isinstance(node, kind):
            return kind(node)
    return str(node)
