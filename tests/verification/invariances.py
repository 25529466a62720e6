"""What may not matter: order, company, orientation, units, interruptions, looking."""

from __future__ import annotations

import numpy as np

from verification.suite import PMMA, RADIUS, Batch, Case, Cylinder, Drive, Material, Result, State, case, scene
from warpdamp.damper.placement import separate

CAVITY = Cylinder(0.03, 0.03)


def bed(seed=1, count=40):
    """Spheres falling and shaken, with velocities and spins, so that every contact does something."""
    rng = np.random.default_rng(seed)
    state = State.at_rest(separate((RADIUS,) * count, CAVITY, seed), RADIUS)
    state.velocity[:] = rng.normal(0, 0.2, (count, 3))
    state.spin[:] = rng.normal(0, 30, (count, 3))
    return state


def shaken_scene(**change):
    given = {"cavity": CAVITY, "gravity": (0, 0, -9.81), "drive": Drive(50.0, 40.0)} | change
    return scene(**given)


def run(s, state, steps, dt=2e-6):
    batch = Batch([Case(s, state, dt)], max_rows=2)
    batch.advance(steps)
    return batch.read()[0]


def apart(a: State, b: State):
    return max(np.abs(a.position - b.position).max() / RADIUS, np.abs(a.velocity - b.velocity).max())


@case(
    "Order of the particles",
    setup="The same 40 moving spheres in another order, 2,000 steps.",
    reference="the same trajectories, to the rounding of sums in another order",
    tolerance="1e-9: rounding of 1e-16 grown by two milliseconds of collisions",
)
def order(fine):
    state = bed()
    shuffle = np.random.default_rng(5).permutation(len(state))
    other = State(state.position[shuffle], state.velocity[shuffle], state.spin[shuffle], state.radius[shuffle])
    a, _ = run(shaken_scene(), state, 2000)
    b, _ = run(shaken_scene(), other, 2000)
    back = np.argsort(shuffle)
    result = Result([])
    result.add(
        "difference", 0.0, apart(a, State(b.position[back], b.velocity[back], b.spin[back], b.radius[back])), 1e-9
    )
    return result


@case(
    "Company in the batch, interruptions, looking, restart",
    setup="One bed alone; among seven others; stopped and read at every turn; saved in mid-run and restored elsewhere.",
    reference="the same bits",
    tolerance="none",
)
def company(fine):
    s, steps = shaken_scene(), 20_000 if fine else 6000
    case_ = Case(s, bed(), 2e-6)
    rows = steps // 10_000 + 1

    def outcome(batch, k=0):
        state, _ = batch.read()[k]
        return np.concatenate(
            [state.position.ravel(), state.velocity.ravel(), state.spin.ravel(), batch.cycles(k).rows.ravel()]
        )

    alone = Batch([case_], max_rows=rows)
    alone.advance(steps)
    expected = outcome(alone)

    crowd = Batch(
        [Case(s, bed(k), 2e-6) for k in (4, 5, 6)] + [case_] + [Case(s, bed(k), 1e-6) for k in (7, 8)],
        max_rows=rows,
    )
    crowd.advance(steps)
    halting = Batch([case_], max_rows=rows)
    for k in range(1, 21):
        halting.advance(k * steps // 20)
        halting.read()
    saved = Batch([case_], max_rows=rows)
    saved.advance(steps // 3)
    checkpoint = saved.checkpoint()
    fresh = Batch([case_], max_rows=rows)
    fresh.restore(checkpoint)
    fresh.advance(steps)
    result = Result([])
    result.add("values that differ, in company", 0, np.sum(outcome(crowd, 3) != expected), 0)
    result.add("values that differ, stopped and read 20 times", 0, np.sum(outcome(halting) != expected), 0)
    result.add("values that differ, restored from a checkpoint", 0, np.sum(outcome(fresh) != expected), 0)
    return result


@case(
    "Rotation of the whole scene",
    setup="40 spheres without enclosure, turned with their velocities, spins and gravity; and in the cavity about its axis.",
    reference="the same trajectories, turned",
    tolerance="1e-9, as for the order",
)
def rotation(fine):
    from scipy.spatial.transform import Rotation

    result = Result([])
    for name, turn, cavity in (
        ("in free space, any rotation", Rotation.from_rotvec([0.3, -1.1, 2.0]), None),
        ("in the cavity, about its axis", Rotation.from_rotvec([0, 0, 1.234]), CAVITY),
    ):
        gravity = np.array([0.0, 0.0, -9.81])
        s = scene(cavity=cavity, gravity=tuple(gravity))
        turned = scene(cavity=cavity, gravity=tuple(turn.apply(gravity)))
        state = bed()
        state.velocity -= 3.0 * (state.position - state.position.mean(axis=0)) / 0.015 * 0.3  # towards each other
        other = State(*(turn.apply(getattr(state, n)) for n in ("position", "velocity", "spin")), state.radius)
        a, _ = run(s, state, 500)
        b, _ = run(turned, other, 500)
        back = State(*(turn.inv().apply(getattr(b, n)) for n in ("position", "velocity", "spin")), b.radius)
        result.add(name, 0.0, apart(a, back), 1e-9)
    return result


@case(
    "Change of units",
    setup="The same bed in units of a quarter metre, a quarter second and a sixteenth of a kilogram (powers of four).",
    reference="the same numbers, exactly: scaling by powers of four commutes with every operation of the law",
    tolerance="rounding grown by 2,000 steps, 1e-9",
)
def units(fine):
    length, time, mass = 4.0, 4.0, 16.0  # numbers in the new units per SI number
    state = bed()
    scaled = State(state.position * length, state.velocity * length / time, state.spin / time, state.radius * length)
    material = Material(
        PMMA.density * mass / length**3, PMMA.youngs_modulus * mass / (length * time**2), PMMA.poissons_ratio
    )
    other = scene(
        particle=material,
        cavity=Cylinder(CAVITY.diameter * length, CAVITY.height * length),
        gravity=(0, 0, -9.81 * length / time**2),
        drive=Drive(50.0 / time, 40.0 * length / time**2),
    )
    a, ledger = run(shaken_scene(), state, 2000)
    b, scaled_ledger = run(other, scaled, 2000, dt=2e-6 * time)
    back = State(b.position / length, b.velocity * time / length, b.spin * time, b.radius / length)
    energy = mass * length**2 / time**2
    result = Result([])
    result.add("difference of the motion", 0.0, apart(a, back), 1e-9)
    result.add("dissipation, ratio", 1.0, scaled_ledger.dissipated[0] / energy / ledger.dissipated[0], 1e-9)
    return result
