"""Shaking of prepared beds until their dissipation is steady, with the uncertainty of the averages."""

from __future__ import annotations

import logging
import math
import time
from dataclasses import replace

import numpy as np

from ..engine.batch import Batch, Case
from ..engine.checks import DEEPEST, LARGEST_RESIDUAL
from ..engine.ledger import Ledger, apparent_mass, harmonic_work, maximum_energy
from ..errors import PackingError
from ..kernels.columns import IMPULSES, KernelStatus
from ..numerics.steady import Steady, steady
from ..numerics.tolerance import RESIDUAL_FACTOR, SMALLEST_EFFECTIVENESS, bed_memory, single_interval
from ..scene.particles import State
from ..scene.scene import Drive
from ..status import Status
from .case import Criteria, Spec
from .compaction import measured_clearance, packing_fraction
from .placement import fill
from .preparation import prepare

FIRST_LOOKS, LOOKS = 10, 1.25
"""A series is looked at every ten cycles at first, and later whenever it has grown by a quarter."""

BALANCE = 0.01
"""In steady state the work put in, the work of the reaction's first harmonic and the dissipation agree to this part of
the dissipation.  A bed that sinks or swells while its dissipation looks steady is not steady: at 730 Hz beds
sink for hundreds of cycles."""

_log = logging.getLogger(__name__)


def shake(chains: list[list[Spec]], criteria: Criteria) -> list[tuple[tuple[int, ...], dict]]:
    """Run chains of cases side by side; each case of a chain starts from the final state of the one before.

    Returns
    -------
    list of (index, values)
        The values of a case as they go into the Dataset.
    """
    beds = [prepare(chain[0].bed) for chain in chains]
    states = [bed.state for bed in beds]
    before = [bed.clearance for bed in beds]
    results = []
    for stage in zip(*chains, strict=True):
        values, states = _shake_stage(stage, states, criteria)
        after = [_clearance_after(spec, state) for spec, state in zip(stage, states, strict=True)]
        for k, (spec, value) in enumerate(zip(stage, values, strict=True)):
            value |= _compaction(spec, before[k], after[k] if "energy_dissipated" in value else math.nan)
            bed = {"compaction_blocks": beds[k].blocks, "compaction_settled": int(beds[k].settled)}
            results.append((spec.index, value | bed))
        before = after
    return results


def _clearance_after(spec: Spec, state: State) -> float:
    """Clearance that a case leaves [m]; not a number, with a warning, if the bed does not come to rest."""
    try:
        return measured_clearance(spec.bed.scene, state, spec.bed.numerics)
    except PackingError as error:
        _log.warning("the clearance after case %s is not known: %s", spec.index, error)
        return math.nan


def _compaction(spec: Spec, before: float, after: float) -> dict:
    """How compact the bed of a case is before and after it."""
    cavity, radius = spec.bed.scene.enclosure, spec.bed.grains.radius
    return {
        "clearance": before,
        "clearance_after": after,
        "packing_fraction": packing_fraction(radius, cavity, before),
        "packing_fraction_after": packing_fraction(radius, cavity, after),
    }


def _shake_stage(stage, states: list[State], criteria: Criteria):
    cases = [Case(spec.scene, state, spec.dt) for spec, state in zip(stage, states, strict=True)]
    batch = Batch(cases, max_rows=criteria.most + 1, effects=stage[0].effects)
    per_cycle = np.array([spec.steps_per_cycle for spec in stage])
    cycles = np.full(len(stage), criteria.most if criteria.fixed else criteria.fewest)
    work = per_cycle * np.array([len(spec.bed.grains) for spec in stage])
    cpu = np.zeros(len(stage))
    averages: list = [None] * len(stage)
    while True:
        before, started = batch.steps, time.process_time()
        batch.advance(cycles * per_cycle)
        done = (batch.steps - before) * work / per_cycle
        cpu += (time.process_time() - started) * done / max(1, done.sum())
        for k, spec in enumerate(stage):
            if averages[k] is None:
                averages[k] = _average(batch, k, spec, criteria, int(cycles[k]))
        unfinished = np.array([average is None for average in averages])
        if not unfinished.any():
            break
        further = np.maximum(cycles + FIRST_LOOKS, (LOOKS * cycles).astype(int))
        cycles[unfinished] = np.minimum(further, criteria.most)[unfinished]

    for k, value in enumerate(averages):
        value["cpu_time"] = float(cpu[k])
    good = batch.status == KernelStatus.OK  # a case that failed leaves the bed that it started from
    states = [now if ok else before for (now, _), ok, before in zip(batch.read(), good, states, strict=True)]
    return averages, states


