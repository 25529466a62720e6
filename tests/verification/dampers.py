"""Whole dampers against closed forms and an event-driven block."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from verification.suite import (
    RADIUS,
    Curve,
    Cylinder,
    Drive,
    Result,
    State,
    case,
    effectiveness,
    scene,
    shaken,
)  # fmt: skip
from warpdamp.engine.ledger import harmonic_work


def one_ball(q, restitution, *, frequency=10.0, clearance=0.02, dt=2e-7, cycles=30):
    """Effectiveness of one frictionless ball in zero gravity at q = X / L, and the ledger's figures."""
    drive = Drive(frequency, q * clearance * (2 * math.pi * frequency) ** 2)
    s = scene(restitution, 0.0, cavity=Cylinder(0.04, clearance + 2 * RADIUS), drive=drive)
    state = State.at_rest([[0, 0, RADIUS]], RADIUS)
    state.velocity[0, 2] = 2 * clearance * frequency - drive.speed
    last = shaken(s, state, dt, cycles).between(cycles - 10, cycles)
    eps = float(np.mean(effectiveness(last, s, state.radius)))
    residual = abs(last.residual[-1]) / (last.dissipated[-1] - last.dissipated[0])
    harmonic = harmonic_work(last.reaction(drive), drive) / float(np.mean(last.per_cycle()))
    return eps, residual, harmonic


def ball_closed_form(q, restitution):
    """pi K cos p + 2 sin p = 1 / q, K = (1 + e) / (1 - e), eps = K cos^2 p."""
    k = (1 + restitution) / (1 - restitution)
    phase = brentq(lambda p: math.pi * k * math.cos(p) + 2 * math.sin(p) - 1 / q, -math.pi / 2, 0)
    return k * math.cos(phase) ** 2


def block_closed_form(q):
    """A plastic block in zero gravity; beyond q = 1 / pi it waits at the wall until the wall slows down."""
    if q >= 1 / math.pi:
        theta = brentq(lambda t: t - math.sin(t) - 1 / q, 1e-3, 2 * math.pi)
        return (1 - math.cos(theta)) ** 2 / 4
    return math.cos(brentq(lambda p: math.pi * math.cos(p) + 2 * math.sin(p) - 1 / q, -math.pi / 2, 0.57)) ** 2


@case(
    "One ball between floor and lid, zero gravity",
    setup="A frictionless PMMA ball, e 0.52, 10 Hz, clearance 20 mm, step 2e-7 s, q = X / L from 0.13 to 0.34.",
    reference="pi K cos p + 2 sin p = 1 / q, K = (1 + e) / (1 - e), eps = K cos^2 p",
    tolerance="0.5 %: contacts of 70 us in a cycle of 0.1 s; harmonic and dissipation agree to 0.1 %",
)
def ball(fine):
    result = Result([])
    qs = np.round(np.arange(0.13, 0.345, 0.03 if fine else 0.07), 3)
    found = []
    for q in qs:
        eps, residual, harmonic = one_ball(q, 0.52)
        expected = ball_closed_form(q, 0.52)
        found.append(eps)
        result.add(f"q = {q:g}: eps", expected, eps, 5e-3 * expected)
        result.add(f"q = {q:g}: ledger residual", 0.0, residual, 1e-3)
        result.add(f"q = {q:g}: harmonic work over dissipation", 1.0, harmonic, 1e-3)
    grid = np.linspace(0.13, 0.34, 50)
    result.curves = [
        Curve("warpdamp", qs, np.array(found), "o"),
        Curve("closed form", grid, np.array([ball_closed_form(q, 0.52) for q in grid])),
    ]
    result.axes = ("q = X / L", "effectiveness")
    return result


@case(
    "Plastic block in zero gravity",
    setup="A ball of e 0 (a rebound of 0.2 %), 10 Hz, clearance 20 mm, q from 0.29 to 1.",
    reference="q >= 1/pi: theta - sin theta = 1/q, eps = (1 - cos theta)^2 / 4; below: pi cos p + 2 sin p = 1/q, eps = cos^2 p",
    tolerance="1 %: a plastic contact lasts several times an elastic one",
)
def block(fine):
    result = Result([])
    qs = np.array([0.29, 0.31, 0.33, 0.4, 0.5, 0.6, 0.8, 1.0] if fine else [0.3, 0.4, 0.8])
    found = []
    for q in qs:
        eps, _, _ = one_ball(q, 0.0)
        found.append(eps)
        result.add(f"q = {q:g}: eps", block_closed_form(q), eps, 0.01)
    grid = np.linspace(0.275, 1.0, 100)
    result.curves = [
        Curve("warpdamp", qs, np.array(found), "o"),
        Curve("closed form", grid, np.array([block_closed_form(q) for q in grid])),
    ]
    result.axes = ("q = X / L", "effectiveness")
    return result


