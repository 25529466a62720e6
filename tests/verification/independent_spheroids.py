"""Two elastic spheroids that collide without friction, integrated by SciPy: shares no code and no algorithm with ours.

Spheroids are quadrics x^T A^-1 x = 1 with rotation matrices for their orientation.  Their common normal n solves
(A_i / h_i + A_j / h_j + g) n = r, h = sqrt(n^T A n), by fixed-point iteration; curvatures are those of the quadrics;
the stiffness is Hertz's with complete elliptic integrals (Johnson, Contact Mechanics, 1985, section 4.2); and forces and
torques are differences of the energy 8/15 E* sqrt(R) d^2.5.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

DIFFERENCE = 1e-7
"""Way [m] and angle [rad, over the radius] of the differences, in units of the radius."""


def common_normal(apart, one, other):
    """Unit vector from the other to the one, and the gap along it."""
    n = apart / np.linalg.norm(apart)
    for _ in range(500):
        h_one, h_other = np.sqrt(n @ one @ n), np.sqrt(n @ other @ n)
        gap = n @ apart - h_one - h_other
        fresh = np.linalg.solve(one / h_one + other / h_other + gap * np.eye(3), apart)
        fresh /= np.linalg.norm(fresh)
        if np.linalg.norm(fresh - n) < 1e-14:
            break
        n = fresh
    return n, n @ apart - np.sqrt(n @ one @ n) - np.sqrt(n @ other @ n)


def curvature(quadric, n, tangent):
    """Curvature matrix of a quadric where its normal is n, in a basis of the tangent plane (3, 2)."""
    inverse = np.linalg.inv(quadric)
    point = quadric @ n / np.sqrt(n @ quadric @ n)
    return tangent.T @ inverse @ tangent / np.linalg.norm(inverse @ point)


def hertz_radius(relative):
    """R of the sphere on a plane that is as stiff, from the relative curvature matrix (2, 2): exact."""
    low, high = np.linalg.eigvalsh(relative)
    if high / low < 1 + 1e-9:
        return 1 / np.sqrt(low * high)

    def parts(ratio):  # of the semi-axes of contact
        m = 1 - ratio**2
        return ellipe(m) / ratio**2 - ellipk(m), ellipk(m) - ellipe(m), ellipk(m), m

    ratio = brentq(lambda x: parts(x)[0] / parts(x)[1] - high / low, 1e-3, 1 - 1e-12, xtol=1e-14)
    first, second, whole, m = parts(ratio)
    f1_cubed = 4 / (np.pi * m) * ratio**1.5 * np.sqrt(first * second)
    f2 = 2 / np.pi * np.sqrt(ratio) * f1_cubed ** (-1 / 3) * whole
    return f2**-3 / np.sqrt(low * high)


def energy(apart, one, other, modulus):
    """Elastic energy [J]."""
    n, gap = common_normal(apart, one, other)
    if gap >= 0:
        return 0.0
    tangent = np.linalg.svd(n[None])[2][1:].T
    radius = hertz_radius(curvature(one, n, tangent) + curvature(other, n, tangent))
    return 8 / 15 * modulus * np.sqrt(radius) * (-gap) ** 2.5


def cross_matrix(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def collide(apart, turns, speed, spins, *, semi_axes, mass, modulus, duration):
    """Relative velocity and spins after a collision.

    Parameters
    ----------
    apart, speed : (3,) arrays
        Of the first from the second [m], [m/s].
    turns : two (3, 3) rotations
        Their third columns are the axes.
    spins : (2, 3) array
        [rad/s].
    semi_axes : (along, across)
        Of both [m].
    mass, modulus : float
        Of each [kg], E* [Pa].
    duration : float
        [s].
    """
    along, across = semi_axes
    squares = np.diag([across**2, across**2, along**2])
    inertia = mass / 5 * np.diag([across**2 + along**2, across**2 + along**2, 2 * across**2])
    step = DIFFERENCE * across

    def quadrics(turns):
        return [turn @ squares @ turn.T for turn in turns]

    def loads(apart, turns):
        one, other = quadrics(turns)
        force, torque = np.zeros(3), np.zeros(3)
        if common_normal(apart, one, other)[1] >= 0:
            return force, torque
        for k, way in enumerate(step * np.eye(3)):
            force[k] = -(energy(apart + way, one, other, modulus) - energy(apart - way, one, other, modulus)) / 2 / step
            turned = [np.eye(3) + cross_matrix(s * way / across) for s in (1, -1)]
            turned = [np.linalg.qr(t)[0] * np.sign(np.diag(np.linalg.qr(t)[1])) for t in turned]
            up, down = (energy(apart, t @ one @ t.T, other, modulus) for t in turned)
            torque[k] = -(up - down) / (2 * step / across)
        return force, torque

    def rates(_t, y):
        apart, speed = y[:3], y[3:6]
        turns, momenta = y[6:24].reshape(2, 3, 3), y[24:].reshape(2, 3)
        force, torque = loads(apart, turns)
        spins = [
            turn @ np.linalg.solve(inertia, turn.T @ momentum) for turn, momentum in zip(turns, momenta, strict=True)
        ]
        turning = [cross_matrix(spin) @ turn for spin, turn in zip(spins, turns, strict=True)]
        other_torque = -torque - np.cross(apart, force)  # the two keep their angular momentum
        return np.concatenate([speed, 2 * force / mass, *(t.ravel() for t in turning), torque, other_torque])

    turns = np.asarray(turns, float)
    momenta = [turn @ inertia @ turn.T @ spin for turn, spin in zip(turns, spins, strict=True)]
    start = np.concatenate([apart, speed, turns.ravel(), *momenta])
    y = solve_ivp(rates, (0, duration), start, method="DOP853", rtol=1e-8, atol=1e-12, max_step=duration / 40).y[:, -1]
    turns, momenta = y[6:24].reshape(2, 3, 3), y[24:].reshape(2, 3)
    spins = [turn @ np.linalg.solve(inertia, turn.T @ momentum) for turn, momentum in zip(turns, momenta, strict=True)]
    return y[3:6], np.array(spins)
