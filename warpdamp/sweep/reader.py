"""Reading of a configuration's ``sweep`` into axes; errors name their place in the file."""

from __future__ import annotations

import difflib
import itertools
import math

from pydantic import ValidationError

from ..config.messages import per_cent
from ..config.plausible import refusal
from ..config.quantities import to_si
from ..config.study import Config
from ..config.sweep import Between, Range, SampleConfig, Span, spread
from ..errors import ConfigError
from ..formats.text_file import TableError
from .axes import (
    CASE,
    GAMMA,
    OWN,
    SEED,
    Axis,
    Path,
    coordinate_names,
    dotted,
    get,
    is_vector,
    leaves,
    put,
    tree,
    tree_copy,
    unit_of,
)  # fmt: skip


def read_axes(config: Config) -> tuple[Config, list[Axis]]:
    """Configuration with every frequency, gamma and seed of the sweep in it, and its other axes.

    Raises
    ------
    ConfigError
        If a path is not one of the configuration's scalars, is given twice, or takes a value that it cannot take.
    """
    return Reader(config).read()


class Reader:
    """Reader of the sweep of one configuration.

    Parameters
    ----------
    config : Config
    """

    def __init__(self, config: Config):
        self.config = config
        self.base = tree(config)
        self.scalars = {path: value for path, value in leaves(self.base) if path[:2] != ("preparation", "made_with")}
        self.taken: dict[Path, tuple] = {}

    def condition(self, key: str, condition, place) -> tuple[Path, object]:
        """Path of a condition, and its values in SI: ``Between``, or a list."""
        path = self._find(key, place)
        if isinstance(condition, Between):
            low, high = (self._single(path, end, place) for end in (condition.from_, condition.to))
            return path, Between(from_=low, to=high)
        values = condition if isinstance(condition, list) else [condition]
        return path, [self._single(path, value, place) for value in values]

    def read(self) -> tuple[Config, list[Axis]]:
        """Read the sweep; see ``read_axes``."""
        lists = self._in_place()
        sweep = self.config.sweep
        together: list[Axis] = []
        config = self.config
        if sweep:
            for key, values in sweep.product.items():
                place = ("sweep", "product", key)
                path = self._take(key, place)
                lists.append((path, self._distinct(self._values(path, values, place), place)))
            for k, group in enumerate(sweep.zip):
                together.append(self._zipped(group, ("sweep", "zip", k)))
            if sweep.sample:
                together.append(self._sampled(sweep.sample))
            if sweep.csv:
                together.append(self.table(sweep.csv))
            config = self._folded(lists)
        paths = [path for path, _ in lists if path not in OWN]
        names = coordinate_names([*paths, *(path for axis in together for path in axis.paths)])
        axes = [Axis(names[path], (path,), tuple((v,) for v in values)) for path, values in lists if path not in OWN]
        return config, axes + _merged(together)

    def _in_place(self) -> list[tuple[Path, list]]:
        """Lists that stand where a scalar may."""
        for path, values in self.scalars.items():
            if path == GAMMA and isinstance(values, list):
                self._distinct(values, path)
        return [
            (path, self._distinct(values, path))
            for path, values in self.scalars.items()
            if isinstance(values, list)
            and path not in OWN
            and path[0] in ("materials", "contact", "excitation", "preparation")
            and not is_vector(path)
        ]

    def _distinct(self, values: list, place) -> list:
        if len(set(values)) < len(values):
            raise self.config.error(place, "each value once")
        return values

    def _folded(self, lists) -> Config:
        """Configuration with the product's frequencies, gammas and seeds in place of its own."""
        values = self.base | {"sweep": None}
        for path, values_of_axis in lists:
            if path in OWN:
                node = values if path == SEED else values[path[0]]
                node[path[-1]] = sorted(values_of_axis)
        folded = Config.model_validate(values)
        folded._source = self.config._source
        return folded.model_copy(update={"sweep": self.config.sweep})

    def _take(self, key: str, place) -> Path:
        """The path that a key stands for, each once."""
        path = self._find(key, place)
        given = self.scalars[path]
        if path in self.taken:
            raise self.config.error(place, f"is given in {dotted(self.taken[path])}, too")
        if isinstance(given, list) and len(given) > 1:
            raise self.config.error(place, f"is a list at {dotted(path)} already: give it once")
        self.taken[path] = place
        return path

    def _find(self, key: str, place) -> Path:
        parts = tuple(int(part) if part.isdigit() else part for part in key.split("."))
        parts = (*parts[:-1], "seeds") if parts[-1] == "seed" else parts
        usable = [path for path in self.scalars if path != ("title",) and not is_vector(path)]
        matches = [path for path in usable if path[-len(parts) :] == parts]
        if parts in matches:
            return parts
        if len(matches) == 1:
            return matches[0]
        if matches:
            raise self.config.error(place, f"may be {' or '.join(map(dotted, matches))}: write the whole path")
        names = [dotted(path) for path in usable]
        last = {str(path[-1]): dotted(path) for path in usable}
        close = difflib.get_close_matches(key, names, n=1) or [
            last[name] for name in difflib.get_close_matches(str(parts[-1]), list(last), n=1)
        ]
        hint = f"; did you mean '{close[0]}'?" if close else "; write a path such as contact.friction"
        raise self.config.error(place, f"is not a scalar of this configuration{hint}")

    def _read(self, row: dict[Path, object], place) -> dict:
        """Values as the models read them: checked, and in SI."""
        values = tree_copy(self.base)
        for path, value in row.items():
            put(values, path, value)
        try:
            read = tree(Config.model_validate(values))
        except ValidationError as error:
            relevant = [e for e in error.errors() if any(_at(e["loc"], path) for path in row)]
            if relevant:
                raise self.config.error(place, _message(relevant[0], row)) from None
            return {path: _in_si(path, value) for path, value in row.items()}  # another combination may be possible
        return {path: get(read, path) for path in row}

    def _values(self, path: Path, values, place) -> list:
        if not isinstance(values, Range):
            return [self._single(path, value, (*place, k)) for k, value in enumerate(values)]
        ends = {end: self._single(path, end, place) for end in values.ends}
        try:
            spread_out = values.spread(ends.get)
        except ValueError as error:
            raise self.config.error(place, str(error)) from None
        return spread_out

    def _single(self, path: Path, value, place):
        return self._read({path: value}, place)[path]

    def _zipped(self, group: dict, place) -> Axis:
        columns = {}
        for key, values in group.items():
            path = self._take(key, (*place, key))
            columns[path] = self._values(path, values, (*place, key))
        if len({len(values) for values in columns.values()}) > 1:
            counts = ", ".join(f"{dotted(path)} {len(values)}" for path, values in columns.items())
            raise self.config.error(place, f"scalars that change together need as many values each, got {counts}")
        rows = tuple(zip(*columns.values(), strict=True))
        for row in rows:
            self._read(dict(zip(columns, row, strict=True)), place)
        return Axis(CASE, tuple(columns), rows)

    def _sampled(self, sample: SampleConfig) -> Axis:
        place = ("sweep", "sample", "over")
        parts = _samples(sample, len(sample.over)).T
        columns = {}
        for (key, ends), part in zip(sample.over.items(), parts, strict=True):
            path = self._take(key, (*place, key))
            ends, logarithmic = (ends.log, True) if isinstance(ends, Span) else (ends, False)
            first, last = (self._single(path, end, (*place, key)) for end in ends)
            try:
                columns[path] = spread(first, last, part, logarithmic=logarithmic)
            except ValueError as error:
                raise self.config.error((*place, key), str(error)) from None
        return Axis(CASE, tuple(columns), tuple(zip(*columns.values(), strict=True)))

    def table(self, name: str) -> Axis:
        """Axis of the scalars of a CSV file, one a column."""
        from .table import read_table  # hides NumPy, and most sweeps have no table

        place = ("sweep", "csv")
        try:
            heads, rows = read_table(self.config.folder / name)
            paths = [_in_file(where, self._take, key, place) for where, key in heads]
            return Axis(CASE, tuple(paths), tuple(self._row(paths, where, cells, place) for where, cells in rows))
        except TableError as error:
            raise self.config.error(place, str(error)) from None

    def _row(self, paths: list[Path], where: str, cells: list, place) -> tuple:
        """Values of a table's row, in SI."""
        for path, cell in zip(paths, cells, strict=True):
            if said := refusal(dotted(path), cell):
                raise self.config.error(place, f"{where}: {dotted(path)}: {said}")
        row = _in_file(where, self._read, dict(zip(paths, cells, strict=True)), place)
        return tuple(row[path] for path in paths)


