"""Runner of a study's cases: compiles kernels, makes each bed once, then runs batches."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..status import Status
from .adaptive import needed_cases
from .batching import batches, limit
from .dispatch import Abandoned, Job, run_jobs
from .store import Finished
from .worker import Work, make_bed, shake_and_keep

if TYPE_CHECKING:
    from ..sweep.plan import Plan
    from .executors import WorkerPool
    from .run_log import RunLog
    from .store import Store

LONGEST_BED = 7200.0
"""Seconds after which a worker that makes a bed counts as hanging."""


class Runner:
    """Runner of the cases of a study on a pool of workers.

    Parameters
    ----------
    plan : Plan
    store : Store of the finished cases
    pool : WorkerPool
    run_log : RunLog
    limit : seconds after which a batch counts as hanging; None: by its cost
    report : called as ``report(stage, part_done)``
    """

    def __init__(
        self,
        plan: Plan,
        store: Store,
        pool: WorkerPool,
        run_log: RunLog,
        limit: float | None,
        report: Callable[[str, float], None],
    ):
        self.plan, self.store, self.pool = plan, store, pool
        self.run_log, self.limit, self.report = run_log, limit, report

    def run(self, numbers: np.ndarray) -> None:
        """Run the cases of these numbers.

        Raises
        ------
        ConfigError
            If none of the study's beds can be made.
        """
        self.report("kernels", 0.0)
        self._warm_up(numbers)
        self.report("kernels", 1.0)
        failed_beds = self._make_beds(numbers, partial(self.report, "beds"))
        failed = numbers[np.isin(self.plan.bed[numbers], list(failed_beds))]
        if len(failed) == len(needed_cases(self.plan, Finished())):
            reason, key = next(iter(failed_beds.values()))
            raise self.plan.cases.config.error(key, reason)
        if len(failed):
            self._fail(failed, Status.FAILED, lambda number: failed_beds[int(self.plan.bed[number])][0])
        if len(failed) < len(numbers):
            self._run_cases(np.setdiff1d(numbers, failed), partial(self.report, "cases"))

    def _warm_up(self, numbers: np.ndarray) -> None:
        """Compile all kernels, before workers need them."""
        from ..damper.preparation import effects
        from ..damper.shake import warm_up

        compiled = set()
        for group in np.unique(self.plan.group[numbers]):
            number = int(numbers[np.argmax(self.plan.group[numbers] == group)])
            spec, _ = self.plan.cases.spec(number)
            needed = {spec.effects} | effects(spec.bed)
            for effects_set in sorted(needed - compiled, key=str):
                warm_up(spec.scene, effects_set)
            compiled |= needed

    def _make_beds(self, numbers: np.ndarray, report: Callable[[float], None]) -> dict[int, tuple[str, str]]:
        """Make the beds; returns (reason, key to look at) of those that fail, by position in the plan."""
        positions = np.unique(self.plan.bed[numbers])
        examples = list(self.plan.beds.values())

        def call(job: Job):
            return make_bed, self.plan.cases.spec(examples[job.parts[0]])[0].bed

        each = (Job([int(position)], self.limit or LONGEST_BED) for position in positions)
        failed = {}
        report(0.0)
        for done, (job, result) in enumerate(self._run(each, call), 1):
            if isinstance(result, Abandoned):
                result = f"the bed could not be made: {result.reason}", "damper"
            if result is not None:
                failed[job.parts[0]] = result
                self.run_log.log(logging.WARNING, f"a bed cannot be made: {result[0]}")
            report(done / len(positions))
        return failed

    def _run(self, jobs: Iterator[Job], submit: Callable[[Job], tuple]) -> Iterator[tuple[Job, object]]:
        return run_jobs(jobs, self.pool, submit, self.run_log.at_work, self.store.folder)

    def _run_cases(self, numbers: np.ndarray, report: Callable[[float], None]) -> None:
        total, shaken = float(self.plan.cost[numbers].sum()), 0.0
        report(0.0)
        for job, result in self._run(self._jobs(numbers), self._order):
            members = [number for chain in job.parts for number in chain]
            if isinstance(result, Abandoned):
                status = Status.OVERDUE if result.overdue else Status.DIED
                self._fail(members, status, lambda _, reason=result.reason: reason)
            else:
                self.run_log.finished(result)
            shaken += float(self.plan.cost[members].sum())
            report(min(1.0, shaken / total))

    def _jobs(self, numbers: np.ndarray) -> Iterator[Job]:
        for chains in batches(self.plan, numbers, self.pool.size):
            yield Job(chains, self.limit or limit(self.plan, chains))

    def _order(self, job: Job) -> tuple:
        """Call that a worker makes for a job, and its arguments."""
        cases, keys = self.plan.cases, self.plan.keys
        chains = [[cases.spec(number)[0] for number in chain] for chain in job.parts]
        known = {
            spec.index: bytes(keys[number])
            for specs, chain in zip(chains, job.parts, strict=True)
            for spec, number in zip(specs, chain, strict=True)
        }
        _, criteria = self.plan.groups[self.plan.group[job.parts[0][0]]]
        return shake_and_keep, str(self.store.folder), Work(chains, known, criteria)

    def _fail(self, numbers, status: Status, why: Callable[[int], str]) -> None:
        """Store cases that could not be run, with their status and the reason."""
        rows = [(bytes(self.plan.keys[n]), {"status": int(status), "message": why(n)}) for n in numbers]
        self.store.write(rows)
        self.run_log.failed(len(rows))
