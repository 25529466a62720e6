"""Single impacts: Hertz, restitution, friction, spin (Chung & Ooi 2011, doi:10.1007/s10035-011-0277-0, tests 1-8)."""

from __future__ import annotations

import math

import numpy as np

from verification.independent import oblique_impact
from verification.suite import (
    RADIUS,
    Curve,
    Material,
    Result,
    Simulation,
    after,
    case,
    head_on,
    impact_time,
    on_floor,
    scene,
    together,
)  # fmt: skip
from warpdamp.scene.contact import contact_constants

RIGID = Material(1e4, 1e18, 0.3)
ALUMINA = Material(4000, 3.8e11, 0.23)
CAST_IRON = Material(7000, 1.0e11, 0.25)
ALUMINIUM = Material(2699, 7.0e10, 0.30)
ALUMINIUM_4 = Material(2700, 7.0e10, 0.33)
MAGNESIUM = Material(1800, 4.0e10, 0.35)
GLASS = Material(2800, 4.8e10, 0.20)
LIMESTONE = Material(2500, 2.0e10, 0.25)
STEEL = Material(7850, 2.08e11, 0.30)
POLYETHYLENE = Material(1400, 1.0e9, 0.40)
NYLON = Material(1000, 2.5e9, 0.40)
COPPER = Material(8900, 1.2e11, 0.35)


def peak(s, state, dt, duration, overlap_of):
    """Largest overlap and time in contact, looked at every few steps."""
    simulation = Simulation(s, state, dt)
    look = 10
    deepest, touching = 0.0, 0
    for _ in range(int(2.2 * duration / dt / look)):
        simulation.advance(look)
        overlap = overlap_of(simulation.read()[0])
        deepest, touching = max(deepest, overlap), touching + (overlap > 0)
    return deepest, touching * look * dt


@case(
    "Hertz: peak overlap, peak force, duration (Chung & Ooi tests 1 and 2)",
    setup="Test 1: two spheres of 10 mm radius at 20 m/s; test 2: a sphere of 0.1 m on a rigid plane at 0.2 m/s; e = 1.",
    reference="closed form d = (15 m* v^2 / (16 E* sqrt R*))^(2/5), F = 4/3 E* sqrt(R*) d^1.5, t = 2.943275 d / v; values "
    "of two materials each: 274.113 um, 10.697 kN, 40.339 us; 368.304 um, 7.108 kN, 54.201 us; 49.717 um, 11.370 kN, "
    "731.66 us; 52.123 um, 7.233 kN, 767.07 us",
    tolerance="overlap 0.1 %, force 0.15 %: second order at 400 (fine 1600) steps a contact, looked at every 10 steps; "
    "duration one look, 2.5 % (0.7 %)",
)
def hertz(fine):
    result = Result([])
    steps = 1600 if fine else 400
    table = (
        ("glass, test 1", GLASS, False, 0.01, 20.0, 274.113e-6, 10696.9, 40.339e-6),
        ("limestone, test 1", LIMESTONE, False, 0.01, 20.0, 368.304e-6, 7108.24, 54.201e-6),
        ("aluminium, test 2", ALUMINIUM, True, 0.1, 0.2, 49.717e-6, 11369.9, 731.66e-6),
        ("magnesium, test 2", MAGNESIUM, True, 0.1, 0.2, 52.123e-6, 7232.68, 767.07e-6),
    )
    for name, material, wall, radius, speed, overlap, force, duration in table:
        gap = 1e-3 * overlap
        if wall:
            state, cavity = on_floor([0, 0, -speed], radius=radius, gap=gap)
            s = scene(1.0, 0.0, particle=material, wall=RIGID, cavity=cavity)
            law = contact_constants(material, RIGID, s.wall_contact)
            effective = radius
            found, time = peak(s, state, duration / steps, duration, lambda x, r=radius: r - x.position[0, 2])
        else:
            s, state = scene(1.0, 0.0, particle=material), head_on(speed, (radius, radius), gap)
            law = contact_constants(material, material, s.particle_contact)
            effective = radius / 2
            found, time = peak(
                s, state, duration / steps, duration, lambda x, r=radius: 2 * r - np.ptp(x.position[:, 0])
            )
        result.add(f"{name}: overlap [um]", 1e6 * overlap, 1e6 * found, 1e3 * overlap)
        peak_force = 4 / 3 * law["modulus"] * math.sqrt(effective) * found**1.5
        result.add(f"{name}: force [N]", force, peak_force, 1.5e-3 * force)
        result.add(f"{name}: duration [us]", 1e6 * duration, 1e6 * time, 1e6 * duration * 10.5 / steps)
    return result


