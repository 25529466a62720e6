"""Motion of the enclosure and of the particles in its frame."""

import functools

import warp as wp

from .bounds import bounds
from .lanes import natural
from .particles import particles
from .shape import shape
from .structs import types


@functools.cache
def motion(effects):
    """Return ``enclosure_phase``, ``integrate`` and ``kick`` for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Case, Particle = t.Case, t.Particle
    at_least = bounds(real).at_least
    inverse_mass_of = particles(effects).inverse_mass_of
    s = shape(effects)
    turn, kick_spin, pace2 = s.turn, s.kick_spin, s.pace2

    @wp.func
    def enclosure_phase(case: Case, step: wp.int64):
        """cos and sin of w t; the enclosure is at X sin(w t) along the drive.

        From the step's number within the cycle, so that cycles repeat to the bit and time never drifts.
        """
        phase = wp.float64(2.0) * wp.float64(wp.PI) * wp.float64(step % wp.int64(case.cycle)) / wp.float64(case.cycle)
        return wp.cos(phase), wp.sin(phase)

    @wp.func
    def body_force(case: Case, inertial: vec3):
        """Force per mass on every particle: the inertial force, and gravity [m/s^2]."""
        if wp.static(effects.gravity):
            return inertial + case.gravity
        else:
            return inertial

    @wp.func
    def integrate(case: Case, p: wp.array(dtype=Particle), inertial: vec3, h: real, shift: vec3):
        """Kick over ``h``, drift over dt, predict the velocities for the next step, and clear the forces.

        Leapfrog: half_velocity is exact at half steps; velocity = half_velocity + a dt / 2 is the prediction that the
        dashpots of the next step see.

        Parameters
        ----------
        inertial : vec3 [m/s^2]
            Minus the enclosure's acceleration.
        shift : vec3 [m]
            Any common displacement since the neighbour list was made.

        Returns
        -------
        work : float64 [J]
            Of the inertial force over ``h``.
        travel2 : real [m^2]
            Largest square of a displacement, less ``shift``, since the list was made.
        fastest2 : real [m^2/s^2]
            Largest square of how fast a particle's surface may approach another's.
        mean_velocity : vec3 [m/s]
        momentum : vec3d [kg m/s]
            Of all particles, mean of before and after.
        """
        momentum = wp.vec3d()  # twice the mean of before and after
        travel2 = real(0.0)
        fastest2 = real(0.0)
        mean_velocity = vec3()
        body = body_force(case, inertial)
        half = real(0.5) * case.dt
        first = natural(case.first)
        for i in range(first, first + case.count):
            inverse_mass = inverse_mass_of(case, p, i)
            acceleration = inverse_mass * p[i].force + body
            before = p[i].half_velocity
            after = before + h * acceleration
            momentum += wp.vec3d((real(1.0) / inverse_mass) * (before + after))
            x = p[i].position + case.dt * after
            p[i].position = x
            p[i].half_velocity = after
            p[i].force = vec3()
            if wp.static(effects.dashpots):
                p[i].velocity = after + half * acceleration

            if wp.static(effects.rotation):
                turn(case, p, i, h)

            mean_velocity += after
            moved = x - p[i].listed - shift
            travel2 = at_least(wp.dot(moved, moved), travel2)
            fastest2 = at_least(pace2(case, p, i, after), fastest2)
        work = wp.float64(0.5) * wp.float64(h) * wp.dot(wp.vec3d(inertial), momentum)
        return work, travel2, fastest2, mean_velocity / real(case.count), wp.float64(0.5) * momentum

    @wp.func
    def kick(case: Case, p: wp.array(dtype=Particle), inertial: vec3, h: real):
        """Bring the velocities from the half step before to the whole step; returns inertial work and mean momentum."""
        momentum = wp.vec3d()  # twice the mean of before and after
        body = body_force(case, inertial)
        for i in range(case.first, case.first + case.count):
            inverse_mass = inverse_mass_of(case, p, i)
            before = p[i].half_velocity
            after = before + h * (inverse_mass * p[i].force + body)
            momentum += wp.vec3d((real(1.0) / inverse_mass) * (before + after))
            p[i].half_velocity = after
            if wp.static(effects.rotation):
                kick_spin(case, p, i, h)
        work = wp.float64(0.5) * wp.float64(h) * wp.dot(wp.vec3d(inertial), momentum)
        return work, wp.float64(0.5) * momentum

    return enclosure_phase, integrate, kick
