"""The hard cases, as data and functions; shortened in the tests, whole in ``scripts/documents/stability.py``."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from warpdamp import (
    Batch,
    Case,
    Cylinder,
    Drive,
    Grains,
    PackingError,
    Request,
    Scene,
    State,
    Surface,
    prepare,
)
from warpdamp.damper.placement import separate
from warpdamp.damper.settling import settle
from warpdamp.engine.checks import DEEPEST, LARGEST_RESIDUAL, residual_share
from warpdamp.engine.ledger import Ledger
from warpdamp.kernels.columns import KernelStatus
from warpdamp.numerics.timestep import check_step, contact_step, steps_per_cycle
from warpdamp.scene.effects import called_for
from warpdamp.scene.paper import CAVITY, PMMA, RADIUS

G = (0.0, 0.0, -9.81)


@dataclass(frozen=True)
class Outcome:
    """How a case ended: it ran (and what the guards say), or it was refused (and what was said)."""

    ran: bool
    message: str
    residual: float = math.nan
    deepest: float = math.nan
    flagged: str = ""


@dataclass(frozen=True)
class HardCase:
    """A hard case and how it has to end: "runs", "refused", or "flagged" (runs, and a guard says that it may not be trusted)."""

    title: str
    expected: str
    run: Callable[[bool], Outcome]


CASES: list[HardCase] = []


def hard(title, expected="runs"):
    def register(run):
        CASES.append(HardCase(title, expected, run))
        return run

    return register


def scene(*, material=PMMA, restitution=0.52, friction=0.86, rolling=0.0, cavity=CAVITY, gravity=G, drive=None):
    surface = Surface(restitution, friction, rolling)
    return Scene(material, material, surface, surface, cavity, gravity, drive)


def bed(count, *, radius=RADIUS, cavity=CAVITY, seed=1):
    """Spheres in the cavity, apart."""
    radii = np.broadcast_to(radius, count).copy()
    return State.at_rest(separate(radii, cavity, seed), radii)


def attempt(
    s: Scene, state: State, *, cycles=2, dt=None, steps=None, precision="float64", plant=None, effects=None
) -> Outcome:
    """Run a scene with the step that is chosen for it (or a given one), and judge it as the runner does."""
    try:
        if s.drive:
            n = math.ceil(1 / (s.drive.frequency * dt)) if dt else steps_per_cycle(s, state)
            dt = 1 / (s.drive.frequency * n)
            steps = steps or cycles * n
        else:
            dt = dt or contact_step(s, state)
        check_step(s, state, dt)
        effects = effects or called_for(s, state, precision=precision)
        batch = Batch([Case(s, state, dt)], effects=effects, max_rows=1)
    except ValueError as error:
        return Outcome(False, str(error))
    start = batch.read()[0][1]
    if plant:
        plant(batch)
    batch.advance(steps)
    now, ledger = batch.read()[0]
    return judge(batch.status[0], Ledger(np.concatenate([start.rows, ledger.rows])), now, s)


def judge(status, ledger, now, s) -> Outcome:
    if status != KernelStatus.OK:
        words = {KernelStatus.NOT_FINITE: "not finite", KernelStatus.ESCAPED: "a particle left the cavity"}
        return Outcome(True, "stopped", flagged=words[int(status)])
    share, deepest = residual_share(ledger), float(ledger["largest_overlap"][-1])
    flagged = []
    if deepest > DEEPEST:
        flagged.append("contacts too deep for Hertz")
    if share > LARGEST_RESIDUAL:
        flagged.append("ledger out of balance")
    if not np.isfinite(now.position).all():
        flagged.append("NOT FINITE AND UNSEEN")
    elif s.enclosure and not _contained(now, s.enclosure):
        flagged.append("NOT CONTAINED AND UNSEEN")
    return Outcome(True, "ran", share, deepest, ", ".join(flagged))


def _contained(state, cavity):
    x, y, z = state.position.T
    inside = np.hypot(x, y) < cavity.diameter / 2
    return bool(np.all(inside & (z > 0) & (z < cavity.height)))


def shaken(frequency=46.0, gamma=6.0, **change):
    return scene(drive=Drive(frequency, gamma * 9.81), **change)


def scaled(material, factor):
    return replace(material, youngs_modulus=material.youngs_modulus * factor)


hard("modulus x 1000")(lambda fine: attempt(shaken(material=scaled(PMMA, 1e3)), bed(30), cycles=1))
hard("modulus / 1000", "flagged")(lambda fine: attempt(shaken(material=scaled(PMMA, 1e-3)), bed(120), cycles=4))
for e in (0.0, 0.01, 0.99, 1.0):
    hard(f"restitution {e:g}")(
        lambda fine, e=e: attempt(shaken(restitution=e), bed(120 if fine else 40), cycles=4 if fine else 1)
    )
for mu in (0.0, 5.0):
    hard(f"friction {mu:g}")(lambda fine, mu=mu: attempt(shaken(friction=mu), bed(120), cycles=4 if fine else 2))


@hard("size ratio 1:20, mixed")
def mixed(fine):
    radius = np.concatenate([np.full(4, 6e-3), np.full(3000 if fine else 400, 0.3e-3)])
    return attempt(shaken(), bed(len(radius), radius=radius), steps=6000 if fine else 1500)


for count in (1, 2):
    hard(f"{count} particle{'s' if count > 1 else ''}")(lambda fine, n=count: attempt(shaken(), bed(n), cycles=10))


@hard("20,000 particles")
def many(fine):
    count = 20_000 if fine else 2000
    scale = (count / 120) ** (1 / 3)
    cavity = Cylinder(0.04 * scale, 0.04 * scale)
    return attempt(shaken(cavity=cavity), bed(count, cavity=cavity), steps=1500 if fine else 500)


def filled(count):
    """A bed of so many of the paper's spheres in its cavity, made and settled as the runner does."""
    try:
        made = prepare(Request(shaken(), Grains.alike(RADIUS, count), 1, "loose"))
    except PackingError as error:
        return Outcome(False, str(error))
    return attempt(shaken(), made.state, cycles=4)


