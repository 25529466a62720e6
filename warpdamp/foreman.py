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
    again: deque[Batch] = deque()
    suspects: deque[Batch] = deque()
    flying: dict[Future, tuple[Batch, float]] = {}
    source = iter(batches)

    def following() -> Batch | None:
        if again:
            return again.popleft()
        batch = next(source, None)
        if batch is None and suspects and not flying:
            return suspects.popleft()
        return batch

    def launch() -> None:
        while len(flying) < crew.width and not any(batch.suspect for batch, _ in flying.values()):
            batch = following()
            if batch is None:
                return
            call, *arguments = submit(batch)
            try:
                flying[crew.submit(call, *arguments)] = batch, time.monotonic()
            except BrokenExecutor:  # a worker died between two looks
                again.appendleft(batch)
                crew.revive(hanging=False)

    def lost(batch: Batch, *, overdue: bool, reason: str) -> tuple[Batch, Lost] | None:
        batch.losses += 1
        _log.warning("a batch of %d did not come back (%s), for the %d. time", len(batch.parts), reason, batch.losses)
        if batch.losses < LOSSES and not overdue:
            (suspects if batch.suspect else again).append(batch)
        elif len(batch.parts) > 1 or not batch.suspect:
            suspects.extend(batch.apart())
        else:
            return batch, Lost(overdue, reason)
        return None

    while True:
        launch()
        if not flying:
            return
        done, _ = wait(flying, timeout=TICK, return_when=FIRST_COMPLETED)
        dead = []
        for future in done:
            batch, _ = flying.pop(future)
            try:
                result = future.result()
            except Exception as error:
                if not _is_death(error):
                    raise
                dead.append((batch, False, f"its worker died: {error}"))
                continue
            yield batch, result
        now = time.monotonic()
        late = [f for f, (batch, started) in flying.items() if now - started > batch.limit]
        for future in late:
            batch, _ = flying.pop(future)
            dead.append((batch, True, f"it took more than {batch.limit:.0f} s"))
        if dead and crew.revive(hanging=bool(late)):
            if late:  # the others were stopped for no fault of theirs
                again.extend(batch for batch, _ in flying.values())
            else:
                dead += [(batch, False, "its worker died, or another's did") for batch, _ in flying.values()]
            flying.clear()
        for batch, overdue, reason in dead:
            if given_up := lost(batch, overdue=overdue, reason=reason):
                yield given_up
        report(len(flying))


def _is_death(error: Exception) -> bool:
    """Whether a call was lost with its worker; Dask's own errors are known by name: it is an extra."""
    return isinstance(error, BrokenExecutor | CancelledError) or type(error).__name__ in (
        "KilledWorker", "FutureCancelledError", "CommClosedError",
    )  # fmt: skip