@case(
    "Restitution: what was asked for comes out (Chung & Ooi test 3)",
    setup="Sphere on sphere with radius ratios 1, 3, 10, and sphere on a plane (2.5 mm, 3.9 m/s, two materials), "
    "restitution 0 to 1 in steps (0 is taken as a rebound of 0.1 %).",
    reference="e_out = e_in; energy lost = (1 - e^2) of the normal kinetic energy",
    tolerance="0.002 as asked of the field's codes, at 1000 steps a contact",
)
def restitution(fine):
    result = Result([])
    values = tuple(np.arange(0, 1.01, 0.1)) if fine else (0.0, 0.1, 0.5, 0.9, 1.0)
    found = {}
    for ratio in (1, 3, 10):
        radius = (RADIUS, RADIUS / ratio)
        cases = []
        for e in values:
            s = scene(e)
            tc = impact_time(s, radius, 1.0)
            cases.append((s, head_on(1.0, radius, gap=1e-3 * tc), tc / 1000))
        start, ended = together(cases, 6000)
        out = [ended[k][0].velocity[1, 0] - ended[k][0].velocity[0, 0] for k in range(len(values))]
        found[f"spheres 1:{ratio}"] = out
        for e, got, before, (_, ledger) in zip(values, out, start, ended, strict=True):
            result.add(f"spheres 1:{ratio}, e = {e:.2f}", e, got, 2e-3)
            kinetic = before["kinetic_translation"][0]
            result.add(f"spheres 1:{ratio}, e = {e:.2f}: energy lost", 1 - e**2, ledger.dissipated[0] / kinetic, 4e-3)
    for name, material in (("alumina", ALUMINA), ("cast iron", CAST_IRON)):
        cases = []
        for e in values:
            state, cavity = on_floor([0, 0, -3.9], radius=2.5e-3, gap=1e-9)
            s = scene(e, 0.0, particle=material, wall=RIGID, cavity=cavity)
            cases.append((s, state, impact_time(s, 2.5e-3, 3.9, wall=True) / 1000))
        _, ended = together(cases, 6000)
        out = [state.velocity[0, 2] / 3.9 for state, _ in ended]
        found[f"{name} on a plane"] = out
        for e, got in zip(values, out, strict=True):
            result.add(f"{name} on a plane, e = {e:.2f}", e, got, 2e-3)
    result.curves = [Curve(name, np.array(values), np.array(out) - values, "o-") for name, out in found.items()]
    result.axes = ("restitution asked for", "found minus asked for")
    return result


def oblique(material, radius, restitution, friction, vn, vt, spin, steps):
    """Rebounds from a rigid plane, many at once: lists of vn, vt, spin; returns arrays (vn', vt', spin')."""
    cases = []
    for n, t, w in zip(vn, vt, spin, strict=True):
        state, cavity = on_floor([t, 0, -n], [0, w, 0], radius=radius, gap=1e-9 * radius)
        s = scene(restitution, friction, particle=material, wall=RIGID, cavity=cavity)
        cases.append((s, state, impact_time(s, radius, n, wall=True) / steps))
    _, ended = together(cases, 2 * steps)
    return np.array([[x.velocity[0, 2], x.velocity[0, 0], x.spin[0, 1]] for x, _ in ended]).T


def independently(material, radius, restitution, friction, vn, vt, spin):
    """The same by the independent integration."""
    from warpdamp import Surface

    law = contact_constants(material, RIGID, Surface(restitution, friction))
    mass = material.density * 4 / 3 * math.pi * radius**3
    return np.array(
        [
            oblique_impact(
                mass=mass, radius=radius, modulus=law["modulus"], shear_modulus=law["shear_modulus"],
                restitution=restitution, friction=friction, vn=n, vt=t, spin=w, steps=8000,
            )
            for n, t, w in zip(vn, vt, spin, strict=True)
        ]
    ).T  # fmt: skip


