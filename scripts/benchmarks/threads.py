"""What a stage of a step costs as a launch of its own, and two threads that wait: python scripts/benchmarks/threads.py.

Two cores within one bed would need every stage of every step to be started, and waited for, on both: this is the price
of that, beside the time of a step.
"""

import statistics
import threading
import time

import warp as wp

from warpdamp.engine import device as _device  # noqa: F401  starts Warp without its messages

ROUNDS, LAUNCHES = 7, 2_000
BARRIERS = 2_000


@wp.kernel(enable_backward=False)
def nothing(a: wp.array(dtype=wp.float64)):
    """One thread that does next to nothing."""
    a[0] = a[0] + wp.float64(1.0)


def launch() -> float:
    """Time of a launch that is recorded once and repeated [us]."""
    array = wp.zeros(1, dtype=wp.float64, device="cpu")
    command = wp.launch(nothing, 1, [array], device="cpu", record_cmd=True)
    command.launch()
    started = time.perf_counter()
    for _ in range(LAUNCHES):
        command.launch()
    return 1e6 * (time.perf_counter() - started) / LAUNCHES


def barrier() -> float:
    """Time that two threads take to wait for each other [us]."""
    meeting = threading.Barrier(2)

    def meet():
        for _ in range(BARRIERS):
            meeting.wait()

    other = threading.Thread(target=meet)
    started = time.perf_counter()
    other.start()
    meet()
    other.join()
    return 1e6 * (time.perf_counter() - started) / BARRIERS


if __name__ == "__main__":
    for name, measure in (("launch_us", launch), ("barrier_us", barrier)):
        values = sorted(measure() for _ in range(ROUNDS))
        print(f"{name} {statistics.median(values):.3g} ({values[0]:.3g} to {values[-1]:.3g})")
