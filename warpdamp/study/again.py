"""A case of a study run again and recorded, and whether its numbers are those of the results."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.results import provenance, read
from ..config.reading import IN_SI
from ..damper.shake import shake, window_values
from ..damper.trajectory import CYCLES, FRAMES, Trajectory, record
from ..engine.ledger import maximum_energy
from ..errors import ConfigError, SimulationError, UsageError
from ..numerics.tolerance import SMALLEST_EFFECTIVENESS
from ..status import Status
from ..sweep.cases import Cases
from ..sweep.choice import Choice, candidates, label, only
from ..sweep.load import load
from ..sweep.plan import make_plan
from ..sweep.resolve import self_contained, with_tolerance
from ..version import PHYSICS_VERSION

if TYPE_CHECKING:
    import xarray as xr

    from ..config.study import Config
    from ..damper.case import Criteria, Spec

WITHOUT_FILM = (Status.NOT_FINITE, Status.ESCAPED)
"""Statuses of cases that stopped before their end; those from ``FAILED`` on did not even begin, or have no results."""


NEEDED = ("status", "cycles", "cycles_discarded")
"""Variables without which it is not known how a case ran."""


@dataclass(frozen=True)
class Again:
    """Case run again, recorded.

    Parameters
    ----------
    title : str
        Of the study.
    label : str
        What the case is known by.
    source : str
        Versions of what ran it.
    trajectory : Trajectory
    values : dict
        Values of the case as the results hold them.
    differing : dict
        Variables that came out otherwise, with the value stored and that of now; empty if every bit is the same.
    apart : str
        Sentence instead of a comparison, where there are no numbers to compare with.
    """

    title: str
    label: str
    source: str
    trajectory: Trajectory
    values: dict
    differing: dict = field(default_factory=dict)
    apart: str = ""

    @property
    def remark(self) -> str:
        """Sentence on how the numbers of now compare with those of the results."""
        if self.apart:
            return self.apart
        if not self.differing:
            return "the case run again, its energies the same in every bit"
        before, now = self.differing.get("energy_dissipated", next(iter(self.differing.values())))
        energies = f"{before:.6g} J per cycle stored, {now:.6g} J now"
        return f"the case run again by another version or on another machine: {energies}"


def again(
    source: str | Path,
    choice: Choice,
    *,
    frames: int = FRAMES,
    shown: int = CYCLES,
    anyway: bool = False,
    most: float = np.inf,
    report: Callable[[float], None] = lambda done: None,
) -> Again:
    """Run a case of a study again and record its last cycles.

    Parameters
    ----------
    source : str or Path
        Results (.nc), or the YAML file of a study, whose case is run twice: to its end, and recorded.
    choice : Choice
        Of results, the case of the largest effectiveness among those that it leaves; of a study it has to leave one.
    frames, shown : int
        Frames, and cycles of the drive that they show.
    anyway : bool
        Record results of another version or machine, too, whose numbers do not come out the same.
    most : float
        Particle-steps that the case and those before it may take.
    report : callable
        Called with the part that is done, 0 to 1.

    Returns
    -------
    Again

    Raises
    ------
    UsageError
        If there is no such case, or results of it; it takes too long; or its numbers are not those of the results.
    SimulationError
        If the case had failed.
    """
    source = Path(source)
    dataset, config = opened(source)
    if config.dampers:
        raise UsageError(f"{source}: is of several dampers on one structure: each has a case of its own")
    if dataset is not None and (missing := [name for name in NEEDED if name not in dataset]):
        raise UsageError(f"{source}: these are not the results of a whole run: there is no {missing[0]}")
    if dataset is not None and not anyway and (made := physics_of(dataset)) != PHYSICS_VERSION:
        raise UsageError(
            f"{source}: made by version {made} of the physics, and this is {PHYSICS_VERSION}: run the study again, or "
            "take --anyway for the case as it runs now"
        )
    cases = Cases(with_tolerance(self_contained(config)))
    numbers = candidates(cases, choice)
    number = only(cases, numbers) if dataset is None else _most_effective(cases, dataset, numbers)
    chain, criteria = chain_of(cases, number)
    values = simulated(chain, criteria) if dataset is None else [_stored(cases, dataset, n) for n, _ in chain]
    for (n, _), own in zip(chain, values, strict=True):
        refuse_failed(label(cases, n), own)
    specs = [spec for _, spec in chain]
    counts = [int(own["cycles"]) for own in values]
    refuse_long(source, particle_steps(chain, counts), most)
    trajectory = record(specs, counts, frames=frames, shown=shown, report=report)
    differing = _differing(trajectory, specs[-1], values[-1])
    if differing and not anyway:
        name, (before, now) = next(iter(differing.items()))
        raise UsageError(
            f"{source}: the case does not run to the same numbers here ({name} {before:.9g} stored, {now:.9g} now), as "
            "on another machine: run the study again, or take --anyway for the case as it runs now"
        )
    return Again(config.title, label(cases, number), provenance()["source"], trajectory, values[-1], differing)


def opened(source: Path) -> tuple[xr.Dataset | None, Config]:
    """Results, none of a study's YAML file, and the configuration of either."""
    dataset = read(source) if source.suffix == ".nc" else None
    return dataset, load(source) if dataset is None else stored_config(dataset, source)


def refuse_long(source: Path, steps: int, most: float) -> None:
    """Refuse a case of more particle-steps than are to be taken.

    Raises
    ------
    UsageError
    """
    if steps > most:
        raise UsageError(f"the case takes {steps:.2g} particle-steps: warpdamp film {source} films it")


