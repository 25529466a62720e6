"""Neighbour lists from Warp's hash grid: pairs i < j, sorted, with what their contacts remember carried over.

The grid groups particles by case, so the cases of a batch never see each other.  Lists are compressed rows: one pass
counts, a scan places, a second pass fills; no capacity is guessed, whatever the mixture of sizes.
"""

import functools

import warp as wp

from .data import types


@functools.cache
def neighbour_search(effects):
    """Return the kernels ``count_pairs`` and ``list_pairs`` for the given effects."""
    t = types(effects.real)
    real, vec3, vec4 = t.real, t.vec3, t.vec4
    Case, Particles, Contacts = t.Case, t.Particles, t.Contacts

    @wp.func
    def near(p: Particles, i: int, j: int, skin: real):
        branch = p.position[i] - p.position[j]
        reach = p.radius[i] + p.radius[j] + skin
        return j > i and wp.dot(branch, branch) < reach * reach

    @wp.kernel(enable_backward=False, module="unique")
    def count_pairs(
        grid: wp.uint64,
        cases: wp.array(dtype=Case),
        group: wp.array(dtype=wp.int32),
        largest_radius: real,
        p: Particles,
        # out:
        counts: wp.array(dtype=wp.int32),
    ):
        i = wp.tid()
        skin = cases[group[i]].skin
        count = wp.int32(0)
        for j in wp.hash_grid_query(grid, p.position[i], p.radius[i] + largest_radius + skin, group[i]):
            if near(p, i, j, skin):
                count += 1
        counts[i] = count

    @wp.func
    def carried_over(old: Contacts, i: int, j: int):
        """The history of pair (i, j) in the old list; zero where it had none."""
        low = old.start[i]
        high = old.start[i + 1]
        while low < high:
            middle = (low + high) / 2
            if old.partner[middle] < j:
                low = middle + 1
            else:
                high = middle
        history = vec4()
        if low < old.start[i + 1]:
            if old.partner[low] == j:
                history = old.pair_history[low]
        return history

    @wp.kernel(enable_backward=False, module="unique")
    def list_pairs(
        grid: wp.uint64,
        cases: wp.array(dtype=Case),
        group: wp.array(dtype=wp.int32),
        largest_radius: real,
        p: Particles,
        old: Contacts,
        # out:
        fresh: Contacts,
        drifts: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        skin = cases[group[i]].skin
        first = fresh.start[i]
        last = first
        for j in wp.hash_grid_query(grid, p.position[i], p.radius[i] + largest_radius + skin, group[i]):
            if near(p, i, j, skin):
                k = last
                while k > first and fresh.partner[k - 1] > j:  # insertion sort: rows are short
                    fresh.partner[k] = fresh.partner[k - 1]
                    k -= 1
                fresh.partner[k] = j
                last += 1
        for k in range(first, last):
            fresh.pair_history[k] = carried_over(old, i, fresh.partner[k])
        p.listed[i] = p.position[i]
        drifts[group[i]] = vec3()

    return count_pairs, list_pairs