hard("fill just below jamming (122 spheres, 0.528)")(lambda fine: filled(122))
hard("fill at jamming (124 spheres, 0.536)")(lambda fine: filled(124))
hard("fill above jamming (132 spheres, 0.571)", "refused")(lambda fine: filled(132))


@hard("a lid that presses on the bed")
def pressed(fine):
    loose = settle(scene(), bed(120))
    top = float(np.max(loose.position[:, 2] + loose.radius))
    low = Cylinder(CAVITY.diameter, top - 0.005 * RADIUS)
    return attempt(shaken(cavity=low), loose, cycles=4 if fine else 1)


hard("Gamma 0.01")(lambda fine: attempt(shaken(gamma=0.01), settle(scene(), bed(120)), cycles=4))
hard("Gamma 1500")(lambda fine: attempt(shaken(gamma=1500.0), bed(120), cycles=1))
hard("1 Hz")(lambda fine: attempt(shaken(1.0, 2.0), bed(40 if fine else 10), steps=None if fine else 40_000, cycles=1))
hard("5 kHz")(lambda fine: attempt(shaken(5000.0, 6.0), bed(120), cycles=100))
hard("no gravity")(lambda fine: attempt(shaken(gravity=(0, 0, 0)), bed(120), cycles=4 if fine else 2))
hard("sideways gravity")(lambda fine: attempt(shaken(gravity=(9.81, 0, 0)), bed(120), cycles=4 if fine else 2))
hard("ten times gravity")(lambda fine: attempt(shaken(gravity=(0, 0, -98.1)), bed(120), cycles=4 if fine else 2))
hard("walls that cross a diameter in a few steps", "refused")(
    lambda fine: attempt(shaken(46.0, 60_000.0), bed(40), dt=2e-6)
)


def overlapping(share):
    state = bed(40)
    state.position[1] = state.position[0] + [0, 0, (2 - share) * RADIUS]
    state.position[0, 2], state.position[1, 2] = 0.01, 0.01 + (2 - share) * RADIUS
    two = State.at_rest(state.position[:2], RADIUS)
    return attempt(shaken(), two, cycles=2)


hard("initial overlap of 1 %")(lambda fine: overlapping(0.01))
hard("initial overlap of 30 %", "refused")(lambda fine: overlapping(0.30))
hard("coincident particles", "refused")(lambda fine: overlapping(2.0))


@hard("particles exactly on the axis")
def on_axis(fine):
    return attempt(shaken(), State.at_rest([[0, 0, (2 * k + 1.01) * RADIUS] for k in range(4)], RADIUS), cycles=10)