def _in_file(where: str, action, *arguments):
    """Result of an action; its errors get a place in the table beside the configuration."""
    try:
        return action(*arguments)
    except ConfigError as error:
        before, key, after = str(error).rpartition("sweep.csv: ")
        raise ConfigError(f"{before}{key}{where}: {after}") from None


def _at(loc: tuple, path: Path) -> bool:
    """Whether an error is about a scalar itself (unions add names of their own to its place)."""
    parts = iter(loc)
    return all(any(part == key for part in parts) for key in path)


def _in_si(path: Path, value):
    unit = unit_of(path)
    return value if unit is None else to_si(value, unit)


def _message(error, row: dict) -> str:
    """Message of the models in one line."""
    message = error["msg"].removeprefix("Value error, ")
    given = " and ".join(f"{dotted(path)} = {value!r}" for path, value in row.items())
    return f"{message[:1].lower()}{message[1:]} (with {given}){per_cent(error)}"


def _samples(sample: SampleConfig, dimensions: int):
    """Points of the unit cube, (n, dimensions)."""
    import numpy as np
    from scipy.stats import qmc

    rng = np.random.default_rng(sample.seed)
    if sample.method == "latin_hypercube":
        return qmc.LatinHypercube(dimensions, seed=rng).random(sample.n)
    return qmc.Sobol(dimensions, seed=rng).random_base2(math.ceil(math.log2(sample.n)))[: sample.n]


def _merged(axes: list[Axis]) -> list[Axis]:
    """Axis of all combinations of several groups, along one dimension."""
    if not axes:
        return []
    rows = tuple(tuple(itertools.chain(*parts)) for parts in itertools.product(*(axis.rows for axis in axes)))
    return [Axis(CASE, tuple(itertools.chain(*(axis.paths for axis in axes))), rows)]
