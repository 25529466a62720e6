"""Bounds in the hot loop: one instruction each, and a NaN stays one (Warp's own min and max drop it, at some cost)."""

import functools
from types import SimpleNamespace

import warp as wp


@functools.cache
def bounds(real):
    """Return ``at_least`` and ``at_most`` for scalars of the type ``real``."""

    @wp.func
    def at_least(value: real, bound: real):
        return wp.where(value < bound, bound, value)

    @wp.func
    def at_most(value: real, bound: real):
        return wp.where(value > bound, bound, value)

    return SimpleNamespace(at_least=at_least, at_most=at_most)
