"""The order of the work: configuration -> modes -> beds -> cases -> Dataset -> modal damping."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .config import Config, load
from .dataset import assemble
from .scene import STANDARD_GRAVITY
from .sources import modes
from .sweep import Point, as_list, drive, grains, particle_mass, points, scene
from .tolerance import applied, first_round, next_round

if TYPE_CHECKING:
    import xarray as xr

    from .effects import Effects
    from .modal.modes import Modes
    from .shaking import Criteria, Spec

Report = Callable[[str, float], None]
"""Told the stage and the part of it that is done, 0 to 1."""

BATCH = 4
"""Cases to a batch: enough to hide what a launch costs, few enough to share out evenly."""

QUICK = {"amplitudes": 5, "fewest_cycles": 12, "most_cycles": 12}


def shortened(config: Config) -> Config:
    """The same study in a minute: five amplitudes, one seed, a loose bed, 12 cycles a case.

    Its figures are a first look only: loose beds drift, and ``status`` says so.
    """
    gammas = as_list(config.excitation.gamma)
    few = sorted({round(k) for k in np.linspace(0, len(gammas) - 1, QUICK["amplitudes"])})
    change = {
        "title": f"{config.title} (quick look)",
        "excitation": config.excitation.model_copy(update={"gamma": [gammas[k] for k in few]}),
        "seeds": config.seeds[:1],
        "accuracy": None,
        "preparation": "loose",
        "steady_state": config.steady_state.model_copy(
            update={name: QUICK[name] for name in ("fewest_cycles", "most_cycles")}
        ),
    }
    short = config.model_copy(update=change)
    short._source = config._source
    return short


def run(
    config: Config | str | Path,
    *,
    quick: bool = False,
    workers: int | None = None,
    report: Report = lambda stage, done: None,
) -> xr.Dataset:
    """Run a study.

    Parameters
    ----------
    config : Config or path of a YAML file
    quick : run ``shortened(config)``
    workers : number of worker processes (default: the cores of this machine)
    report : called as ``report(stage, part_done)``

    Returns
    -------
    xarray.Dataset
        See ``warpdamp.results.VARIABLES`` for its variables.

    Raises
    ------
    ConfigError
        If the configuration cannot be run, or its beds cannot be made.
    SimulationError
        If every case failed.
    """
    from .packing import separate
    from .shaking import warm_up

    if not isinstance(config, Config):
        config = load(config)
    if workers is not None and workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers}")
    config = applied(shortened(config) if quick else config)

    report("modes", 0.0)
    every = study_points(config)
    report("modes", 1.0)
    specs = every_spec(config, every)
    first = next(iter(specs.values()))
    for seed in config.seeds:  # a bed that cannot be made is refused before anything long starts
        _placed(config, partial(separate, first.bed.grains.radius, first.scene.enclosure, seed))

    report("kernels", 0.0)
    for effects in sorted(every_effects(specs.values()), key=str):
        warm_up(first.scene, effects)
    report("kernels", 1.0)
    values = {}
    with processes(workers) as executor:
        todo = first_round(config, specs)
        while todo:
            values |= _run_cases(config, todo, executor, report)
            todo = next_round(config, specs, values)
    _raise_if_all_failed(values)
    return assemble(config, every, specs.values(), values)


def every_effects(specs: Iterable[Spec]) -> set[Effects]:
    """All that kernels are compiled for in a study."""
    from .packing import effects

    specs = list(specs)
    beds = {spec.bed for spec in specs}
    return {spec.effects for spec in specs}.union(*(effects(bed) for bed in beds))


def _raise_if_all_failed(values: dict) -> None:
    """One bad case of a sweep is a value; a study of which nothing is left is an error.

    Raises
    ------
    SimulationError
    """
    from .guards import SimulationError
    from .steady import Status

    if not any("energy_dissipated" in value for value in values.values()):
        worst = Status(max(value["status"] for value in values.values()))
        raise SimulationError(f"all {len(values)} cases failed: {worst.meaning}")


def study_points(config: Config) -> list[Point]:
    """Every combination of the swept scalars, with the modes of the structure for each mass of particles."""
    found: dict[float, Modes] = {}
    every = []
    for index, single in points(config):
        single._source = config._source
        particles = particle_mass(single)
        if config.excitation.frequency == "modes" and particles not in found:
            found[particles] = modes(single, particles=particles)
        own = found.get(particles)
        if config.excitation.frequency == "modes":
            # to a microhertz: an eigensolver's last bits depend on the machine, and beds are chaotic
            frequencies = [round(float(f), 6) for f in own.frequency]
        else:
            frequencies = as_list(config.excitation.frequency)
        every.append(Point(index, single, own, frequencies))
    return every


def every_spec(config: Config, every: list[Point] | None = None) -> dict[tuple[int, ...], Spec]:
    """All cases of a study, by their index in (frequency, gamma, swept scalars, seed)."""
    specs = {}
    for point in every or study_points(config):
        specs |= _specs(config, point)
    return specs


def _specs(config: Config, point: Point) -> dict[tuple[int, ...], Spec]:
    """All cases of a point, by their index in (frequency, gamma, swept scalars, seed)."""
    from .packing import Request
    from .shaking import PAPER_SETTLING, Spec
    from .timestep import Numerics

    still, own = scene(point.config), grains(point.config)
    numerics = Numerics(config.numerics.precision, config.numerics.steps_per_contact, config.effects.forced())
    paper = config.steady_state.recipe == "paper"
    specs = {}
    for i, frequency in enumerate(point.frequencies):
        for j, gamma in enumerate(as_list(config.excitation.gamma)):
            driven = still.driven(drive(point.config, frequency, gamma))
            steps = _steps(config, driven, own)
            for k, seed in enumerate(config.seeds):
                bed = Request(
                    scene=still,
                    grains=own,
                    seed=seed,
                    preparation="loose" if config.preparation == "carried" else config.preparation,
                    settling_time=PAPER_SETTLING if paper else None,
                    numerics=numerics,
                )
                index = (i, j, *point.index, k)
                specs[index] = Spec(index, driven, steps, bed)
    return specs


def _steps(config: Config, driven, own) -> int:
    """Steps per cycle, chosen or forced.

    Raises
    ------
    ConfigError
        If a forced step does not resolve the shortest contact expected.
    """
    from .timestep import (
        FEWEST_STEPS_PER_CONTACT,
        FEWEST_STEPS_PER_CYCLE,
        contact_step,
        expected_speed,
        shortest_contact,
        steps_per_cycle,
    )

    numerics = config.numerics
    if numerics.step == "auto":
        return steps_per_cycle(driven, own, steps_per_contact=numerics.steps_per_contact)
    longest = contact_step(driven, own, steps_per_contact=FEWEST_STEPS_PER_CONTACT)
    if numerics.step > longest:
        shortest = shortest_contact(driven, own, expected_speed(driven, own.radius))
        raise config.error(
            "numerics.step",
            f"{numerics.step:.3g} s is too large for the shortest contact expected, {shortest:.3g} s at "
            f"{driven.drive.frequency:.1f} Hz and Gamma {driven.drive.acceleration / STANDARD_GRAVITY:g}: "
            f"take at most {longest:.2g} s, or 'auto'",
        )
    return max(FEWEST_STEPS_PER_CYCLE, math.ceil(1 / (driven.drive.frequency * numerics.step)))


@contextmanager
def processes(workers: int | None) -> Iterator[Executor]:
    """Processes, started fresh: Warp does not promise that its runtime survives a fork.

    A fresh process imports the script that was started.  The workers do not need it, and a script that calls ``run``
    at its top level would start itself again in every one of them: so they are not told of it.
    """
    main = sys.modules["__main__"]
    kept = {name: getattr(main, name) for name in ("__file__", "__spec__") if hasattr(main, name)}
    try:
        main.__spec__ = None
        main.__dict__.pop("__file__", None)
        with ProcessPoolExecutor(workers or os.cpu_count(), mp_context=get_context("spawn")) as executor:
            yield executor
    finally:
        vars(main).update(kept)


def _placed(config: Config, call: Callable):
    """Call, and point a packing that cannot be made at the configuration's key."""
    from .packing import PackingError

    try:
        return call()
    except PackingError as error:
        raise config.error(error.key, str(error)) from None


