"""What sweeps take beside the physics, and what they survive; writes docs/sweeps.md.

python scripts/documents/sweeps.py [--cases 10000] [--kills 20] [--docs DIR]

A part of the time goes into the uninterrupted sweep of many small cases; the kills are of a smaller one.
"""

import argparse
import contextlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import xarray as xr
from shared import DOCS, head, machine, table, write_document

import warpdamp
from warpdamp.analysis.results import write

STUDY = """
title: many small cases
damper:
  enclosure: {{diameter: 24 mm, height: 20 mm, material: pmma}}
  particles: {{count: 16, radius: 3.73 mm, material: pmma}}
materials:
  pmma: {{density: 920 kg/m^3, youngs_modulus: 330 MPa, poissons_ratio: 0.37}}
contact: {{restitution: 0.52, friction: 0.5}}
excitation: {{gamma: {{from: 2, to: 8, n: {amplitudes}}}, frequency: {{from: 40 Hz, to: 90 Hz, n: 10}}}}
preparation: loose
steady_state: {{fewest_cycles: {cycles}, most_cycles: {cycles}, standard_error: 10 %}}
seeds: [1]
"""
RUN = "from warpdamp.cli.app import app; app(prog_name='warpdamp')"
SMALL_BATCHES = f"import warpdamp.execution.batching; warpdamp.execution.batching.BATCH_COST = 2e6; {RUN}"


def memory(process: int) -> float:
    """Resident memory [MB]."""
    try:
        text = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1e3 for line in text.splitlines() if line.startswith("VmRSS")), 0.0)


def children(process: int) -> list[int]:
    """Processes started by one."""
    with contextlib.suppress(OSError):
        return [int(p) for t in Path(f"/proc/{process}/task").iterdir() for p in (t / "children").read_text().split()]
    return []


def watched(call, every: float = 1.0):
    """The result of a call, and the memory [MB] of this process and of its children meanwhile."""
    seen, over = [], threading.Event()

    def look():
        while not over.wait(every):
            seen.append((memory(os.getpid()), max(map(memory, children(os.getpid())), default=0.0)))

    thread = threading.Thread(target=look)
    thread.start()
    try:
        return call(), np.array(seen)
    finally:
        over.set()
        thread.join()