@case(
    "Oblique impact at constant speed (Chung & Ooi test 4)",
    setup="Alumina sphere, 2.5 mm, 3.9 m/s on a rigid plane at 5-85 deg from the normal, mu 0.092, e 0.98.",
    reference="sliding (beyond 32.5 deg): e_t = 1 - mu (1 + e) / tan, w = 5/2 mu (1 + e) v cos / R; sticking: an independent "
    "integration of the same law (its published curve is not to be had in numbers)",
    tolerance="sliding: 0.5 % of e_t, 1 % of the spin (the contact is at R - d, d / R = 0.3 %); sticking: 0.5 % of the "
    "tangential velocity and of the spin's surface speed, of the incoming one",
)
def test_4(fine):
    result = Result([])
    angles = np.radians(np.arange(5, 86, 5) if fine else [10, 25, 40, 60, 85])
    speed, radius, mu, e = 3.9, 2.5e-3, 0.092, 0.98
    vn, vt = speed * np.cos(angles), speed * np.sin(angles)
    _, out_t, out_w = oblique(ALUMINA, radius, e, mu, vn, vt, 0 * vn, 2000 if fine else 500)
    limit = math.atan(3.5 * mu * (1 + e))
    slide = angles > limit + 0.02
    for angle, n, t, got, w in zip(angles[slide], vn[slide], vt[slide], out_t[slide], out_w[slide], strict=True):
        degrees = round(math.degrees(angle))
        expected = 1 - mu * (1 + e) / math.tan(angle)
        result.add(f"{degrees} deg, sliding: e_t", expected, got / t, 5e-3 * expected)
        spin = 2.5 * mu * (1 + e) * n / radius
        result.add(f"{degrees} deg, sliding: spin [rad/s]", spin, w, 0.01 * spin)
    stick = ~slide
    reference = independently(ALUMINA, radius, e, mu, vn[stick], vt[stick], 0 * vn[stick])
    for angle, t, got, w, expected_t, expected_w in zip(
        angles[stick], vt[stick], out_t[stick], out_w[stick], reference[1], reference[2], strict=True
    ):
        degrees = round(math.degrees(angle))
        result.add(f"{degrees} deg, sticking: v_t' / v_t", expected_t / t, got / t, 5e-3)
        result.add(f"{degrees} deg, sticking: w R / v_t", expected_w * radius / t, w * radius / t, 5e-3)
    result.curves = [
        Curve("warpdamp", np.degrees(angles), out_t / vt, "o"),
        Curve("sliding, closed form", np.degrees(angles[slide]), 1 - mu * (1 + e) / np.tan(angles[slide]), "-"),
        Curve("sticking, independent integration", np.degrees(angles[stick]), reference[1] / vt[stick], "--"),
    ]
    result.axes = ("angle from the normal [deg]", "tangential restitution")
    return result


@case(
    "Oblique impact at constant normal speed (Chung & Ooi test 5)",
    setup="Spheres of 10 um at 5 m/s normal speed on a rigid plane, e 1, mu 0.3; steel and polyethylene.",
    reference="x = v_t / (mu v_n); sliding for x >= 7: R w' / (mu v_n) = 5, v_s' / (mu v_n) = x - 7; below: an independent "
    "integration",
    tolerance="sliding d / R, 0.7 % for steel and 2.7 % for polyethylene (the contact is at R - d); sticking 0.5 % of x, and of 5, at 2000 (500) steps a contact",
)
def test_5(fine):
    result = Result([])
    radius, mu, vn = 1e-5, 0.3, 5.0
    x = np.array([0.5, 1, 2, 3, 4, 5, 6, 8, 10, 12] if fine else [1.0, 4.0, 8.0, 12.0])
    for name, material in (("steel", STEEL), ("polyethylene", POLYETHYLENE)):
        vt = x * mu * vn
        _, out_t, out_w = oblique(material, radius, 1.0, mu, vn + 0 * x, vt, 0 * x, 2000 if fine else 500)
        modulus = contact_constants(material, RIGID, scene().wall_contact)["modulus"]
        depth = (15 * material.density * 4 / 3 * math.pi * vn**2 / (16 * modulus)) ** 0.4  # d / R
        spin, surface = out_w * radius / (mu * vn), (out_t - out_w * radius) / (mu * vn)
        for k in np.flatnonzero(x > 7):
            result.add(f"{name}, x = {x[k]:g}: spin", 5.0, spin[k], 5 * depth)
            result.add(f"{name}, x = {x[k]:g}: surface speed", x[k] - 7, surface[k], 5 * depth)
        below = np.flatnonzero(x < 7)
        reference = independently(material, radius, 1.0, mu, vn + 0 * x[below], vt[below], 0 * x[below])
        for k, expected_t, expected_w in zip(below, reference[1], reference[2], strict=True):
            result.add(f"{name}, x = {x[k]:g}: v_t'", expected_t / (mu * vn), out_t[k] / (mu * vn), 5e-3 * max(x[k], 1))
            result.add(f"{name}, x = {x[k]:g}: spin", expected_w * radius / (mu * vn), spin[k], 0.025)
        result.curves += [
            Curve(name, x, spin, "o"),
            Curve(f"{name}, independent", x[below], reference[2] * radius / (mu * vn), "--"),
        ]
    result.axes = ("v_t / (mu v_n)", "R w' / (mu v_n)")
    return result


