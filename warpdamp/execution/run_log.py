"""Log of a run: a text file for people, and a line of state for ``warpdamp status``."""

from __future__ import annotations

import json
import logging
import os
import platform
import time
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import StoreError
from ..files import keep

if TYPE_CHECKING:
    from .worker import Outcome

EVERY = 5.0
"""Seconds between two states on disk."""


class _LogFile(logging.FileHandler):
    """Log file that ends with a line on standard error when it cannot be written, as on a full disk."""

    def handleError(self, record):
        logging.getLogger("warpdamp").removeHandler(self)
        logging.getLogger("warpdamp").warning("%s cannot be written any more", self.baseFilename)


class RunLog:
    """Log of one run.

    Parameters
    ----------
    folder : Path
        Of the store.
    cases : number to run
    part : (k, n) or None
    """

    def __init__(self, folder: Path, cases: int, part: tuple[int, int] | None):
        name = time.strftime("%Y%m%d-%H%M%S") + f"-{platform.node()}-{os.getpid()}"
        self.state = {
            "host": platform.node(),
            "process": os.getpid(),
            "part": f"{part[0]}/{part[1]}" if part else "",
            "started": time.time(),
            "cases": cases,
            "done": 0,
            "unfinished": 0,
            "jobs_at_work": 0,
            "share": 0.0,
            "first_case": 0.0,
            "cpu": 0.0,
            "advancing": 0.0,
            "ended": "",
        }
        self._file = folder / "runs" / f"{name}.json"
        self._log = logging.getLogger("warpdamp")
        self._handler = _LogFile(folder / "logs" / f"{name}.log", delay=True)
        self._handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
        self._written = 0.0

    def __enter__(self) -> RunLog:
        self._level = self._log.level
        self._log.setLevel(logging.INFO)
        self._log.addHandler(self._handler)
        self._log.info("%d cases to run%s", self.state["cases"], self.state["part"] and f", part {self.state['part']}")
        self._keep()
        return self

    def __exit__(self, kind, error, _):
        self.state["ended"] = "done" if kind is None else f"stopped: {kind.__name__}: {error}".strip(": ")
        self._log.info(
            "%s: %d cases run, %d of them failed", self.state["ended"], self.state["done"], self.state["unfinished"]
        )
        self._log.removeHandler(self._handler)
        self._log.setLevel(self._level)
        self._handler.close()
        if kind is None or not issubclass(kind, OSError | StoreError):
            self._keep()

    def further(self, cases: int) -> None:
        """Record that ``cases`` more cases are needed."""
        self.state["cases"] += cases
        self._log.info("%d further cases are needed", cases)

    def log(self, level: int, message: str) -> None:
        """Log a message at a ``logging`` level."""
        self._log.log(level, message)

    def finished(self, outcome: Outcome) -> None:
        """Record a finished batch."""
        for level, message in outcome.records:
            self._log.log(level, message)
        self._log.info("%d cases in %.1f s, %d failed", outcome.cases, outcome.seconds, outcome.unfinished)
        self.state["done"] += outcome.cases
        self.state["unfinished"] += outcome.unfinished
        self.state["cpu"] += outcome.cpu
        self.state["advancing"] += outcome.advancing
        self._now_and_then()

    def failed(self, cases: int) -> None:
        """Record cases that could not be run."""
        self.state["done"] += cases
        self.state["unfinished"] += cases
        self._now_and_then()

    def cases_start(self) -> bool:
        """Record that cases are given to a worker; true for the first, from which the time left counts."""
        first = not self.state["first_case"]
        if first:
            self.state["first_case"] = time.time()
        return first

    def progress(self, share: float) -> None:
        """Record the part of the work that is done, 0 to 1."""
        self.state["share"] = share

    def at_work(self, jobs: int) -> None:
        """Record the number of jobs in progress."""
        self.state["jobs_at_work"] = jobs
        self._now_and_then()

    def _now_and_then(self) -> None:
        if time.time() - self._written > EVERY:
            self._keep()

    def _keep(self) -> None:
        self._written = self.state["seen"] = time.time()
        keep(self._file, json.dumps(self.state).encode())
