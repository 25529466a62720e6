"""Work of a worker: make a bed, or run a batch of cases and store it."""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..errors import PackingError, StoreError
from ..status import FIRST_UNFINISHED, Status
from .store import Store

if TYPE_CHECKING:
    from ..damper.case import Criteria, Request, Spec
    from ..kernels.groups import Kernels

_alone = threading.Lock()
"""A process runs one batch at a time: Dask may give a worker several threads, Warp's runtime serves one."""


@dataclass(frozen=True)
class Work:
    """Chains of cases of equal effects and criteria, ready to be shaken.

    Parameters
    ----------
    chains : list of chains of Spec
    keys : keys of the cases, by their index
    criteria : Criteria
    """

    chains: list[list[Spec]]
    keys: dict[tuple[int, ...], bytes]
    criteria: Criteria


@dataclass
class Outcome:
    """Summary of a batch; the results themselves are on disk.

    Parameters
    ----------
    cases : how many
    unfinished : those of them that could not be run
    seconds : of wall time
    cpu : of processor time, and what of it was spent in advancing cases [s]
    each : processor time of each case, in the order of the chains; 0 for those that failed [s]
    records : log records (level, message)
    """

    cases: int = 0
    unfinished: int = 0
    seconds: float = 0.0
    cpu: float = 0.0
    advancing: float = 0.0
    each: list[float] = field(default_factory=list)
    records: list[tuple[int, str]] = field(default_factory=list)


def shake_and_keep(folder: str, work: Work) -> Outcome:
    """Run a batch and write it to a shard of the store in ``folder``.

    Raises
    ------
    OSError, StoreError
        If results, beds or kernels cannot be kept, as on a full disk.
    """
    with _alone, _LogRecords() as records:
        started, cpu = time.perf_counter(), time.process_time()
        results = _values(work.chains, work.criteria)
        Store(folder).write([(work.keys[index], values) for index, values in results])
        failures = [value["message"] for _, value in results if value["status"] >= FIRST_UNFINISHED]
        records += [(logging.WARNING, f"a case failed: {message}") for message in failures]
        return Outcome(
            cases=len(results),
            unfinished=len(failures),
            seconds=time.perf_counter() - started,
            cpu=time.process_time() - cpu,
            advancing=sum(value.get("cpu_time", 0.0) for _, value in results),
            each=_seconds(work.chains, results, time.process_time() - cpu),
            records=records,
        )


def _values(chains: list[list[Spec]], criteria: Criteria) -> list[tuple[tuple[int, ...], dict]]:
    """Results of chains; a chain that raises becomes values with a message, and does not affect the others."""
    from ..damper.shake import shake

    try:
        return shake(chains, criteria)
    except (OSError, StoreError):  # of the machine, not of a case
        raise
    except Exception as error:
        if len(chains) == 1:
            message = f"{type(error).__name__}: {error}"
            return [(spec.index, {"status": int(Status.FAILED), "message": message}) for spec in chains[0]]
    return [result for chain in chains for result in _values([chain], criteria)]


def _seconds(chains: list[list[Spec]], results, cpu: float) -> list[float]:
    """Processor time of each case: of its advance, and its part of what else the batch took."""
    advance = {index: values.get("cpu_time", 0.0) for index, values in results}
    others = max(0.0, cpu - sum(advance.values())) / max(1, sum(spent > 0 for spent in advance.values()))
    return [advance[spec.index] + others * (advance[spec.index] > 0) for chain in chains for spec in chain]


def get_ready() -> None:
    """Import what all other work of a worker takes; half a second."""
    from ..damper import shake  # noqa: F401


def compile_kernels(kernels: Kernels) -> None:
    """Compile kernels into the cache on disk."""
    from ..engine.compiling import compile_kernels

    with _alone:
        compile_kernels(kernels)


def make_bed(request: Request) -> tuple[str, str] | None:
    """Make a bed and store it; returns None, or why that failed and the configuration's key to look at."""
    from ..damper.preparation import prepare

    with _alone:
        try:
            prepare(request)
        except PackingError as error:
            return str(error), error.key
        except (OSError, StoreError):
            raise
        except Exception as error:
            return f"{type(error).__name__}: {error}", "damper"
    return None


class _LogRecords(logging.Handler):
    """Logging handler that collects what warpdamp logs."""

    def __enter__(self) -> list[tuple[int, str]]:
        self.records: list[tuple[int, str]] = []
        logging.getLogger("warpdamp").addHandler(self)
        return self.records

    def __exit__(self, *_):
        logging.getLogger("warpdamp").removeHandler(self)

    def emit(self, record):
        self.records.append((record.levelno, record.getMessage()))