@case(
    "A spinning sphere on a plane (Chung & Ooi test 6)",
    setup="Sphere of 0.1 m, 0.2 m/s, surface speed 0.2 tan(theta); e 0.5, mu 0.4; aluminium and nylon.",
    reference="sliding, for 7/2 mu (1 + e) v_n < v_s: v_x' = mu (1 + e) v_n, w' = w - 5/2 mu (1 + e) v_n / R; below: an "
    "independent integration; v_z' = e v_n",
    tolerance="0.2 % of v_n each (contact at R - d, d / R = 0.1 %), normal 0.2 %",
)
def test_6(fine):
    result = Result([])
    radius, mu, e, vn = 0.1, 0.4, 0.5, 0.2
    theta = np.radians([5, 15, 30, 45, 60, 67, 75, 85] if fine else [15, 45, 75, 85])
    spin = vn * np.tan(theta) / radius
    for name, material in (("aluminium", ALUMINIUM_4), ("nylon", NYLON)):
        # a positive spin about y drives the lowest point along -x, friction pushes along +x
        out_n, out_t, out_w = oblique(material, radius, e, mu, vn + 0 * spin, 0 * spin, spin, 2000 if fine else 500)
        slides = spin * radius > 1.05 * 3.5 * mu * (1 + e) * vn
        reference = independently(material, radius, e, mu, vn + 0 * spin[~slides], 0 * spin[~slides], spin[~slides])
        expected_t, expected_w = np.empty_like(spin), np.empty_like(spin)
        expected_t[slides] = mu * (1 + e) * vn
        expected_w[slides] = spin[slides] - 2.5 * mu * (1 + e) * vn / radius
        expected_t[~slides], expected_w[~slides] = reference[1], reference[2]
        for k, angle in enumerate(np.degrees(theta)):
            branch = "sliding" if slides[k] else "sticking"
            scale = max(1.0, spin[k] * radius / vn)
            result.add(
                f"{name}, {angle:.0f} deg, {branch}: v_x' / v_n", expected_t[k] / vn, out_t[k] / vn, 3e-3 * scale
            )
            result.add(
                f"{name}, {angle:.0f} deg, {branch}: R w' / v_n",
                expected_w[k] * radius / vn, out_w[k] * radius / vn, 7e-3 * scale,
            )  # fmt: skip
        result.add(f"{name}: normal restitution", e, out_n[0] / vn, 2e-3)
        result.curves += [
            Curve(name, np.degrees(theta), out_t / vn, "o"),
            Curve("reference", np.degrees(theta), expected_t / vn, "--"),
        ]
    result.axes = ("theta [deg]", "v_x' / v_n")
    return result


