"""A verification case: what is set up, what it is compared with, and how far off it may be, and why.

The cases are data and functions; the tests run them shortened, ``scripts/documents/verification.py`` at full resolution.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from warpdamp import Batch, Case, Cylinder, Drive, Material, Scene, Simulation, State, Surface
from warpdamp.engine.ledger import maximum_energy
from warpdamp.scene.contact import contact_constants, contact_time
from warpdamp.scene.paper import PMMA, RADIUS


@dataclass(frozen=True)
class Check:
    """One figure: found must lie within ``tolerance`` of expected (both absolute)."""

    name: str
    expected: float
    found: float
    tolerance: float

    @property
    def error(self) -> float:
        return abs(self.found - self.expected)

    @property
    def holds(self) -> bool:
        return bool(self.error <= self.tolerance)


@dataclass(frozen=True)
class Curve:
    """A line of a case's plot; ``style`` is matplotlib's."""

    label: str
    x: np.ndarray
    y: np.ndarray
    style: str = "-"


@dataclass
class Result:
    """What a case found: its checks, and curves where they say more."""

    checks: list[Check]
    curves: list[Curve] = field(default_factory=list)
    axes: tuple[str, str] = ("", "")

    def add(self, name, expected, found, tolerance):
        self.checks.append(Check(name, float(expected), float(found), float(tolerance)))


@dataclass(frozen=True)
class Verification:
    """A case of the suite."""

    title: str
    setup: str
    reference: str
    tolerance: str
    run: Callable[[bool], Result]


CASES: list[Verification] = []


def case(title, *, setup, reference, tolerance):
    """Register ``run(fine)`` as a case."""

    def register(run):
        CASES.append(Verification(title, setup, reference, tolerance, run))
        return run

    return register


def scene(restitution=0.52, friction=0.86, *, particle=PMMA, wall=None, cavity=None, gravity=(0, 0, 0), drive=None):
    surface = Surface(restitution, friction)
    return Scene(particle, wall or particle, surface, surface, cavity, gravity, drive)


def impact_time(s: Scene, radius, speed: float, *, wall: bool = False) -> float:
    """Hertz's contact time of two given spheres, or of one and a wall."""
    mass = s.mass(radius)
    if wall:
        modulus = contact_constants(s.particle, s.wall, s.wall_contact)["modulus"]
        return contact_time(modulus, float(np.max(radius)), float(np.max(mass)), speed)
    modulus = contact_constants(s.particle, s.particle, s.particle_contact)["modulus"]
    return contact_time(modulus, np.prod(radius) / np.sum(radius), float(np.prod(mass) / np.sum(mass)), speed)


def head_on(speed, radius=(RADIUS, RADIUS), gap=1e-6):
    """Two spheres that meet along x at a relative speed, seen from their centre of mass."""
    radius = np.asarray(radius, float)
    mass = radius**3
    state = State.at_rest([[-radius[0] - gap / 2, 0, 0], [radius[1] + gap / 2, 0, 0]], radius)
    state.velocity[:, 0] = [speed * mass[1] / mass.sum(), -speed * mass[0] / mass.sum()]
    return state


def on_floor(velocity, spin=(0, 0, 0), radius=RADIUS, gap=1e-6):
    """A sphere just above the floor, and a cavity wide enough for it alone."""
    state = State.at_rest([[0, 0, radius + gap]], radius)
    state.velocity[0], state.spin[0] = velocity, spin
    return state, Cylinder(100 * radius, 100 * radius)


def after(s: Scene, state: State, dt: float, time: float):
    simulation = Simulation(s, state, dt)
    simulation.advance(int(np.ceil(time / dt)))
    return simulation.read()


def together(cases, steps):
    """Many small cases at once: (scene, state, dt) each; returns the ledgers before, and states and ledgers after."""
    batch = Batch([Case(*c) for c in cases])
    start = [ledger for _, ledger in batch.read()]
    batch.advance(steps)
    return start, batch.read()


def shaken(s: Scene, state: State, dt: float, cycles: int):
    n = int(np.ceil(1 / (s.drive.frequency * dt)))
    batch = Batch([Case(s, state, 1 / (s.drive.frequency * n), n)], max_rows=cycles + 1)
    batch.advance(cycles * n)
    return batch.cycles(0)


def effectiveness(ledger, s: Scene, radius):
    return ledger.per_cycle() / maximum_energy(s.drive, float(np.sum(s.mass(radius))))


__all__ = [
    "CASES", "PMMA", "RADIUS", "Batch", "Case", "Check", "Curve", "Cylinder", "Drive", "Material", "Result", "Scene",
    "Simulation", "State", "Surface", "after", "case", "effectiveness", "head_on", "impact_time", "on_floor", "scene",
    "shaken", "together",
]  # fmt: skip
