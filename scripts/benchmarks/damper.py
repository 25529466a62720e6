"""The paper's damper as every code of the benchmark gets it, and how time and memory are taken (Linux)."""

import os
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context

from warpdamp import Batch, Case, Cylinder, Drive, Material, Scene, Surface

COUNT = 120
RADIUS = 3.73e-3  # [m]
PMMA = Material(density=920, youngs_modulus=3.3e9, poissons_ratio=0.37)
SURFACE = Surface(restitution=0.52, friction=0.86)
FREQUENCY = 46.0  # [Hz]
GAMMA = 6.0
STEPS_PER_CYCLE = 10_870
DT = 1 / (FREQUENCY * STEPS_PER_CYCLE)
"""The paper's step, 2e-6 s, made a whole part of the cycle."""


def cavity(count: int = COUNT) -> Cylinder:
    """The paper's cavity, scaled so that ``count`` spheres fill the same part of it."""
    size = 0.040 * (count / COUNT) ** (1 / 3)
    return Cylinder(diameter=size, height=size)


def damper(count: int = COUNT, gamma: float = GAMMA) -> Scene:
    """The shaken cavity of ``count`` spheres; at rest for Gamma 0."""
    drive = Drive(FREQUENCY, gamma * 9.81) if gamma else None
    return Scene(PMMA, PMMA, SURFACE, SURFACE, cavity(count), drive=drive)


def shake(cases, steps: int, *, cycles: int = 0) -> tuple[float, Batch]:
    """Advance (scene, state) pairs together with everything on; returns processor time [s] of the stepping alone.

    Full physics, float64, guards, ledger with all channels.  Making the batch, and compiling, is left out.
    """
    batch = Batch([Case(scene, state, DT) for scene, state in cases], max_rows=cycles + 1)
    started = time.process_time()
    batch.advance(steps)
    return time.process_time() - started, batch


def contacts(state) -> float:
    """Contacts per particle, with others and with walls; one between two particles counts for both."""
    return (2 * len(state.pairs) + int((state.wall_history.radius > 0).sum())) / len(state)


@contextmanager
def one_core():
    """Keep this process, and those that it starts, to one core."""
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(allowed)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)


def in_fresh_process(function, *arguments):
    """What ``function`` returns in a process of its own, so that its memory is its own."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        return executor.submit(function, *arguments).result()


def peak_memory() -> int:
    """Largest resident memory of this process so far [bytes]."""
    with open("/proc/self/status") as file:
        (line,) = [line for line in file if line.startswith("VmHWM:")]
    return 1024 * int(line.split()[1])
