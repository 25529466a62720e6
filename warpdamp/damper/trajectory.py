"""Trajectory of a case: the case run again to the same bits, and its last cycles recorded frame by frame.

Recording stops a run at its frames and looks at copies; the case's own numbers do not change by it, and ``Again`` says
whether they are those of the results that the case was taken from.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..engine.batch import Batch, Case
from ..engine.ledger import Ledger, maximum_energy
from ..engine.probe import Probe, Touching
from ..errors import SimulationError
from ..kernels.columns import KernelStatus
from ..numerics.limits import STEPS_PER_CONTACT
from ..scene.particles import State
from ..scene.scene import Scene
from .case import Spec
from .preparation import prepare

FRAMES, CYCLES = 60, 3
"""Usual frames of a film, and cycles of the drive that they show."""

SAMPLES_PER_CONTACT = 4
"""Looks at the losses within the shortest contact.  On the paper's damper the particles' losses then add up to the
ledger's to 2 %."""


@dataclass(frozen=True)
class Frame:
    """Moment of a case, in the frame of the cavity.

    Parameters
    ----------
    cycle : float
        Cycles of the drive since the case began; the cavity is at X sin(2 pi cycle).
    state : State
        Velocities of the whole step.
    touching : Touching
        Contacts that press.
    lost : (n,) array
        Energy that each particle lost since the first frame [J].
    """

    cycle: float
    state: State
    touching: Touching
    lost: np.ndarray


@dataclass(frozen=True)
class Trajectory:
    """Recorded part of a case.

    Parameters
    ----------
    scene : Scene
        With its drive.
    frames : list of Frame
    ledger : Ledger
        At the start and at the end of every cycle of the case, recorded or not.
    particle_mass : float
        Of all particles [kg].
    """

    scene: Scene
    frames: list[Frame]
    ledger: Ledger
    particle_mass: float

    @property
    def effectiveness(self) -> np.ndarray:
        """Effectiveness of every cycle of the case, (cycles,) [-]."""
        return self.ledger.per_cycle() / maximum_energy(self.scene.drive, self.particle_mass)

    @property
    def displacement(self) -> np.ndarray:
        """Displacement of the cavity at every frame, (frames, 3) [m]."""
        phase = 2 * np.pi * np.array([frame.cycle for frame in self.frames])
        return self.scene.drive.displacement * np.sin(phase)[:, None] * np.asarray(self.scene.drive.direction)


def record(
    chain: list[Spec],
    cycles: list[int],
    *,
    frames: int = FRAMES,
    shown: int = CYCLES,
    early: float = 0.0,
    report: Callable[[float], None] = lambda done: None,
) -> Trajectory:
    """Run a case again and record its last cycles.

    Parameters
    ----------
    chain : list of Spec
        The case, last, and those before it that its bed was carried through.
    cycles : list of int
        Cycles that each of them ran.
    frames : int
        Moments to record, evenly spaced.
    shown : int
        Cycles of the drive to record, at most those of the case.
    early : float
        Cycles before the end of the case at which the recording ends, less than those that are not shown.
    report : callable
        Called with the part that is done, 0 to 1.

    Returns
    -------
    Trajectory

    Raises
    ------
    SimulationError
        If the case, or one before it, fails.
    """
    state = prepare(chain[0].bed).state
    for spec, count in zip(chain[:-1], cycles[:-1], strict=True):
        batch = _batch(spec, state, count)
        batch.advance(count * spec.steps_per_cycle)
        if batch.status[0] == KernelStatus.OK:  # one that failed leaves the bed that it started from
            state = batch.read()[0][0]
    spec, count = chain[-1], cycles[-1]
    batch, shown = _batch(spec, state, count), min(shown, count)
    last = count * spec.steps_per_cycle
    first = last - round((shown + early) * spec.steps_per_cycle)
    moments = first + _spread(shown * spec.steps_per_cycle, frames)
    recorded = list(_frames(batch, spec, moments, report))
    batch.advance(last)
    _refuse_failed(batch)
    mass = float(np.sum(spec.scene.masses(spec.bed.grains)))
    return Trajectory(spec.scene, recorded, batch.cycles(0), mass)


def _batch(spec: Spec, state: State, cycles: int) -> Batch:
    return Batch([Case(spec.scene, state, spec.dt)], max_rows=cycles + 1, effects=spec.effects)


def _spread(steps: int, frames: int) -> np.ndarray:
    """Steps of the frames after the first one's: the film ends a frame before it would repeat the phase."""
    return np.round(np.arange(frames) * steps / frames).astype(int)


def _frames(batch: Batch, spec: Spec, moments: np.ndarray, report):
    """Frames at some steps; between them the losses are looked at several times within the shortest contact."""
    stride = max(1, round(STEPS_PER_CONTACT / SAMPLES_PER_CONTACT))
    probe, lost, before = Probe(batch), np.zeros(len(spec.bed.grains)), int(moments[0])
    for k, moment in enumerate(moments):
        for step in range(before, moment, stride):
            batch.advance(step)
            lost += min(stride, moment - step) * probe.lost()
        batch.advance(moment)
        _refuse_failed(batch)
        yield Frame(moment / spec.steps_per_cycle, batch.read()[0][0], probe.touching(), lost.copy())
        before = int(moment)
        report((k + 1) / len(moments))


def _refuse_failed(batch: Batch) -> None:
    if batch.status[0] != KernelStatus.OK:
        raise SimulationError(f"the case cannot be recorded: {KernelStatus(batch.status[0]).sentence}")