def _run_cases(config: Config, specs: dict, executor: Executor, report: Report) -> dict:
    """Beds first, each once; then batches of cases, the dearest first so that all workers finish together."""
    from .packing import prepare
    from .shaking import shake

    beds = {spec.bed.key(): spec.bed for spec in specs.values()}
    pending = {executor.submit(prepare, bed): 1.0 for bed in beds.values()}
    for future in _finished(pending, partial(report, "beds")):
        _placed(config, future.result)

    pending = {}
    for batch, criteria in _batches(config, list(specs.values())):
        pending[executor.submit(shake, batch, criteria)] = sum(s.cost(criteria) for chain in batch for s in chain)
    values = {}
    for future in _finished(pending, partial(report, "cases")):
        values |= dict(future.result())
    return values


def _finished(pending: dict[Future, float], report: Callable[[float], None]):
    """The futures as they finish; reports the part of their weights that is done."""
    total, done = sum(pending.values()), 0.0
    report(0.0)
    try:
        for future in as_completed(pending):
            yield future
            done += pending[future]
            report(done / total)
    finally:
        for future in pending:
            future.cancel()


def _batches(config: Config, specs: list[Spec]) -> list[tuple[list[list[Spec]], Criteria]]:
    """Chains of cases in batches of equal criteria and effects, sorted by cost."""
    chains: dict[tuple, list[Spec]] = {}
    for spec in specs:
        own = (spec.index[0], *spec.index[2:]) if config.preparation == "carried" else spec.index
        chains.setdefault(own, []).append(spec)

    groups: dict[tuple[Criteria, Effects], list[list[Spec]]] = {}
    for chain in chains.values():
        chain.sort(key=lambda spec: spec.scene.drive.acceleration)
        groups.setdefault((criteria_of(config, chain[0]), chain[0].effects), []).append(chain)
    batches = []
    for (criteria, _), group in groups.items():
        group.sort(key=lambda chain: -sum(spec.cost(criteria) for spec in chain))
        batches += [(group[k : k + BATCH], criteria) for k in range(0, len(group), BATCH)]
    return sorted(batches, key=lambda b: -sum(spec.cost(b[1]) for chain in b[0] for spec in chain))


def criteria_of(config: Config, spec: Spec) -> Criteria:
    """When a case is done."""
    from .shaking import Criteria, paper_criteria

    wanted = config.steady_state
    if wanted.recipe == "paper":
        return paper_criteria(spec.scene.drive.frequency)
    return Criteria(wanted.standard_error, wanted.fewest_cycles, wanted.most_cycles)