def event_driven(gamma, frequency, clearance, *, cycles=40, gravity=9.81):
    """Effectiveness of a plastic block in a shaken cavity with gravity, from flight to flight; no lid: infinity."""
    w = 2 * math.pi * frequency
    acceleration = gamma * 9.81
    x0 = acceleration / w**2

    def wall(t):
        return x0 * math.sin(w * t), x0 * w * math.cos(w * t), -acceleration * math.sin(w * t)

    t, place, lost, losses = 0.0, "floor", 0.0, []
    step = 1 / frequency / 400
    end, cycle = cycles / frequency, 1
    while t < end:
        pressed = 1 if place == "floor" else -1
        while pressed * (gravity + wall(t)[2]) >= 0 and t < end:  # carried along
            t += step
        low, high = t - step, t
        if pressed * (gravity + wall(low)[2]) >= 0 > pressed * (gravity + wall(high)[2]):
            t = brentq(lambda u: gravity + wall(u)[2], low, high)
        z0, v0, _ = wall(t)
        offset = 0.0 if place == "floor" else clearance
        start = t

        def relative(u, z0=z0, v0=v0, start=start, offset=offset):
            return z0 + offset + v0 * (u - start) - gravity * (u - start) ** 2 / 2 - wall(u)[0]

        u = start + step / 10
        while u < end and 0 < relative(u) < clearance:
            u += step / 10
        target = 0.0 if relative(u) <= 0 else clearance
        if u >= end:
            break
        hit = brentq(lambda x, target=target: relative(x) - target, u - step / 10, u)
        while hit * frequency > cycle:
            losses.append(lost)
            cycle += 1
        lost += 0.5 * (v0 - gravity * (hit - start) - wall(hit)[1]) ** 2
        t, place = hit, "floor" if target == 0 else "lid"
    half = len(losses) // 2
    per_cycle = (losses[-1] - losses[half]) / (len(losses) - 1 - half)
    return per_cycle / (4 * (acceleration / w) ** 2)


def shaken_ball(gamma, frequency, clearance, cycles=24):
    """A DEM ball of e 0.02 in the same cavity; the mean over the last two thirds."""
    s = scene(
        0.02,
        0.0,
        cavity=Cylinder(0.04, clearance + 2 * RADIUS),
        gravity=(0, 0, -9.81),
        drive=Drive(frequency, gamma * 9.81),
    )
    ledger = shaken(s, State.at_rest([[0, 0, RADIUS]], RADIUS), 5e-7, cycles)
    return float(np.mean(effectiveness(ledger.between(cycles // 3, cycles), s, np.array([RADIUS]))))


@case(
    "Plastic block under gravity, without and with a lid",
    setup="A ball of e 0.02 at 39.5 Hz; clearance 32 mm (the lid is not met) and 2.257 mm (eq. 2 of the paper).",
    reference="without lid: lift-off at sin a = 1 / Gamma, one flight, eps = v^2 / 8 (maximum 0.565 at 2.58); with lid: the "
    "block integrated from event to event",
    tolerance="2 %: e is 0.02 instead of 0, contacts last 0.1-0.3 ms of 25 ms.  The jump between the two regimes (Gamma 4.2 to "
    "4.8) is left out: there that delay alone shifts the curve by 0.1 in Gamma, 0.1 in effectiveness",
)
def gravity_block(fine):
    result = Result([])
    frequency = 39.5
    free = np.array([1.5, 2.0, 2.3, 2.58, 2.8, 3.0] if fine else [2.0, 2.58, 3.0])
    found = [shaken_ball(g, frequency, 0.032) for g in free]
    for g, eps in zip(free, found, strict=True):
        result.add(f"no lid, Gamma {g:g}: eps", event_driven(g, frequency, 1.0), eps, 0.02 * 0.565)
    lidded = np.array([2.0, 3.0, 3.5, 5.0, 5.6, 6.0, 7.0, 8.0] if fine else [2.58, 5.6, 7.0])
    under = [shaken_ball(g, frequency, 2.257e-3) for g in lidded]
    for g, eps in zip(lidded, under, strict=True):
        result.add(f"lid, Gamma {g:g}: eps", event_driven(g, frequency, 2.257e-3), eps, 0.02)
    grid = np.arange(1.1, 8.0, 0.1)
    result.curves = [
        Curve("no lid", free, np.array(found), "o"),
        Curve("lid", lidded, np.array(under), "s"),
        Curve("lid, event-driven", grid, np.array([event_driven(g, frequency, 2.257e-3) for g in grid]), "-"),
    ]
    result.axes = ("Gamma", "effectiveness")
    return result
