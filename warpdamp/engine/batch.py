"""Batch of cases on the device: the only module that launches kernels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from ..kernels.advance import stepper
from ..kernels.columns import KernelStatus
from ..kernels.coupled import coupled_stepper
from ..kernels.lanes import lanes_for
from ..kernels.neighbours import NO_GRID, neighbour_search
from ..kernels.structs import PER_PAIR, SCRATCH, types
from ..numerics.timestep import check_step
from ..scene.contact import contact_constants
from ..scene.effects import Effects, called_for, covering
from ..scene.particles import State
from ..scene.scene import Scene
from ..scene.sphere import inverse_sphere_inertia
from . import checks as guards
from .arrays import Transfer
from .device import check_device
from .hosts import HostStructures, shared
from .ledger import Ledger

SKIN = 0.2
"""Usual extra reach of the neighbour lists, as a part of the smallest radius."""

MOST_SEARCHED = 300
"""In cases of so many particles all pairs are looked at for the neighbour lists: building the grid takes longer."""

_NEVER = np.iinfo(np.int32).max


@dataclass(frozen=True)
class Case:
    """Case of a batch: a scene, its initial state, and the step.

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
        if self.scene.excitation_frequency is None:
            return
        period = 1 / self.scene.excitation_frequency
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


class Batch:
    """Batch of cases that advance together; each gives the same bits as alone with the same effects.

    Parameters
    ----------
    cases : list of Case
    max_rows : int
        Ledger rows to keep for each case, the one at the start included.
    max_records : int
        Records to keep of a case whose host asks for them; see ``HostStructure.record``.
    effects : Effects or None
        What the kernels are compiled for.  None: all that the cases call for.
    skin : float
        Extra reach of the neighbour lists, as a part of the smallest radius.  Sets speed, never results.
    enclosures : sequence of int or None
        How many cases, one after the other, sit on one structure each, as (2, 1) of three cases: their scenes' hosts
        are the same but for ``amplitude``, and a force acts at the first of them.  None: each has its own.

    Raises
    ------
    ValueError
        If a start is not finite or overlaps too deeply, or cases that share a structure differ in it or in their step.
    """

    def __init__(
        self,
        cases: list[Case],
        *,
        max_rows: int = 1,
        max_records: int = 0,
        effects: Effects | None = None,
        skin: float = SKIN,
        enclosures: Sequence[int] | None = None,
    ):
        self.cases = list(cases)
        self._enclosures = shared(self.cases, enclosures)
        for case in self.cases:
            guards.check_values(case.state)
            guards.check_shapes(case.scene, case.state)
        self.effects = effects or covering([called_for(case.scene, case.state) for case in self.cases])
        for case in self.cases:
            guards.check_walls(case.scene, self.effects)
        t = types(self.effects)
        device = self.effects.device
        check_device(device)
        self._types, self._device = t, device
        loop = stepper if all(self._enclosures) else coupled_stepper
        self._advance, self._synchronise = loop(self.effects, lanes_for(self.effects))
        self._count_pairs, self._list_pairs = neighbour_search(self.effects)

        self._transfer = Transfer(t, [case.state for case in self.cases], device)
        self._max_rows, self._max_records, self._skin = max_rows, max_records, skin
        n, m = len(self._transfer), len(self.cases)
        counts = [len(case.state) for case in self.cases]

        laws: dict[str, list] = {"laws": [], "wall_laws": []}
        hosts = HostStructures()
        self._constants = wp.array([self._device_case(k, laws, hosts) for k in range(m)], dtype=t.Case, device=device)
        self._host = hosts.on_device(t, device)
        self._group = wp.array(np.repeat(np.arange(m, dtype=np.int32), counts), device=device)
        self._particles = self._transfer.particles([c.scene.masses(c.state) for c in self.cases])
        self._contacts = self._transfer.contacts(laws)
        self._steps = wp.zeros(m, dtype=wp.int64, device=device)
        self._target = wp.zeros(m, dtype=wp.int64, device=device)
        self._shifts = wp.zeros(m, dtype=t.vec3, device=device)
        self._cycle_start = wp.zeros(n if self.effects.indicators else 0, dtype=t.vec3, device=device)
        self._tallies = wp.zeros(m, dtype=t.Row, device=device)
        self._rows = wp.full(m * max_rows, t.Row(math.nan), dtype=t.Row, device=device)
        self._status = wp.zeros(m, dtype=wp.int32, device=device)
        self._counts = wp.zeros(n + 1, dtype=wp.int32, device=device)

        self._largest_radius = max(float(np.max(c.state.bounding_radius)) for c in self.cases)
        self._cell = 2 * self._largest_radius * (1 + skin)
        self._grid = None
        if max(counts) > MOST_SEARCHED:
            side = int(np.clip(np.ceil(np.cbrt(max(counts))), 8, 128))
            self._grid = wp.HashGrid(side, side, side, device=device, dtype=self.effects.real)
        self._check_overlaps()

    def _device_case(self, k: int, laws: dict[str, list], hosts: HostStructures):
        t, case = self._types, self.cases[k]
        scene, state, drive = case.scene, case.state, case.scene.drive
        moved = drive or scene.host
        radius = float(state.radius[0])
        mass = float(scene.masses(state)[0])
        values = {
            "first": int(self._transfer.first[k]),
            "count": len(state),
            "first_row": k * self._max_rows,
            "rows": self._max_rows,
            "cycle": case.steps_per_cycle or _NEVER,
            "dt": case.dt,
            "skin": self._skin * float(np.min(state.bounding_radius)),
            "gravity": t.vec3(*scene.gravity),
            "direction": t.vec3(*(moved.direction if moved else (0.0, 0.0, 1.0))),
            "acceleration": drive.acceleration if drive else 0.0,
            **hosts.add(scene.host, case.dt, self._max_records, self._enclosures[k]),
            "particle_radius": radius,
            "particle_curvature": 1 / radius,
            "particle_mass": float(np.sum(scene.masses(state))),
            "inverse_mass": 1 / mass,
            "inverse_inertia": inverse_sphere_inertia(mass, radius),
        }
        if scene.enclosure:
            values |= vars(scene.enclosure) | {"radius": scene.enclosure.diameter / 2}
        values |= self._device_laws(scene, laws)
        device = t.Case()
        for name in t.Case.vars:
            setattr(device, name, values[name])
        return device

    def _device_laws(self, scene: Scene, laws: dict[str, list]) -> dict:
        """The laws of a scene: two if all particles are of one material, places in the tables if not."""
        every = range(len(scene.materials))
        if not self.effects.materials:
            only = scene.materials[0]
            return {
                "particle_law": self._law(only, only, scene.pair_surface(0, 0)),
                "wall_law": self._law(only, scene.wall, scene.wall_surface(0)),
            }
        first = {"species": len(every), "first_law": len(laws["laws"]), "first_wall_law": len(laws["wall_laws"])}
        for i in every:
            for j in every:
                surface = scene.pair_surface(i, j)
                laws["laws"].append(self._law(scene.materials[i], scene.materials[j], surface))
            laws["wall_laws"].append(self._law(scene.materials[i], scene.wall, scene.wall_surface(i)))
        return first

    def _law(self, one, other, surface):
        law = self._types.Law()
        constants = contact_constants(one, other, surface)
        for name in self._types.Law.vars:
            setattr(law, name, constants[name])
        return law

    def _find_neighbours(self) -> None:
        """List anew the neighbours of every case that has not reached its target."""
        t, old = self._types, self._contacts
        n = len(self._transfer)
        grid = NO_GRID
        if self._grid:
            self._grid.build(self._positions(), self._cell, groups=self._group)
            grid = self._grid.id
        search = [grid, self._constants, self._group, self._steps, self._target, self._largest_radius, self._particles]
        search.append(old)
        wp.launch(self._count_pairs, n, [*search, self._counts], device=self._device)
        fresh = t.Contacts()
        fresh.start = wp.empty(n + 1, dtype=wp.int32, device=self._device)
        wp.utils.array_scan(self._counts, fresh.start, inclusive=False)
        total = int(fresh.start.numpy()[-1])
        for name, variable in t.Contacts.vars.items():
            large_enough = name in SCRATCH and len(getattr(old, name)) >= total
            if name in PER_PAIR and not large_enough:
                setattr(fresh, name, wp.empty(total, dtype=variable.type.dtype, device=self._device))
            elif name != "start":
                setattr(fresh, name, getattr(old, name))
        wp.launch(self._list_pairs, n, [*search, fresh, self._shifts], device=self._device)
        self._contacts = fresh

    def _positions(self) -> wp.array:
        """Positions of all particles, side by side as the grid wants them."""
        p = self._particles
        field = self._types.Particle.numpy_dtype()
        view = wp.array(
            ptr=p.ptr + field["offsets"][field["names"].index("position")],
            dtype=self._types.vec3,
            shape=p.shape,
            strides=p.strides,
            device=self._device,
        )
        return view.contiguous()

    def _find_all_neighbours(self) -> None:
        """List the neighbours of every case anew."""
        self._target.fill_(np.iinfo(np.int64).max)
        self._find_neighbours()

    def _check_overlaps(self):
        self._find_all_neighbours()
        for k, case in enumerate(self.cases):
            guards.check_overlaps(case.scene, case.state, self._transfer.listed(k, self._contacts))

    @property
    def steps(self) -> np.ndarray:
        """Step number that each case has reached, (cases,)."""
        return self._steps.numpy().copy()

    @property
    def status(self) -> np.ndarray:
        """Status of each case, (cases,) numbers of ``kernels.columns.KernelStatus``."""
        return self._status.numpy().copy()

    def advance(self, steps) -> None:
        """Run every case on to its step number in ``steps`` (one for all, or one each).

        A case whose state is no longer finite, or that has lost a particle, stops where it is, with all on its
        structure; see ``status``.  Cases on one structure run to the step of the first of them.
        """
        target = np.broadcast_to(np.asarray(steps, np.int64), len(self.cases))
        target = target[np.maximum.accumulate(np.where(self._enclosures, np.arange(len(self.cases)), 0))]
        self._target.assign(np.where(self.status == KernelStatus.OK, target, 0))
        while np.any(self.steps < self._target.numpy()):
            self._find_neighbours()
            wp.launch(
                self._advance,
                len(self.cases),
                [self._constants, self._particles, self._contacts, self._host]
                + [self._target, self._steps, self._shifts, self._cycle_start, self._tallies, self._rows, self._status],
                device=self._device,
            )

    def cycles(self, k: int) -> Ledger:
        """Ledger of case ``k`` at its start and at the end of each cycle so far."""
        reached = int(self._steps.numpy()[k]) // (self.cases[k].steps_per_cycle or _NEVER)
        if reached >= self._max_rows:
            raise ValueError(f"case {k} ran {reached} cycles, and max_rows={self._max_rows} kept fewer")
        first = k * self._max_rows
        return Ledger(self._rows.numpy()[first : first + reached + 1].copy(), self.effects)

    def records(self, k: int) -> np.ndarray:
        """Records of case ``k``, (n, 4): time [s], place [m] and acceleration [m/s^2] of the enclosure, reaction [N].

        The reaction is the particles' force on the enclosure along the host's direction.
        """
        host, case = self.cases[k].scene.host, self._constants.numpy()[k]
        kept = self._host.records.numpy()[case["first_record"] : case["first_record"] + case["records"]]
        reached = min(len(kept), 1 + (int(self._steps.numpy()[k]) - 1) // host.record)
        time = np.arange(reached) * host.record * self.cases[k].dt
        return np.concatenate([time[:, None], kept[:reached]], axis=1)

    def checkpoint(self) -> dict[str, np.ndarray]:
        """Checkpoint of a run, as arrays: ``restore`` continues it in a batch of the same cases to the same bits."""
        return {name: array.numpy().copy() for name, array in self._changing().items()}

    def restore(self, checkpoint: dict[str, np.ndarray]) -> None:
        """Restore the state of a ``checkpoint``."""
        pairs = checkpoint["partner"].shape[0]
        for name, variable in self._types.Contacts.vars.items():
            if name in PER_PAIR:
                setattr(self._contacts, name, wp.empty(pairs, dtype=variable.type.dtype, device=self._device))
        for name, array in self._changing().items():
            array.assign(checkpoint[name])

    def _changing(self) -> dict:
        constant = ("laws", "wall_laws", *SCRATCH)
        contacts = {name: getattr(self._contacts, name) for name in self._types.Contacts.vars if name not in constant}
        host = {
            name: getattr(self._host, name) for name in ("modes", "records") if name in self._types.HostStructure.vars
        }
        return contacts | {
            **host,
            "particles": self._particles,
            "steps": self._steps,
            "shifts": self._shifts,
            "cycle_start": self._cycle_start,
            "tallies": self._tallies,
            "rows": self._rows,
            "status": self._status,
        }

    def read(self) -> list[tuple[State, Ledger]]:
        """Read state and ledger of every case, velocities brought to the whole step.

        Works on copies: reading never changes what comes after.
        """
        self._find_all_neighbours()
        p, c, t = self._particles, self._contacts, self._types
        copy_p, copy_c = wp.clone(p), t.Contacts()
        for name in t.Contacts.vars:
            setattr(copy_c, name, wp.clone(getattr(c, name)) if name in ("pair", "wall") else getattr(c, name))
        copy_m = t.HostStructure()
        for name in t.HostStructure.vars:
            value = getattr(self._host, name)
            setattr(copy_m, name, value if name == "count" else wp.clone(value))
        tallies = wp.clone(self._tallies)
        wp.launch(
            self._synchronise,
            len(self.cases),
            [self._constants, self._steps, copy_p, copy_c, copy_m, tallies],
            device=self._device,
        )
        rows = tallies.numpy()
        return [
            (self._transfer.state(k, copy_p, copy_c), Ledger(rows[k : k + 1].copy(), self.effects))
            for k in range(len(self.cases))
        ]


class Simulation(Batch):
    """Simulation of one scene from a given state, step by step.

    Parameters
    ----------
    scene : Scene
    state : State
    dt : step [s]
    effects : Effects or None
        What the kernels are compiled for.  None: what the scene calls for.

    Raises
    ------
    ValueError
        If the start is not finite or overlaps too deeply, or the step does not resolve the fastest contact expected or
        does not divide the drive's period.

    Examples
    --------
    >>> from warpdamp import Cylinder, Material, Scene, Simulation, State, Surface
    >>> pmma, surface = Material(920, 3.3e9, 0.37), Surface(0.52, 0.86)
    >>> scene = Scene(pmma, pmma, surface, surface, Cylinder(0.04, 0.04))
    >>> ball = State.at_rest([[0, 0, 0.02]], radius=3.73e-3)
    >>> simulation = Simulation(scene, ball, dt=2e-6)
    >>> simulation.advance(20_000)
    >>> state, ledger = simulation.read()
    >>> round(1e3 * float(state.position[0, 2]), 2)  # after 40 ms of free fall, 20 mm - g t^2 / 2 [mm]
    12.15
    >>> bool(abs(ledger.residual[-1]) < 1e-12)  # [J]
    True
    """

    def __init__(self, scene: Scene, state: State, dt: float, *, effects: Effects | None = None):
        guards.check_values(state)
        check_step(scene, state, dt)
        super().__init__([Case(scene, state, dt)], effects=effects)
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
        if self.status[0] != KernelStatus.OK:
            _, ledger = super().read()[0]
            raise guards.SimulationError(
                f"{KernelStatus(self.status[0]).sentence} by step {self.steps[0]} (largest overlap so far "
                f"{ledger['largest_overlap'][0]:.2g} of the reduced radius): take a step below {self.cases[0].dt:.3g} s"
            )
        _, ledger = self.read()
        guards.check_run(ledger, self.cases[0].dt)

    def read(self) -> tuple[State, Ledger]:
        """Read the state, and the ledger's rows at the start and now."""
        state, ledger = super().read()[0]
        return state, Ledger(np.concatenate([self._start, ledger.rows]), self.effects)
