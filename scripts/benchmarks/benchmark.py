"""Measure how fast warpdamp is, beside other DEM codes where they are installed.

    python scripts/benchmarks/benchmark.py                      everything, about a quarter of an hour (Linux)
    python scripts/benchmarks/benchmark.py peers two_core_gain  groups, or the groups of single metrics
    python scripts/benchmarks/benchmark.py --document           everything, and docs/benchmark.md

Prints one line ``name value`` for each metric as it is known, the median where it was taken several times, and then
what was required and what was aimed at.  Ends with status 1 if something required was missed.  Compiling is left out.
Ratios to other codes are taken round by round in one run; times of one machine at another hour are no reference.
"""

import argparse
import os
import statistics
import sys
import time
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from documents.shared import write_document

from benchmarks import document, peers, scaling, startup

GROUPS = {
    "peers": peers.compare,
    "one_cavity": scaling.one_cavity,
    "memory": scaling.memory,
    "million": scaling.million,
    "batches": scaling.batches,
    "two_cores": startup.two_cores,
    "machine_gain": startup.machine_gain,
    "commands": startup.commands,
    "warm_start": startup.warm_start,
    "compilations": startup.compilations,
}


@dataclass(frozen=True)
class Metric:
    """A figure, the group that measures it, and what is asked of it (at least, or at most: ``sense``)."""

    name: str
    group: str
    unit: str
    meaning: str
    sense: str = ""
    required: float | None = None
    aimed: float | None = None

    def meets(self, value: float, limit: float) -> bool:
        """Whether a value keeps a limit."""
        return value >= limit if self.sense == ">=" else value <= limit


BUSY = 0.5
"""Load from which wall times are not to be trusted."""

SPEED, COST, CASE = "10⁶ particle-steps/s", "ns", "us"
METRICS = (
    Metric("warpdamp_speed", "peers", SPEED, "paper's damper, ledger with channels, float64, one core"),
    Metric("lammps_speed", "peers", SPEED, "the same of LAMMPS, power summed at every step"),
    Metric("liggghts_speed", "peers", SPEED, "the same of LIGGGHTS, power summed at every step"),
    Metric("yade_speed", "peers", SPEED, "the same of YADE, its own energy tally on"),
    Metric("lammps_lean_speed", "peers", SPEED, "LAMMPS, power sampled every ten steps"),
    Metric("liggghts_lean_speed", "peers", SPEED, "LIGGGHTS, power sampled every ten steps"),
    Metric("yade_lean_speed", "peers", SPEED, "YADE without its tally"),
    Metric("lammps_ratio", "peers", "1", "speed over that of LAMMPS", ">=", 3.5, 4.0),
    Metric("liggghts_ratio", "peers", "1", "speed over that of LIGGGHTS", ">=", 2.2, 2.5),
    Metric("yade_ratio", "peers", "1", "speed over that of YADE", ">=", 12.0, 14.0),
    Metric("lammps_lean_ratio", "peers", "1", "speed over that of lean LAMMPS"),
    Metric("liggghts_lean_ratio", "peers", "1", "speed over that of lean LIGGGHTS"),
    Metric("yade_lean_ratio", "peers", "1", "speed over that of lean YADE"),
    Metric("warpdamp_effectiveness", "peers", "1", "over the measured cycles, from the work put in"),
    Metric("lammps_effectiveness", "peers", "1", "the same of LAMMPS"),
    Metric("liggghts_effectiveness", "peers", "1", "the same of LIGGGHTS"),
    Metric("yade_effectiveness", "peers", "1", "the same of YADE, from its tally of the dissipation"),
    *(
        metric
        for count in scaling.SIZES
        for metric in (
            Metric(f"cost_{count}", "one_cavity", COST, f"of a particle-step, {count:,} particles in one cavity"),
            Metric(f"contacts_{count}", "one_cavity", "1", "contacts per particle there"),
        )
    ),
    Metric("cost_spread", "one_cavity", "1", "largest of these costs over the smallest", "<=", 1.3),
    *(
        metric
        for peer in scaling.LARGE_PEERS
        for metric in (
            Metric(f"{peer}_cost_120", "one_cavity", COST, f"of a particle-step of {peer}, 120 particles"),
            Metric(f"{peer}_cost_100000", "one_cavity", COST, "the same, 100,000 particles"),
            Metric(f"{peer}_cost_spread", "one_cavity", "1", "the larger over the smaller"),
        )
    ),
    Metric("memory_stepping", "memory", "byte", "a particle's share of the peak while 100,000 run", "<=", 800.0),
    Metric("memory_with_copy", "memory", "byte", "the same, and a copy of the state read at the end"),
    Metric("million_cost", "million", COST, f"of a particle-step of a million, {scaling.MILLION_STEPS} steps"),
    Metric("million_memory", "million", "byte", "a particle's share of the peak while they run"),
    Metric("million_contacts", "million", "1", "contacts per particle there (a lattice: more than in a bed)"),
    *(Metric(f"case_cost_{n}", "batches", CASE, f"of a case and step, {n:,} cases a batch") for n in scaling.BATCHES),
    Metric("case_cost_spread", "batches", "1", "largest of these costs over the smallest", "<=", 1.15),
    Metric("sweep_one_worker", "two_cores", "s", "cases of a sweep of 64, one worker"),
    Metric("sweep_two_workers", "two_cores", "s", "the same, two workers"),
    Metric("two_core_gain", "two_cores", "1", "the first over the second", ">=", 1.9),
    Metric("machine_gain", "machine_gain", "1", "two processes that share nothing over one of them, on this machine"),
    Metric("help_time", "commands", "s", "`warpdamp --help`", "<=", 0.4),
    Metric("import_time", "commands", "s", "`python -c 'import warpdamp'`", "<=", 0.5),
    Metric("load_time", "commands", "s", "`warpdamp.load('configs/beam.yaml')` in a fresh process"),
    Metric("warm_start", "warm_start", "s", "from `warpdamp run` to the end of its first batch, warm", "<=", 3.0),
    Metric("kernel_modules", "compilations", "1", "modules of one set of effects"),
    Metric("compilations_per_module", "compilations", "1", "in two runs of two workers, cold cache", "<=", 1.0),
    Metric("compilations_when_warm", "compilations", "1", "in the second of the two", "<=", 0.0),
)


