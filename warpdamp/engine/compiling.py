"""Compiling of kernels into the cache on disk, before workers launch them."""

from __future__ import annotations

import warp as wp

from ..kernels.advance import stepper
from ..kernels.groups import Group, Kernels
from ..kernels.lanes import lanes_for
from ..kernels.neighbours import neighbour_search
from .device import present


def compile_kernels(kernels: Kernels) -> None:
    """Compile kernels, unless they are in the cache, or the device is not there (which beds refuse)."""
    effects = kernels.effects
    if effects.device not in present():
        return
    if kernels.group is Group.SEARCH:
        group = neighbour_search(effects)
    else:
        advance, synchronise = stepper(effects, lanes_for(effects))
        group = [advance] if kernels.group is Group.STEPS else [synchronise]
    for kernel in group:
        wp.load_module(kernel.module, device=effects.device)
