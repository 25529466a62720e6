"""Motion: falling, bouncing, stacking, rolling; the contact law on prescribed paths; momentum."""

from __future__ import annotations

import itertools
import math

import numpy as np

from verification.independent import stacked_spheres
from verification.suite import (
    PMMA,
    RADIUS,
    Curve,
    Cylinder,
    Result,
    Simulation,
    State,
    after,
    case,
    scene,
)  # fmt: skip
from warpdamp.scene.contact import contact_constants

G = 9.81


@case(
    "Free fall",
    setup="One sphere thrown upwards without enclosure, steps of 1e-4 s.",
    reference="x = v0 t - g t^2 / 2",
    tolerance="rounding: leapfrog is exact under constant acceleration",
)
def free_fall(fine):
    state = State.at_rest([[0, 0, 0.1]], RADIUS)
    state.velocity[0] = [0.3, 0, 2.0]
    t = 0.5
    ended, ledger = after(scene(gravity=(0, 0, -G)), state, 1e-4, t)
    result = Result([])
    result.add("height [m]", 0.1 + 2.0 * t - G * t**2 / 2, ended.position[0, 2], 1e-12)
    result.add("distance [m]", 0.3 * t, ended.position[0, 0], 1e-13)
    result.add("speed [m/s]", 2.0 - G * t, ended.velocity[0, 2], 1e-12)
    result.add("ledger residual over the energy", 0.0, ledger.residual[-1] / ledger.stored[0], 1e-12)
    return result


@case(
    "Bouncing heights (MFiX DEM02)",
    setup="A PMMA sphere dropped on the floor from 50 mm (its lowest point), e 0.9 and 0.6, three bounces.",
    reference="h_k = h0 e^(2k), measured at the lowest point",
    tolerance="0.5 % a bounce at 110 steps a contact (1.6 % at 28): the restitution's error, twice",
)
def bouncing(fine):
    result = Result([])
    dt = 0.5e-6 if fine else 2e-6
    for e in (0.9, 0.6):
        state = State.at_rest([[0, 0, RADIUS + 0.05]], RADIUS)
        simulation = Simulation(scene(e, 0.0, cavity=Cylinder(0.2, 0.2), gravity=(0, 0, -G)), state, dt)
        heights, times, look = [], [], 200
        for k in range(int(0.75 / dt / look)):
            simulation.advance(look)
            heights.append(simulation.read()[0].position[0, 2] - RADIUS)
            times.append((k + 1) * look * dt)
        heights = np.array(heights)
        tops = [k for k in range(1, len(heights) - 1) if heights[k - 1] < heights[k] >= heights[k + 1] > 1e-3][:3]
        for n, k in enumerate(tops, start=1):
            result.add(
                f"e = {e:g}: height of bounce {n} [mm]",
                50 * e ** (2 * n),
                1e3 * heights[k],
                (5e-3 if fine else 1.6e-2) * n * 50 * e ** (2 * n),
            )
        result.curves.append(Curve(f"e = {e:g}", np.array(times), 1e3 * heights))
    result.axes = ("time [s]", "height [mm]")
    return result


