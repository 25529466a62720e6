"""Runs of a configuration in which the structure answers the particles: YAML in, a Dataset out."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..config.build import bed, grains, particle_mass, scene
from ..config.preparation import carried_path
from ..damper.case import Request
from ..damper.preparation import prepare
from ..engine import checks as guards
from ..errors import PackingError, SimulationError
from ..kernels.columns import KernelStatus
from ..modal.from_config import modes as modes_of
from ..numerics.timestep import Numerics, contact_step
from ..scene.host import Signal
from ..scene.scene import Drive, Scene
from ..sweep.cases import Cases
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
    """Coupled run: a bed in a scene with its host.

    Parameters
    ----------
    bed : Request
    scene : Scene, with its host
    dt : [s]
    steps : int
    """

    bed: Request
    scene: Scene
    dt: float
    steps: int


def simulate(config: Config, executor: Executor, report: Callable[[float], None] = lambda done: None) -> xr.Dataset:
    """Simulate the coupled runs of a configuration: its levels, and a bed for each seed.

    Returns
    -------
    xarray.Dataset
        Motion, force or base acceleration, and reaction on (level, seed, time); energies on (level, seed).  With one
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
    runs, signals = _runs(config)
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
        ``records``, (n, 4) as of ``Batch.records``; energies; ``cpu_time``.
    """
    from ..engine.batch import Batch, Case

    state = prepare(run.bed).state
    effects = run.bed.numerics.effects(run.scene, run.bed.grains)
    most = 1 + (run.steps - 1) // run.scene.host.record
    batch = Batch([Case(run.scene, state, run.dt)], max_records=most, effects=effects)
    first = batch.read()[0][1]
    started = time.process_time()
    batch.advance(run.steps)
    spent = time.process_time() - started
    if batch.status[0] != KernelStatus.OK:
        raise SimulationError(
            f"the run of seed {run.bed.seed} broke off at step {batch.steps[0]}: raise numerics.steps_per_contact, or "
            "lower the force"
        )
    last = batch.read()[0][1]
    ledger = replace(last, rows=np.concatenate([first.rows, last.rows]))
    guards.check_run(ledger, run.dt)
    lost = float(np.diff(ledger.dissipated)[0])
    structure = ledger.change("structure_loss")
    return {
        "records": batch.records(0),
        "force_work": ledger.change("force_work"),
        "structure_loss": structure,
        "particle_loss": lost,
        "closure": abs(float(ledger.coupled_residual[-1])) / (lost + structure) if lost + structure else 0.0,
        "cpu_time": spent,
    }


def _runs(config: Config) -> tuple[dict[tuple[int, int], Run], list[Signal | None]]:
    """Runs by (level, seed), and the signal of each level."""
    config = _single(config)
    own, modes = config.coupled, modes_of(config, particles=0.0)
    _check(config, modes)
    beds, base, particles = grains(config), scene(config), particle_mass(config)
    weight = particles * float(np.dot(base.gravity, config.excitation.direction))
    signals = excitation.signals(config)
    hosts = [
        host_of(
            modes,
            modes.inherent_damping,
            **{"base" if own.base else "force": signal},
            position=excitation.start(own, modes, level, weight),
            direction=config.excitation.direction,
        )
        for signal, level in zip(signals, own.levels, strict=True)
    ]
    fastest = max(excitation.largest_speed(host, modes, particles, own.duration) for host in hosts)
    reference = excitation.reference(own, modes)
    numerics = Numerics(config.numerics.precision, config.numerics.steps_per_contact, config.effects.forced())
    drive = Drive(reference, 2 * math.pi * reference * fastest)
    longest = contact_step(base.driven(drive), beds, steps_per_contact=numerics.steps_per_contact)
    dt, between = _step(reference, excitation.content(own, signals[0]), longest)
    steps = math.ceil(own.duration / dt)
    rest = scene(config.while_made())
    runs = {}
    for i, host in enumerate(hosts):
        for j, seed in enumerate(config.seeds):
            request = Request(rest, beds, seed, numerics=numerics, **bed(config))
            runs[i, j] = Run(request, base.on_host(replace(host, record=between)), dt, steps)
    return runs, signals


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
    if config.dampers:
        raise config.error("dampers", "a coupled run takes one damper: leave them out, or predict with `warpdamp run`")
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
