"""Dispatch of jobs to a pool of workers, with retries where a worker died or hangs."""

from __future__ import annotations

import logging
import os
import platform
import time
from collections import deque
from collections.abc import Callable, Hashable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .executors import WorkerPool

_log = logging.getLogger(__name__)

TICK = 1.0
"""Seconds between two checks of the jobs in progress."""

LOSSES = 3
"""After so many losses a job is split, and its parts are run with nothing else in progress; after as many more a
part is abandoned."""

STARTS_WITHIN = 600.0
"""Seconds beyond its limit after which a job that has not even started is lost: its worker may still be starting."""

_numbers = count()


@dataclass
class Job:
    """Unit of work that can be split.

    Parameters
    ----------
    parts : list
        What it can be split into.
    limit : float
        Seconds from its start on a worker after which it counts as hanging.
    losses : int
        How often it did not come back.
    suspect : bool
        Whether it runs with nothing else in progress.
    needs : frozenset
        Names of the jobs that must have ended, well or not, before it starts.
    name : hashable or None
        By which others need it.
    """

    parts: list
    limit: float
    losses: int = 0
    suspect: bool = False
    needs: frozenset = frozenset()
    name: Hashable = None

    def apart(self) -> list[Job]:
        """Jobs of one part each."""
        return [replace(self, parts=[part], losses=0, suspect=True) for part in self.parts]


@dataclass(frozen=True)
class Abandoned:
    """Outcome of an abandoned job."""

    overdue: bool
    reason: str


