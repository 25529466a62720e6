"""A design problem: its variables, and the damper and modes that values of them make."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from pydantic import ValidationError

from ..config.build import grains, particle_mass, scene
from ..config.design import DesignConfig, Interval
from ..config.messages import suggestion
from ..config.study import Config
from ..errors import ConfigError
from ..modal.from_config import modes as structure_modes
from ..modes import Modes
from ..scene.materials import LIBRARY
from ..scene.sphere import sphere_volume
from ..sweep.axes import Path, dotted, leaves, put, tree, tree_copy
from ..sweep.cases import Cases
from ..sweep.reader import Reader

FIXED = ("excitation", "steady_state", "numerics", "accuracy", "seeds", "effects", "title", "preparation")
"""Sections whose scalars are no part of a damper."""

DENSEST, WALL = 0.60, 0.6
"""Packing fraction of compacted beds, 0.60 (1 - 0.6 d / D): within 0.02 of those measured between D/d 3.6 and 8
(docs/bed-states.md)."""

MODE_MASSES = 6
"""Masses of particles at which the modes of a structure are computed; between them they are interpolated."""


@dataclass(frozen=True)
class Variable:
    """Scalar of the configuration that the design chooses: choices, or a range with or without a step.

    Parameters
    ----------
    path : of the scalar
    choices : values to choose from; empty for a range without a step
    low, high : ends of a range
    """

    path: Path
    choices: tuple = ()
    low: float = math.nan
    high: float = math.nan

    @property
    def name(self) -> str:
        """Path as it is written."""
        return dotted(self.path)

    def at(self, part: float):
        """Value at a part of the way through, 0 to 1."""
        if self.choices:
            return self.choices[min(int(part * len(self.choices)), len(self.choices) - 1)]
        return self.low * (self.high / self.low) ** part if self.low > 0 else self.low + (self.high - self.low) * part

    def part(self, value) -> float:
        """The part of the way at which a value lies; the middle of its share for a choice."""
        if self.choices:
            return (self.choices.index(value) + 0.5) / len(self.choices)
        if self.low > 0:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


@dataclass(frozen=True)
class Design:
    """A damper that values of the variables make.

    Parameters
    ----------
    values : of the variables, by path
    config : the whole configuration with them, without its design section
    mass : of the particles [kg]
    """

    values: dict[Path, object]
    config: Config = field(repr=False)
    mass: float

    @property
    def key(self) -> tuple:
        """What tells it from others."""
        return tuple(self.values.values())

    @cached_property
    def cavity(self):
        """Enclosure of the cavity."""
        return self.config.damper.enclosure

    @cached_property
    def radius(self) -> float:
        """Mean radius of the particles [m]."""
        return float(np.mean(grains(self.config).radius))

    @cached_property
    def fill(self) -> float:
        """Volume of the particles over the cavity's."""
        volume = float(np.sum(sphere_volume(np.array(grains(self.config).radius))))
        return volume / (math.pi / 4 * self.cavity.diameter**2 * self.cavity.height)

    @property
    def packing(self) -> float:
        """Packing fraction that a compacted bed is expected to have: less where the wall is near."""
        return DENSEST * (1 - WALL * 2 * self.radius / self.cavity.diameter)

    def clearance(self, packing: float) -> float:
        """Clearance h = L (1 - v / v_max) [m] (eq. 2), v_max the packing fraction of a compacted bed."""
        return self.cavity.height * (1 - self.fill / packing)