@case(
    "Two stacked, compressed spheres (MFiX DEM03)",
    setup="Two PMMA spheres squeezed by 0.5 % and 1 % of their radius between floor and lid, released; e 0.5 and 1.",
    reference="the two equations of motion solved by SciPy (DOP853, tolerance 1e-11)",
    tolerance="0.5 % (fine 0.05 %) of the largest excursion: second order at 100 (400) steps an oscillation",
)
def stacked(fine):
    result = Result([])
    height = 3.98 * RADIUS
    positions = (0.25 * height, 0.7501 * height)
    mass = float(scene().mass(RADIUS))
    modulus = contact_constants(PMMA, PMMA, scene().particle_contact)["modulus"]
    dt = 1e-7 if fine else 4e-7
    looks = np.arange(1, 61) * 8e-6
    for e in (0.5, 1.0):
        s = scene(e, 0.0, cavity=Cylinder(0.04, height), gravity=(0, 0, -G))
        simulation = Simulation(s, State.at_rest([[0, 0, z] for z in positions], RADIUS), dt)
        found = []
        for _ in looks:
            simulation.advance(round(8e-6 / dt))
            found.append(simulation.read()[0].position[:, 2])
        expected = stacked_spheres(
            masses=(mass, mass), radii=(RADIUS, RADIUS), modulus_pair=modulus, modulus_wall=modulus,
            restitution=e, height=height, positions=positions, gravity=G, times=looks,
        ).T  # fmt: skip
        excursion = np.ptp(expected)  # of both
        excursion = max(np.ptp(expected[:, 0]), np.ptp(expected[:, 1]))
        worst = np.max(np.abs(np.array(found) - expected)) / excursion
        result.add(f"e = {e:g}: largest deviation over the excursion", 0.0, worst, 5e-4 if fine else 8e-3)
        result.curves += [
            Curve(f"e = {e:g}", 1e6 * looks, 1e6 * (np.array(found)[:, 1] - positions[1]), "o"),
            Curve(f"e = {e:g}, SciPy", 1e6 * looks, 1e6 * (expected[:, 1] - positions[1]), "-"),
        ]
    result.axes = ("time [us]", "upper sphere [um]")
    return result


def resting(s, radius=RADIUS):
    """Overlap at which the floor carries the sphere."""
    modulus = contact_constants(s.particle, s.wall, s.wall_contact)["modulus"]
    weight = float(s.mass(radius)) * -s.gravity[2]
    return (weight / (4 / 3 * modulus * math.sqrt(radius))) ** (2 / 3)


@case(
    "From slip to roll (MFiX DEM04)",
    setup="A sphere set sliding on the floor at 0.1 m/s, mu 0.1, 0.2, 0.4.",
    reference="rolls after 2 v0 / (7 mu g), at 5/7 v0",
    tolerance="0.3 %: the contact's tangential spring swings while it settles",
)
def slip_to_roll(fine):
    result = Result([])
    for mu in (0.1, 0.2, 0.4):
        s = scene(0.5, mu, cavity=Cylinder(0.4, 0.04), gravity=(0, 0, -G))
        state = State.at_rest([[-0.1, 0, RADIUS - resting(s)]], RADIUS)
        state.velocity[0, 0] = 0.1
        stop = 2 * 0.1 / (7 * mu * G)
        dt = 1e-6 if fine else 4e-6
        early, _ = after(s, state, dt, 0.8 * stop)
        late, _ = after(s, state, dt, 1.6 * stop)
        result.add(f"mu = {mu:g}: speed before [m/s]", 0.1 - mu * G * 0.8 * stop, early.velocity[0, 0], 3e-4)
        result.add(f"mu = {mu:g}: speed after [m/s]", 5 / 7 * 0.1, late.velocity[0, 0], 3e-4)
        result.add(f"mu = {mu:g}: surface speed after [m/s]", 5 / 7 * 0.1, late.spin[0, 1] * RADIUS, 3e-4)
    return result


@case(
    "Rolling and sliding down an incline",
    setup="A sphere released on a slope of 10 to 60 deg (gravity tilted), mu 0.3.",
    reference="rolling below tan = 7/2 mu: a = 5/7 g sin; sliding above: a = g (sin - mu cos)",
    tolerance="0.5 % of g: as above",
)
def incline(fine):
    result = Result([])
    mu, time = 0.3, 0.05
    angles = np.radians(range(10, 61, 10) if fine else (20, 40, 60))
    found, expected = [], []
    for angle in angles:
        gravity = (G * math.sin(angle), 0, -G * math.cos(angle))
        s = scene(0.5, mu, cavity=Cylinder(0.4, 0.04), gravity=gravity)
        state = State.at_rest([[-0.1, 0, RADIUS - resting(s)]], RADIUS)
        ended, _ = after(s, state, 1e-6 if fine else 4e-6, time)
        rolls = math.tan(angle) < 3.5 * mu
        expected.append(5 / 7 * math.sin(angle) if rolls else math.sin(angle) - mu * math.cos(angle))
        found.append(ended.velocity[0, 0] / time / G)
        result.add(f"{math.degrees(angle):.0f} deg: a / g", expected[-1], found[-1], 5e-3)
    result.curves = [
        Curve("warpdamp", np.degrees(angles), np.array(found), "o"),
        Curve("closed form", np.degrees(angles), np.array(expected), "--"),
    ]
    result.axes = ("slope [deg]", "a / g")
    return result


