"""Cases of a study, constructed when asked for: a sweep of a million cases is a few numbers a case."""

from __future__ import annotations

import itertools
import json
import math
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from pydantic import ValidationError

from ..config.build import bed, drive, grains, numerics_of, particle_mass, scene
from ..config.study import Config
from ..config.sweep import as_list
from ..damper.case import PAPER_SETTLING, Criteria, Request, Spec, paper_criteria
from ..errors import ConfigError
from ..numerics.limits import FEWEST_STEPS_PER_CONTACT, FEWEST_STEPS_PER_CYCLE
from ..numerics.timestep import contact_step, expected_speed, shortest_contact, steps_per_cycle
from ..numerics.tolerance import settings_for
from ..scene.scene import STANDARD_GRAVITY
from .axes import FREQUENCY, leaves, put, tree, tree_copy
from .grid import Grid

if TYPE_CHECKING:
    from ..modes import Modes
    from ..scene.scene import Scene

KEPT_POINTS = 512
"""Points whose scenes are kept while their cases are made."""


@dataclass(frozen=True)
class Point:
    """Combination of the swept scalars other than frequency, gamma and seed.

    Parameters
    ----------
    index : position on the study's axes
    config : without any axis but those three; None where the combination is refused
    modes : of the structure with these particles, where the frequencies are its own
    frequencies : of the excitation [Hz]
    refused : why this combination cannot be
    """

    index: tuple[int, ...]
    config: Config | None
    modes: Modes | None = None
    frequencies: tuple[float, ...] = ()
    refused: str = ""