def groups_of(names: list[str]) -> list[str]:
    """The groups to run for names of groups or of metrics; all for none.

    Raises
    ------
    ValueError
        If there is no such group or metric; lists the groups.
    """
    home = {metric.name: metric.group for metric in METRICS}
    unknown = [name for name in names if name not in home and name not in GROUPS]
    if unknown:
        raise ValueError(f"no metric or group '{unknown[0]}': take one of {', '.join(GROUPS)}, or a metric of theirs")
    wanted = {home.get(name, name) for name in names} or set(GROUPS)
    return [group for group in GROUPS if group in wanted]


def verdicts(values: dict[str, float]) -> tuple[list[str], int]:
    """One sentence for each limit of what was measured, and how many required ones were missed."""
    lines, missed = [], 0
    for metric in METRICS:
        for kind, limit in (("required", metric.required), ("aimed", metric.aimed)):
            if limit is None or metric.name not in values:
                continue
            value = values[metric.name]
            holds = metric.meets(value, limit)
            missed += kind == "required" and not holds
            lines.append(f"{kind} {metric.name} {metric.sense} {limit:g}: {value:.4g} {'pass' if holds else 'MISS'}")
    return lines, missed


def measure(groups: list[str]) -> dict[str, list[float]]:
    """Run the groups; prints every metric as it is known."""
    samples = {}
    for group in groups:
        started = time.perf_counter()
        found = GROUPS[group]()
        samples |= found
        for metric in METRICS:
            if metric.name in found:
                print(f"{metric.name} {statistics.median(found[metric.name]):.5g}", flush=True)
        print(f"({group}: {time.perf_counter() - started:.0f} s)", file=sys.stderr, flush=True)
    return samples


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="metric", help=f"groups ({', '.join(GROUPS)}) or metrics")
    parser.add_argument("--document", action="store_true", help="run everything and write docs/benchmark.md")
    asked = parser.parse_args()
    if asked.document and asked.names:
        parser.error("--document runs everything: leave the names out")
    try:
        groups = groups_of(asked.names)
    except ValueError as error:
        parser.error(str(error))
    machine = document.machine()
    if (load := os.getloadavg()[0]) > BUSY:
        print(f"load {load:.1f}: times by the wall (two_cores, commands, warm_start) are too long", file=sys.stderr)
    samples = measure(groups)
    lines, missed = verdicts({name: statistics.median(values) for name, values in samples.items()})
    print("\n".join(lines))
    if asked.document:
        write_document("benchmark.md", *document.blocks(__file__, METRICS, samples, machine))
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
