"""Running of a study's cases: kernels, beds and batches of cases, each as soon as what it needs is there."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..damper.scenes import effects
from ..kernels.groups import Kernels, kernels_for
from ..status import Status
from .adaptive import needed_cases
from .batching import batches, limit, pilots
from .dispatch import Abandoned, Job, run_jobs
from .estimate import Estimate
from .store import Finished
from .worker import Work, compile_kernels, make_bed, shake_and_keep

if TYPE_CHECKING:
    from ..damper.case import Spec
    from ..scene.effects import Effects
    from ..sweep.plan import Plan
    from .executors import WorkerPool
    from .run_log import RunLog
    from .store import Store

LONGEST_BED = 7200.0
"""Seconds after which a worker that compiles kernels or makes a bed counts as hanging."""


class KernelJob(Job):
    """Kernels to compile, which are its part and its name."""


class BedJob(Job):
    """Bed to make; its part is the bed's position in the plan."""


class CaseJob(Job):
    """Cases to run; its parts are chains of their numbers."""


STAGES = {KernelJob: "kernels", BedJob: "beds"}


class Runner:
    """Runner of the cases of a study.

    Parameters
    ----------
    plan : Plan
    store : Store
        Where results are kept.
    pool : WorkerPool
    run_log : RunLog
    limit : float or None
        Seconds after which a job counts as hanging; None: by its cost.
    report : callable
        Called as ``report(stage, part_done)``; the stages are kernels, beds and cases.
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
        self._numbers = np.zeros(0, int)
        self._estimate = Estimate(plan, self._numbers)
        self._bed_examples = list(plan.beds.values())
        self._planned: set = set()
        self._kernels: dict[Effects, frozenset[Kernels]] = {}
        self._counts = {kind: [0, 0] for kind in STAGES}  # of jobs ended, and of all
        self._failed_beds: dict[int, tuple[str, str]] = {}
        self._given = 0  # jobs of cases that workers have been given
        self._new_results = False

    def run(self, numbers: np.ndarray, further: Callable[[], np.ndarray]) -> None:
        """Run cases.

        Parameters
        ----------
        numbers : (n,) array
            Numbers of the cases.
        further : callable
            Returns numbers of cases that the results so far require beside those that it has returned before.

        Raises
        ------
        ConfigError
            If none of the study's beds can be made.
        """
        end = {KernelJob: self._kernels_compiled, BedJob: self._bed_made, CaseJob: self._cases_run}
        jobs = self._jobs(numbers, further)
        for job, result in run_jobs(jobs, self.pool, self._order, self.run_log.at_work, self.store.folder):
            end[type(job)](job, result)
        self._refuse_if_no_bed_can_be_made()

    def _jobs(self, numbers: np.ndarray, further: Callable[[], np.ndarray]) -> Iterator[Job | None]:
        """Jobs of the numbers given, then of further ones as results require them; None while none are known."""
        while True:
            if len(numbers):
                first = pilots(self.plan, numbers) if not len(self._numbers) else numbers[:0]
                self._numbers = np.union1d(self._numbers, numbers)
                self._estimate.add(numbers)
                yield from self._first_jobs(numbers)
                pilot_jobs = list(self._case_jobs(first, mixed=True))  # all frequencies early, for what they take
                yield from pilot_jobs
                while self._given < len(pilot_jobs):  # says how the others are put together
                    yield None
                yield from self._case_jobs(numbers[~np.isin(self.plan.keys[numbers], self.plan.keys[first])])
            while not self._new_results:
                yield None
            self._new_results = False
            numbers = further()

    def _first_jobs(self, numbers: np.ndarray) -> Iterator[Job]:
        """Jobs for kernels and beds that cases need and no job was made for yet; first the kernels of the beds."""
        longest = self.limit or LONGEST_BED
        beds = {int(bed): self.plan.cases.spec(self._bed_examples[bed])[0] for bed in np.unique(self.plan.bed[numbers])}
        for_beds = {bed: effects(spec.bed) for bed, spec in beds.items()}
        for_cases = {self.plan.groups[group][0] for group in np.unique(self.plan.group[numbers])}
        self._kernels |= {needed: frozenset(kernels_for(needed)) for needed in for_cases}
        first = _kernels_of(set().union(*for_beds.values()))
        later = [kernels for kernels in _kernels_of(for_cases) if kernels not in first]
        jobs: list[Job] = [KernelJob([kernels], longest, name=kernels) for kernels in first]
        jobs += [BedJob([bed], longest, needs=frozenset(_kernels_of(of)), name=bed) for bed, of in for_beds.items()]
        jobs += [KernelJob([kernels], longest, name=kernels) for kernels in later]
        jobs = [job for job in jobs if job.name not in self._planned]
        self._planned.update(job.name for job in jobs)
        for kind in STAGES:
            self._counts[kind][1] += sum(isinstance(job, kind) for job in jobs)
            self._report_stage(kind)
        yield from jobs

    def _case_jobs(self, numbers: np.ndarray, *, mixed: bool = False) -> Iterator[Job]:
        for chains in batches(self.plan, numbers, self.pool.size, costs=self._estimate.costs, mixed=mixed):
            first = [chain[0] for chain in chains]
            effects, _ = self.plan.groups[self.plan.group[first[0]]]
            needs = self._kernels[effects] | set(map(int, self.plan.bed[first]))
            yield CaseJob(chains, self.limit or limit(self.plan, chains), needs=needs)

    def _order(self, job: Job) -> tuple | None:
        """Call that a worker makes for a job, and its arguments."""
        if isinstance(job, KernelJob):
            return compile_kernels, job.parts[0]
        if isinstance(job, BedJob):
            return make_bed, self.plan.cases.spec(self._bed_examples[job.parts[0]])[0].bed
        self._given += 1
        job.parts = [chain for chain in job.parts if int(self.plan.bed[chain[0]]) not in self._failed_beds]
        return (shake_and_keep, str(self.store.folder), self._work(job.parts)) if job.parts else None

    def _work(self, chains: list[list[int]]) -> Work:
        if self.run_log.cases_start():
            self.report("cases", 0.0)
        specs: list[list[Spec]] = [[self.plan.cases.spec(number)[0] for number in chain] for chain in chains]
        keys = {
            spec.index: bytes(self.plan.keys[number])
            for chain_specs, chain in zip(specs, chains, strict=True)
            for spec, number in zip(chain_specs, chain, strict=True)
        }
        _, criteria = self.plan.groups[self.plan.group[chains[0][0]]]
        return Work(specs, keys, criteria)

    def _kernels_compiled(self, job: KernelJob, result) -> None:
        if isinstance(result, Abandoned):
            self.run_log.log(logging.WARNING, f"kernels could not be compiled: {result.reason}")
        self._end_of(KernelJob)

    def _bed_made(self, job: BedJob, result) -> None:
        """Note a bed; if it cannot be made, its cases have failed."""
        if isinstance(result, Abandoned):
            result = f"the bed could not be made: {result.reason}", "damper"
        if result is not None:
            (bed,) = job.parts
            self._failed_beds[bed] = result
            self.run_log.log(logging.WARNING, f"a bed cannot be made: {result[0]}")
            self._fail(self._numbers[self.plan.bed[self._numbers] == bed], Status.FAILED, result[0])
        self._end_of(BedJob)

    def _cases_run(self, job: CaseJob, result) -> None:
        members = np.array([number for chain in job.parts for number in chain])
        if isinstance(result, Abandoned):
            self._fail(members, Status.OVERDUE if result.overdue else Status.DIED, result.reason)
            return
        self.run_log.finished(result)
        self._count(members, result.each)

    def _fail(self, numbers: np.ndarray, status: Status, reason: str) -> None:
        """Store cases that could not be run, with their status and the reason."""
        self.store.write([(bytes(self.plan.keys[n]), {"status": int(status), "message": reason}) for n in numbers])
        self.run_log.failed(len(numbers))
        self._count(numbers, np.zeros(len(numbers)))

    def _count(self, numbers: np.ndarray, seconds) -> None:
        self._new_results = True
        self._estimate.finished(numbers, seconds)
        self.run_log.progress(self._estimate.share)
        self.report("cases", self._estimate.share)

    def _end_of(self, kind: type[Job]) -> None:
        self._counts[kind][0] += 1
        self._report_stage(kind)

    def _report_stage(self, kind: type[Job]) -> None:
        ended, planned = self._counts[kind]
        self.report(STAGES[kind], ended / planned if planned else 1.0)

    def _refuse_if_no_bed_can_be_made(self) -> None:
        """Raise if every bed of the study failed.

        Raises
        ------
        ConfigError
        """
        needed = needed_cases(self.plan, Finished())
        if self._failed_beds and np.isin(self.plan.bed[needed], list(self._failed_beds)).all():
            reason, key = next(iter(self._failed_beds.values()))
            raise self.plan.cases.config.error(key, reason)


def _kernels_of(sets: set[Effects]) -> list[Kernels]:
    """Kernels of several sets of effects, each once, the slowest to compile first."""
    groups = zip(*(kernels_for(effects) for effects in sorted(sets, key=str)), strict=True)
    return list(dict.fromkeys(kernels for group in groups for kernels in group))