class Cases(Grid):
    """Cases of a study, numbered in the order of (frequency, gamma, swept scalars, seed).

    Parameters
    ----------
    config : Config

    Raises
    ------
    ConfigError
        If an axis cannot be read.
    """

    def __init__(self, config: Config):
        super().__init__(config)
        self._base = tree(self.config)
        self._points: OrderedDict[tuple, Point] = OrderedDict()
        self._modes: dict[str, Modes] = {}
        self._beds: dict = {}

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each dimension; computed on first use, since files of modes may have to be read."""
        return self._frequencies(), len(self.gammas), *(len(axis) for axis in self.axes), len(self.seeds)

    def _frequencies(self) -> int:
        """Number of frequencies: one where ``case`` carries it; modes may be known to their source only."""
        if FREQUENCY in self.carried:
            return 1
        if not self.modal:
            return len(as_list(self.config.excitation.frequency))
        if self.config.structure.modes:
            return len(self.config.structure.modes)
        return next((len(point.frequencies) for point in self.points() if not point.refused), 1)

    def __len__(self) -> int:
        return math.prod(self.shape)

    def points(self) -> Iterator[Point]:
        """Combinations of the swept scalars other than frequency, gamma and seed, in order."""
        for index in itertools.product(*(range(len(axis)) for axis in self.axes)):
            yield self.point(index)

    def point(self, index: tuple[int, ...]) -> Point:
        """Point at an index on the study's axes."""
        if index in self._points:
            self._points.move_to_end(index)
            return self._points[index]
        point = self._points[index] = self._made(index)
        if len(self._points) > KEPT_POINTS:
            self._points.popitem(last=False)
        return point

    def row(self, index: tuple[int, ...]) -> dict:
        """Values of the swept scalars at a point, by path."""
        return {
            path: value
            for axis, k in zip(self.axes, index, strict=True)
            for path, value in zip(axis.paths, axis.rows[k], strict=True)
        }

    def _made(self, index) -> Point:
        values = tree_copy(self._base) if self.axes else self._base
        for path, value in self.row(index).items():
            put(values, path, value)
        try:
            single = Config.model_validate(values)
        except ValidationError as error:
            return Point(index, None, refused="; ".join(e["msg"].removeprefix("Value error, ") for e in error.errors()))
        single._source = self.config._source
        if single.excitation.frequency != "modes":
            return Point(index, single, None, tuple(as_list(single.excitation.frequency)))
        try:
            modes = self._own_modes(single)
        except ConfigError as problem:
            if not any(path[0] == "structure" for axis in self.axes for path in axis.paths):
                raise
            return Point(index, None, refused=str(problem))  # here only: a damper on a node, a mode that is not there
        if "shape" in vars(self) and len(modes.number) != self.shape[0]:
            return Point(index, None, refused="the structure has other modes here: name them in structure.modes")
        # to a microhertz: an eigensolver's last bits depend on the machine, and beds are chaotic
        return Point(index, single, modes, tuple(round(float(f), 6) for f in modes.frequency))

    def _own_modes(self, single: Config) -> Modes:
        """Modes of the structure with a point's particles; computed once for each structure and particle mass."""
        from ..modal.from_config import modes as modes_of_structure

        particles = particle_mass(single)
        structure = single.structure.model_dump(mode="json")
        materials = {
            name: single.materials[name].elastic() for path, name in leaves(structure) if path[-1] == "material"
        }
        key = json.dumps([particles, structure, materials])
        if key not in self._modes:
            self._modes[key] = modes_of_structure(single, particles=particles)
        return self._modes[key]

    def numbers(self, point: Point) -> Iterator[tuple[int, tuple[int, int, int]]]:
        """Numbers of a point's cases, with their positions in (frequency, gamma, seed)."""
        steps = np.cumprod((1, *self.shape[:0:-1]))[::-1]  # from one case to the next along each dimension
        inner = int(np.dot(steps[2:-1], point.index)) if point.index else 0
        for i, j, k in itertools.product(range(self.shape[0]), range(self.shape[1]), range(self.shape[-1])):
            yield int(i * steps[0] + j * steps[1] + inner + k), (i, j, k)

    def spec(self, number: int) -> tuple[Spec, Criteria]:
        """Case to run, and its criteria, by number."""
        index = tuple(int(k) for k in np.unravel_index(number, self.shape))
        return self.spec_at(self.point(index[2:-1]), (index[0], index[1], index[-1]))

    def spec_at(self, point: Point, position: tuple[int, int, int]) -> tuple[Spec, Criteria]:
        """Case of a point at a position in (frequency, gamma, seed), and its criteria.

        Raises
        ------
        ConfigError
            If a forced step does not resolve the shortest contact expected.
        """
        i, j, k = position
        config = point.config
        frequency, gamma, seed = self.drive_at(point, position)
        request, own = self._bed(config, point.index, seed)
        driven = own.driven(drive(config, frequency, gamma))
        index = (i, j, *point.index, k)
        return Spec(index, driven, steps_of(config, driven, request.grains), request), criteria_of(config, frequency)

    def specs(self) -> Iterator[Spec]:
        """Cases that are possible and not excluded, in order."""
        for point in self.points():
            if not point.refused:
                for _, position in self.numbers(point):
                    if not self.excluded(point, *self.drive_at(point, position)):
                        yield self.spec_at(point, position)[0]

    def drive_at(self, point: Point, position: tuple[int, int, int]) -> tuple[float, float, int]:
        """Frequency [Hz], Gamma and seed of a case."""
        i, j, k = position
        return point.frequencies[i], as_list(point.config.excitation.gamma)[j], point.config.seeds[k]

    def _bed(self, config: Config, index, seed: int) -> tuple[Request, Scene]:
        """Bed of a point, and the scene that it is shaken in: another one than it was made in, if so asked."""
        if (index, seed) not in self._beds:
            if len(self._beds) > KEPT_POINTS:
                self._beds.clear()
            request = Request(
                scene=scene(config.while_made()),
                grains=grains(config),
                seed=seed,
                settling_time=PAPER_SETTLING if config.steady_state.recipe == "paper" else None,
                numerics=numerics_of(config),
                **bed(config),
            )
            self._beds[index, seed] = request, scene(config)
        return self._beds[index, seed]


def steps_of(config: Config, driven, particles) -> int:
    """Steps per cycle, chosen or forced.

    Raises
    ------
    ConfigError
        If a forced step does not resolve the shortest contact expected.
    """
    numerics = config.numerics
    if numerics.step == "auto":
        return steps_per_cycle(driven, particles, steps_per_contact=numerics.steps_per_contact)
    longest = contact_step(driven, particles, steps_per_contact=FEWEST_STEPS_PER_CONTACT)
    if numerics.step > longest:
        shortest = shortest_contact(driven, particles, expected_speed(driven, particles.radius))
        raise config.error(
            "numerics.step",
            f"{numerics.step:.3g} s is too large for the shortest contact expected, {shortest:.3g} s at "
            f"{driven.drive.frequency:.1f} Hz and Gamma {driven.drive.acceleration / STANDARD_GRAVITY:g}: "
            f"take at most {longest:.2g} s, or 'auto'",
        )
    return max(FEWEST_STEPS_PER_CYCLE, math.ceil(1 / (driven.drive.frequency * numerics.step)))


def criteria_of(config: Config, frequency: float) -> Criteria:
    """Criteria by which a case at a frequency [Hz] ends."""
    steady_state = config.steady_state
    if steady_state.recipe == "paper":
        return paper_criteria(frequency)
    slack = settings_for(config.accuracy.tolerance).slack if config.accuracy else 0.0
    return Criteria(steady_state.standard_error, steady_state.fewest_cycles, steady_state.most_cycles, slack=slack)