def overhead(folder: Path, cases: int) -> dict:
    """Time and memory of an uninterrupted sweep."""
    config = folder / "many.yaml"
    config.write_text(STUDY.format(amplitudes=cases // 10, cycles=20))
    started, before = time.perf_counter(), _cpu()
    dataset, seen = watched(lambda: warpdamp.run(config, store=folder / "many"))
    wall, cpu = time.perf_counter() - started, _cpu() - before
    advancing = float(dataset["cpu_time"].sum())
    started = time.perf_counter()
    write(dataset, folder / "many.nc")
    writing = time.perf_counter() - started
    started = time.perf_counter()
    with xr.open_dataset(folder / "many.nc") as opened:
        float(opened["effectiveness"].mean())
    opening = time.perf_counter() - started
    started = time.perf_counter()
    warpdamp.collect(folder / "many")
    collecting = time.perf_counter() - started
    early, late = seen[len(seen) // 3], seen[-2]
    shards = list((folder / "many" / "shards").glob("*.nc"))
    return {
        "cases": dataset["status"].size,
        "wall [s]": wall,
        "processor time [s]": cpu,
        "of it advancing cases [s]": advancing,
        "overhead [% of the processor time]": 100 * (1 - advancing / cpu),
        "memory of the runner, a third of the way [MB]": early[0],
        "memory of the runner, at the end [MB]": late[0],
        "memory of a worker, a third of the way [MB]": early[1],
        "memory of a worker, at the end [MB]": late[1],
        "shards": len(shards),
        "shards [MB]": sum(path.stat().st_size for path in shards) / 1e6,
        "consolidated file [MB]": (folder / "many.nc").stat().st_size / 1e6,
        "collecting [s]": collecting,
        "writing the consolidated file [s]": writing,
        "opening it and averaging a variable [s]": opening,
    }


def _cpu() -> float:
    return sum(
        use.ru_utime + use.ru_stime for use in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


def planning(folder: Path, amplitudes: int = 2000) -> float:
    """Seconds that one case takes to be planned: its scene, step, identity."""
    from warpdamp.sweep.cases import Cases
    from warpdamp.sweep.plan import make_plan

    config = folder / "planned.yaml"
    config.write_text(STUDY.format(amplitudes=amplitudes, cycles=20))
    cases = Cases(warpdamp.load(config))
    started = time.perf_counter()
    make_plan(cases)
    return (time.perf_counter() - started) / len(cases)


def kills(folder: Path, count: int, executor: str) -> dict:
    """kill -9 at random moments, the runner or one of its workers by turns; then to the end."""
    config = folder / f"killed-{executor}.yaml"
    config.write_text(STUDY.format(amplitudes=max(6, 2 * count), cycles=20))
    whole = warpdamp.run(config, executor="in-process")
    rng, done, workers_killed = random.Random(7), 0, 0
    shards = folder / config.stem / "shards"
    while done < count:
        process, before = _start(config, folder, executor), _shards(shards)
        wanted, delay = before + rng.randrange(3), rng.uniform(0, 1)
        while process.poll() is None and _shards(shards) < wanted:
            time.sleep(0.05)
        time.sleep(delay)
        if process.poll() is None:
            workers = _workers(process.pid) if done % 2 else []
            with contextlib.suppress(ProcessLookupError):
                os.kill(rng.choice(workers or [process.pid]), signal.SIGKILL)
            done += 1
            workers_killed += bool(workers)
            time.sleep(rng.uniform(0, 2))
        elif process.returncode == 0:  # it got to the end before all kills: begin again with an empty folder
            shutil.rmtree(folder / config.stem)
        process.kill()
        process.wait()
    process = _start(config, folder, executor)
    if process.wait(timeout=1800):
        raise SystemExit(f"the last run ended with {process.returncode}")
    with xr.open_dataset(folder / f"{config.stem}.nc") as opened:
        resumed = opened.load()
    names = set(whole.variables) - {"cpu_time"}
    different = [name for name in names if not whole[name].equals(resumed[name])]
    return {
        "executor": executor,
        "cases": whole["status"].size,
        "kills": done,
        "of the runner": done - workers_killed,
        "of a worker": workers_killed,
        "variables that differ by a bit": ", ".join(different) or "none",
    }


def _shards(folder: Path) -> int:
    return len(list(folder.glob("*.nc")))


def _start(config: Path, folder: Path, executor: str):
    command = [sys.executable, "-c", SMALL_BATCHES, "run", config, "-o", folder, "--executor", executor]
    return subprocess.Popen(list(map(str, command)), stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)


def _workers(process: int) -> list[int]:
    """Children that compute (the others only keep the accounts)."""
    return [child for child in children(process) if memory(child) > 100]


def partitions(folder: Path) -> dict:
    """The same sweep by processes, Dask and array parts."""
    config = folder / "shared.yaml"
    config.write_text(STUDY.format(amplitudes=6, cycles=20))
    whole = warpdamp.run(config, executor="processes")
    others = {"dask": warpdamp.run(config, executor="dask")}
    for part in (2, 3, 1):
        warpdamp.carry_out(config, folder / "parts", part=(part, 3), executor="in-process")
    others["three array parts"] = warpdamp.collect(folder / "parts")
    names = set(whole.variables) - {"cpu_time"}
    found = {how: [n for n in names if not whole[n].equals(other[n])] for how, other in others.items()}
    return {f"processes against {how}": ", ".join(names) or "identical" for how, names in found.items()}


def million(measured: dict, each: float) -> str:
    """A plan on paper for 1,000,000 cases, from what was measured."""
    n = measured["cases"]
    per_case = measured["of it advancing cases [s]"] / n
    collect = 1e6 / n * measured["collecting [s]"]
    lines = [
        f"- Planning: {1e3 * each:.2f} ms a case, {1e6 * each:.0f} s, once: runs that go on and array parts "
        "that start later read the plan that is kept. Where each case has a bed of its own, planning takes longer. "
        "Its arrays take 69 bytes a case.",
        f"- Cases such as these: {per_case:.3f} s of one core each, {1e6 * per_case / 3600:.0f} core hours; on 200 "
        f"cores {1e6 * per_case / 60 / 200:.1f} minutes.",
        f"- Shards: {1e6 / n * measured['shards']:.0f}, {1e6 / n * measured['shards [MB]']:.0f} MB; "
        f"read and put together in about {collect:.0f} s if time goes with their number.",
        f"- Consolidated file: {1e6 / n * measured['consolidated file [MB]']:.0f} MB; a variable of it 8 MB.",
        "- Beds: one file of some 10 kB each, kept in the cache folder, for every combination that changes the bed; a "
        "sampled sweep makes one for every case.",
    ]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--docs", type=Path, default=DOCS)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        measured = overhead(folder, options.cases)
        print(json.dumps(measured, indent=1), flush=True)
        each = planning(folder, min(2000, options.cases))
        endured = [kills(folder, options.kills, how) for how in ("processes", "dask")]
        print(json.dumps(endured, indent=1), flush=True)
        shared = partitions(folder)
    write_document(
        "sweeps.md",
        head("Sweeps: what they cost and what they survive", __file__)
        + f" with `--cases {options.cases} --kills {options.kills}` on {machine()}.",
        "## An uninterrupted sweep",
        "16 spheres, 20 cycles a case, by processes.",
        table(["", ""], [(key, f"{value:.4g}") for key, value in measured.items()]),
        "Everything that is not the advance of cases counts as overhead: start of the processes, compiled kernels, "
        "beds, statistics, shards, and the Dataset.",
        "## kill -9 at random moments",
        "Every physical variable (all but `cpu_time`) against the same sweep run in one process without a break.",
        table(endured[0], [row.values() for row in endured]),
        "## However it is shared out",
        "\n".join(f"- {key}: {value}" for key, value in shared.items()),
        "## 1,000,000 cases, on paper",
        million(measured, each),
        folder=options.docs,
    )


if __name__ == "__main__":
    main()
