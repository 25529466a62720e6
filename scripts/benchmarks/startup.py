"""What a user waits for: starting, compiling, and how two cores share a sweep."""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from documents.shared import ROOT, processes
from ruamel.yaml import YAML

from warpdamp import load, run

from .damper import damper, shake
from .peers import resting_bed

WARPDAMP = (sys.executable, "-m", "warpdamp")

SWEEP = {
    "damper": {"particles": {"count": 120}},
    "excitation": {"frequency": ["92 Hz"], "gamma": [1 + k / 4 for k in range(32)]},
    "preparation": "loose",
    "steady_state": {"fewest_cycles": 30, "most_cycles": 30},
    "numerics": {"step": "4e-6 s"},
    "seeds": [1, 2],
}
"""Changes to configs/beam.yaml: 64 cases of the fewest cycles that a case usually runs, half a second each; two beds,
so that two workers start for them."""

SMALL = {
    "damper": {"particles": {"count": 20}},
    "excitation": {"frequency": ["200 Hz"], "gamma": [2, 4, 6, 8]},
    "preparation": "loose",
    "steady_state": {"fewest_cycles": 8, "most_cycles": 8},
    "seeds": [1],
}
"""One batch of four short cases."""


def changed_beam(folder: Path, changes: dict) -> Path:
    """configs/beam.yaml with changes, written to a folder."""
    yaml = YAML()
    config = yaml.load(ROOT / "configs" / "beam.yaml")
    _update(config, changes)
    path = folder / "benchmark.yaml"
    yaml.dump(config, path)
    return path


def _update(node, changes: dict) -> None:
    for key, value in changes.items():
        if isinstance(value, dict):
            _update(node[key], value)
        else:
            node[key] = value


def commands(rounds: int = 9) -> dict[str, list[float]]:
    """Wall time [s] of ``warpdamp --help``, of ``import warpdamp``, and of reading configs/beam.yaml."""
    asked = {
        "help_time": [*WARPDAMP, "--help"],
        "import_time": [sys.executable, "-c", "import warpdamp"],
        "load_time": [sys.executable, "-c", f"import warpdamp; warpdamp.load({str(ROOT / 'configs' / 'beam.yaml')!r})"],
    }
    return {name: [_seconds(command) for _ in range(rounds)] for name, command in asked.items()}


def _seconds(command) -> float:
    started = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    return time.perf_counter() - started


def warm_start(rounds: int = 5) -> dict[str, list[float]]:
    """Wall time [s] from the start of ``warpdamp run`` to the end of its first batch, kernels and bed from disk.

    Modes, worker processes and 0.1 s or so of simulation included.
    """
    with tempfile.TemporaryDirectory() as name:
        config = changed_beam(Path(name), SMALL)
        times = [_until_first_batch(config, Path(name) / str(k)) for k in range(rounds + 1)]  # none resumes another
    return {"warm_start": times[1:]}  # the first may compile, and makes the bed


def _until_first_batch(config: Path, output: Path) -> float:
    command = [*WARPDAMP, "run", config, "-o", output]
    started = time.perf_counter()
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as process:
        told = [(line, time.perf_counter()) for line in process.stderr]
    ended = [moment for line, moment in told if line.startswith("cases") and not line.startswith("cases 0")]
    if process.returncode or not ended:
        raise RuntimeError(f"{' '.join(map(str, command))} ended with status {process.returncode} and ran no cases")
    return ended[0] - started


def compilations() -> dict[str, list[float]]:
    """Compilations for each kernel module that two runs of two workers leave in a cache that was empty."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        config = changed_beam(folder, SMALL | {"excitation": {"frequency": ["200 Hz"], "gamma": list(range(1, 13))}})
        environment = os.environ | {"WARPDAMP_CACHE": str(folder)}
        command = [*WARPDAMP, "run", config, "-o", folder, "--workers", "2"]
        builds = [_builds(command, environment, folder / "kernels") for _ in range(2)]
        kept = {path.parent for path in (folder / "kernels").rglob("*.o")}
    return {
        "kernel_modules": [len(kept)],
        "compilations_per_module": [len(builds[0] | builds[1]) / len(kept)],
        "compilations_when_warm": [len(builds[1])],
    }


def _builds(command, environment, cache: Path) -> set[str]:
    """Folders that Warp compiles in while a command runs: one to a compilation, named after module and process."""
    seen = set()
    with subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as process:
        while process.poll() is None:
            seen |= {name for _, names, _ in os.walk(cache) for name in names if re.search(r"_p\d+_t\d+$", name)}
            time.sleep(0.005)
    if process.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))} ended with status {process.returncode}")
    return seen


def two_cores(rounds: int = 3) -> dict[str, list[float]]:
    """Wall time [s] of the cases of a sweep of 64 by one worker and by two, in turn, and their ratio.

    From the first case's submission to the last one's end.  The workers have started before, for the two beds.
    """
    samples = {"sweep_one_worker": [], "sweep_two_workers": []}
    with tempfile.TemporaryDirectory() as name:
        config = load(changed_beam(Path(name), SWEEP))
        _cases_time(config, 2)  # compiles and makes the bed
        for _ in range(rounds):
            for key, workers in (("sweep_one_worker", 1), ("sweep_two_workers", 2)):
                samples[key].append(_cases_time(config, workers))
    pairs = zip(*samples.values(), strict=True)
    return samples | {"two_core_gain": [one / two for one, two in pairs]}


def machine_gain(rounds: int = 5) -> dict[str, list[float]]:
    """What this machine makes of two cores: one process that shakes one bed, against two of them side by side.

    Nothing is shared, shared out or kept: no sweep can gain more.
    """
    gains = []
    with processes(2) as executor:
        list(executor.map(_shaken, [1.0, 1.0]))  # starts both, and compiles
        for _ in range(rounds):
            one = executor.submit(_shaken, 3.0).result()
            two = list(executor.map(_shaken, [3.0, 3.0]))
            gains.append(sum(two) / one)
    return {"machine_gain": gains}


def _shaken(seconds: float) -> float:
    """Steps a second of wall time of the paper's damper, for some seconds."""
    started, steps = time.perf_counter(), 0
    _, batch = shake([(damper(), resting_bed(1))], 1)
    began = time.perf_counter()
    while time.perf_counter() - started < seconds + (began - started):
        steps += 2000
        batch.advance(1 + steps)
    return steps / (time.perf_counter() - began)


def _cases_time(config, workers: int) -> float:
    moments = []

    def report(stage: str, done: float) -> None:
        if stage == "cases":
            moments.append(time.perf_counter())

    run(config, workers=workers, report=report)
    return moments[-1] - moments[0]