def run_jobs(
    jobs: Iterator[Job | None],
    pool: WorkerPool,
    submit: Callable[[Job], tuple | None],
    report: Callable[[int], None],
    folder: Path,
    *,
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[tuple[Job, object]]:
    """Run all jobs; yields each with its result, or with ``Abandoned``.

    Parameters
    ----------
    jobs : iterator of Job
        In the order in which they start, as far as what they need has ended; None where there is none at the moment.
    pool : WorkerPool
    submit : callable
        From a job to a call and its arguments, or None if there is nothing left to do for it.
    report : callable
        Given the number of jobs in progress, at every look.
    folder : Path
        Where workers say that they have started a job; all of them see it.
    clock : callable
        Seconds, by which limits are measured.

    Raises
    ------
    Exception
        What a call raises, other than by the death of its worker.
    """
    dispatcher = _Dispatcher(jobs, pool, submit, folder, clock)
    while dispatcher.submit_next():
        yield from dispatcher.completed()
        yield from dispatcher.abandoned()
        report(len(dispatcher.in_flight))


def _announced(marker: str, call: Callable, arguments: tuple):
    """Run a call on a worker after touching ``marker``, which shows that the job has started."""
    Path(marker).touch()
    return call(*arguments)


@dataclass
class _Running:
    """Job in progress: when it was submitted and started, and the file that its worker makes when it starts."""

    job: Job
    marker: Path
    submitted: float
    started: float | None = None

    def overdue(self, now: float) -> bool:
        """Whether it takes longer than its limit, counted from its start."""
        if self.started is None and self.marker.exists():
            self.started = now
        if self.started is None:
            return now - self.submitted > self.job.limit + STARTS_WITHIN
        return now - self.started > self.job.limit


@dataclass(frozen=True)
class _Lost:
    """Job that did not come back, and why."""

    job: Job
    reason: str
    overdue: bool = False


class _Dispatcher:
    """State of the dispatch: jobs in progress, retries and suspects."""

    def __init__(self, jobs: Iterator[Job], pool: WorkerPool, submit: Callable[[Job], tuple], folder: Path, clock):
        self.source, self.pool, self.submit = iter(jobs), pool, submit
        self.folder, self.clock = folder, clock
        self.in_flight: dict[Future, _Running] = {}
        self.waiting: list[Job] = []
        self.ended: set[Hashable] = set()
        self.retries: deque[Job] = deque()
        self.suspects: deque[Job] = deque()
        self.lost: list[_Lost] = []

    def submit_next(self) -> bool:
        """Submit jobs until every worker is busy; returns whether any are in progress."""
        while len(self.in_flight) < self.pool.size and not any(run.job.suspect for run in self.in_flight.values()):
            job = self._following()
            if job is None:
                break
            order = self.submit(job)
            if order is None:
                continue
            call, *arguments = order
            marker = self.folder / f".started-{platform.node()}-{os.getpid()}-{next(_numbers)}.tmp"
            try:
                future = self.pool.submit(_announced, str(marker), call, tuple(arguments))
                self.in_flight[future] = _Running(job, marker, self.clock())
            except BrokenExecutor:  # a worker died between two looks
                self.retries.appendleft(job)
                self.pool.restart(hanging=False)
        return bool(self.in_flight)

    def _following(self) -> Job | None:
        """Next job that can start: one to retry, one that has waited, one from the source; alone, a suspect."""
        if self.retries:
            return self.retries.popleft()
        for k, job in enumerate(self.waiting):
            if job.needs <= self.ended:
                return self.waiting.pop(k)
        while (job := next(self.source, None)) is not None:
            if job.needs <= self.ended:
                return job
            self.waiting.append(job)
        return self.suspects.popleft() if self.suspects and not self.in_flight else None

    def _landed(self, future: Future) -> Job:
        """Remove a job from those in progress."""
        running = self.in_flight.pop(future)
        running.marker.unlink(missing_ok=True)
        return running.job

    def completed(self) -> Iterator[tuple[Job, object]]:
        """Wait up to ``TICK``; yields finished jobs with their results, and records lost ones."""
        done, _ = wait(self.in_flight, timeout=TICK, return_when=FIRST_COMPLETED)
        for future in done:
            job = self._landed(future)
            try:
                result = future.result()
            except Exception as error:
                if not _is_death(error):
                    raise
                self.lost.append(_Lost(job, f"its worker died: {error}"))
            else:
                self.ended.add(job.name)
                yield job, result

    def abandoned(self) -> Iterator[tuple[Job, Abandoned]]:
        """Retry lost jobs, with new workers where needed; yields those that are abandoned."""
        hanging = self._overdue()
        lost, self.lost = self.lost + hanging, []
        if lost and self.pool.restart(hanging=bool(hanging)):
            others = [self._landed(future) for future in list(self.in_flight)]
            if hanging:  # stopped although they did not hang
                self.retries.extend(others)
            else:
                lost += [_Lost(job, "its worker died, or another's did") for job in others]
        for loss in lost:
            if not self._retried(loss):
                self.ended.add(loss.job.name)
                yield loss.job, Abandoned(loss.overdue, loss.reason)

    def _overdue(self) -> list[_Lost]:
        """Jobs over their time limit, removed from those in progress."""
        now = self.clock()
        jobs = [self._landed(future) for future, running in list(self.in_flight.items()) if running.overdue(now)]
        return [_Lost(job, f"it took more than {job.limit:.0f} s", overdue=True) for job in jobs]

    def _retried(self, loss: _Lost) -> bool:
        """Retry a job as it is, split, or alone; returns whether it is retried."""
        job = loss.job
        job.losses += 1
        _log.warning("a job of %d did not come back (%s), for the %d. time", len(job.parts), loss.reason, job.losses)
        if job.losses < LOSSES and not loss.overdue:
            (self.suspects if job.suspect else self.retries).append(job)
        elif len(job.parts) > 1 or not job.suspect:
            self.suspects.extend(job.apart())
        else:
            return False
        return True


def _is_death(error: Exception) -> bool:
    """Whether a call was lost with its worker; Dask's own errors are known by name: it is an extra."""
    return isinstance(error, BrokenExecutor | CancelledError) or type(error).__name__ in (
        "KilledWorker", "FutureCancelledError", "CommClosedError",
    )  # fmt: skip
