"""A sweep's axes: scalars of the configuration, found by their paths, and the values they take.

Frequency, gamma and seed have dimensions of their own; any other scalar of a product becomes a dimension called by its
key.  Scalars that change together (``zip``, ``sample``, ``csv``) share one dimension, ``case``, and are its
coordinates.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

from ..config.study import Config
from ..variables import VARIABLES

Path = tuple[str | int, ...]

FREQUENCY, GAMMA, SEED = ("excitation", "frequency"), ("excitation", "gamma"), ("seeds",)
OWN = {FREQUENCY: "frequency", GAMMA: "gamma", SEED: "seed"}
"""Scalars whose dimensions every gridded Dataset has."""

CASE = "case"
"""Dimension of scalars that change together."""

LEG = "leg"
"""Dimension of the legs of a path along which beds are carried through all amplitudes; it changes no scalar."""

_LONG_NAMES = {
    "youngs_modulus": "Young's modulus",
    "poissons_ratio": "Poisson's ratio",
    "restitution": "coefficient of restitution",
    "friction": "coefficient of friction",
    "rolling_friction": "coefficient of rolling friction",
    "frequency": "excitation frequency",
    "gamma": "acceleration amplitude over g",
    "seeds": "seed of the packing",
    "preparation": "how the bed was prepared",
    "aspect": "aspect of spheroids, along over across their axis",
}
_CF_UNITS = {"": "1", "kg/m^3": "kg m-3", "m/s^2": "m s-2"}


@dataclass(frozen=True)
class Axis:
    """Scalars that change together along one dimension.

    Parameters
    ----------
    name : of the dimension
    paths : of the scalars in the configuration
    rows : their values (SI), one row a point
    """

    name: str
    paths: tuple[Path, ...]
    rows: tuple[tuple, ...]

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def values(self) -> tuple:
        """Values of an axis of one scalar."""
        return tuple(row[0] for row in self.rows)

    def columns(self) -> dict[Path, list]:
        """Values of each scalar, by path."""
        return {path: [row[k] for row in self.rows] for k, path in enumerate(self.paths)}


def attributes(path: Path) -> dict:
    """CF attributes of a scalar's coordinate."""
    unit = unit_of(path)
    return {
        "units": _CF_UNITS.get(unit, unit) or "1",
        "long_name": _LONG_NAMES.get(path[-1], str(path[-1]).replace("_", " ")),
        "configuration_key": dotted(path),
    }


def dotted(path: Path) -> str:
    """Path as it is written, parts joined by dots."""
    return ".".join(map(str, path))


def coordinate_names(paths) -> dict[Path, str]:
    """Names for scalars: the last key, or as much of the path as makes them unique, among variables too."""
    paths = list(paths)
    taken = {*VARIABLES, *OWN.values(), CASE, LEG, "mode"}

    def name(path):
        if path in OWN:
            return OWN[path]
        for first in (len(path) - 1, min(1, len(path) - 1)):
            short = "_".join(map(str, path[first:]))
            others = ["_".join(map(str, other[-(len(path) - first) :])) for other in paths if other != path]
            if short not in taken and (first == 1 or short not in others):
                return short
        return "_".join(map(str, path))

    return {path: name(path) for path in paths}


def is_vector(path: Path) -> bool:
    """Whether a list at a path is one value, of several components."""
    return "direction" in str(path[-1]) or path[-2:] == ("carried", "path")


@functools.cache
def _schema() -> dict:
    return Config.model_json_schema()


def unit_of(path: Path) -> str | None:
    """SI unit of a scalar of the configuration, as the models state it; None where it is no quantity."""
    nodes = [_schema()]
    for part in path:
        nodes = [child for node in nodes for child in _below(node, part)]
    return next((node["unit"] for node in _flat(nodes) if "unit" in node), None)


def _flat(nodes):
    """JSON-schema nodes with references and alternatives followed."""
    for node in nodes:
        if "$ref" in node:
            yield from _flat([_schema()["$defs"][node["$ref"].rpartition("/")[2]]])
        elif "anyOf" in node:
            yield from _flat(node["anyOf"])
        else:
            yield node


def _below(node, part):
    for alternative in _flat([node]):
        if part in alternative.get("properties", {}):
            yield alternative["properties"][part]
        elif isinstance(part, int) and "items" in alternative:
            yield alternative["items"]
        elif isinstance(alternative.get("additionalProperties"), dict):
            yield alternative["additionalProperties"]
        yield from alternative.get("patternProperties", {}).values()


def tree(config: Config) -> dict:
    """Tree of plain SI values of a configuration, without its sweep, coupled runs and design."""
    return config.model_dump(mode="json", exclude={"sweep", "coupled", "design"})


def put(node, path: Path, value) -> None:
    """Set a scalar of a configuration's tree (a seed: as the only one)."""
    for part in path[:-1]:
        node = node[part]
    node[path[-1]] = [value] if path == SEED else value


def get(node, path: Path):
    """Value of a scalar of a configuration's tree."""
    for part in path:
        node = node[part]
    return node[0] if path == SEED else node


def leaves(node, path: Path = ()):
    """Paths and values of all scalars of a configuration's tree (lists that stand for an axis among them)."""
    if isinstance(node, dict):
        for key, value in node.items():
            yield from leaves(value, (*path, key))
    elif isinstance(node, list) and any(isinstance(part, dict) for part in node):
        for k, value in enumerate(node):
            yield from leaves(value, (*path, k))
    elif node is not None:
        yield path, node


def tree_copy(node):
    """Copy of a tree down to its scalars."""
    if isinstance(node, dict):
        return {key: tree_copy(value) for key, value in node.items()}
    return [tree_copy(value) for value in node] if isinstance(node, list) else node