@case(
    "Two spheres whose spins cancel at the contact (Chung & Ooi test 7)",
    setup="Two spheres of 0.1 m, 0.2 m/s each, opposite spins (0.2 / 0.1) tan(theta); e 0.5, mu 0.4; aluminium and copper.",
    reference="no slip at the contact, so no tangential force: spins stay, no tangential velocity",
    tolerance="1e-10 of the spin: nothing but rounding",
)
def test_7(fine):
    result = Result([])
    for name, material in (("aluminium", ALUMINIUM_4), ("copper", COPPER)):
        for degrees in (5, 30, 60, 85):
            spin = 2.0 * math.tan(math.radians(degrees))
            s = scene(0.5, 0.4, particle=material)
            state = head_on(0.4, (0.1, 0.1), gap=1e-7)
            state.spin[:, 2] = [spin, -spin]
            tc = impact_time(s, (0.1, 0.1), 0.4)
            ended, _ = after(s, state, tc / (1000 if fine else 200), 3 * tc)
            result.add(f"{name}, {degrees} deg: spin ratio", 1.0, ended.spin[0, 2] / spin, 1e-10)
            result.add(f"{name}, {degrees} deg: v_t' / v_n", 0.0, ended.velocity[0, 1] / 0.2, 1e-10)
    return result


@case(
    "A spinning sphere on a much heavier one (Chung & Ooi test 8)",
    setup="Sphere of 0.1 m, 0.2 m/s, spinning, on a sphere of 10 m at rest; e 0.5, mu 0.4.",
    reference="the plane's results of test 6 as the ratio goes to infinity (sliding branch)",
    tolerance="2 % of v_n: the ratio of 100 leaves R* 1 % below R",
)
def test_8(fine):
    result = Result([])
    radius, mu, e, vn = 0.1, 0.4, 0.5, 0.2
    for degrees in (75, 85):
        spin = vn * math.tan(math.radians(degrees)) / radius
        s = scene(e, mu, particle=ALUMINIUM_4)
        state = head_on(vn, (radius, 10.0), gap=1e-7)
        state.velocity[:] = [[vn, 0, 0], [0, 0, 0]]
        state.spin[0, 2] = spin
        tc = impact_time(s, (radius, 10.0), vn)
        ended, _ = after(s, state, tc / (1000 if fine else 300), 2.5 * tc)
        result.add(f"{degrees} deg: normal restitution", e, -ended.velocity[0, 0] / vn, 5e-3)
        result.add(f"{degrees} deg: v_t' / v_n", mu * (1 + e), abs(ended.velocity[0, 1]) / vn, 0.02)
        result.add(
            f"{degrees} deg: R (w - w') / v_n", 2.5 * mu * (1 + e), (spin - ended.spin[0, 2]) * radius / vn, 0.05
        )
    return result


@case(
    "Grazing impacts gain nothing (LAMMPS PR 5007)",
    setup="PMMA sphere on the floor at 60-89 deg from the normal, mu 0.1-0.9, e 0.52 and 1, 50 steps a contact.",
    reference="kinetic energy after <= before",
    tolerance="2e-3 of the energy before: the step's order at 50 steps a contact",
)
def grazing(fine):
    result = Result([])
    angles = np.radians(np.arange(60, 90, 1 if fine else 4))
    for e in (0.52, 1.0):
        for mu in (0.1, 0.3, 0.9):
            vn, vt = np.cos(angles), np.sin(angles)
            out = oblique(ALUMINA, RADIUS, e, mu, vn, vt, 0 * vn, 50)
            kinetic = out[0] ** 2 + out[1] ** 2 + 0.4 * (RADIUS * out[2]) ** 2
            result.add(f"e = {e:g}, mu = {mu:g}: largest gain", 0.0, max(0.0, np.max(kinetic - 1)), 2e-3)
    return result


@case(
    "Convergence order of the impact",
    setup="Two PMMA spheres, oblique with spin: elastic, damped, sliding; steps of tc/25 to tc/800 and as many phases.",
    reference="final velocities at tc/6400; the slope of the error is the order",
    tolerance="slope 2 for elastic impacts (leapfrog), 5/4 for damped ones (the dashpot sets in as d^(1/4), and the step in "
    "which a contact begins does not see the whole of it), within 0.25 (elastic 0.35: errors down to 1e-7 scatter with the "
    "phase of the first touch)",
)
def order(fine):
    result = Result([])
    steps = np.array([25, 50, 100, 200, 400])
    for name, e, mu in (("elastic", 1.0, 0.0), ("damped", 0.52, 0.0), ("sticking", 0.52, 0.9), ("sliding", 0.52, 0.1)):
        s = scene(e, mu)
        tc = impact_time(s, (RADIUS, RADIUS), 1.0)

        def outcome(n, gap, s=s, tc=tc):
            state = head_on(1.0, gap=gap)
            state.velocity[:, 1] = [0.2, -0.2]
            state.spin[0] = [5, 10, 15]
            ended, _ = after(s, state, tc / n, 2.5 * tc + gap)
            return np.concatenate([ended.velocity.ravel(), ended.spin.ravel() * RADIUS])

        gaps = 1e-6 + np.linspace(0, 1, 9 if fine else 5) * tc / 25  # the phase of the first touch within a step
        exact = [outcome(6400, gap) for gap in gaps]
        errors = [
            np.mean([np.linalg.norm(outcome(n, gap) - x) for gap, x in zip(gaps, exact, strict=True)]) for n in steps
        ]
        slope = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
        expected = 2.0 if e == 1 else 1.25
        result.add(f"{name}: order", expected, slope, 0.35 if e == 1 else 0.25)
        result.curves.append(Curve(f"{name} ({slope:.2f})", steps, np.array(errors), "o-"))
    result.axes = ("steps a contact (log)", "error of the velocities [m/s] (log)")
    return result


