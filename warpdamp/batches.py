"""What a worker does: shake a batch of cases and keep them; and how cases are put into batches."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .steady import FIRST_UNFINISHED, Status

if TYPE_CHECKING:
    from .packing import Request
    from .plan import Plan
    from .shaking import Criteria, Spec

BATCH_COST = 1.5e8
"""Particle-steps that make a batch where there are many: some ten seconds, beside which keeping its results costs
nothing, and no more than a kill may take away."""

MOST_CASES = 256
"""To a batch: what they keep in memory stays small."""

AHEAD = 2
"""A batch is no more than one of so many shares of each worker in what is left: batches become smaller towards the end,
so that all workers finish together."""

SMALLEST_SHARE = 50
"""And no less than one of so many shares of each worker in the whole."""

SLOWEST = 3e-6
"""Seconds that a particle-step may take (thirty times what is usual) before a worker is taken for hanging."""

PATIENCE = 300.0
"""Seconds that a batch may take in any case: kernels are compiled, and beds made, in them."""

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
    """What a worker tells of a batch; the results themselves are on disk.

    Parameters
    ----------
    cases : how many
    unfinished : those of them that could not be run
    seconds : of wall time
    cpu : of processor time, and what of it was spent in advancing cases [s]
    said : log records (level, message)
    """

    cases: int = 0
    unfinished: int = 0
    seconds: float = 0.0
    cpu: float = 0.0
    advancing: float = 0.0
    said: list[tuple[int, str]] = field(default_factory=list)


def shake_and_keep(folder: str, work: Work) -> Outcome:
    """Run a batch and keep it in a shard of the store in ``folder``.

    Raises
    ------
    OSError
        If results, beds or kernels cannot be kept, as on a full disk.
    """
    from .store import Store

    with _alone, _listening() as said:
        started, cpu = time.perf_counter(), time.process_time()
        results = _values(work.chains, work.criteria)
        Store(folder).write([(work.keys[index], values) for index, values in results])
        failures = [value["message"] for _, value in results if value["status"] >= FIRST_UNFINISHED]
        said += [(logging.WARNING, f"a case failed: {message}") for message in failures]
        return Outcome(
            cases=len(results),
            unfinished=len(failures),
            seconds=time.perf_counter() - started,
            cpu=time.process_time() - cpu,
            advancing=sum(value.get("cpu_time", 0.0) for _, value in results),
            said=said,
        )


def _values(chains: list[list[Spec]], criteria: Criteria) -> list[tuple[tuple[int, ...], dict]]:
    """Results of chains; one that raises is a value with a message, and does not take others along."""
    from .shaking import shake

    try:
        return shake(chains, criteria)
    except OSError:  # of the machine, not of a case
        raise
    except Exception as error:
        if len(chains) == 1:
            said = f"{type(error).__name__}: {error}"
            return [(spec.index, {"status": int(Status.FAILED), "message": said}) for spec in chains[0]]
    return [result for chain in chains for result in _values([chain], criteria)]


def make_bed(request: Request) -> tuple[str, str] | None:
    """Make a bed and keep it; if that cannot be, what to say, and the configuration's key to look at."""
    from .guards import PackingError
    from .packing import prepare

    with _alone:
        try:
            prepare(request)
        except PackingError as error:
            return str(error), error.key
        except OSError:
            raise
        except Exception as error:
            return f"{type(error).__name__}: {error}", "damper"
    return None


class _listening(logging.Handler):
    """Collects what warpdamp logs."""

    def __enter__(self) -> list[tuple[int, str]]:
        self.said: list[tuple[int, str]] = []
        logging.getLogger("warpdamp").addHandler(self)
        return self.said

    def __exit__(self, *_):
        logging.getLogger("warpdamp").removeHandler(self)

    def emit(self, record):
        self.said.append((record.levelno, record.getMessage()))


def batches(plan: Plan, numbers: np.ndarray, workers: int) -> Iterator[list[list[int]]]:
    """Chains of the numbers of cases, in batches of one group each, the dearest first.

    A chain of which any case is to be run is run whole; cases with one key are run once.
    """
    if not len(numbers):
        return
    heads = np.unique(plan.chain[numbers])
    members = {}
    for head, chain in _members(plan, heads).items():
        members.setdefault(bytes(plan.keys[chain[-1]]), (head, chain))
    members = dict(members.values())
    costs = {head: float(plan.cost[chain].sum()) for head, chain in members.items()}
    left = sum(costs.values())
    smallest = left / (SMALLEST_SHARE * workers)
    order = sorted(members, key=lambda head: (-costs[head], head))
    open_batches: dict[int, tuple[list, float]] = {}
    for head in order:
        chain = members[head]
        group = int(plan.group[head])
        batch, cost = open_batches.pop(group, ([], 0.0))
        batch.append(chain)
        cost += costs[head]
        left -= costs[head]
        share = min(BATCH_COST, max((left + cost) / (AHEAD * workers), smallest))
        if cost >= share or len(batch) >= MOST_CASES:
            yield batch
        else:
            open_batches[group] = batch, cost
    for batch, _ in open_batches.values():
        yield batch


def _members(plan: Plan, heads: np.ndarray) -> dict[int, list[int]]:
    """Numbers of the cases of each chain, by rising amplitude."""
    from .plan import RUN

    alone = np.bincount(plan.chain, minlength=len(plan.chain)) == 1
    members = {int(head): [int(head)] for head in heads if alone[head]}
    longer = {int(head): [] for head in heads if not alone[head]}
    if longer:
        for number in np.flatnonzero((plan.fate == RUN) & ~alone[plan.chain]):
            if plan.chain[number] in longer:
                longer[int(plan.chain[number])].append(int(number))
        for chain in longer.values():
            chain.sort(key=lambda number: (plan.cases.acceleration(number), number))
    return members | longer


def limit(plan: Plan, chains: list[list[int]]) -> float:
    """Seconds after which a worker with these cases is taken for hanging."""
    steps = 0.0
    for chain in chains:
        for number in chain:
            criteria = plan.groups[plan.group[number]][1]
            steps += plan.cost[number] * criteria.most / criteria.fewest
    return PATIENCE + SLOWEST * steps if math.isfinite(steps) else math.inf