def stored_config(dataset: xr.Dataset, source: Path) -> Config:
    """Configuration that results hold.

    Raises
    ------
    UsageError
        If they hold none, or one that this version cannot read.
    """
    if "configuration" not in dataset.attrs:
        raise UsageError(f"{source}: holds no configuration, so that no case of it can be run")
    with tempfile.TemporaryDirectory(prefix="warpdamp-") as folder:
        path = Path(folder) / "study.yaml"
        path.write_text(IN_SI + dataset.attrs["configuration"], encoding="utf-8")
        try:
            config = load(path)
        except ConfigError as error:
            first = str(error).splitlines()[0].removeprefix(f"{path}:")
            raise UsageError(f"{source}: its configuration cannot be read: {first}") from None
    config._source = None  # its file is gone
    return config


def physics_of(dataset: xr.Dataset) -> int | None:
    """Version of the physics that results are of; None if they do not say."""
    found = re.search(r"\(physics (\d+)\)", dataset.attrs.get("source", ""))
    return int(found[1]) if found else None


def chain_of(cases: Cases, number: int) -> tuple[list[tuple[int, Spec]], Criteria]:
    """The case and those before it that its bed was carried through, with their numbers; and its criteria."""
    plan = make_plan(cases)
    if not plan.keys[number]:
        raise UsageError(f"the case at {label(cases, number)} is no part of the study: excluded, or impossible")
    before = np.flatnonzero((plan.chain == plan.chain[number]) & (plan.turn < plan.turn[number]))
    numbers = [*before[np.argsort(plan.turn[before])], number]
    return [(int(n), cases.spec(int(n))[0]) for n in numbers], cases.spec(number)[1]


def simulated(chain, criteria: Criteria) -> list[dict]:
    """Values of the cases of a chain, run now."""
    return [values for _, values in shake([[spec for _, spec in chain]], criteria)]


def particle_steps(chain: list[tuple[int, Spec]], cycles: list[int]) -> int:
    """Particle-steps that cases of a chain take."""
    return sum(n * own.steps_per_cycle * len(own.bed.grains) for n, (_, own) in zip(cycles, chain, strict=True))


def _position(cases: Cases, dataset: xr.Dataset, number: int) -> dict[str, int] | None:
    """Index of a case in the Dataset; None if its packing was never needed."""
    place = np.unravel_index(number, cases.shape)
    index = {name: int(k) for name, k in zip(cases.dims, place, strict=True) if name in dataset["status"].dims}
    if "seed" in index:
        there = np.flatnonzero(dataset["seed"].values == cases.seeds[index["seed"]])
        if not len(there):
            return None
        index["seed"] = int(there[0])
    return index


def _stored(cases: Cases, dataset: xr.Dataset, number: int) -> dict:
    """Values of a case in the results; only its status, if it was not run."""
    index = _position(cases, dataset, number)
    if index is None:
        return {"status": int(Status.NOT_RUN)}
    dims = set(dataset["status"].dims)
    own = {name: array for name, array in dataset.data_vars.items() if set(array.dims) == dims}
    return {name: array.isel(index).item() for name, array in own.items()}


def _most_effective(cases: Cases, dataset: xr.Dataset, numbers: np.ndarray) -> int:
    """Number of the case of largest effectiveness among some that did not fail; the first, if none has any."""
    status, effectiveness = dataset["status"], dataset["effectiveness"].transpose(*dataset["status"].dims)
    value = np.full(len(numbers), -1.0)
    for k, number in enumerate(numbers):
        place = _position(cases, dataset, int(number))
        at = tuple(place[str(dim)] for dim in status.dims) if place else None
        if at and not _failed({"status": status.values[at]}):
            value[k] = np.nan_to_num(effectiveness.values[at], nan=-1.0)
    return int(numbers[int(np.argmax(value))])


def _failed(values: dict) -> bool:
    """Whether a case stopped before its end, or was not run."""
    status = Status(int(values["status"]))
    return status == Status.NOT_RUN or status in WITHOUT_FILM or status >= Status.FAILED


def refuse_failed(name: str, values: dict) -> None:
    """Refuse a case that stopped before its end, or was not run.

    Raises
    ------
    UsageError
        If it was not run.
    SimulationError
        If it had failed.
    """
    status = Status(int(values["status"]))
    if status == Status.NOT_RUN:
        raise UsageError(f"the results have no case at {name}: it was not run")
    if _failed(values):
        why = values.get("message") or status.meaning
        raise SimulationError(f"the case at {name} had failed, there is nothing to film: {why}")


def _differing(trajectory: Trajectory, spec: Spec, values: dict) -> dict:
    """Variables of the averaging window that came out otherwise than the results have them."""
    smallest = SMALLEST_EFFECTIVENESS * maximum_energy(spec.scene.drive, trajectory.particle_mass)
    window = trajectory.ledger.between(int(values["cycles_discarded"]), int(values["cycles"]))
    now = {"energy_dissipated": float(np.mean(window.per_cycle()))}
    now |= window_values(window, spec, trajectory.particle_mass, smallest)
    same = {name: value for name, value in now.items() if name in values}
    return {name: (values[name], value) for name, value in same.items() if not _equal(values[name], value)}


def _equal(one: float, other: float) -> bool:
    return one == other or (np.isnan(one) and np.isnan(other))
