"""Run of a study: configuration -> cases -> beds -> batches -> store -> Dataset."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import ExitStack
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
from ..execution.worker import get_ready
from ..status import FIRST_UNFINISHED, Status
from ..sweep.cases import Cases
from ..sweep.load import load
from ..sweep.plan import Plan, load_or_make_plan, save_plan
from ..sweep.resolve import self_contained, shortened, with_tolerance
from ..sweep.stored import load_plan
from .dataset import assemble
from .several import combined, studies

if TYPE_CHECKING:
    import xarray as xr


Report = Callable[[str, float], None]
"""Called with the stage and the part of it that is done, 0 to 1."""


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
    config : Config, str or Path
        Configuration, or its YAML file.
    store : str or Path, optional
        Folder in which every case is stored as soon as its batch is done, and from which a study that was interrupted,
        or enlarged, continues (default: nothing is stored).
    executor : str or concurrent.futures.Executor
        "processes", "in-process", "dask" (a cluster started here), the address of a Dask scheduler, or an Executor.
    workers : int, optional
        Number of workers (default: the cores of this machine).
    quick : bool
        Run ``shortened(config)``, a first look.
    limit : float, optional
        Seconds after which a batch counts as hanging (default: far above what it may take).
    report : callable
        Called as ``report(stage, part_done)``, ``part_done`` from 0 to 1.

    Returns
    -------
    xarray.Dataset
        See ``warpdamp.variables.VARIABLES`` for its variables.

    Raises
    ------
    ConfigError
        If the configuration cannot be run, or its beds cannot be made.
    SimulationError
        If every case failed.
    StoreError
        If the store cannot be written, or another run is in progress in it.
    ValueError
        If there is no such executor, or fewer than one worker.

    Examples
    --------
    >>> import warpdamp
    >>> study = warpdamp.Config(  # or a path, as "configs/beam.yaml"
    ...     damper={
    ...         "enclosure": {"diameter": "40 mm", "height": "40 mm", "material": "pmma"},
    ...         "particles": {"count": 12, "radius": "3.73 mm", "material": "pmma"},
    ...     },
    ...     materials={"pmma": {"density": "920 kg/m^3", "youngs_modulus": "3.3 GPa", "poissons_ratio": 0.37}},
    ...     contact={"restitution": 0.52, "friction": 0.86},
    ...     excitation={"frequency": "46 Hz", "gamma": [4, 8]},
    ...     preparation="loose",
    ...     steady_state={"fewest_cycles": 8, "most_cycles": 8},
    ... )
    >>> results = warpdamp.run(study, executor="in-process")
    >>> dict(results.sizes)
    {'frequency': 1, 'gamma': 2, 'seed': 1}
    >>> bool((results["ledger_residual"] < 0.02).all())
    True
    """
    if not isinstance(config, Config):
        config = load(config)
    options = {"executor": executor, "workers": workers, "limit": limit, "report": report}
    if config.dampers:
        return _run_several(shortened(config) if quick else config, store, options)
    with TemporaryDirectory(prefix="warpdamp-") as scratch:
        folder = Path(store or scratch)
        plan = carry_out(config, folder, quick=quick, **options)
        return _collected(plan, Store(folder))


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
    config : Config, str or Path
        Configuration, or its YAML file.
    store : str or Path
        Folder of the finished cases; made if it does not exist.
    part : (int, int), optional
        (k, n) for the k-th of n parts, which may run at the same time; together they are the whole.
    executor, workers, quick, limit, report
        See ``run``.

    Returns
    -------
    Plan
        All cases of the study, those of other parts among them.

    Raises
    ------
    ConfigError
        If the configuration cannot be run, or its beds cannot be made.
    StoreError
        If the store cannot be written, or another run is in progress in it or in this part.
    ValueError
        If there is no such executor, or fewer than one worker.
    """
    if workers is not None and workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers}")
    if not isinstance(config, Config):
        config = load(config)
    if config.dampers:
        raise config.error("dampers", "several dampers are run as a whole: leave --part out")
    config = with_tolerance(self_contained(shortened(config) if quick else config))
    results = Store(store)
    with results.lock(part), ExitStack() as stack:
        pool = None
        if executor == "processes" and results.is_empty:  # there is something to run: they start while it is planned
            pool = stack.enter_context(worker_pool(executor, workers))
            pool.start(get_ready)
        report("modes", 0.0)
        plan = load_or_make_plan(Cases(config), results.folder)
        report("modes", 1.0)
        _refuse_what_does_not_fit(plan)
        save_plan(plan, results.folder)
        numbers = _left(plan, results, part)
        with RunLog(results.folder, len(numbers), part) as run_log:
            if len(numbers):
                pool = pool or stack.enter_context(worker_pool(executor, workers))
                further = _Further(plan, results, part, numbers, run_log)
                Runner(plan, results, pool, run_log, limit, report).run(numbers, further)
    return plan


class _Further:
    """Numbers of the cases that the results so far require, beside those that were run before; each is tried once."""

    def __init__(self, plan: Plan, store: Store, part: tuple[int, int] | None, tried: np.ndarray, run_log: RunLog):
        self.plan, self.store, self.part = plan, store, part
        self.tried, self.run_log = tried, run_log

    def __call__(self) -> np.ndarray:
        if self.plan.cases.config.accuracy is None:
            return np.zeros(0, int)
        numbers = np.setdiff1d(_left(self.plan, self.store, self.part), self.tried)
        if len(numbers):
            self.tried = np.union1d(self.tried, numbers)
            self.run_log.further(len(numbers))
        return numbers


def collect(store: str | Path) -> xr.Dataset:
    """Dataset of what is done of the study in a store, at any moment.

    Parameters
    ----------
    store : str or Path
        Folder that ``run`` or ``carry_out`` was given, or one above it.

    Returns
    -------
    xarray.Dataset
        See ``warpdamp.variables.VARIABLES`` for its variables; cases not yet run have the ``status`` NOT_RUN.

    Raises
    ------
    StoreError
        If there is no study in the folder.
    """
    results = Store.existing(store)
    return _with_accessor(assemble(load_plan(results.folder), results.read()))


def _collected(plan: Plan, store: Store) -> xr.Dataset:
    """Dataset of what is done, unless every case failed.

    Raises
    ------
    ConfigError, SimulationError
        If every case failed.
    """
    finished = store.read()
    _raise_if_all_failed(plan, finished)
    return _with_accessor(assemble(plan, finished))


def _with_accessor(dataset: xr.Dataset) -> xr.Dataset:
    """Register ``dataset.damper``; returns the Dataset."""
    from .. import accessor  # noqa: F401  it registers itself with xarray, which takes its time to import

    return dataset


def _raise_if_all_failed(plan: Plan, finished: Finished) -> None:
    """Raise if every case failed; a single failed case of a sweep is a value.

    Raises
    ------
    SimulationError
    """
    in_study = np.isin(finished.keys, plan.keys[plan.to_run()])
    status = finished.status[in_study]
    energy = finished.values.get("energy_dissipated", np.full(len(finished), np.nan))[in_study]
    if not in_study.any() or np.isfinite(energy).any():
        return
    worst = Status(int(status.max()))
    reason = next((message for message in finished.messages[in_study] if message), worst.meaning)
    raise SimulationError(f"all {in_study.sum()} cases failed: {reason}")


def _left(plan: Plan, store: Store, part: tuple[int, int] | None) -> np.ndarray:
    """Numbers of the cases to run: needed, of this part, and not in the store."""
    finished = store.read(NEEDED, repair=True)
    numbers = needed_cases(plan, finished)
    if part is not None:
        k, n = part
        owners = plan.keys[plan.chain[_first_packings(plan)[numbers]]]
        in_part = np.array([int.from_bytes(bytes(owner)[:7], "big") % n == k - 1 for owner in owners], bool)
        numbers = numbers[in_part]
    return numbers[~np.isin(plan.keys[numbers], finished.keys[finished.status < FIRST_UNFINISHED])]


def _first_packings(plan: Plan) -> np.ndarray:
    """Case by which each is assigned to a part: itself or, with a tolerance, its point's first packing.

    Whether a point needs another packing is seen only by who has the others.
    """
    numbers = np.arange(len(plan.keys))
    return numbers if plan.cases.config.accuracy is None else numbers - numbers % plan.cases.shape[-1]


def _refuse_what_does_not_fit(plan: Plan) -> None:
    """Refuse a single bed that cannot be made before anything long starts; one of several is a failed case.

    Raises
    ------
    ConfigError
    """
    from ..damper.placement import place

    if math.prod(plan.cases.shape[2:-1]) > 1:
        return
    for number in plan.beds.values():
        spec, _ = plan.cases.spec(number)
        try:
            place(spec.bed.grains, spec.scene.enclosure, spec.bed.seed)
        except PackingError as error:
            raise plan.cases.config.error(error.key, str(error)) from None
