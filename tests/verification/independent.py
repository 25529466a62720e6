"""The contact law once more, written as differential equations and integrated by SciPy: shares no code with the kernels.

A sphere meets a rigid plane at an angle, in two dimensions.  Unknowns: overlap d, its rate, the tangential velocity of
the centre, the spin, and the spring's force f.  Loading keeps f, unloading scales it with the stiffness, and sliding
holds it at the limit:

    f' = -St s + (f St'/St if St' < 0 else 0),   |f| <= mu max(Fn, 0),   s = vt - w R
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp


def strength(restitution):
    """Dashpot strength without tension: Thornton, Cummins & Cleary's fit (2013), whose F = 2 gamma sqrt(m S) v.

    Good to 2e-3 up to 0.95 (doi:10.1016/j.powtec.2012.08.012); from there on a straight line in 1 - e to zero.
    """
    if restitution > 0.95:
        return strength(0.95) * (1 - restitution) / 0.05
    h = (-6.918798, -16.41105, 146.8049, -796.4559, 2928.711, -7206.864, 11494.29, -11342.18, 6276.757, -1489.915)
    e = restitution
    alpha = e * sum(c * e**k for k, c in enumerate(h))
    return math.sqrt(6 / 5) * math.sqrt(1 / (1 - (1 + e) ** 2 * math.exp(alpha)) - 1)


def oblique_impact(*, mass, radius, modulus, shear_modulus, restitution, friction, vn, vt, spin=0.0, steps=40_000):
    """Rebound of a sphere from a plane: (normal velocity, tangential velocity, spin).

    ``spin`` turns the sphere so that positive ``spin`` moves its lowest point along +vt backwards: s = vt - spin R.
    """
    damping = 2 * math.sqrt(5 / 6) * strength(restitution)
    inertia = 0.4 * mass * radius**2

    def forces(y):
        d, rate, v, w, _ = y
        a = math.sqrt(radius * max(d, 0.0))
        sn, st = 2 * modulus * a, 8 * shear_modulus * a
        normal = max(0.0, 4 / 3 * modulus * a * d + damping * math.sqrt(sn * mass) * rate)
        limit = friction * normal
        slip = v - w * (radius - d)
        return a, st, normal, limit, slip

    def rates(_t, y):
        d, rate, _, _, f = y
        _, st, normal, limit, slip = forces(y)
        held = max(-limit, min(limit, f))
        viscous = -damping * math.sqrt(st * mass) * slip
        tangential = max(-limit, min(limit, held + viscous))
        growth = rate / (2 * d) if d > 0 else 0.0  # St'/St, St ~ sqrt(d)
        df = -st * slip + (f * growth if rate < 0 else 0.0)
        return [rate, -normal / mass, tangential / mass, -tangential * (radius - d) / inertia, df]

    d = 1e-12 * radius
    y = np.array([d, vn, vt, spin, 0.0])
    duration = 2.943275 * (15 * mass * vn**2 / (16 * modulus * math.sqrt(radius))) ** 0.4 / vn
    # a fixed fine grid, each piece by a Runge-Kutta step of high order, the spring's force cut to the limit between
    # pieces: sliding is then exact to the order of the piece
    h = 2.0 * duration / steps
    t = 0.0
    for _ in range(20 * steps):
        piece = solve_step(rates, t, y, h)
        limit = forces(piece)[3]
        piece[4] = max(-limit, min(limit, piece[4]))
        t, y = t + h, piece
        if y[1] < 0 and forces(y)[2] == 0:
            break
    return -y[1], y[2], y[3]


def solve_step(rates, t, y, h):
    """One classical Runge-Kutta step."""
    k1 = np.asarray(rates(t, y))
    k2 = np.asarray(rates(t + h / 2, y + h / 2 * k1))
    k3 = np.asarray(rates(t + h / 2, y + h / 2 * k2))
    k4 = np.asarray(rates(t + h, y + h * k3))
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def stacked_spheres(*, masses, radii, modulus_pair, modulus_wall, restitution, height, positions, gravity, times):
    """Heights of two spheres squeezed between floor and lid, by SciPy with tight tolerances."""
    damping = 2 * math.sqrt(5 / 6) * strength(restitution)
    reduced_mass = masses[0] * masses[1] / sum(masses)
    reduced_radius = radii[0] * radii[1] / sum(radii)

    def push(overlap, rate, modulus, radius, mass):
        if overlap <= 0:
            return 0.0
        a = math.sqrt(radius * overlap)
        return max(0.0, 4 / 3 * modulus * a * overlap + damping * math.sqrt(2 * modulus * a * mass) * rate)

    def rates(_t, y):
        z1, z2, v1, v2 = y
        floor = push(radii[0] - z1, -v1, modulus_wall, radii[0], masses[0])
        between = push(sum(radii) - (z2 - z1), v1 - v2, modulus_pair, reduced_radius, reduced_mass)
        lid = push(z2 + radii[1] - height, v2, modulus_wall, radii[1], masses[1])
        return [v1, v2, (floor - between) / masses[0] - gravity, (between - lid) / masses[1] - gravity]

    start = [*positions, 0.0, 0.0]
    solved = solve_ivp(rates, (0, times[-1]), start, t_eval=times, method="DOP853", rtol=1e-11, atol=1e-15)
    return solved.y[:2]
