"""Measure what a user waits for at the start, beside another checkout of warpdamp (Linux).

    git worktree add ../before 890df44
    python scripts/benchmarks/before.py ../before [ROUNDS]

Runs ``warpdamp --help``, ``import warpdamp`` and ``load("configs/beam.yaml")`` of both in fresh processes, in turn,
with compiled files as of an installation, and prints medians of the wall and of the processor time [s], and of the
ratios of each round.  Run it where warpdamp is not installed as editable: looking for that takes time of its own.
"""

import os
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
COMMANDS = {
    "help": ("-m", "warpdamp", "--help"),
    "import": ("-c", "import warpdamp"),
    "load": ("-c", "import warpdamp; warpdamp.load('configs/beam.yaml')"),
}
ROUNDS = 15


def seconds(checkout: Path, arguments: tuple[str, ...]) -> tuple[float, float]:
    """Wall and processor time [s] of a fresh process of a checkout."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(
        [sys.executable, *arguments],
        cwd=checkout,
        env=environment | {"PYTHONPATH": str(checkout)},
        check=True,
        capture_output=True,
    )
    ended, after = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    return ended - started, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    other = Path(sys.argv[1]).resolve()
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else ROUNDS
    for name, arguments in COMMANDS.items():
        pairs = [(seconds(other, arguments), seconds(ROOT, arguments)) for _ in range(rounds + 1)][1:]  # one compiles
        for k, kind in enumerate(("wall", "processor")):
            old, new = ([pair[side][k] for pair in pairs] for side in (0, 1))
            ratios = sorted(n / o for o, n in zip(old, new, strict=True))
            spread = f"{ratios[0]:.3f} to {ratios[-1]:.3f}"
            medians = f"{statistics.median(old):.3f} s, now {statistics.median(new):.3f} s"
            print(f"{name} {kind}: before {medians}, ratio {statistics.median(ratios):.3f} ({spread})", flush=True)


if __name__ == "__main__":
    main()
