"""Hands batches to a crew, and sees to those that do not come back."""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .executors import Crew

_log = logging.getLogger(__name__)

TICK = 1.0
"""Seconds between looks at what is in progress."""

LOSSES = 3
"""After so many losses a batch is taken apart, and its parts are run with nobody else at work; after as many more a
part is given up."""


@dataclass
class Batch:
    """Work that is done as one, and can be taken apart.

    Parameters
    ----------
    parts : what it can be taken apart into
    limit : seconds after which it is taken for hanging
    losses : how often it did not come back
    suspect : whether it runs with nobody else at work
    """

    parts: list
    limit: float
    losses: int = 0
    suspect: bool = False

    def apart(self) -> list[Batch]:
        """Each part on its own."""
        return [Batch([part], self.limit, 0, True) for part in self.parts]


@dataclass(frozen=True)
class Lost:
    """What became of a batch that was given up."""

    overdue: bool
    reason: str


def work(
    batches: Iterator[Batch], crew: Crew, submit: Callable[[Batch], tuple], report: Callable[[int], None]
) -> Iterator[tuple[Batch, object]]:
    """Have every batch done; yields each with its result, or with ``Lost``.

    Parameters
    ----------
    submit : from a batch to a call and its arguments
    report : told the number of batches in progress, at every look

    Raises
    ------
    Exception
        What a call raises, other than by the death of its worker.
    """
    shift = _Shift(batches, crew, submit)
    while shift.launch():
        yield from shift.landed()
        yield from shift.given_up()
        report(len(shift.flying))


@dataclass(frozen=True)
class _Missing:
    """A batch that did not come back, and why."""

    batch: Batch
    reason: str
    overdue: bool = False


class _Shift:
    """Who is at what, and what has to be done again."""

    def __init__(self, batches: Iterator[Batch], crew: Crew, submit: Callable[[Batch], tuple]):
        self.source, self.crew, self.submit = iter(batches), crew, submit
        self.flying: dict[Future, tuple[Batch, float]] = {}
        self.again: deque[Batch] = deque()
        self.suspects: deque[Batch] = deque()
        self.missing: list[_Missing] = []

    def launch(self) -> bool:
        """Give everybody something to do; whether anything is in progress."""
        while len(self.flying) < self.crew.width and not any(batch.suspect for batch, _ in self.flying.values()):
            batch = self._following()
            if batch is None:
                break
            call, *arguments = self.submit(batch)
            try:
                self.flying[self.crew.submit(call, *arguments)] = batch, time.monotonic()
            except BrokenExecutor:  # a worker died between two looks
                self.again.appendleft(batch)
                self.crew.revive(hanging=False)
        return bool(self.flying)

    def _following(self) -> Batch | None:
        if self.again:
            return self.again.popleft()
        batch = next(self.source, None)
        if batch is None and self.suspects and not self.flying:
            return self.suspects.popleft()
        return batch

    def landed(self) -> Iterator[tuple[Batch, object]]:
        """Wait for a while; yields what came back with its result, and notes what did not."""
        done, _ = wait(self.flying, timeout=TICK, return_when=FIRST_COMPLETED)
        for future in done:
            batch, _ = self.flying.pop(future)
            try:
                result = future.result()
            except Exception as error:
                if not _is_death(error):
                    raise
                self.missing.append(_Missing(batch, f"its worker died: {error}"))
            else:
                yield batch, result

    def given_up(self) -> Iterator[tuple[Batch, Lost]]:
        """Have what is missing done again, with new workers where need be; yields what is given up."""
        hanging = self._overdue()
        missing, self.missing = self.missing + hanging, []
        if missing and self.crew.revive(hanging=bool(hanging)):
            others = [batch for batch, _ in self.flying.values()]
            self.flying.clear()
            if hanging:  # they were stopped for no fault of theirs
                self.again.extend(others)
            else:
                missing += [_Missing(batch, "its worker died, or another's did") for batch in others]
        for one in missing:
            if not self._done_again(one):
                yield one.batch, Lost(one.overdue, one.reason)

    def _overdue(self) -> list[_Missing]:
        """What has been in progress for too long, and is not waited for any more."""
        now = time.monotonic()
        late = [future for future, (batch, started) in self.flying.items() if now - started > batch.limit]
        batches = [self.flying.pop(future)[0] for future in late]
        return [_Missing(batch, f"it took more than {batch.limit:.0f} s", overdue=True) for batch in batches]

    def _done_again(self, missing: _Missing) -> bool:
        """Whether a batch is tried once more: as it is, taken apart, or alone."""
        batch = missing.batch
        batch.losses += 1
        _log.warning(
            "a batch of %d did not come back (%s), for the %d. time", len(batch.parts), missing.reason, batch.losses
        )
        if batch.losses < LOSSES and not missing.overdue:
            (self.suspects if batch.suspect else self.again).append(batch)
        elif len(batch.parts) > 1 or not batch.suspect:
            self.suspects.extend(batch.apart())
        else:
            return False
        return True


def _is_death(error: Exception) -> bool:
    """Whether a call was lost with its worker; Dask's own errors are known by name: it is an extra."""
    return isinstance(error, BrokenExecutor | CancelledError) or type(error).__name__ in (
        "KilledWorker", "FutureCancelledError", "CommClosedError",
    )  # fmt: skip
