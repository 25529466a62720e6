"""Neighbour lists: pairs i < j, sorted, with what their contacts remember carried over.

Large cases are searched with Warp's hash grid, which groups particles by case, so that the cases of a batch never see
each other; in small ones every pair is looked at, which takes less time than building the grid.  Lists are compressed
rows: one pass counts, a scan places, a second pass fills; no capacity is guessed, whatever the mixture of sizes.
"""

import functools

import warp as wp

from .options import UNIQUE
from .shape import shape
from .structs import types

NO_GRID = wp.constant(wp.uint64(0))
"""Instead of a grid's number: look at every pair."""


@functools.cache
def neighbour_search(effects):
    """Return the kernels ``count_pairs`` and ``list_pairs`` for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Case, Particle, History, Contacts = t.Case, t.Particle, t.History, t.Contacts
    s = shape(effects)
    reach_of, pair_listed = s.reach_of, s.pair_listed

    @wp.func
    def near(case: Case, p: wp.array(dtype=Particle), i: int, j: int):
        return j > i and pair_listed(case, p, i, j)

    @wp.func
    def is_waiting(n: int, steps: wp.array(dtype=wp.int64), target: wp.array(dtype=wp.int64)):
        """Whether a case is to be advanced, and needs a list."""
        return steps[n] < target[n]

    @wp.kernel(**UNIQUE)
    def count_pairs(
        grid: wp.uint64,
        cases: wp.array(dtype=Case),
        group: wp.array(dtype=wp.int32),
        steps: wp.array(dtype=wp.int64),
        target: wp.array(dtype=wp.int64),
        largest_radius: real,
        p: wp.array(dtype=Particle),
        old: Contacts,
        # out:
        counts: wp.array(dtype=wp.int32),
    ):
        """How many partners every particle of the waiting cases has; the other cases keep what they have."""
        i = wp.tid()
        if not is_waiting(group[i], steps, target):
            counts[i] = old.start[i + 1] - old.start[i]
            return
        case = cases[group[i]]
        count = wp.int32(0)
        if grid == NO_GRID:
            for j in range(i + 1, case.first + case.count):
                if near(case, p, i, j):
                    count += 1
        else:
            reach = reach_of(case, p, i) + largest_radius + case.skin
            for j in wp.hash_grid_query(grid, p[i].position, reach, group[i]):
                if near(case, p, i, j):
                    count += 1
        counts[i] = count

    @wp.func
    def place_in(old: Contacts, i: int, j: int):
        """Where the pair (i, j) is in the old list; -1 where it was not near."""
        low = old.start[i]
        high = old.start[i + 1]
        while low < high:
            middle = (low + high) / 2
            if old.partner[middle] < j:
                low = middle + 1
            else:
                high = middle
        if low < old.start[i + 1]:
            if old.partner[low] == j:
                return low
        return wp.int32(-1)

    @wp.func
    def insert(fresh: Contacts, first: int, last: int, i: int, j: int):
        """Put the pair (i, j) into the row first .. last - 1, which is sorted and short."""
        k = last
        while k > first and fresh.partner[k - 1] > j:
            fresh.partner[k] = fresh.partner[k - 1]
            k -= 1
        fresh.partner[k] = j
        fresh.owner[last] = i

    @wp.kernel(**UNIQUE)
    def list_pairs(
        grid: wp.uint64,
        cases: wp.array(dtype=Case),
        group: wp.array(dtype=wp.int32),
        steps: wp.array(dtype=wp.int64),
        target: wp.array(dtype=wp.int64),
        largest_radius: real,
        p: wp.array(dtype=Particle),
        old: Contacts,
        # out:
        fresh: Contacts,
        shifts: wp.array(dtype=vec3),
    ):
        """List them, and carry over what their contacts remember."""
        i = wp.tid()
        first = fresh.start[i]
        last = first
        if not is_waiting(group[i], steps, target):
            for k in range(old.start[i], old.start[i + 1]):
                fresh.owner[last] = i
                fresh.partner[last] = old.partner[k]
                if wp.static(effects.history):
                    fresh.pair[last] = old.pair[k]
                last += 1
            return
        case = cases[group[i]]
        if grid == NO_GRID:
            for j in range(i + 1, case.first + case.count):
                if near(case, p, i, j):
                    insert(fresh, first, last, i, j)
                    last += 1
        else:
            reach = reach_of(case, p, i) + largest_radius + case.skin
            for j in wp.hash_grid_query(grid, p[i].position, reach, group[i]):
                if near(case, p, i, j):
                    insert(fresh, first, last, i, j)
                    last += 1
        if wp.static(effects.history):
            for k in range(first, last):
                before = place_in(old, i, fresh.partner[k])
                fresh.pair[k] = History()
                if before >= 0:
                    fresh.pair[k] = old.pair[before]
        p[i].listed = p[i].position
        shifts[group[i]] = vec3()

    return count_pairs, list_pairs
