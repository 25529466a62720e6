"""The configuration: YAML in, validated models out, and errors that name file, line and column."""

from __future__ import annotations

import difflib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import (
    BaseModel,
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
    most_packings: Annotated[StrictInt, Field(ge=FEWEST_PACKINGS, le=100)] = 12

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
        return ConfigError(_printable(f"{path}:{_place(data, parts)}: {said}"))

    @property
    def folder(self) -> Path:
        """Where files that the configuration names are looked for: its own folder."""
        return self._source[0].parent if self._source else Path()

    def line(self, key: str) -> int | None:
        """Line of a dotted key in the file that the configuration came from; None where it does not say it."""
        if self._source is None:
            return None
        data, parts = self._source[1], key.split(".")
        return int(_place(data, parts).split(":")[0]) if len(_keys(data, parts)) == len(parts) else None

    @model_validator(mode="after")
    def _consistent(self):
        named = self.damper.materials()
        own = self.structure.material if self.structure else None
        if own:
            named[f"structure.{self.structure.source}.material"] = own
        for place, name in named.items():
            if name not in self.materials:
                raise ValueError(f"{place}: there is no material '{name}'{_suggestion(name, self.materials)}")
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
        lines = [f"{path}:{_place(data, e['loc'])}: {_explained(e)}" for e in _telling(error.errors(), data)]
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


def _keys(data, loc) -> list:
    """The part of a pydantic location that exists in the YAML tree (unions add names of their own)."""
    keys, node = [], data
    for part in loc:
        if isinstance(node, dict) and part in node:
            node = node[part]
            keys.append(part)
        elif isinstance(node, list) and isinstance(part, int) and part < len(node):
            node = node[part]
            keys.append(part)
    return keys


def _place(data, loc) -> str:
    """line:column of the innermost key of a location."""
    node, place = data, (0, 0)
    for key in _keys(data, loc):
        place = node.lc.item(key) if isinstance(key, int) else node.lc.key(key)
        node = node[key]
    return f"{place[0] + 1}:{place[1] + 1}"


def _telling(errors, data):
    """The errors worth a line: one a place, the most telling branch of a union, no echo of a misspelt key."""
    best: dict = {}
    for error in errors:
        loc = tuple(part for part in error["loc"] if not _is_union_name(part))
        loc, message = _pointed(loc, error["msg"].removeprefix("Value error, "), data)
        rank = error["type"] in ("list_type", "literal_error")
        if loc not in best or rank < best[loc][0]:
            best[loc] = (rank, error | {"loc": loc, "msg": message})
    misspelt = {
        (*loc[:-1], _closest(loc[-1], _known_keys(loc[:-1])))
        for loc, (_, error) in best.items()
        if error["type"] == "extra_forbidden"
    }
    return [
        error
        for loc, (_, error) in best.items()
        if not (error["type"] == "missing" and loc in misspelt)
        and not (loc and any(other != loc and other[: len(loc)] == loc for other in best))
    ]


def _pointed(loc, message, data):
    """A model's error that starts with a key of its own ("modes: each mode once") is placed at that key."""
    head, _, rest = message.partition(": ")
    target = (*loc, *(int(key) if key.isdecimal() else key for key in head.split(".")))
    if rest and len(_keys(data, target)) == len(target):
        return target, rest
    return loc, message


def _is_union_name(part) -> bool:
    return isinstance(part, str) and ("[" in part or part in ("float", "int", "list"))


def _explained(error) -> str:
    key = ".".join(str(part) for part in error["loc"])
    kind, given = error["type"], error.get("input")
    if kind == "extra_forbidden":
        return f"{key}: unknown key{_suggestion(error['loc'][-1], _known_keys(error['loc'][:-1]))}"
    if kind == "missing":
        return f"{key}: missing"
    message = error["msg"]
    if kind == "literal_error":
        message = f"'{given}' is not one of {error['ctx']['expected']}"
    elif kind in ("model_type", "dict_type"):
        message = f"expected keys below it, got {given!r}"
    elif kind in ("tuple_type", "list_type"):
        message = f"expected a list, as [a, b], got {given!r}"
    elif kind != "value_error":
        message = f"{message[0].lower()}{message[1:]}, got {given!r}"
    return f"{key}: {message}" if key else message


def _known_keys(loc) -> list[str]:
    """Keys allowed at a location, from the models' own fields."""
    model: Any = Config
    for part in loc:
        field = model.model_fields.get(part)
        if field:  # otherwise an item of a list, or a name of the user's own
            model = next(_models(field.annotation), model)
    return list(model.model_fields)


def _models(annotation) -> Iterator[type[BaseModel]]:
    """The models that an annotation is made of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models(part)


def _closest(name, known) -> str | None:
    return next(iter(difflib.get_close_matches(str(name), list(known), n=1)), None)


def _suggestion(name, known) -> str:
    close = _closest(name, known)
    return f"; did you mean '{close}'?" if close else f"; choose from {', '.join(known)}"
