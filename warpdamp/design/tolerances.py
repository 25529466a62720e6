"""What tolerances a claim bears: contacts and sizes varied about the design, by a Monte Carlo through an emulator."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from ..config.study import Config
from ..errors import ConfigError
from ..numerics.process import fit
from ..scene.materials import LIBRARY
from ..sweep.axes import Path, put, tree, tree_copy
from .assess import Drives, drives_of, judged
from .cases import Order, Row
from .problem import Design
from .search import Search
from .verify import FRESH, Verified

SAMPLES = 8
"""Designs about the one claimed that are simulated."""
DRIVES = 3
SURFACE, SIZE = 0.2, 0.01
"""Tolerances, relative, of contacts where the library knows none, and of the cavity's sizes."""
DRAWS = 1000
SCANNED = 5

VARIED: dict[str, Path] = {
    "contact.friction": ("contact", "friction"),
    "contact.restitution": ("contact", "restitution"),
    "damper.enclosure.height": ("damper", "enclosure", "height"),
    "damper.enclosure.diameter": ("damper", "enclosure", "diameter"),
}


@dataclass(frozen=True)
class Tolerance:
    """Tolerance of one scalar.

    Parameters
    ----------
    name : path as it is written
    value : of the design
    range : that was tried, (low, high)
    kept : part of it, about the value, over which the claim keeps its confidence, (low, high)
    """

    name: str
    value: float
    range: tuple[float, float]
    kept: tuple[float, float]


@dataclass(frozen=True)
class Sensitivity:
    """What tolerances a claim bears.

    Parameters
    ----------
    probability : that the target is met with every scalar anywhere in its range
    tolerances : of each
    samples, impossible : designs drawn about the one claimed, and those of them that cannot be: they were left out
    cases, failed : simulated of the others, and those of them that gave no result: they were left out, too
    """

    probability: float
    tolerances: list[Tolerance]
    samples: int
    impossible: int
    cases: int
    failed: int


def ranges(config: Config) -> dict[str, tuple[float, float, float]]:
    """Value and range of every scalar that is varied: the library's where the particles' contact is the library's."""
    which = config.materials[config.damper.mixture[0].material].library
    known = LIBRARY[which].values() if which in LIBRARY else {}
    values = tree(config)
    found = {}
    for name, path in VARIED.items():
        node = values
        for part in path:
            node = node[part]
        value = known.get(path[-1])
        if value is not None and value.value == node:
            low, high = value.low, value.high
        if value is None or value.value != node or low == high:
            relative = SIZE if path[0] == "damper" else SURFACE
            low, high = node * (1 - relative), node * (1 + relative)
        found[name] = (node, low, min(high, 1.0) if path[-1] == "restitution" else high)
    return found


def sensitivity(search: Search, verified: Verified) -> Sensitivity:
    """Vary contacts and sizes about a design that was simulated again.

    Parameters
    ----------
    search : Search
    verified : Verified

    Returns
    -------
    Sensitivity
    """
    from scipy.stats import qmc

    design, spans = verified.design, ranges(verified.design.config)
    unit = qmc.Sobol(len(spans), seed=np.random.default_rng(3)).random(SAMPLES)
    finer = drives_of(search.problem, design, search.masses)
    where = np.argsort(-verified.least.decisive, kind="stable")[:DRIVES]
    orders, offsets, impossible = [], [], 0
    for k, part in enumerate(unit):
        varied = _varied(design, spans, part)
        if varied is None:
            impossible += 1
            continue
        orders += [Order(varied, int(finer.mode[i]), float(finer.gamma[i]), FRESH + 500 + k) for i in where]
        offsets += [part] * len(where)
    rows = search.run_apart(orders)
    own = [row for row in search.rows if row.order.design.key == design.key]
    middle = np.array([_part(value, low, high) for value, low, high in spans.values()])
    every = [*zip(own, [middle] * len(own), strict=True), *zip(rows, offsets, strict=True)]
    probability, tolerances = _judged(search, verified, spans, [(row, part) for row, part in every if row.known], finer)
    failed = sum(not row.known for row in rows)
    return Sensitivity(probability, tolerances, len(unit), impossible, len(rows), failed)


def _varied(design: Design, spans: dict, part: np.ndarray) -> Design | None:
    """A design with scalars at parts of their ranges; None if it cannot be."""
    values = tree_copy(tree(design.config))
    added = {}
    for (name, (_, low, high)), x in zip(spans.items(), part, strict=True):
        put(values, VARIED[name], low + (high - low) * float(x))
        added[VARIED[name]] = low + (high - low) * float(x)
    try:
        config = Config.model_validate(values)
    except (ValueError, ConfigError):
        return None
    config._source = design.config._source
    return replace(design, values=design.values | added, config=config)


def _part(value: float, low: float, high: float) -> float:
    return (value - low) / (high - low)


def _judged(search: Search, verified: Verified, spans: dict, known: list[tuple[Row, np.ndarray]], finer: Drives):
    points = np.array([[np.log(row.frequency), np.log(row.order.gamma), *part] for row, part in known])
    kept = np.flatnonzero(np.ptp(points, axis=0) > 1e-9)
    beds: dict[tuple, int] = {}
    groups = [beds.setdefault((row.order.design.key, row.order.seed), len(beds)) for row, _ in known]
    values, errors = np.log([row.effectiveness for row, _ in known]), [row.error for row, _ in known]
    process = fit(points[:, kept], values, errors, groups)
    middle = np.array([_part(value, low, high) for value, low, high in spans.values()])
    rng = np.random.default_rng(4)

    def probability(parts: np.ndarray) -> float:
        """Probability that the target is met, over parts (k, d) of the ranges."""
        drives = np.column_stack([np.log(finer.frequency), np.log(finer.gamma)])
        at = [np.column_stack([drives, np.tile(part, (len(drives), 1))])[:, kept] for part in parts]
        with threadpool_limits(1):
            mean, covariance = process.joints(np.array(at))
        value, vector = np.linalg.eigh(covariance)
        normal = rng.standard_normal(mean.shape)
        draws = np.exp(mean + np.einsum("kmn,kn->km", vector, np.sqrt(np.maximum(value, 0)) * normal))
        return judged(search.problem, verified.design, finer, draws).probability

    everywhere = probability(rng.random((DRAWS, len(spans))))
    confidence = search.problem.design.confidence
    tolerances = []
    for k, (name, (value, low, high)) in enumerate(spans.items()):
        ends = []
        for end in (0.0, 1.0):
            reached = middle[k]
            for x in np.linspace(middle[k], end, SCANNED + 1)[1:]:
                part = middle.copy()
                part[k] = x
                if probability(np.tile(part, (DRAWS // SCANNED, 1))) < confidence:
                    break
                reached = x
            ends.append(low + (high - low) * float(reached))
        tolerances.append(Tolerance(name, value, (low, high), (ends[0], ends[1])))
    return everywhere, tolerances