def _average(batch: Batch, k: int, spec: Spec, criteria: Criteria, cycles: int) -> dict | None:
    """Averages of a case, or None if it has to go on."""
    if batch.status[k] != KernelStatus.OK:
        return {"status": int(_FAILURES[batch.status[k]]), "cycles": cycles, "steps": int(batch.steps[k])}
    ledger = batch.cycles(k)
    drive = spec.scene.drive
    mass = float(np.sum(spec.scene.masses(spec.bed.grains)))
    smallest = SMALLEST_EFFECTIVENESS * maximum_energy(drive, mass)
    series = ledger.per_cycle()
    if criteria.fixed:
        discarded = cycles // 3
        judged = steady(series[discarded:], fewest=cycles, floor=smallest)
        balanced = _balanced(ledger.between(discarded, cycles), drive, BALANCE, smallest)
        average = replace(judged, discarded=discarded, drifting=judged.drifting or not balanced)
    else:
        average = _settled(ledger, drive, criteria, smallest)
    precise = average.standard_error <= max(criteria.standard_error * average.mean, smallest)
    if (average.drifting or not precise) and cycles < criteria.most:
        return None
    values = window_values(ledger.between(average.discarded, cycles), spec, mass, smallest)
    memory = bed_memory(fill(spec.bed.grains.radius, spec.scene.enclosure)) * average.mean
    return values | {
        "energy_dissipated": average.mean,
        "energy_dissipated_standard_error": average.standard_error,
        "energy_dissipated_interval": single_interval(average.standard_error, average.degrees, memory),
        "degrees_of_freedom": average.degrees,
        "memory_error": memory,
        "discretisation_error": RESIDUAL_FACTOR * values["ledger_residual"] * average.mean,
        "status": int(_status(values, average, precise)),
        "cycles": cycles,
        "cycles_discarded": average.discarded,
        "steps": cycles * spec.steps_per_cycle,
    }


_FAILURES = {KernelStatus.NOT_FINITE: Status.NOT_FINITE, KernelStatus.ESCAPED: Status.ESCAPED}


def _status(values: dict, average: Steady, precise: bool) -> Status:
    """Status of a case, the worst that applies."""
    if values["largest_overlap"] > DEEPEST:
        return Status.TOO_DEEP
    if values["ledger_residual"] > LARGEST_RESIDUAL:
        return Status.UNBALANCED
    if average.drifting:
        return Status.DRIFTING
    return Status.STEADY if precise else Status.IMPRECISE


def _settled(ledger: Ledger, drive: Drive, criteria: Criteria, smallest: float) -> Steady:
    """The average from the earliest tenth of the run on, up to its half, after which work and dissipation balance."""
    series = ledger.per_cycle()
    n, fewest = len(series), criteria.fewest * 2 // 3
    floor = max(smallest, criteria.slack * float(np.mean(series[n // 2 :])))
    for earliest in range(0, max(1, min(n // 2, n - fewest)), max(1, n // 10)):
        average = steady(series, fewest=fewest, floor=floor, earliest=earliest)
        if _balanced(ledger.between(average.discarded, n), drive, max(BALANCE, criteria.slack), smallest):
            return average
    return replace(average, drifting=True)


def _balanced(window: Ledger, drive: Drive, part: float, smallest: float) -> bool:
    dissipated = float(np.mean(window.per_cycle()))
    work = window.change("work_input") / (len(window.rows) - 1)
    harmonic = harmonic_work(window.reaction(drive), drive)
    return max(abs(work - dissipated), abs(harmonic - dissipated)) <= max(part * dissipated, smallest)


def window_values(window: Ledger, spec: Spec, mass: float, smallest: float) -> dict:
    """Values of the averaging window, per cycle.

    Parameters
    ----------
    window : Ledger
        At the ends of the cycles that are averaged.
    spec : Spec
    mass : float
        Of all particles [kg].
    smallest : float
        Energy per cycle that residuals are compared with at the least [J].
    """
    drive = spec.scene.drive
    cycles = len(window.rows) - 1
    reaction = window.reaction(drive)
    dissipated = float(np.mean(window.per_cycle()))
    return {
        **{f"{name}_loss": window.change(name) / cycles for name in window.losses},
        **(_indicators(window, drive) if window.effects.indicators else {}),
        "work_input": window.change("work_input") / cycles,
        "harmonic_work": harmonic_work(reaction, drive),
        "apparent_mass": apparent_mass(reaction, drive),
        "ledger_residual": abs(float(window.residual[-1])) / cycles / max(dissipated, smallest),
        "largest_overlap": float(window["largest_overlap"][-1]),
        "maximum_energy": maximum_energy(drive, mass),
    }


def _indicators(window: Ledger, drive: Drive) -> dict:
    """Indicators of the regime of motion; across the axis floor and lid are not what the bed collides with."""
    cycles = len(window.rows) - 1
    axial = abs(drive.direction[2]) > 1 - 1e-9
    return {
        **{name: window.change(name) / cycles if axial else math.nan for name in IMPULSES},
        "cycle_displacement": float(np.mean(window["displacement"][1:])),
    }