@case(
    "Two thousand random impacts",
    setup="Angle 0-89 deg, mu 0-1.5, e 0.05-1, size ratio 0.1-10, random spins; 50 steps a contact.",
    reference="no gain of kinetic energy; every channel non-negative; the ledger closes; momentum and angular momentum kept",
    tolerance="gain 2e-3 and residual 2 % of the energy, the order of 50 steps a contact (a restitution of 0.05 stops the "
    "spheres within a few of them); channels -1e-15, momenta 1e-12 of theirs",
)
def random_impacts(fine):
    rng = np.random.default_rng(11)
    count = 2000 if fine else 400
    cases, closing = [], []
    for _ in range(count):
        radius = RADIUS * np.array([1, 10 ** rng.uniform(-1, 1)])
        direction = _unit(rng.normal(size=3))
        angle = math.radians(rng.uniform(0, 89))
        s = scene(float(rng.choice(np.linspace(0.05, 1, 20))), rng.uniform(0, 1.5))
        state = head_on(1.0, radius, gap=1e-7)
        gap = radius.sum() + 1e-7
        state.position[:] = [[0, 0, 0], gap * direction]
        state.velocity[:] = 0
        aside = _unit(np.cross(direction, rng.normal(size=3)))
        state.velocity[1] = -math.cos(angle) * direction + math.sin(angle) * aside
        state.spin[:] = rng.uniform(-1, 1, (2, 3)) * 0.3 / radius[:, None]
        cases.append((s, state, impact_time(s, radius, math.cos(angle)) / 50))
        closing.append(math.cos(angle))
    start, ended = together(cases, 400)
    kinetic = ("kinetic_translation", "kinetic_rotation")
    gain = residual = momentum = turning = 0.0
    lowest = 0.0
    for (s, state, _), before, (now, ledger) in zip(cases, start, ended, strict=True):
        energy = before.total(kinetic)[0]
        gain = max(gain, (ledger.total(kinetic)[0] - energy) / energy)
        left = ledger.stored[0] + ledger.dissipated[0] - before.stored[0]
        residual = max(residual, abs(left) / energy)
        lowest = min(lowest, min(ledger[name][0] for name in ledger.losses) / energy)
        mass = s.mass(state.radius)[:, None]
        momenta = [
            (
                (mass * x.velocity).sum(0),
                (mass * np.cross(x.position, x.velocity) + 0.4 * mass * x.radius[:, None] ** 2 * x.spin).sum(0),
            )
            for x in (state, now)
        ]
        momentum = max(momentum, np.abs(momenta[1][0] - momenta[0][0]).max() / np.abs(mass * state.velocity).max())
        turning = max(
            turning,
            np.abs(momenta[1][1] - momenta[0][1]).max() / (np.abs(mass * state.velocity).max() * state.radius.max()),
        )
    result = Result([])
    result.add(f"largest gain in {count} impacts", 0.0, max(0.0, gain), 2e-3)
    result.add("largest ledger residual", 0.0, residual, 0.02)
    result.add("lowest channel", 0.0, lowest, 1e-15)
    result.add("momentum", 0.0, momentum, 1e-12)
    result.add("angular momentum", 0.0, turning, 1e-12)
    return result


def _unit(v):
    return v / np.linalg.norm(v)
