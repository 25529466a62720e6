"""A batch of cases on the device: the only module that launches kernels."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import warp as wp

from . import guards
from .device import DEVICE
from .effects import Effects
from .kernels import data
from .kernels.advance import stepper
from .kernels.ledger import Row
from .kernels.neighbours import neighbour_search
from .law import contact_constants
from .ledger import Ledger
from .scene import Scene, State
from .timestep import Precision, check_step

SKIN = 0.2
"""Extra reach of the neighbour lists, as a part of the smallest radius.  Sets speed, never results."""

_NEVER = np.iinfo(np.int32).max


@dataclass(frozen=True)
class Case:
    """A scene, where it starts, and its step.

    Parameters
    ----------
    dt : step [s]; with a drive, period / steps_per_cycle
    steps_per_cycle : int or None
        Steps to a cycle of the drive, at the end of each of which a ledger row is kept.  None: as the drive's
        frequency says; without a drive, no row but the first is kept.

    Raises
    ------
    ValueError
        If the step does not divide the drive's period into ``steps_per_cycle``.
    """

    scene: Scene
    state: State
    dt: float
    steps_per_cycle: int | None = None

    def __post_init__(self):
        if self.scene.drive is None:
            return
        period = 1 / self.scene.drive.frequency
        steps = round(period / self.dt)
        if steps < 1 or abs(steps * self.dt / period - 1) > 1e-9:
            near = max(1, math.ceil(period / self.dt))
            raise ValueError(
                f"the step {self.dt:.6g} s does not divide the drive's period {period:.6g} s: take period / {near}, "
                f"{period / near!r} s"
            )
        if self.steps_per_cycle not in (None, steps):
            raise ValueError(
                f"steps_per_cycle is {self.steps_per_cycle}, but a step of {self.dt:.6g} s divides the drive's period "
                f"of {period:.6g} s into {steps}: leave it out"
            )
        object.__setattr__(self, "steps_per_cycle", steps)


_WENT_WRONG = {data.NOT_FINITE: "the state is not finite", data.ESCAPED: "a particle has left the cavity"}


class Batch:
    """Cases that advance together.  Each gives the same bits as alone.

    Parameters
    ----------
    cases : list of Case
        All with an enclosure, or all without.
    max_rows : int
        Ledger rows to keep for each case, the one at the start included.
    precision : "float64" or "float32"
    guarded : bool
        Whether the kernels check for what went wrong; see ``Effects``.
    """

    def __init__(self, cases: list[Case], *, max_rows: int = 1, precision: Precision = "float64", guarded: bool = True):
        self.cases = list(cases)
        enclosures = {case.scene.enclosure is not None for case in cases}
        if len(enclosures) != 1:
            raise ValueError("the cases of a batch must all have an enclosure, or all have none")
        self.effects = Effects(precision=precision, enclosure=enclosures.pop(), guards=guarded)
        t = data.types(self.effects.real)
        self._types = t
        self._advance, self._synchronise = stepper(self.effects)
        self._count_pairs, self._list_pairs = neighbour_search(self.effects)

        for case in self.cases:
            guards.check_values(case.state)
        counts = [len(case.state) for case in self.cases]
        self._first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        self._max_rows = max_rows
        n, m = int(self._first[-1]), len(self.cases)

        self._constants = wp.array([self._device_case(k) for k in range(m)], dtype=t.Case, device=DEVICE)
        self._group = wp.array(np.repeat(np.arange(m, dtype=np.int32), counts), device=DEVICE)
        self._particles = self._device_particles()
        self._contacts = self._device_contacts()
        self._steps = wp.zeros(m, dtype=wp.int64, device=DEVICE)
        self._target = wp.zeros(m, dtype=wp.int64, device=DEVICE)
        self._drifts = wp.zeros(m, dtype=t.vec3, device=DEVICE)
        self._tallies = wp.zeros(m, dtype=Row, device=DEVICE)
        self._rows = wp.full(m * max_rows, Row(math.nan), dtype=Row, device=DEVICE)
        self._status = wp.zeros(m, dtype=wp.int32, device=DEVICE)
        self._counts = wp.zeros(n + 1, dtype=wp.int32, device=DEVICE)

        self._largest_radius = max(float(np.max(c.state.radius)) for c in self.cases)
        self._cell = 2 * self._largest_radius * (1 + SKIN)
        side = int(np.clip(2 * np.ceil(np.cbrt(max(counts))), 8, 128))
        self._grid = wp.HashGrid(side, side, side, device=DEVICE, dtype=self.effects.real)
        self._check_overlaps()

    def _device_case(self, k: int):
        t, case = self._types, self.cases[k]
        scene = case.scene
        drive = scene.drive
        c = t.Case()
        c.first, c.count = int(self._first[k]), len(case.state)
        c.first_row, c.rows = k * self._max_rows, self._max_rows
        c.cycle = case.steps_per_cycle or _NEVER
        c.dt = case.dt
        c.skin = SKIN * float(np.min(case.state.radius))
        if scene.enclosure:
            c.radius, c.height = scene.enclosure.diameter / 2, scene.enclosure.height
        c.gravity = t.vec3(*scene.gravity)
        if drive:
            c.direction, c.acceleration = t.vec3(*drive.direction), drive.acceleration
        for law, wall, surface in (
            (c.particle_law, scene.particle, scene.particle_contact),
            (c.wall_law, scene.wall, scene.wall_contact),
        ):
            for name, value in contact_constants(scene.particle, wall, surface).items():
                setattr(law, name, value)
        return c

    def _array(self, values, dtype):
        return wp.array(np.ascontiguousarray(values), dtype=dtype, device=DEVICE)

    def _device_particles(self):
        t = self._types
        states = [case.state for case in self.cases]
        radius = np.concatenate([s.radius for s in states])
        mass = np.concatenate([c.scene.mass(c.state.radius) for c in self.cases])
        p = t.Particles()
        p.position = self._array(np.concatenate([s.position for s in states]), t.vec3)
        for name in ("velocity", "spin"):
            values = np.concatenate([getattr(s, name) for s in states])
            setattr(p, name, self._array(values, t.vec3))
            setattr(p, f"half_{name}", self._array(values, t.vec3))
        for name in ("force", "torque", "listed"):
            setattr(p, name, wp.zeros(len(radius), dtype=t.vec3, device=DEVICE))
        p.radius = self._array(radius, t.real)
        p.inverse_mass = self._array(1 / mass, t.real)
        p.inverse_inertia = self._array(2.5 / (mass * radius**2), t.real)
        return p

    def _device_contacts(self):
        t = self._types
        n = int(self._first[-1])
        pairs = np.concatenate([c.state.pairs + first for c, first in zip(self.cases, self._first, strict=False)])
        order = np.lexsort((pairs[:, 1], pairs[:, 0]))
        start = np.concatenate([[0], np.cumsum(np.bincount(pairs[:, 0], minlength=n))])
        history = np.concatenate([c.state.pair_history for c in self.cases])
        walls = np.concatenate([c.state.wall_history for c in self.cases])
        c = t.Contacts()
        c.start = self._array(start.astype(np.int32), wp.int32)
        c.partner = self._array(pairs[order, 1].astype(np.int32), wp.int32)
        c.pair_history = self._array(history[order], t.vec4)
        c.wall_history = self._array(walls.reshape(-1, 4), t.vec4)
        return c

    def _find_neighbours(self):
        t, p, old = self._types, self._particles, self._contacts
        n = int(self._first[-1])
        self._grid.build(p.position, self._cell, groups=self._group)
        search = [self._grid.id, self._constants, self._group, self._largest_radius, p]
        wp.launch(self._count_pairs, n, [*search, self._counts], device=DEVICE)
        fresh = t.Contacts()
        fresh.wall_history = old.wall_history
        fresh.start = wp.empty(n + 1, dtype=wp.int32, device=DEVICE)
        wp.utils.array_scan(self._counts, fresh.start, inclusive=False)
        total = int(fresh.start.numpy()[-1])
        fresh.partner = wp.empty(total, dtype=wp.int32, device=DEVICE)
        fresh.pair_history = wp.empty(total, dtype=t.vec4, device=DEVICE)
        wp.launch(self._list_pairs, n, [*search, old, fresh, self._drifts], device=DEVICE)
        self._contacts = fresh

    def _check_overlaps(self):
        self._find_neighbours()
        start, partner = self._contacts.start.numpy(), self._contacts.partner.numpy()
        for case, first, last in zip(self.cases, self._first[:-1], self._first[1:], strict=True):
            owner = np.repeat(np.arange(last - first), np.diff(start[first : last + 1]))
            pairs = np.stack([owner, partner[start[first] : start[last]] - first], axis=1)
            guards.check_overlaps(case.scene, case.state, pairs)

    @property
    def steps(self) -> np.ndarray:
        """Step number that each case has reached."""
        return self._steps.numpy().copy()

    @property
    def status(self) -> np.ndarray:
        """``OK``, ``NOT_FINITE`` or ``ESCAPED`` of ``kernels.data`` for each case."""
        return self._status.numpy().copy()

    def advance(self, steps) -> None:
        """Run every case on to its step number in ``steps`` (one for all, or one each).

        A case whose state is no longer finite, or that has lost a particle, stops where it is; see ``status``.
        """
        self._target.assign(np.broadcast_to(np.asarray(steps, np.int64), len(self.cases)).copy())
        done, target, status = self._steps.numpy(), self._target.numpy(), self._status.numpy()
        target[status != data.OK] = done[status != data.OK]
        while np.any(done < target):
            self._find_neighbours()
            wp.launch(
                self._advance,
                len(self.cases),
                [self._constants, self._target, self._particles, self._contacts]
                + [self._steps, self._drifts, self._tallies, self._rows, self._status],
                device=DEVICE,
            )
            target[status != data.OK] = done[status != data.OK]

    def cycles(self, k: int) -> Ledger:
        """Ledger of case ``k`` at its start and at the end of each cycle so far."""
        reached = int(self._steps.numpy()[k]) // (self.cases[k].steps_per_cycle or _NEVER)
        if reached >= self._max_rows:
            raise ValueError(f"case {k} ran {reached} cycles, and max_rows={self._max_rows} kept fewer")
        first = k * self._max_rows
        return Ledger(self._rows.numpy()[first : first + reached + 1].copy())

    def checkpoint(self) -> dict[str, np.ndarray]:
        """All that a run has, as arrays: ``restore`` it into a batch of the same cases and go on to the same bits."""
        return {name: array.numpy().copy() for name, array in self._changing().items()}

    def restore(self, checkpoint: dict[str, np.ndarray]) -> None:
        """Go back to a ``checkpoint``."""
        pairs = checkpoint["partner"].shape[0]
        self._contacts.partner = wp.empty(pairs, dtype=wp.int32, device=DEVICE)
        self._contacts.pair_history = wp.empty(pairs, dtype=self._types.vec4, device=DEVICE)
        for name, array in self._changing().items():
            array.assign(checkpoint[name])

    def _changing(self) -> dict:
        p, c = self._particles, self._contacts
        own = {name: getattr(p, name) for name in self._types.Particles.vars}
        own |= {name: getattr(c, name) for name in self._types.Contacts.vars}
        return own | {
            "steps": self._steps,
            "drifts": self._drifts,
            "tallies": self._tallies,
            "rows": self._rows,
            "status": self._status,
        }

    def read(self) -> list[tuple[State, Ledger]]:
        """State and ledger of every case now, velocities brought to the whole step.

        Works on copies: reading never changes what comes after.
        """
        self._find_neighbours()
        p, c, t = self._particles, self._contacts, self._types
        copy_p, copy_c = t.Particles(), t.Contacts()
        for name in t.Particles.vars:
            setattr(copy_p, name, wp.clone(getattr(p, name)))
        for name in t.Contacts.vars:
            setattr(copy_c, name, wp.clone(getattr(c, name)))
        tallies = wp.clone(self._tallies)
        wp.launch(
            self._synchronise,
            len(self.cases),
            [self._constants, self._steps, copy_p, copy_c, tallies],
            device=DEVICE,
        )
        return [self._read_case(k, copy_p, copy_c, tallies) for k in range(len(self.cases))]

    def _read_case(self, k, p, c, tallies):
        first, last = self._first[k], self._first[k + 1]
        start, history = c.start.numpy(), c.pair_history.numpy().astype(float)
        a, b = start[first], start[last]
        owner = np.repeat(np.arange(last - first), np.diff(start[first : last + 1]))
        pairs = np.stack([owner, c.partner.numpy()[a:b] - first], axis=1)
        touching = history[a:b, 3] > 0
        state = State(
            position=p.position.numpy()[first:last].astype(float),
            velocity=p.half_velocity.numpy()[first:last].astype(float),
            spin=p.half_spin.numpy()[first:last].astype(float),
            radius=p.radius.numpy()[first:last].astype(float),
            pairs=pairs[touching],
            pair_history=history[a:b][touching],
            wall_history=c.wall_history.numpy()[3 * first : 3 * last].astype(float).reshape(-1, 3, 4),
        )
        return state, Ledger(tallies.numpy()[k : k + 1].astype(float).copy())


class Simulation(Batch):
    """One scene from a given start: the researcher's door.

    Parameters
    ----------
    scene : Scene
    state : State
    dt : step [s]
    precision : "float64" or "float32"

    Raises
    ------
    ValueError
        If the start is not finite or overlaps too deeply, or the step does not resolve the fastest contact expected or
        does not divide the drive's period.

    Examples
    --------
    >>> ball = State.at_rest([[0, 0, 0.02]], radius=0.00373)
    >>> simulation = Simulation(scene, ball, dt=1e-6)
    >>> simulation.advance(10_000)
    >>> state, ledger = simulation.read()
    """

    def __init__(self, scene: Scene, state: State, dt: float, *, precision: Precision = "float64"):
        guards.check_values(state)
        check_step(scene, state, dt)
        super().__init__([Case(scene, state, dt)], precision=precision)
        self._start = super().read()[0][1].rows

    def advance(self, steps: int) -> None:
        """Run ``steps`` more steps.

        Raises
        ------
        guards.SimulationError
            If the state is no longer finite, a particle has left the cavity, a contact is too deep for Hertz's theory,
            or the energy ledger does not close.
        """
        super().advance(int(self.steps[0]) + steps)
        if self.status[0] != data.OK:
            _, ledger = super().read()[0]
            raise guards.SimulationError(
                f"{_WENT_WRONG[int(self.status[0])]} by step {self.steps[0]} (largest overlap so far "
                f"{ledger['largest_overlap'][0]:.2g} of the reduced radius): take a step below {self.cases[0].dt:.3g} s"
            )
        _, ledger = self.read()
        guards.check_run(ledger, self.cases[0].dt)

    def read(self) -> tuple[State, Ledger]:
        """State now, and the ledger's rows at the start and now."""
        state, ledger = super().read()[0]
        return state, Ledger(np.concatenate([self._start, ledger.rows]))