@hard("particles exactly touching each other, floor and side")
def touching(fine):
    x = CAVITY.diameter / 2 - RADIUS
    return attempt(
        shaken(), State.at_rest([[x, 0, RADIUS], [x - 2 * RADIUS, 0, RADIUS], [x, 0, 3 * RADIUS]], RADIUS), cycles=10
    )


for factor, expected in ((0.5, "runs"), (1.0, "runs"), (3.0, "refused")):
    hard(f"a step of {factor:g} times the one chosen", expected)(
        lambda fine, f=factor: attempt(
            shaken(), bed(120), dt=f * contact_step(shaken(), Grains.alike(RADIUS, 120)), cycles=2
        )
    )

for gamma in (3.0, 6.0, 14.0):
    for frequency in (46.0, 280.0):
        hard(f"float32, {frequency:g} Hz, Gamma {gamma:g}")(
            lambda fine, g=gamma, f=frequency: attempt(
                shaken(f, g), settle(scene(), bed(120)), cycles=4, precision="float32"
            )
        )
hard("float32, a bed that hardly moves (Gamma 0.5)", "flagged")(
    lambda fine: attempt(shaken(gamma=0.5), settle(scene(), bed(120)), cycles=20, precision="float32")
)
hard("float32, no gravity")(lambda fine: attempt(shaken(gravity=(0, 0, 0)), bed(120), cycles=2, precision="float32"))
hard("float32, modulus x 1000", "flagged")(
    lambda fine: attempt(shaken(material=scaled(PMMA, 1e3)), bed(30), cycles=1, precision="float32")
)
hard("float32, one particle")(lambda fine: attempt(shaken(), bed(1), cycles=10, precision="float32"))


@hard("a small bed at rest for ten million steps")
def resting(fine):
    """No drift and no heating."""
    s = scene(cavity=Cylinder(0.02, 0.02))
    state = settle(s, bed(8, cavity=s.enclosure))
    dt = contact_step(s, state)
    batch = Batch([Case(s, state, dt)])
    batch.advance(100_000)  # what is left of the settling dies away
    before, start = batch.read()[0]
    batch.advance(10_000_000 if fine else 400_000)
    after, ledger = batch.read()[0]
    moved = float(np.abs(after.position - before.position)[:, 2].max()) / RADIUS
    heat = float(ledger["kinetic_translation"][0] + ledger["kinetic_rotation"][0])
    was = float(start["kinetic_translation"][0] + start["kinetic_rotation"][0])
    outcome = judge(batch.status[0], Ledger(np.concatenate([start.rows, ledger.rows])), after, s)
    if moved > 1e-4 or heat > was + 1e-15:
        return dataclasses.replace(outcome, flagged=f"MOVED BY {moved:.1g} R, KINETIC ENERGY {was:.1g} -> {heat:.1g} J")
    return dataclasses.replace(outcome, message=f"sank by {moved:.1g} R, kinetic energy {was:.1g} -> {heat:.1g} J")


@hard("one bouncing sphere for 1e8 steps")
def bouncing(fine):
    """Restitution 1, shaken by nothing: height and energy are those of the start."""
    s = scene(restitution=1.0, friction=0.0, cavity=Cylinder(0.02, 0.05))
    state = State.at_rest([[0, 0, 0.02]], RADIUS)
    batch = Batch([Case(s, state, 1e-6)])
    start = batch.read()[0][1]
    batch.advance(100_000_000 if fine else 2_000_000)
    after, ledger = batch.read()[0]
    change = float(ledger.stored[0] / start.stored[0] - 1)
    outcome = judge(batch.status[0], Ledger(np.concatenate([start.rows, ledger.rows])), after, s)
    return dataclasses.replace(outcome, message=f"energy changed by {change:.1e} of itself")


def _nan(batch):
    particles = batch._particles.numpy().copy()
    particles["half_velocity"][3, 1] = np.nan
    batch._particles.assign(particles)


hard("NaN planted in a state", "flagged")(lambda fine: attempt(shaken(), bed(40), cycles=1, plant=_nan))


def _nan_state(fine):
    state = bed(40)
    state.velocity[3, 1] = np.nan
    try:
        Batch([Case(shaken(), state, 1 / 46 / 10_000)])
    except ValueError as error:
        return Outcome(False, str(error))
    return Outcome(True, "ran")


hard("NaN in the state given", "refused")(_nan_state)
