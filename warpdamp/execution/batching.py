"""Batches: how the cases of a study are grouped for the workers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..sweep.plan import Fate

if TYPE_CHECKING:
    from ..sweep.plan import Plan

BATCH_COST = 1.5e8
"""Particle-steps that make a batch where there are many: some ten seconds, beside which keeping its results costs
nothing, and no more than a kill may take away."""

MOST_CASES = 256
"""Most cases of a batch, so that its memory stays small."""

AHEAD = 2
"""A batch is no more than one of so many shares of each worker in what is left: batches become smaller towards the end,
so that all workers finish together."""

SMALLEST_SHARE = 50
"""A batch is no less than one of so many shares of each worker in the whole."""

FEW_BEDS = 32
"""Up to so many beds, a batch holds cases of one, so that it can start before the others are made."""

GOLDEN = 0.618033988749895
"""Multiples of it, less their whole parts, put case numbers in an order of which any beginning is a fair sample."""

FEW_FREQUENCIES = 8
"""Up to so many frequencies, one packing of each point runs before the others, so that the time left is known."""

SLOWEST = 3e-6
"""Seconds that a particle-step may take (thirty times what is usual) before a worker counts as hanging."""

PATIENCE = 300.0
"""Seconds that a batch may take in any case: kernels are compiled, and beds made, in them."""


def batches(
    plan: Plan, numbers: np.ndarray, workers: int, *, costs: np.ndarray | None = None, mixed: bool = False
) -> Iterator[list[list[int]]]:
    """Batches of chains of case numbers, of one group and length each, the most expensive first, or ``mixed``.

    A chain of which any case is to be run is run whole; cases with one key are run once.

    Parameters
    ----------
    plan : Plan
    numbers : (n,) array
        Cases to run.
    workers : int
    costs : array or None
        Particle-steps that each case of the plan is expected to take.  None: those that it takes at the least.
    mixed : bool
        Whether any beginning is to be a fair sample.
    """
    if not len(numbers):
        return
    costs = plan.cost if costs is None else costs
    heads = np.unique(plan.chain[numbers])
    members = {}
    for head, chain in _members(plan, heads).items():
        members.setdefault(bytes(plan.keys[chain[-1]]), (head, chain))
    members = dict(members.values())
    price = {head: float(costs[chain].sum()) for head, chain in members.items()}
    left = sum(price.values())
    smallest = left / (SMALLEST_SHARE * workers)
    order = sorted(members, key=lambda head: (head * GOLDEN % 1 if mixed else -price[head], head))
    by_bed = len(np.unique(plan.bed[heads])) <= FEW_BEDS
    open_batches: dict[tuple, tuple[list, float]] = {}
    for head in order:
        chain = members[head]
        group = int(plan.group[head]), len(chain), int(plan.bed[head]) if by_bed else -1
        batch, cost = open_batches.pop(group, ([], 0.0))
        batch.append(chain)
        cost += price[head]
        left -= price[head]
        share = min(BATCH_COST, max((left + cost) / (AHEAD * workers), smallest))
        if cost >= share or len(batch) >= MOST_CASES:
            yield batch
        else:
            open_batches[group] = batch, cost
    for batch, _ in open_batches.values():
        yield batch


def pilots(plan: Plan, numbers: np.ndarray) -> np.ndarray:
    """Case numbers to run first: of each point the first packing, if others are to follow and frequencies are few.

    What they take says how long the others will.
    """
    points, first = np.unique(numbers // plan.cases.shape[-1], return_index=True)
    few = len(np.unique(plan.frequency[numbers])) <= FEW_FREQUENCIES
    return np.sort(numbers)[first] if few and len(points) < len(numbers) else numbers[:0]


def _members(plan: Plan, heads: np.ndarray) -> dict[int, list[int]]:
    """Numbers of the cases of each chain, in the order in which they run."""
    alone = np.bincount(plan.chain, minlength=len(plan.chain)) == 1
    members = {int(head): [int(head)] for head in heads if alone[head]}
    longer = {int(head): [] for head in heads if not alone[head]}
    if longer:
        for number in np.flatnonzero((plan.fate == Fate.RUN) & ~alone[plan.chain]):
            if plan.chain[number] in longer:
                longer[int(plan.chain[number])].append(int(number))
        for chain in longer.values():
            chain.sort(key=lambda number: plan.turn[number])
    return members | longer


def limit(plan: Plan, chains: list[list[int]]) -> float:
    """Time limit [s] of a worker with these cases, after which it counts as hanging."""
    steps = 0.0
    for chain in chains:
        for number in chain:
            criteria = plan.groups[plan.group[number]][1]
            steps += plan.cost[number] * criteria.most / criteria.fewest
    return PATIENCE + SLOWEST * steps if math.isfinite(steps) else math.inf
