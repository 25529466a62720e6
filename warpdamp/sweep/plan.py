"""Plan of a study: the identity, cost and grouping of every case, found in one pass over them.

A case is known by a hash of all that its result depends on: its bed, drive, step and criteria, the version of the
physics, and, where beds are carried on, the amplitudes before it.
"""

from __future__ import annotations

import functools
import hashlib
import io
import json
import zipfile
import zlib
from dataclasses import asdict, dataclass, field, fields
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..config.build import particle_mass
from ..config.preparation import carried_path
from ..config.reading import IN_SI, resolved_yaml
from ..files import keep
from ..version import PHYSICS_VERSION, RESULTS_VERSION
from .carried import beside_legs, leg_of
from .cases import Cases

if TYPE_CHECKING:
    from ..damper.case import Criteria, Spec
    from ..scene.effects import Effects


class Fate(IntEnum):
    """Fate of a case in a study."""

    RUN = 0
    EXCLUDED = 1
    REFUSED = 2


def identity(spec: Spec, criteria: Criteria, bed: str) -> dict:
    """Inputs that determine the result of a case, except the amplitudes before it; ``bed``: key of its bed."""
    rest = {f.name: getattr(spec, f.name) for f in fields(spec) if f.name not in ("index", "scene", "bed")}
    drive = asdict(spec.scene.drive)
    versions = {"physics": PHYSICS_VERSION, "results": RESULTS_VERSION}
    at_rest = spec.scene.driven(None)
    other = {} if at_rest == spec.bed.scene.driven(None) else {"scene": asdict(at_rest)}  # than beds are made in
    return {**versions, "bed": bed, "drive": drive, "criteria": asdict(criteria), **rest, **other}


def key(identity: dict, before: list[dict] = []) -> bytes:  # noqa: B006 - not changed
    """Key of a case, 16 bytes, from its identity and those of the cases before it."""
    text = json.dumps({**identity, "before": before}, sort_keys=True)
    return hashlib.sha256(text.encode()).digest()[:16]


@dataclass
class Plan:
    """Cases of a study, as arrays over their numbers.

    Parameters
    ----------
    cases : Cases
    keys : (n,) array of 16 bytes; empty where there is nothing to run
    fate : (n,) array of ``Fate``
    frequency, particle_mass : (n,) arrays [Hz, kg]
    dt : (n,) array of steps [s]
    particles : (n,) array of their number
    cost : (n,) array of particle-steps, at the least
    chain : (n,) array: number of the first case of the chain that a case belongs to
    turn : (n,) array: position in that chain
    group : (n,) array: position in ``groups``, of which a batch holds one
    bed : (n,) array: position in ``beds``
    groups : (effects, criteria) that occur
    beds : keys of the beds, with the number of a case that has them
    refused : why, by the index of the point
    attributes : attributes of the Dataset: what was simulated, and what was forced off
    """

    cases: Cases
    keys: np.ndarray
    fate: np.ndarray
    frequency: np.ndarray
    particle_mass: np.ndarray
    dt: np.ndarray
    particles: np.ndarray
    cost: np.ndarray
    chain: np.ndarray
    turn: np.ndarray
    group: np.ndarray
    bed: np.ndarray
    groups: list[tuple[Effects, Criteria]] = field(default_factory=list)
    beds: dict[str, int] = field(default_factory=dict)
    refused: dict[tuple, str] = field(default_factory=dict)
    attributes: dict[str, str] = field(default_factory=dict)

    def to_run(self) -> np.ndarray:
        """Numbers of the cases that are run."""
        return np.flatnonzero(self.fate == Fate.RUN)


def make_plan(cases: Cases) -> Plan:
    """Plan of a study, in one pass over its cases.

    Raises
    ------
    ConfigError
        If no combination can be, all are excluded, or a forced step does not resolve the shortest contact expected.
    """
    n = len(cases)
    plan = Plan(
        cases,
        keys=np.zeros(n, "S16"),
        fate=np.full(n, Fate.RUN, np.int8),
        frequency=np.full(n, np.nan),
        particle_mass=np.full(n, np.nan),
        dt=np.full(n, np.nan),
        particles=np.zeros(n, np.int32),
        cost=np.zeros(n),
        chain=np.arange(n),
        turn=np.zeros(n, np.int32),
        group=np.zeros(n, np.int32),
        bed=np.zeros(n, np.int32),
    )
    carried: dict[tuple, list] = {}
    groups: dict = {}
    positions: dict = {}
    for point in cases.points():
        _look(plan, point, groups, positions, carried)
    plan.groups, plan.attributes = list(groups), _effect_attributes(cases, groups)
    _chain_up(plan, carried)
    if len(plan.refused) == len(list(_indices(cases))):
        raise cases.config.error(("sweep",), next(iter(plan.refused.values())))
    if not len(plan.to_run()):
        raise cases.config.error(("sweep", "exclude"), "leaves no case to run: exclude less")
    return plan


