"""Status of a case: how it ended, and the remedy."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """Status of a case; the value is what the Dataset's ``status`` holds."""

    NOT_RUN = -1
    STEADY = 0
    IMPRECISE = 1
    DRIFTING = 2
    UNBALANCED = 3
    TOO_DEEP = 4
    NOT_FINITE = 5
    ESCAPED = 6
    FAILED = 20
    DIED = 21
    OVERDUE = 22
    REFUSED = 23
    EXCLUDED = 24

    @property
    def meaning(self) -> str:
        """Sentence that explains the status, with the remedy."""
        return _MEANINGS[self]


MORE_CYCLES = "raise steady_state.most_cycles"
"""Remedy of a case that ended at its most cycles."""

_MEANINGS = {
    Status.STEADY: "steady: no drift left, work and dissipation in balance, standard error as asked",
    Status.DRIFTING: f"still drifting, or work and dissipation out of balance, at the limit of cycles: {MORE_CYCLES}",
    Status.IMPRECISE: f"steady, but the standard error is larger than asked: {MORE_CYCLES}",
    Status.UNBALANCED: "the energy ledger does not close to 2 %: raise numerics.steps_per_contact",
    Status.TOO_DEEP: "contacts deeper than a tenth of the reduced radius, where Hertz's theory ends: take a stiffer "
    "material or lower amplitudes",
    Status.NOT_FINITE: "the state was no longer finite: raise numerics.steps_per_contact",
    Status.ESCAPED: "a particle left the cavity: raise numerics.steps_per_contact, or lower the amplitude",
    Status.FAILED: "could not be run; see message; a further run tries again",
    Status.DIED: "its process died each time, perhaps out of memory; a further run tries again",
    Status.OVERDUE: "its process was stopped at the limit of time; a further run tries again",
    Status.REFUSED: "an impossible combination; see message",
    Status.EXCLUDED: "left out by sweep.exclude",
    Status.NOT_RUN: "not run yet",
}


FIRST_UNFINISHED = Status.FAILED
"""From this status on a case has not been simulated to its end."""
