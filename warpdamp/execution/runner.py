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
"""Seconds after which a worker that makes a bed is taken for hanging."""


class Runner:
    """Runner of the cases of a study on a pool of workers.

    Parameters
    ----------
    plan : Plan
    store : where they are kept
    pool : WorkerPool
    run_log : RunLog
    limit : seconds after which a batch is taken for hanging; None: by its cost
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
        without = self._make_beds(numbers, partial(self.report, "beds"))
        bad = numbers[np.isin(self.plan.bed[numbers], list(without))]
        if len(bad) == len(needed_cases(self.plan, Finished())):
            said, key = next(iter(without.values()))
            raise self.plan.cases.config.error(key, said)
        if len(bad):
            self._give_up(bad, Status.FAILED, lambda number: without[int(self.plan.bed[number])][0])
        if len(bad) < len(numbers):
            self._run_cases(np.setdiff1d(numbers, bad), partial(self.report, "cases"))

    def _warm_up(self, numbers: np.ndarray) -> None:
        """Compile all kernels, before workers need them."""
        from ..damper.preparation import effects
        from ..damper.shake import warm_up

        seen = set()
        for group in np.unique(self.plan.group[numbers]):
            number = int(numbers[np.argmax(self.plan.group[numbers] == group)])
            spec, _ = self.plan.cases.spec(number)
            needed = {spec.effects} | effects(spec.bed)
            for one in sorted(needed - seen, key=str):
                warm_up(spec.scene, one)
            seen |= needed

    def _make_beds(self, numbers: np.ndarray, report: Callable[[float], None]) -> dict[int, tuple[str, str]]:
        """Make the beds; returns (reason, key to look at) of those that fail, by position in the plan."""
        wanted = np.unique(self.plan.bed[numbers])
        examples = list(self.plan.beds.values())

        def call(job: Job):
            return make_bed, self.plan.cases.spec(examples[job.parts[0]])[0].bed

        each = (Job([int(position)], self.limit or LONGEST_BED) for position in wanted)
        without = {}
        report(0.0)
        for done, (job, answer) in enumerate(self._run(each, call), 1):
            if isinstance(answer, Abandoned):
                answer = f"the bed could not be made: {answer.reason}", "damper"
            if answer is not None:
                without[job.parts[0]] = answer
                self.run_log.say(logging.WARNING, f"a bed cannot be made: {answer[0]}")
            report(done / len(wanted))
        return without

    def _run(self, jobs: Iterator[Job], submit: Callable[[Job], tuple]) -> Iterator[tuple[Job, object]]:
        return run_jobs(jobs, self.pool, submit, self.run_log.at_work, self.store.folder)

    def _run_cases(self, numbers: np.ndarray, report: Callable[[float], None]) -> None:
        total, shaken = float(self.plan.cost[numbers].sum()), 0.0
        report(0.0)
        for job, answer in self._run(self._jobs(numbers), self._order):
            members = [number for chain in job.parts for number in chain]
            if isinstance(answer, Abandoned):
                self._give_up(members, Status.OVERDUE if answer.overdue else Status.DIED, lambda _: answer.reason)  # noqa: B023
            else:
                self.run_log.finished(answer)
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
            for own, chain in zip(chains, job.parts, strict=True)
            for spec, number in zip(own, chain, strict=True)
        }
        _, criteria = self.plan.groups[self.plan.group[job.parts[0][0]]]
        return shake_and_keep, str(self.store.folder), Work(chains, known, criteria)

    def _give_up(self, numbers, status: Status, why: Callable[[int], str]) -> None:
        """Keep cases that could not be run as what they are."""
        rows = [(bytes(self.plan.keys[n]), {"status": int(status), "message": why(n)}) for n in numbers]
        self.store.write(rows)
        self.run_log.given_up(len(rows))