class Problem:
    """A design problem read from a configuration.

    Parameters
    ----------
    config : Config
        With a ``design`` section.

    Raises
    ------
    ConfigError
        With file, line and column, if a variable is no scalar of the configuration or takes values that it cannot,
        limits contradict it, or a mode of the target has a node at the damper wherever that may sit.
    """

    def __init__(self, config: Config):
        if config.design is None:
            raise config.error("design", "missing: say what is wanted, under design")
        self.config, self.design = config, config.design
        self._base = tree(config) | {"seeds": [1]}
        self._modes: dict[tuple, tuple[np.ndarray, list[Modes]]] = {}
        self._exact: dict[tuple, Modes] = {}
        varied = [path for axis in Cases(config).axes for path in axis.paths]
        if varied:
            raise config.error(varied[0], "takes one value in a design: make it one of design.variables")
        reader = Reader(config)
        self.variables = [self._variable(reader, key, rule) for key, rule in self.design.variables.items()]
        self._check_limits()

    @property
    def target(self):
        """What is wanted."""
        return self.design.target

    def error(self, key: str, message: str) -> ConfigError:
        """Error at a key below ``design``."""
        return self.config.error(("design", *key.split(".")), message)

    def _variable(self, reader: Reader, key: str, rule) -> Variable:
        place = ("design", "variables", key)
        path, values = reader.condition(key, rule, place)
        if path[0] in FIXED:
            raise self.config.error(place, f"{dotted(path)} is no part of a damper or of its place")
        if not isinstance(rule, Interval):
            if len(set(values)) < len(values):
                raise self.config.error(place, "each choice once")
            for value in values:
                self._check_word(path, value, place)
            return Variable(path, tuple(values))
        low, high = values.from_, values.to
        if isinstance(low, str) or isinstance(high, str) or not low < high:
            raise self.config.error(place, f"the range from {low} to {high} is empty: give the smaller end first")
        step = rule.step
        if step is None and isinstance(low, int) and isinstance(high, int):
            step = 1
        if step is None:
            if path[0] == "structure":
                raise self.config.error(place, "modes are found anew at every place: give a step, or a list of choices")
            return Variable(path, (), low, high)
        size = step if isinstance(low, int) and isinstance(step, int) else self._step(reader, path, step, place)
        if not 0 < size <= high - low:
            raise self.config.error(place, f"a step of {size:g} is not positive, or longer than the range")
        count = int((high - low) / size * (1 + 1e-12)) + 1
        values = (low + k * size for k in range(count))
        return Variable(path, tuple(v if isinstance(v, int) else float(f"{v:.12g}") for v in values))

    def _check_word(self, path: Path, value, place) -> None:
        """Refuse a word, as of a material, with which the configuration cannot be."""
        if not isinstance(value, str):
            return
        known = [*self.config.materials, *LIBRARY]
        if path[-1] == "material" and value not in known:
            raise self.config.error(place, f"there is no material '{value}'{suggestion(value, known)}")
        try:
            self.configured({path: value})
        except ValidationError as error:
            said = error.errors()[0]["msg"].removeprefix("Value error, ")
            raise self.config.error(place, f"with {value}: {said}") from None

    def _step(self, reader: Reader, path: Path, step, place) -> float:
        value = reader.condition(dotted(path), [step], place)[1][0]
        return float(value)

    def _check_limits(self) -> None:
        limits = self.design.limits
        for name in ("diameter", "height"):
            limit, least = getattr(limits, name), self._least(("damper", "enclosure", name))
            if limit is not None and least > limit:
                raise self.error(f"limits.{name}", f"{limit:g} m, and the cavity is never less than {least:g} m")

    def _least(self, path: Path) -> float:
        """Smallest value that a scalar takes."""
        for variable in self.variables:
            if variable.path == path:
                return min(variable.choices) if variable.choices else variable.low
        node = self._base
        for part in path:
            node = node[part]
        return node

    def make(self, parts) -> Design | None:
        """Design at parts (0 to 1) of the variables' ranges; None if it cannot be, or exceeds the envelope."""
        return self.of({v.path: v.at(float(part)) for v, part in zip(self.variables, parts, strict=True)})

    def of(self, values: dict[Path, object]) -> Design | None:
        """Design of values of the variables; None if it cannot be, or exceeds the envelope."""
        try:
            config = self.configured(values)
        except ValidationError:
            return None  # particles that do not fit, a place that does not move: such designs are not taken
        cavity, limits = config.damper.enclosure, self.design.limits
        if limits.diameter is not None and cavity.diameter > limits.diameter * (1 + 1e-9):
            return None
        if limits.height is not None and cavity.height > limits.height * (1 + 1e-9):
            return None
        return Design(values, config, particle_mass(config))

    def light_enough(self, design: Design) -> bool:
        """Whether a design's particles weigh no more than is allowed."""
        limit = self.design.limits.mass
        return limit is None or design.mass <= limit * (1 + 1e-9)

    def configured(self, values: dict[Path, object]) -> Config:
        """Configuration with values of the variables, and without what asked for them.

        Raises
        ------
        pydantic.ValidationError
            If they cannot be.
        """
        changed = tree_copy(self._base)
        for path, value in values.items():
            put(changed, path, value)
        used = {value for path, value in leaves(changed) if path[-1] == "material"}
        changed["materials"] = {name: value for name, value in changed["materials"].items() if name in used}
        if any(path[-1] == "material" and path[1] == "particles" for path in values):
            self._take_surface_again(changed)
        config = Config.model_validate(changed)
        config._source = self.config._source
        return config

    def _take_surface_again(self, changed: dict) -> None:
        """Leave out restitution and friction that were the library's of another material."""
        contact = changed["contact"]
        for name in ("restitution", "friction"):
            if contact.get("source") and f"{name}:" in contact["source"]:
                del contact[name]
        contact["source"] = None

    def modes(self, design: Design) -> Modes:
        """Modes of the target with a design's particles, as its damper sees them.

        Raises
        ------
        ConfigError
            At ``design.target.modes``, if one has a node there.
        """
        key = (*(value for path, value in design.values.items() if path[0] == "structure"), design.mass)
        if key not in self._exact:
            self._exact[key] = self._found(design)
        return self._exact[key]

    def _found(self, design: Design) -> Modes:
        try:
            found = structure_modes(design.config, particles=design.mass)
            return found.pick(self.target.modes or found.number)
        except ConfigError as error:
            if "node" not in str(error):
                raise
            raise self.error("target.modes", str(error).split(": ", 2)[-1]) from None
        except ValueError as error:
            raise self.error("target.modes", str(error)) from None

    def shapes(self, design: Design, masses: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Frequency [Hz], phi [kg^-0.5] and inherent damping of the target's modes, interpolated over the mass.

        Parameters
        ----------
        design : Design
        masses : (float, float)
            Range of masses [kg] that the modes of this place are computed for, once.
        """
        place = tuple(value for path, value in design.values.items() if path[0] == "structure")
        if place not in self._modes:
            grid = np.geomspace(masses[0], masses[1] * (1 + 1e-9), MODE_MASSES)
            found = [structure_modes(design.config, particles=float(m)) for m in grid]
            self._modes[place] = grid, [own.pick(self.target.modes or own.number) for own in found]
        grid, found = self._modes[place]

        def between(values):
            return np.array([np.interp(design.mass, grid, column) for column in np.transpose(values)])

        frequency = between([own.frequency**-2.0 for own in found]) ** -0.5
        amplitude = between([own.amplitude**-2.0 for own in found]) ** -0.5
        return frequency, amplitude, between([own.inherent_damping for own in found])

    def participation(self, design: Design) -> np.ndarray:
        """Participation of the target's modes along the excitation [kg^0.5], of a base that moves.

        Raises
        ------
        ConfigError
            If the modes are known without it.
        """
        modes = self.modes(design)
        if modes.participation is None:
            raise self.error(
                "target.base", "the modes say nothing of their participation: give it, or a range of gamma"
            )
        return np.abs(modes.participation @ np.asarray(modes.direction))

    def gravity(self) -> bool:
        """Whether gravity acts along the motion."""
        made = scene(self.config)
        return abs(float(np.dot(made.gravity, self.config.excitation.direction))) > 0.1


def goal_words(design: DesignConfig) -> str:
    """What is sought, in words."""
    return {"mass": "the least mass", "response": "the least response", "damping": "the most damping"}[design.goal]
