"""Runs of a configuration in which the structure answers the particles: YAML in, a Dataset out."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..config.build import bed as bed_of
from ..config.build import grains, numerics_of, particle_mass, scene
from ..config.preparation import carried_path
from ..damper.case import Request
from ..damper.preparation import prepare
from ..engine import checks as guards
from ..errors import PackingError, SimulationError
from ..kernels.columns import KernelStatus
from ..modal.from_config import amplitudes, with_further_masses
from ..modal.from_config import modes as modes_of
from ..numerics.timestep import contact_step
from ..scene.effects import WALLS, covering
from ..scene.host import HostStructure, Signal
from ..scene.scene import Drive, Scene
from ..sweep.cases import Cases
from ..sweep.dampers import every_damper
from . import excitation
from .excitation import RECORDS, RECORDS_OF_CONTENT, STEPS_OF_CONTENT
from .identify import host_of
from .results import WINDOW, assembled

if TYPE_CHECKING:
    import xarray as xr

    from ..config.study import Config
    from ..modes import Modes


@dataclass(frozen=True)
class Run:
    """Coupled run: a bed in each damper, and the scene around it.

    Parameters
    ----------
    beds : tuple of Request
    scenes : tuple of Scene
        With the structure as each damper sees it; a force acts at the first.
    dt : [s]
    steps : int
    """

    beds: tuple[Request, ...]
    scenes: tuple[Scene, ...]
    dt: float
    steps: int

    @property
    def host(self) -> HostStructure:
        """Structure as the first damper sees it."""
        return self.scenes[0].host


def simulate(config: Config, executor: Executor, report: Callable[[float], None] = lambda done: None) -> xr.Dataset:
    """Simulate the coupled runs of a configuration: its levels, and a bed for each seed.

    Returns
    -------
    xarray.Dataset
        Motion, force or base acceleration, and reaction on (level, seed, time); energies on (level, seed); where there
        are several dampers, motion, reaction and what their particles lose also on ``damper``.  With one
        mode and a harmonic signal or a release, the mode as it answers, on (level, seed, window); with any other
        force the accelerance, with any other motion of the base the transmissibility on (level, frequency), mean over
        seeds.  Of noise, the root mean squares in and out.

    Raises
    ------
    ConfigError
        If the configuration has no such section, or leaves a choice open.
    SimulationError
        If a run goes wrong.
    """
    runs, signals = planned(config)
    futures = {executor.submit(advance, run): index for index, run in runs.items()}
    found = {}
    try:
        for future in as_completed(futures):
            found[futures[future]] = future.result()
            report(len(found) / len(futures))
    except PackingError as error:
        raise config.error(error.key, str(error)) from None
    return assembled(config, runs, found, signals)


def advance(run: Run) -> dict:
    """Carry out one run.

    Returns
    -------
    dict
        ``records``, (dampers, n, 4) as of ``Batch.records``; energies, ``particle_loss`` that of each damper;
        ``cpu_time``.
    """
    from ..engine.batch import Batch, Case

    states = [prepare(bed).state for bed in run.beds]
    effects = covering(
        [bed.numerics.effects(scene, bed.grains) for bed, scene in zip(run.beds, run.scenes, strict=True)]
    )
    most = 1 + (run.steps - 1) // run.host.record
    cases = [Case(scene, state, run.dt) for scene, state in zip(run.scenes, states, strict=True)]
    batch = Batch(cases, max_records=most, effects=effects, enclosures=[len(cases)])
    first = [ledger for _, ledger in batch.read()]
    started = time.process_time()
    batch.advance(run.steps)
    spent = time.process_time() - started
    if batch.status[0] != KernelStatus.OK:
        raise SimulationError(
            f"the run of seed {run.beds[0].seed} broke off at step {batch.steps[0]}: raise numerics.steps_per_contact, "
            "or lower the force"
        )
    last = [ledger for _, ledger in batch.read()]
    ledgers = [
        replace(after, rows=np.concatenate([before.rows, after.rows]))
        for before, after in zip(first, last, strict=True)
    ]
    for ledger in ledgers:
        guards.check_run(ledger, run.dt)
    lost = [float(np.diff(ledger.dissipated)[0]) for ledger in ledgers]
    structure = sum(ledger.change("structure_loss") for ledger in ledgers)
    residual = sum(float(ledger.coupled_residual[-1]) for ledger in ledgers)
    total = sum(lost) + structure
    return {
        "records": np.array([batch.records(k) for k in range(len(cases))]),
        "force_work": sum(ledger.change("force_work") for ledger in ledgers),
        "structure_loss": structure,
        "particle_loss": lost,
        "closure": abs(residual) / total if total else 0.0,
        "cpu_time": spent,
    }


def planned(config: Config) -> tuple[dict[tuple[int, int], Run], list[Signal | None]]:
    """Runs by (level, seed), and the signal of each level.

    Raises
    ------
    ConfigError
        If the configuration has no such section, or leaves a choice open, or names a record that cannot be used.
    """
    config = _single(config)
    own, modes = config.coupled, modes_of(config, particles=0.0)
    _check(config, modes)
    dampers = every_damper(config) if config.dampers else [config]
    _check_walls(config)
    scenes, beds, particles = ([of(damper) for damper in dampers] for of in (scene, grains, particle_mass))
    shapes = amplitudes(config, modes)
    weight = sum(
        phi * (mass * float(np.dot(still.gravity, config.excitation.direction)))
        for phi, mass, still in zip(shapes, particles, scenes, strict=True)
    )
    signals = excitation.signals(config)
    hosts = [
        _hosts(config, modes, shapes, signal, excitation.start(own, modes, level, weight))
        for signal, level in zip(signals, own.levels, strict=True)
    ]
    loaded = with_further_masses(config, modes.with_mass(particles[0]), particles[1:])
    moved = amplitudes(config, loaded)
    fastest = max(excitation.largest_speed(level, loaded, moved, own.duration) for level in hosts)
    reference = excitation.reference(own, modes)
    numerics = numerics_of(config)
    drive = Drive(reference, 2 * math.pi * reference * fastest)
    longest = min(
        contact_step(still.driven(drive), bed, steps_per_contact=numerics.steps_per_contact)
        for still, bed in zip(scenes, beds, strict=True)
    )
    dt, between = _step(reference, excitation.content(own, signals[0]), longest)
    steps = math.ceil(own.duration / dt)
    rests = [scene(damper.while_made()) for damper in dampers]
    runs = {}
    for i, level in enumerate(hosts):
        on_host = tuple(still.on_host(replace(host, record=between)) for still, host in zip(scenes, level, strict=True))
        for j, seed in enumerate(config.seeds):
            requests = tuple(
                Request(rest, bed, own_seed(seed, k), numerics=numerics, **bed_of(config))
                for k, (rest, bed) in enumerate(zip(rests, beds, strict=True))
            )
            runs[i, j] = Run(requests, on_host, dt, steps)
    return runs, signals


def own_seed(seed: int, damper: int) -> int:
    """Seed of the bed in a damper, 0 the first: beds of one run are independent of each other."""
    return seed if damper == 0 else int(np.random.SeedSequence([seed, damper]).generate_state(1)[0])


def _hosts(config: Config, modes: Modes, shapes: np.ndarray, signal: Signal | None, position) -> list[HostStructure]:
    """The structure as each damper sees it."""
    first = host_of(
        modes,
        modes.inherent_damping,
        **{"base" if config.coupled.base else "force": signal},
        position=position,
        direction=config.excitation.direction,
    )
    return [first, *(replace(first, amplitude=tuple(map(float, phi))) for phi in shapes[1:])]


def _step(reference: float, content: float, longest: float) -> tuple[float, int]:
    """The step [s], at most ``longest``, and how many lie between records, for the frequencies [Hz] to be shown."""
    rate = max(RECORDS * reference, RECORDS_OF_CONTENT * content)
    between = math.ceil(max(1 / (rate * longest), STEPS_OF_CONTENT * content / rate))
    return 1 / (rate * between), between


def _single(config: Config) -> Config:
    """The configuration without lists, if it is of one combination and has all that a coupled run takes."""
    if config.coupled is None:
        raise config.error("coupled", "missing: it says what moves the structure, as release: {gamma: 10, mode: 1}")
    if config.structure is None:
        raise config.error("structure", "missing: there is nothing to answer the particles")
    if config.structure.particles_included:
        raise config.error("structure.particles_included", "is true, and a coupled run adds the particles itself")
    if config.accuracy is not None:
        raise config.error("accuracy", "is for `warpdamp run`: give numerics.steps_per_contact and seeds instead")
    if config.numerics.step != "auto":
        raise config.error("numerics.step", "is chosen here: give numerics.steps_per_contact instead")
    if carried_path(config.preparation):
        raise config.error("preparation", "'carried' is for studies of several amplitudes: take loose or compacted")
    points = [point for point in Cases(config).points() if not point.refused]
    if len(points) != 1:
        said = f"and the study has {len(points)}: run one combination at a time"
        raise config.error("coupled", f"takes one combination of single values, {said}")
    single = points[0].config.model_copy(update={"coupled": config.coupled, "seeds": config.seeds})
    single._source = config._source
    return single


def _check(config: Config, modes: Modes) -> None:
    own = config.coupled
    if own.release and own.release.mode not in modes.number:
        known = ", ".join(map(str, modes.number))
        raise config.error("coupled.release.mode", f"there is no mode {own.release.mode}; the structure has {known}")
    harmonic = own.signals.harmonic
    if harmonic and len(modes.number) == 1 and own.duration * harmonic.frequency < 2 * WINDOW:
        raise config.error("coupled.duration", f"is too short to read a mode: take at least {2 * WINDOW} cycles of it")
    if own.base:
        _check_base(config, modes)


def _check_walls(config: Config) -> None:
    """The kernels of a structure are compiled for the walls of all its dampers."""
    first = config.damper.enclosure
    for k, damper in enumerate(config.dampers):
        for wall in WALLS:
            if getattr(damper.enclosure, wall) != getattr(first, wall):
                said = "in a coupled run either all dampers have this wall or none has it"
                raise config.error(f"dampers.{k}.enclosure.{wall}", said)


def _check_base(config: Config, modes: Modes) -> None:
    """A base that moves needs to be known to take the modes along."""
    if modes.participation is None:
        where = f"structure.{config.structure.source}"
        said = "gives no participation (Gamma = phi^T M d, in kg^0.5) of its modes, which a base that moves calls for"
        raise config.error("coupled.base", f"{where} {said}: add participation to each mode")
    gamma = excitation.base_participation(modes)
    if np.all(np.abs(gamma) < NO_PART * np.linalg.norm(modes.participation, axis=1).max()) or not gamma.any():
        raise config.error("coupled.base", "moves none of these modes: the structure is free, or they move across it")


NO_PART = 1e-6
"""Of a participation factor, over the largest along any axis: less is rounding."""