def _indices(cases: Cases):
    return np.ndindex(*cases.shape[2:-1])


def _look(plan: Plan, point, groups: dict, positions: dict, carried: dict) -> None:
    """Fill in the cases of a point."""
    cases = plan.cases
    if point.refused:
        plan.refused[point.index] = point.refused
        plan.fate[[number for number, _ in cases.numbers(point)]] = Fate.REFUSED
        return
    mass, beds, effects = particle_mass(point.config), {}, None
    for number, position in cases.numbers(point):
        frequency, gamma, seed = cases.drive_at(point, position)
        plan.frequency[number], plan.particle_mass[number] = frequency, mass
        if cases.excluded(point, frequency, gamma, seed):
            plan.fate[number] = Fate.EXCLUDED
            continue
        spec, criteria = cases.spec_at(point, position)
        effects = effects or spec.effects
        if seed not in beds:
            beds[seed] = spec.bed.key()
            positions.setdefault(beds[seed], len(positions))
            plan.beds.setdefault(beds[seed], number)
        plan.dt[number], plan.particles[number] = spec.dt, len(spec.bed.grains)
        plan.cost[number] = spec.cost(criteria)
        plan.group[number], _ = groups.setdefault((effects, criteria), (len(groups), number))
        inputs = identity(spec, criteria, beds[seed])
        plan.bed[number] = positions[beds[seed]]
        if path := carried_path(point.config.preparation):
            alike = key({**inputs, "drive": {**inputs["drive"], "acceleration": 0}, "steps_per_cycle": 0})
            leg, acceleration = leg_of(cases.axes, point.index), spec.scene.drive.acceleration
            order = (leg, acceleration if path[leg] == "up" else -acceleration, number)
            carried.setdefault((alike, beside_legs(cases.axes, point.index)), []).append((order, inputs))
        else:
            plan.keys[number] = key(inputs)


def _chain_up(plan: Plan, carried: dict) -> None:
    """Set the keys of carried cases: each depends on those before it."""
    for chain in carried.values():
        chain.sort(key=lambda member: member[0])
        first, before = chain[0][0][-1], []
        for turn, ((*_, number), inputs) in enumerate(chain):
            plan.chain[number], plan.turn[number] = first, turn
            plan.keys[number] = key(inputs, before)
            before = [*before, {"drive": inputs["drive"], "steps_per_cycle": inputs["steps_per_cycle"]}]


def _effect_attributes(cases: Cases, groups: dict) -> dict[str, str]:
    forced_off = {name for _, number in groups.values() for name in cases.spec(number)[0].forced_off}
    return {
        "effects": "; ".join(sorted({str(effects) for effects, _ in groups})),
        "effects_forced_off": ", ".join(sorted(forced_off)),
    }


_ARRAYS = ("keys", "fate", "frequency", "particle_mass", "dt", "particles", "cost", "chain", "turn", "group", "bed")


def save_plan(plan: Plan, folder: Path) -> None:
    """Save a plan beside its cases, so that a continued run, its parts and ``status`` need not make it again."""
    study = resolved_yaml(plan.cases.config).encode()
    about = {
        "fingerprint": _fingerprint(study),
        "refused": [[list(index), why] for index, why in plan.refused.items()],
        "attributes": plan.attributes,
        "beds": plan.beds,
        "groups": [int(plan.to_run()[np.argmax(plan.group[plan.to_run()] == k)]) for k in range(len(plan.groups))],
    }
    content = io.BytesIO()
    np.savez_compressed(content, about=np.array(json.dumps(about)), **{name: getattr(plan, name) for name in _ARRAYS})
    keep(folder / "plan.npz", content.getvalue())
    keep(folder / "study.yaml", IN_SI.encode() + study)


def load_or_make_plan(cases: Cases, folder: Path) -> Plan:
    """Plan saved in a folder, if the same study and the same code made it; otherwise a new one.

    Raises
    ------
    ConfigError
        See ``make_plan``.
    """
    try:
        with np.load(folder / "plan.npz") as file:
            arrays = {name: file[name] for name in _ARRAYS}
            about = json.loads(str(file["about"]))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):  # not there, or damaged
        return make_plan(cases)
    if about.get("fingerprint") != _fingerprint(resolved_yaml(cases.config).encode()):
        return make_plan(cases)
    groups = [(spec.effects, criteria) for spec, criteria in map(cases.spec, about["groups"])]
    refused = {tuple(index): why for index, why in about["refused"]}
    return Plan(cases, **arrays, groups=groups, beds=about["beds"], refused=refused, attributes=about["attributes"])


def _fingerprint(study: bytes) -> str:
    """Hash of a study and of the code: a plan by other code may differ."""
    return hashlib.sha256(study + _code()).hexdigest()


@functools.cache
def _code() -> bytes:
    folder = Path(__file__).parents[1]
    return b"".join(hashlib.sha256(path.read_bytes()).digest() for path in sorted(folder.rglob("*.py")))
