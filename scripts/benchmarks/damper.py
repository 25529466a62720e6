"""The paper's damper as every code of the benchmark gets it, and how time and memory are taken (Linux)."""

import os
import time
from contextlib import contextmanager

from documents.shared import processes

from warpdamp import Batch, Case, Cylinder, Scene
from warpdamp.scene import paper
from warpdamp.scene.paper import CAVITY, COUNT, FREQUENCY, GAMMA, STEPS_PER_CYCLE

DT = 1 / (FREQUENCY * STEPS_PER_CYCLE)
"""The paper's step [s]."""


def cavity(count: int = COUNT) -> Cylinder:
    """The paper's cavity, scaled so that ``count`` spheres fill the same part of it."""
    size = CAVITY.diameter * (count / COUNT) ** (1 / 3)
    return Cylinder(diameter=size, height=size)


def damper(count: int = COUNT, gamma: float = GAMMA) -> Scene:
    """The shaken cavity of ``count`` spheres; at rest for Gamma 0."""
    return paper.damper(gamma=gamma, cavity=cavity(count))


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
    with processes(1) as executor:
        return executor.submit(function, *arguments).result()


def peak_memory() -> int:
    """Largest resident memory of this process so far [bytes]."""
    with open("/proc/self/status") as file:
        (line,) = [line for line in file if line.startswith("VmHWM:")]
    return 1024 * int(line.split()[1])