def follow(path, *, friction=0.5, restitution=1.0, steps=400):
    """The contact law along a prescribed path: rows of (overlap [um], tangential place [um]), straight in between.

    Returns forces (n, 2), work done on the contact, energy stored, and losses, step by step.
    """
    from verification.probe import probe

    law = contact_constants(PMMA, PMMA, scene(restitution, friction).particle_contact)
    corners = 1e-6 * np.asarray(path, float)
    legs = [np.linspace(a, b, steps, endpoint=False) for a, b in itertools.pairwise(corners)]
    places = np.concatenate([*legs, corners[-1:]])
    return probe(law, places, h=1e-7, radius=RADIUS / 2, mass=float(scene().mass(RADIUS)) / 2)


@case(
    "Closed loops of normal and tangential load create nothing",
    setup="The contact law alone on prescribed loops: squeeze, shear, release, shear back, in every order, e 1, mu 0.5.",
    reference="net work put into a closed loop >= 0; work = stored + lost, step by step",
    tolerance="energy created: 1e-6 of the largest stored (normal force summed to second order); balance 1e-8 in the "
    "tangential direction (history to third order in a step)",
)
def loops(fine):
    result = Result([])
    moves = {"squeeze": (4, 0), "shear": (0, 1), "release": (-4, 0), "shear back": (0, -1)}
    created, unbalanced, count = 0.0, 0.0, 0
    for repeat in (1, 2, 3) if fine else (1,):
        for order in itertools.permutations(moves):
            for shear in (0.3, 3.0):  # within friction's limit and beyond it
                path = [(10.0, 0.0)]
                for name in order * repeat:
                    path.append((path[-1][0] + moves[name][0], path[-1][1] + shear * moves[name][1]))
                out = follow(path, steps=2000 if fine else 500)
                created = max(created, -out.net_work / out.largest_store)
                unbalanced = max(unbalanced, out.unbalanced / out.largest_store)
                count += 1
    result.add(f"energy created in {count} loops, over the largest stored", 0.0, max(0.0, created), 1e-6)
    result.add("tangential work - stored - lost", 0.0, unbalanced, 1e-8)
    return result


@case(
    "Cyclic shear does not ratchet",
    setup="The contact law alone, sheared to and fro 1,000 times while the normal load swings in and out of phase.",
    reference="the force at the end of a cycle settles (shakedown) and then stays",
    tolerance="1e-9 of friction's limit after 1,000 cycles (1e-4 after 100)",
)
def ratchet(fine):
    result = Result([])
    cycles = 1000 if fine else 100
    for name, load in (("constant load", (0, 0)), ("load in phase", (2, -2)), ("load a quarter behind", (-2, 2))):
        path = [(10.0, 0.0)]
        for _ in range(cycles):
            path += [(10.0 + load[0], 1.0), (10.0, 0.0), (10.0 + load[1], -1.0), (10.0, 0.0)]
        out = follow(path, steps=50)
        ends = out.force[:: 4 * 50, 1]
        limit = 0.5 * abs(out.force[0, 0])
        result.add(
            f"{name}: change of the force over the last cycle",
            0.0,
            (ends[-1] - ends[-2]) / limit,
            1e-9 if fine else 1e-4,
        )
    out = follow([(10, 0), *[(10, 1), (10, -1)] * 3], steps=200)
    result.curves = [Curve("constant load", 1e6 * out.place[:, 1], out.force[:, 1])]
    result.axes = ("tangential place [um]", "tangential force [N]")
    return result
