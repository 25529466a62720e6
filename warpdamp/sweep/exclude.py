"""Combinations that a sweep leaves out."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..config.sweep import Between
from .axes import FREQUENCY, GAMMA, SEED, Path, dotted, get, tree
from .reader import Reader

if TYPE_CHECKING:
    from ..config.study import Config
    from .cases import Point
    from .grid import Grid


class Exclusions:
    """Conditions under ``sweep.exclude``: a case that meets all of any entry is left out.

    Parameters
    ----------
    config : Config

    Raises
    ------
    ConfigError
        If a path is not a scalar of the configuration, or a value is none that it can take.
    """

    def __init__(self, config: Config):
        self.entries: list[dict[Path, object]] = []
        reader = Reader(config)
        for k, entry in enumerate(config.sweep.exclude if config.sweep else ()):
            place = ("sweep", "exclude", k)
            self.entries.append(dict(reader.condition(key, rule, (*place, key)) for key, rule in entry.items()))

    def __call__(self, point: Point, frequency: float, gamma: float, seed: int) -> bool:
        """Whether a case is left out."""
        if not self.entries:
            return False
        values, drive = tree(point.config), {FREQUENCY: frequency, GAMMA: gamma, SEED: seed}
        return any(
            all(_meets(drive[path] if path in drive else get(values, path), rule) for path, rule in entry.items())
            for entry in self.entries
        )


def refuse_exclusions_in_vain(grid: Grid) -> None:
    """Refuse a condition that no value of the study meets: it would leave out nothing.

    Frequencies that are the structure's own are not looked at: they are not known yet.

    Raises
    ------
    ConfigError
        At the condition.
    """
    for k, entry in enumerate(grid.excluded.entries):
        for path, rule in entry.items():
            values = _values(grid, path)
            if values and not any(_meets(value, rule) for value in values):
                written = list(grid.config.sweep.exclude[k])[list(entry).index(path)]
                raise grid.config.error(
                    ("sweep", "exclude", k, written),
                    f"leaves nothing out: no case has such a value of {dotted(path)}; correct it, or leave it out",
                )


def _values(grid: Grid, path: Path) -> list:
    """Values that a scalar has in a study; none where they are not known yet."""
    for axis in grid.axes:
        if path in axis.paths:
            return [row[axis.paths.index(path)] for row in axis.rows]
    if path == FREQUENCY:
        frequencies = [] if grid.modal else grid.config.excitation.frequency
        return frequencies if isinstance(frequencies, list) else [frequencies]
    own = {GAMMA: grid.gammas, SEED: grid.seeds}
    return own[path] if path in own else [get(tree(grid.config), path)]


def _meets(value, rule) -> bool:
    if isinstance(rule, Between):
        return rule.from_ <= value <= rule.to or any(map(lambda end: _same(value, end), (rule.from_, rule.to)))
    return any(_same(value, allowed) for allowed in rule)


def _same(value, other) -> bool:
    """Whether two values are equal, numbers to the rounding of their units."""
    numbers = [isinstance(v, int | float) and not isinstance(v, bool) for v in (value, other)]
    return math.isclose(value, other, rel_tol=1e-9) if all(numbers) else value == other
