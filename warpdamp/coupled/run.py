"""Runs of a configuration in which the structure answers the particles: YAML in, a Dataset out."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..config.build import grains, particle_mass, scene
from ..damper.case import Request
from ..damper.preparation import prepare
from ..engine import checks as guards
from ..kernels.columns import KernelStatus
from ..numerics.timestep import Numerics, contact_step
from ..scene.scene import STANDARD_GRAVITY, Drive, Force, Mount, Scene
from . import forces
from .identify import Identified, from_decay, from_response, mount_of

if TYPE_CHECKING:
    import xarray as xr

    from ..config.coupled import CoupledConfig
    from ..config.study import Config
    from ..modal.modes import Modes

RECORDS = 32
"""To a period of the fastest thing that happens."""

WINDOW = 10
"""Cycles of a harmonic force over which a mode is read."""

LEAST_DAMPING = 0.01
"""Damping ratio with which the structure's largest speed is foreseen, if its own is less: the damper adds more."""

AVERAGES = 8
"""Pieces that the spectra of random forces are averaged over, half of each overlapping the next."""

LEAST_POWER = 1e-6
"""Smallest usable power of a force over its largest: lines with less are left out."""

STEADY = 0.02
"""A window is steady if its amplitude is the one before's to this part."""


@dataclass(frozen=True)
class Run:
    """Coupled run: a bed in a scene with its mount.

    Parameters
    ----------
    bed : Request
    scene : Scene, with its mount
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
        Motion, force and reaction on (level, seed, time); energies on (level, seed).  With one mode and a harmonic
        force or a release, the mode as it answers, on (level, seed, window); with any other force the accelerance on
        (level, frequency), mean over seeds.

    Raises
    ------
    ConfigError
        If the configuration has no such section, or leaves a choice open.
    SimulationError
        If a run goes wrong.
    """
    runs, force = _runs(config)
    futures = {executor.submit(advance, run): index for index, run in runs.items()}
    found = {}
    try:
        for future in as_completed(futures):
            found[futures[future]] = future.result()
            report(len(found) / len(futures))
    except guards.PackingError as error:
        raise config.error(error.key, str(error)) from None
    return _assembled(config, runs, found, force)


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
    most = 1 + (run.steps - 1) // run.scene.mount.record
    batch = Batch([Case(run.scene, state, run.dt)], max_records=most, effects=effects)
    first = batch.read()[0][1]
    started = time.process_time()
    batch.advance(run.steps)
    spent = time.process_time() - started
    if batch.status[0] != KernelStatus.OK:
        raise guards.SimulationError(
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


def _runs(config: Config) -> tuple[dict[tuple[int, int], Run], list[Force | None]]:
    """Runs by (level, seed), and the force of each level."""
    config = _single(config)
    own, modes = config.coupled, _modes(config)
    _check(config, modes)
    inherent = modes.inherent_damping
    beds, base = grains(config), scene(config)
    every = [_force(config, level) for level in own.levels]
    mounts = [
        mount_of(
            modes,
            inherent,
            force=force,
            position=_release(own, modes, level),
            direction=config.excitation.direction,
        )
        for force, level in zip(every, own.levels, strict=True)
    ]
    fastest = max(_largest_speed(mount, modes, particle_mass(config), own.duration) for mount in mounts)
    reference = _reference(own, modes)
    numerics = Numerics(config.numerics.precision, config.numerics.steps_per_contact, config.effects.forced())
    drive = Drive(reference, 2 * math.pi * reference * fastest)
    longest = contact_step(base.driven(drive), beds, steps_per_contact=numerics.steps_per_contact)
    between = math.ceil(1 / (RECORDS * reference * longest))
    dt = 1 / (RECORDS * reference * between)
    steps = math.ceil(own.duration / dt)
    runs = {}
    for i, mount in enumerate(mounts):
        for j, seed in enumerate(config.seeds):
            request = Request(base, beds, seed, config.preparation, numerics=numerics)
            runs[i, j] = Run(request, base.mounted(replace(mount, record=between)), dt, steps)
    return runs, every


def _single(config: Config) -> Config:
    """The configuration without lists, if it is of one combination and has all that a coupled run takes."""
    from ..sweep.cases import Cases

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
    if config.preparation == "carried":
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
    if own.harmonic and len(modes.number) == 1 and own.duration * own.harmonic.frequency < 2 * WINDOW:
        raise config.error(
            "coupled.duration", f"is too short to read a mode: take at least {2 * WINDOW} cycles of the force"
        )


def _modes(config: Config) -> Modes:
    from ..modal.from_config import modes

    return modes(config, particles=0.0)


def _force(config: Config, level: float) -> Force | None:
    own = config.coupled
    if own.harmonic:
        return Force(level * own.harmonic.amplitude, own.harmonic.frequency)
    if own.release:
        return None
    try:
        if own.swept:
            samples, step = forces.swept(own.swept, own.duration)
        elif own.random:
            samples, step = forces.random(own.random, own.duration)
        else:
            samples, step = forces.recorded(config.folder / own.recorded.file)
    except (OSError, ValueError) as error:
        raise config.error(f"coupled.{own.source}", str(error)) from None
    return Force(samples=level * samples, sample_step=step)


def _release(own: CoupledConfig, modes: Modes, level: float) -> tuple[float, ...]:
    """Modal coordinates at the start."""
    place = np.zeros(len(modes.number))
    if own.release:
        k = int(np.flatnonzero(modes.number == own.release.mode)[0])
        acceleration = level * own.release.gamma * STANDARD_GRAVITY
        place[k] = acceleration / (2 * math.pi * modes.frequency[k]) ** 2 / modes.amplitude[k]
    return tuple(place)


def _reference(own: CoupledConfig, modes: Modes) -> float:
    """Highest frequency that the records are to show [Hz]; a harmonic force's cycle is a whole number of theirs."""
    highest = float(max(modes.frequency))
    if own.harmonic:
        return own.harmonic.frequency * max(1, math.ceil(highest / own.harmonic.frequency))
    band = own.swept or own.random
    return max(highest, band.from_, band.to) if band else highest


def _largest_speed(mount: Mount, modes: Modes, particles: float, duration: float) -> float:
    """Speed of the enclosure [m/s], if the particles were one rigid mass: the step is chosen for it."""
    from scipy.signal import lsim

    if mount.force is None:
        return mount.speed
    time = forces.moments(mount.force, duration)
    force = forces.applied(mount.force, time)
    loaded = modes.with_mass(particles)
    speed = np.zeros(len(time))
    for f, phi, own in zip(loaded.frequency, loaded.amplitude, loaded.inherent_damping, strict=True):
        w, zeta = 2 * math.pi * f, max(own, LEAST_DAMPING)
        system = ([[0, 1], [-(w**2), -2 * zeta * w]], [[0], [phi]], [[0, phi]], [[0]])
        speed += lsim(system, force, time)[1]
    return float(np.abs(speed).max())


def _assembled(config: Config, runs, found, every) -> xr.Dataset:
    import xarray as xr

    from ..analysis.results import provenance
    from ..config.reading import resolved_yaml
    from ..variables import describe

    own, seeds = config.coupled, config.seeds
    shape = (len(own.levels), len(seeds))
    records = np.array([[found[i, j]["records"] for j in range(shape[1])] for i in range(shape[0])])
    time = records[0, 0, :, 0]
    series = ("level", "seed", "time")
    data = {
        "structure_displacement": (series, records[..., 1]),
        "structure_acceleration": (series, records[..., 2]),
        "reaction": (series, records[..., 3]),
    }
    if not own.release:
        data["applied_force"] = (("level", "time"), np.array([forces.applied(force, time) for force in every]))
    for name in ("force_work", "structure_loss", "particle_loss", "closure", "cpu_time"):
        data[name] = (("level", "seed"), [[found[i, j][name] for j in range(shape[1])] for i in range(shape[0])])
    dataset = xr.Dataset(data, {"level": own.levels, "seed": seeds, "time": ("time", time, {"units": "s"})})
    dataset = dataset.merge(_identified(own, runs, found, shape))
    dataset = describe(dataset)
    dataset.attrs = {"title": f"{config.title}, coupled", **provenance(), "configuration": resolved_yaml(config)}
    return dataset


def _identified(own: CoupledConfig, runs, found, shape) -> xr.Dataset:
    """Dataset of what an experimenter would identify from the records."""
    import xarray as xr

    mount = runs[0, 0].scene.mount
    if own.source in ("harmonic", "release"):
        if len(mount.frequency) > 1:
            return xr.Dataset()
        read = {
            index: from_response(one["records"], runs[index].scene.mount, WINDOW)
            if own.harmonic
            else from_decay(one["records"])
            for index, one in found.items()
        }
        return _windows(read, shape)
    step = runs[0, 0].dt * mount.record
    curves = []
    for i in range(shape[0]):
        force = runs[i, 0].scene.mount.force
        pairs = [
            (forces.applied(force, one["records"][:, 0]), one["records"][:, 1])
            for (k, _), one in found.items()
            if k == i
        ]
        frequency, curve = accelerance_from_records(pairs, step, AVERAGES if own.random else 1)
        curves.append(curve)
    band, curves = own.swept or own.random, np.array(curves)
    low, high = sorted((band.from_, band.to)) if band else (0.0, math.inf)
    kept = (frequency > 0) & (frequency >= low) & (frequency <= high) & np.isfinite(curves).all(axis=0)
    curves = curves[:, kept]
    dims = ("level", "frequency")
    curve = xr.Dataset(
        {"accelerance_real": (dims, curves.real), "accelerance_imaginary": (dims, curves.imag)},
        {"frequency": ("frequency", frequency[kept], {"units": "Hz"})},
    )
    return curve.squeeze("level", drop=True) if shape[0] == 1 else curve  # one curve is what `fit` reads


def accelerance_from_records(pairs, step: float, pieces: int) -> tuple[np.ndarray, np.ndarray]:
    """Accelerance of a structure from records of the force on it and of its displacement.

    H1 = S_fx / S_ff, spectra averaged over all records and their pieces, times -(2 pi f)^2: of the acceleration itself
    the impacts would be sampled by chance, and fold back into the band.

    Parameters
    ----------
    pairs : of (n,) arrays: force [N], displacement [m]
    step : [s] between their values
    pieces : 1 (the whole, without a window: for what begins and ends at rest) or more (Hann windows)

    Returns
    -------
    frequency : (m,) array [Hz]
    accelerance : (m,) complex array [m s^-2 N^-1]
        NaN where the force has no power.
    """
    from scipy.signal import csd, welch

    n = len(pairs[0][0])
    length = 2 * n // (pieces + 1)
    options = {
        "fs": 1 / step,
        "nperseg": min(n, length),
        "window": "hann" if pieces > 1 else "boxcar",
        "detrend": False,
    }
    frequency, _ = welch(pairs[0][0], **options)
    cross = sum(csd(force, displacement, **options)[1] for force, displacement in pairs)
    power = sum(welch(force, **options)[1] for force, _ in pairs)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = -((2 * np.pi * frequency) ** 2) * cross / power
    return frequency, np.where(power > LEAST_POWER * power.max(), found, np.nan)


def _windows(read: dict[tuple[int, int], list[Identified]], shape) -> xr.Dataset:
    import xarray as xr

    longest = max(len(one) for one in read.values())
    values = np.full((3, *shape, longest), np.nan)
    for (i, j), one in read.items():
        for k, window in enumerate(one):
            values[:, i, j, k] = window.gamma, window.frequency, window.damping
    with np.errstate(invalid="ignore"):
        steady = abs(values[0, ..., 1:] / values[0, ..., :-1] - 1) <= STEADY
    steady = np.concatenate([np.zeros((*shape, 1), bool), steady], axis=-1)
    dims = ("level", "seed", "window")
    names = ("window_gamma", "window_frequency", "window_damping_ratio")
    return xr.Dataset(
        {name: (dims, own) for name, own in zip(names, values, strict=True)}
        | {"window_steady": (dims, steady.astype(np.int8))},
        {"window": np.arange(1, longest + 1)},
    )
