"""How the cost of a particle-step grows: with the particles in one cavity, and with the cases in a batch."""

import statistics
from collections import defaultdict

from warpdamp import State

from .beds import bed, lattice
from .damper import contacts, damper, in_fresh_process, one_core, peak_memory, shake
from .peers import installed, resting_bed, run_peer

SIZES = (120, 1_000, 10_000, 100_000)
WINDOW = 500
"""Steps from rest that are timed, the same part of the drive's first cycle for every size."""
SHORTEST = 1_000_000
"""Particle-steps to a sample at the least: short windows are run several times over."""

LARGE_PEERS = ("lammps", "liggghts")
"""YADE would take minutes for 100,000."""

BATCHES = (4, 16, 64, 250, 1_000)
GAMMAS = (1.5, 3.0, 6.0, 12.0)
"""Mixed as in a sweep, the same mixture in every batch."""
SHAKEN = 2 * 10_870
"""Steps that a batch's cases have been shaken for before they are timed, two cycles."""

MILLION = 1_000_000
MILLION_STEPS = 200


def one_cavity(rounds: int = 3) -> dict[str, list[float]]:
    """Cost of a particle-step [ns] against the number of particles in one cavity, and the peers' at both ends."""
    starts = {count: bed(count) for count in SIZES}
    peers = [peer for peer in installed() if peer.name in LARGE_PEERS]
    samples = defaultdict(list)
    with one_core():
        shake([(damper(), starts[SIZES[0]])], 1)  # compiles
        for _ in range(rounds):
            costs = [_cost(samples, count, state) for count, state in starts.items()]
            samples["cost_spread"].append(max(costs) / min(costs))
            for peer in peers:
                ends = [_peer_cost(peer, count, starts[count]) for count in (SIZES[0], SIZES[-1])]
                for count, cost in zip((SIZES[0], SIZES[-1]), ends, strict=True):
                    samples[f"{peer.name}_cost_{count}"].append(cost)
                samples[f"{peer.name}_cost_spread"].append(max(ends) / min(ends))
    return samples


def _repeats(count: int) -> int:
    return max(1, SHORTEST // (count * WINDOW))


def _cost(samples: dict, count: int, state: State) -> float:
    """Of a particle-step [ns]; notes it, and the contacts per particle at the window's end."""
    runs = [shake([(damper(count), state)], WINDOW) for _ in range(_repeats(count))]
    cost = 1e9 * statistics.mean(seconds for seconds, _ in runs) / (count * WINDOW)
    samples[f"cost_{count}"].append(cost)
    samples[f"contacts_{count}"].append(contacts(runs[-1][1].read()[0][0]))
    return cost


def _peer_cost(peer, count: int, state: State) -> float:
    runs = [run_peer(peer, damper(count), state, WINDOW)[0] for _ in range(_repeats(count))]
    return 1e9 * statistics.mean(runs) / (count * WINDOW)


def memory() -> dict[str, list[float]]:
    """Peak memory per particle [bytes] of a run of 100,000 beside that of a run of 120, without and with reading it."""
    few, many = SIZES[0], SIZES[-1]
    bed(many)  # made here, not in the process that is measured
    base, peak = in_fresh_process(_peaks_of_bed, few), in_fresh_process(_peaks_of_bed, many)
    stepping, whole = ((most - least) / (many - few) for least, most in zip(base, peak, strict=True))
    return {"memory_stepping": [stepping], "memory_with_copy": [whole]}


def _peaks_of_bed(count: int) -> tuple[int, int]:
    _, batch = shake([(damper(count), bed(count))], 100)
    stepping = peak_memory()
    batch.read()
    return stepping, peak_memory()


def million() -> dict[str, list[float]]:
    """A million particles for a few hundred steps: cost [ns], memory [bytes] and contacts per particle."""
    with one_core():
        base = in_fresh_process(_run_lattice, SIZES[0])
        peak = in_fresh_process(_run_lattice, MILLION)
    return {
        "million_cost": [peak["cost"]],
        "million_memory": [(peak["memory"] - base["memory"]) / (MILLION - SIZES[0])],
        "million_contacts": [peak["contacts"]],
    }


def _run_lattice(count: int) -> dict[str, float]:
    scene, state = damper(count), lattice(count)
    seconds, batch = shake([(scene, state)], MILLION_STEPS)
    memory = peak_memory()
    if batch.status[0]:
        raise RuntimeError(f"{count} particles did not run {MILLION_STEPS} steps: status {batch.status[0]}")
    (now, _), *_ = batch.read()
    return {"cost": 1e9 * seconds / (count * MILLION_STEPS), "memory": memory, "contacts": contacts(now)}


def batches(rounds: int = 3) -> dict[str, list[float]]:
    """Cost of a case and step [us] against the number of cases in a batch."""
    scenes = [damper(gamma=gamma) for gamma in GAMMAS]
    _, batch = shake([(scene, resting_bed(1)) for scene in scenes], SHAKEN)
    mixture = [(scene, state) for scene, (state, _) in zip(scenes, batch.read(), strict=True)]
    samples = defaultdict(list)
    with one_core():
        for _ in range(rounds):
            costs = [_cost_of_case(mixture, count) for count in BATCHES]
            for count, cost in zip(BATCHES, costs, strict=True):
                samples[f"case_cost_{count}"].append(cost)
            samples["case_cost_spread"].append(max(costs) / min(costs))
    return samples


def _cost_of_case(mixture, count: int) -> float:
    """Of a step [us], in a batch of ``count``."""
    cases = [mixture[k % len(mixture)] for k in range(count)]
    runs = [shake(cases, WINDOW)[0] for _ in range(max(1, 100 // count))]
    return 1e6 * statistics.mean(runs) / (count * WINDOW)
