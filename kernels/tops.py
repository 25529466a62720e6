"""Rotation of spheroids: symmetric tops by their unit axis u and their angular momentum L.

The spin about the axis changes nothing that anybody sees, so no angle of it is kept.  With I_t across the axis and I_a
along it,

    w = L / I_t + (1 / I_a - 1 / I_t) (L.u) u,   u' = L x u / I_t,   T = L^2 / (2 I_t) + (1 / I_a - 1 / I_t) (L.u)^2 / 2

Leapfrog: the torque kicks L at a whole step; then u turns about L for a step by Cayley's rotation of the vector
dt L / (2 I_t), which keeps its length and L.u, and so T, to round-off.  Both are flows of a Hamiltonian: the scheme is
symplectic, reversible, and of second order.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .structs import types


@functools.cache
def tops(effects):
    """Return ``turn``, ``kick_spin``, ``axis_back``, ``rotational_energy`` and ``pace2`` for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Case, Particle = t.Case, t.Particle

    @wp.func
    def rotated(u: vec3, half: vec3):
        """Vector u turned by Cayley's rotation, by the angle 2 atan |half| about ``half``."""
        across = wp.cross(half, u)
        return u + (real(2.0) / (real(1.0) + wp.dot(half, half))) * (across + wp.cross(half, across))

    @wp.func
    def spin_of(p: wp.array(dtype=Particle), i: int, momentum: vec3, u: vec3):
        """Angular velocity w [rad/s] of an angular momentum."""
        transverse = p[i].inverse_transverse
        return transverse * momentum + ((p[i].inverse_axial - transverse) * wp.dot(momentum, u)) * u

    @wp.func
    def axis_back(p: wp.array(dtype=Particle), i: int, offset: real):
        """The axis ``offset`` seconds back."""
        return rotated(p[i].axis, (real(-0.5) * offset * p[i].inverse_transverse) * p[i].half_momentum)

    @wp.func
    def turn(case: Case, p: wp.array(dtype=Particle), i: int, h: real):
        """Kick a particle's angular momentum over ``h``, turn its axis over dt, predict the spin, clear the torque."""
        half = real(0.5) * case.dt
        torque = p[i].torque
        momentum = p[i].half_momentum + h * torque
        before = p[i].axis
        after = rotated(before, (half * p[i].inverse_transverse) * momentum)
        p[i].half_momentum = momentum
        p[i].axis = after
        p[i].torque = vec3()
        # mean over the step, for surfaces slide by it
        transverse = p[i].inverse_transverse
        along = real(0.5) * (p[i].inverse_axial - transverse) * wp.dot(momentum, before)
        p[i].half_spin = transverse * momentum + along * (before + after)
        if wp.static(effects.dashpots):
            p[i].spin = spin_of(p, i, momentum + half * torque, after)

    @wp.func
    def kick_spin(_case: Case, p: wp.array(dtype=Particle), i: int, h: real):
        """Bring a particle's angular momentum and spin from the half step before to the whole step."""
        momentum = p[i].half_momentum + h * p[i].torque
        p[i].half_momentum = momentum
        p[i].half_spin = spin_of(p, i, momentum, p[i].axis)

    @wp.func
    def rotational_energy(_case: Case, p: wp.array(dtype=Particle), i: int):
        """Energy of a particle's rotation at the half step [J]."""
        momentum = p[i].half_momentum
        along = wp.dot(momentum, p[i].axis)
        transverse = p[i].inverse_transverse
        return real(0.5) * (transverse * wp.dot(momentum, momentum) + (p[i].inverse_axial - transverse) * along * along)

    @wp.func
    def pace2(_case: Case, p: wp.array(dtype=Particle), i: int, velocity: vec3):
        """Square of how fast a particle's gap to another may close, |v| + |a - b| |u'| at the most [m^2/s^2]."""
        momentum = p[i].half_momentum
        lever = p[i].tilt * p[i].inverse_transverse
        moving = wp.dot(velocity, velocity)
        tilting = lever * lever * wp.dot(momentum, momentum)
        return moving + tilting + real(2.0) * wp.sqrt(moving * tilting)

    return SimpleNamespace(
        turn=turn, kick_spin=kick_spin, axis_back=axis_back, rotational_energy=rotational_energy, pace2=pace2
    )
