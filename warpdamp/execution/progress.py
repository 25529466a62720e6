"""Progress of the runs in a folder."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..status import FIRST_UNFINISHED
from ..sweep.plan import Fate
from ..sweep.stored import load_plan
from .adaptive import NEEDED, needed_cases
from .run_log import EVERY
from .store import Store

SILENT = 12 * EVERY
"""Seconds without an update after which a run counts as dead."""


def status(folder: str | Path) -> Iterator[str]:
    """Lines of the state of a run: cases done, failed and left, runs in progress, time left.

    Raises
    ------
    StoreError
        If the folder holds no study.
    """
    store = Store.existing(folder)
    plan, stored = load_plan(store.folder), store.read(NEEDED)
    keys = np.unique(plan.keys[needed_cases(plan, stored)])
    in_study = np.isin(stored.keys, keys)
    finished = in_study & (stored.status < FIRST_UNFINISHED)
    done, failed = int(finished.sum()), int(in_study.sum() - finished.sum())
    yield f"{store.folder}: {plan.cases.config.title}"
    share, left = 100 * done / max(1, len(keys)), len(keys) - done - failed
    yield f"  {done} of {len(keys)} cases done ({share:.1f} %), {failed} failed, {left} left"
    for fate, what in ((Fate.EXCLUDED, "excluded"), (Fate.REFUSED, "impossible combinations")):
        if count := int(np.sum(plan.fate == fate)):
            yield f"  {count} {what}"
    if len(stored) > in_study.sum():
        others = len(stored) - int(in_study.sum())
        yield f"  {others} cases of other studies, or of another version of the physics, are stored, too"
    runs = [json.loads(path.read_text()) for path in sorted((store.folder / "runs").glob("*.json"))]
    at_work = [run for run in runs if not run["ended"] and time.time() - run["seen"] < SILENT] if store.in_use() else []
    for run in at_work:
        yield "  " + _run_line(run)
    if not at_work:
        last = max(runs, key=lambda run: run["started"], default=None)
        ended = f"; the last run {last['ended'] or 'was killed'}" if last else ""
        rest = "" if done == len(keys) else "; run again to continue"
        yield f"  no run in progress{ended}{rest}"


def _run_line(run: dict) -> str:
    spent = run["seen"] - run["started"]
    part = f", part {run['part']}" if run["part"] else ""
    left = "not known yet"
    if run["share"] > 0:
        left = duration((run["seen"] - run["first_case"]) * (1 - run["share"]) / run["share"])
    return (
        f"in progress: process {run['process']} on {run['host']}{part}: {run['done']} of {run['cases']} cases in "
        f"{duration(spent)}, {run['jobs_at_work']} jobs in progress, {run['unfinished']} failed; "
        f"time left: {left}"
    )


def duration(seconds: float) -> str:
    """Duration with the unit that suits it, from seconds."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
