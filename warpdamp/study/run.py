"""The order of the work: configuration -> cases -> beds -> batches -> store -> Dataset."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from ..config.study import Config
from ..errors import ConfigError, PackingError, SimulationError
from ..execution.adaptive import NEEDED, needed_cases
from ..execution.executors import worker_pool
from ..execution.run_log import RunLog
from ..execution.runner import Runner
from ..execution.store import Finished, Store
from ..status import FIRST_UNFINISHED, Status
from ..sweep.cases import Cases
from ..sweep.load import load, load_plan
from ..sweep.plan import Plan, load_or_make_plan, save_plan
from ..sweep.resolve import applied, settled, shortened
from .dataset import assemble
from .several import combined, studies

if TYPE_CHECKING:
    import xarray as xr


Report = Callable[[str, float], None]
"""Told the stage and the part of it that is done, 0 to 1."""


def run(
    config: Config | str | Path,
    *,
    store: str | Path | None = None,
    executor: str | Executor = "processes",
    workers: int | None = None,
    quick: bool = False,
    limit: float | None = None,
    report: Report = lambda stage, done: None,
) -> xr.Dataset:
    """Run a study, or what is left of it.

    Parameters
    ----------
    config : Config or path of a YAML file
    store : folder in which every case is kept as soon as its batch is done, and from which a study that was
        interrupted, or enlarged, goes on (default: none is kept)
    executor : "processes", "in-process", "dask" (a cluster started here), the address of a Dask scheduler, or an
        ``concurrent.futures.Executor``
    workers : how many (default: the cores of this machine)
    quick : run ``shortened(config)``
    limit : seconds after which a batch is taken for hanging (default: far above what it may take)
    report : called as ``report(stage, part_done)``

    Returns
    -------
    xarray.Dataset
        See ``warpdamp.results.VARIABLES`` for its variables.

    Raises
    ------
    ConfigError
        If the configuration cannot be run, or its beds cannot be made.
    SimulationError
        If every case failed.
    StoreError
        If the store cannot be written, or another run is at work in it.
    """
    if not isinstance(config, Config):
        config = load(config)
    options = {"executor": executor, "workers": workers, "limit": limit, "report": report}
    if config.dampers:
        return _run_several(shortened(config) if quick else config, store, options)
    with TemporaryDirectory(prefix="warpdamp-") as scratch:
        folder = Path(store or scratch)
        made = carry_out(config, folder, quick=quick, **options)
        return _collected(made, Store(folder))


def _run_several(config: Config, store: str | Path | None, options: dict) -> xr.Dataset:
    """The study of each of several dampers, in a folder of its own, and what they add up to."""
    own, seen = studies(config)
    found = []
    for k, study in enumerate(own):
        try:
            found.append(run(study, store=Path(store) / f"damper-{k + 1}" if store else None, **options))
        except ConfigError as error:
            raise config.error(("dampers", k - 1) if k else "damper", str(error)) from None
    return _with_accessor(combined(config, found, seen))


def carry_out(
    config: Config | str | Path,
    store: str | Path,
    *,
    part: tuple[int, int] | None = None,
    executor: str | Executor = "processes",
    workers: int | None = None,
    quick: bool = False,
    limit: float | None = None,
    report: Report = lambda stage, done: None,
) -> Plan:
    """Run the cases of a study, or of one part of it, that are not in a store yet; see ``run``.

    Parameters
    ----------
    part : (k, n) for the k-th of n parts, which may run side by side; together they are the whole
    """
    if workers is not None and workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers}")
    if not isinstance(config, Config):
        config = load(config)
    if config.dampers:
        raise config.error("dampers", "several dampers are run as a whole: leave --part out")
    config = applied(settled(shortened(config) if quick else config))
    kept = Store(store)
    with kept.lock(part):
        report("modes", 0.0)
        made = load_or_make_plan(Cases(config), kept.folder)
        report("modes", 1.0)
        _refuse_what_does_not_fit(made)
        save_plan(made, kept.folder)
        numbers = _left(made, kept, part)
        with RunLog(kept.folder, len(numbers), part) as run_log:
            if len(numbers):
                with worker_pool(executor, workers) as own:
                    runner = Runner(made, kept, own, run_log, limit, report)
                    runner.run(numbers)
                    for further in _further(made, kept, part, numbers):
                        run_log.further(len(further))
                        runner.run(further)
    return made


def _further(made: Plan, kept: Store, part: tuple[int, int] | None, tried: np.ndarray) -> Iterator[np.ndarray]:
    """Numbers of the cases that the results of those before call for, round by round; each is tried once."""
    while made.cases.config.accuracy is not None:
        numbers = np.setdiff1d(_left(made, kept, part), tried)
        if not len(numbers):
            return
        tried = np.union1d(tried, numbers)
        yield numbers


def collect(store: str | Path) -> xr.Dataset:
    """What is done of the study in a store, at any moment, as one Dataset.

    Raises
    ------
    StoreError
        If there is no study in the folder.
    """
    kept = Store.existing(store)
    return _with_accessor(assemble(load_plan(kept.folder), kept.read()))


def _collected(made: Plan, kept: Store) -> xr.Dataset:
    """All that is done, if anything is.

    Raises
    ------
    ConfigError, SimulationError
        If every case failed.
    """
    finished = kept.read()
    _raise_if_all_failed(made, finished)
    return _with_accessor(assemble(made, finished))


def _with_accessor(dataset: xr.Dataset) -> xr.Dataset:
    """The Dataset, once ``dataset.damper`` is there."""
    from .. import accessor  # noqa: F401  it registers itself with xarray, which takes its time to import

    return dataset


def _raise_if_all_failed(made: Plan, finished: Finished) -> None:
    """One bad case of a sweep is a value; a study of which nothing is left is an error.

    Raises
    ------
    SimulationError
    """
    own = np.isin(finished.keys, made.keys[made.to_run()])
    status = finished.status[own]
    energy = finished.values.get("energy_dissipated", np.full(len(finished), np.nan))[own]
    if not own.any() or np.isfinite(energy).any():
        return
    worst = Status(int(status.max()))
    said = next((message for message in finished.messages[own] if message), worst.meaning)
    raise SimulationError(f"all {own.sum()} cases failed: {said}")


def _left(made: Plan, kept: Store, part: tuple[int, int] | None) -> np.ndarray:
    """Numbers of the cases to run: called for, of this part, and not in the store."""
    finished = kept.read(NEEDED, repair=True)
    numbers = needed_cases(made, finished)
    if part is not None:
        k, n = part
        owners = made.keys[made.chain[_first_packings(made)[numbers]]]
        own = np.array([int.from_bytes(bytes(owner)[:7], "big") % n == k - 1 for owner in owners], bool)
        numbers = numbers[own]
    return numbers[~np.isin(made.keys[numbers], finished.keys[finished.status < FIRST_UNFINISHED])]


def _first_packings(made: Plan) -> np.ndarray:
    """For every case the one by which it is dealt to a part: itself or, with a tolerance, its point's first packing.

    Whether a point needs another packing is seen only by who has the others.
    """
    every = np.arange(len(made.keys))
    return every if made.cases.config.accuracy is None else every - every % made.cases.shape[-1]


def _refuse_what_does_not_fit(made: Plan) -> None:
    """A single bed that cannot be made is refused before anything long starts; one of several is a failed case.

    Raises
    ------
    ConfigError
    """
    from ..damper.placement import separate

    if math.prod(made.cases.shape[2:-1]) > 1:
        return
    for number in made.beds.values():
        spec, _ = made.cases.spec(number)
        try:
            separate(spec.bed.grains.radius, spec.scene.enclosure, spec.bed.seed)
        except PackingError as error:
            raise made.cases.config.error(error.key, str(error)) from None
