"""Run every hard case whole, measure what each guard costs, and write docs/stability.md.

python scripts/documents/stability.py
"""

import os
import statistics
import sys
import tempfile
import time

from fuzz import section as damaged_files
from shared import head, table, write_document

from stability import shapes  # noqa: F401  its cases are among them
from stability.cases import CASES, bed, shaken
from warpdamp import Batch, Case, Effects
from warpdamp.engine.checks import check_overlaps, check_run, check_values
from warpdamp.numerics.timestep import steps_per_cycle

INTRODUCTION = """. Every case either runs, stays finite, contained and closed in energy; or is refused
before it starts; or runs and is flagged by a guard. The guards, on by default: every step, that the state is finite;
every launch, that all particles are in the cavity; every case, the largest overlap (Hertz's theory ends at a tenth of
the reduced radius) and the ledger's residual (2 % of the energy turned over). In a sweep each becomes a `status` with a
remedy, in a single `Simulation` an error. Neighbour lists cannot overflow: they are counted before they are made."""


def how(outcome):
    if not outcome.ran:
        return "refused"
    return "flagged" if outcome.flagged else "runs"


def cost_of_guards():
    """Medians of the processor time of a shaken bed, with the kernels' guards and without, in turn."""
    s, state = shaken(), bed(120)
    n = steps_per_cycle(s, state)
    spent = {True: [], False: []}
    for repeat in range(8):
        for guarded in (True, False):
            batch = Batch([Case(s, state, 1 / 46 / n)], max_rows=3, effects=Effects(guards=guarded))
            started = time.process_time()
            batch.advance(2 * n)
            if repeat:  # the first compiles
                spent[guarded].append(time.process_time() - started)
    ratios = [a / b for a, b in zip(spent[True], spent[False], strict=True)]
    batch = Batch([Case(s, state, 1 / 46 / n)], max_rows=3)
    _, ledger = batch.read()[0]
    lines = [
        f"- in the kernels (finite every step, contained every launch): {100 * (statistics.median(ratios) - 1):+.1f} % "
        f"of the run (median of {len(ratios)} paired runs; quartiles "
        f"{', '.join(f'{100 * (q - 1):+.1f}' for q in statistics.quantiles(ratios, n=4)[::2])} %)",
    ]
    for name, call in (
        ("values at the start", lambda: check_values(state)),
        ("overlaps at the start (pairs given)", lambda: check_overlaps(s, state, [state.pairs])),
        ("overlap and ledger at the end", lambda: check_run(ledger, 1e-6)),
    ):
        times = []
        for _ in range(200):
            started = time.perf_counter()
            call()
            times.append(time.perf_counter() - started)
        lines.append(f"- {name}: {1e6 * statistics.median(times):.0f} us a case")
    return "\n".join(lines)


def main():
    rows, wrong = [], 0
    for case in CASES:
        started = time.perf_counter()
        outcome = case.run(True)
        seconds = time.perf_counter() - started
        ended = how(outcome)
        bad = ended != case.expected or "UNSEEN" in outcome.flagged
        wrong += bad
        words = outcome.flagged or (outcome.message if outcome.message != "ran" else "")
        figures = ["" if x != x else f"{x:.1e}" for x in (outcome.residual, outcome.deepest)]
        rows.append([case.title, case.expected, f"**{ended}**" if bad else ended, *figures, words, f"{seconds:.1f}"])
        print(f"{case.title}: {ended}{' WRONG' if bad else ''}, {words} ({seconds:.1f} s)", flush=True)
    write_document(
        "stability.md",
        head("Hard cases", __file__) + INTRODUCTION,
        f"{len(CASES) - wrong} of {len(CASES)} cases end as they must.",
        table(["case", "expected", "ended", "ledger residual", "largest overlap / R*", "in words", "s"], rows),
        "## What the guards cost",
        cost_of_guards(),
        damaged_files(),
    )
    return wrong


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as cache:  # beds made anew, and the user's left alone
        os.environ["WARPDAMP_CACHE"] = cache
        sys.exit(1 if main() else 0)
