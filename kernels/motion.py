"""Motion of the enclosure and of the particles in its frame."""

import functools

import warp as wp

from .data import types


@functools.cache
def motion(effects):
    """Return ``enclosure_phase``, ``integrate`` and ``kick`` for the given effects."""
    t = types(effects.real)
    real, vec3 = t.real, t.vec3
    Case, Particles = t.Case, t.Particles

    @wp.func
    def enclosure_phase(case: Case, step: wp.int64):
        """cos and sin of w t; the enclosure is at X sin(w t) along the drive.

        From the step's number within the cycle, so that cycles repeat to the bit and time never drifts.
        """
        phase = wp.float64(2.0) * wp.float64(wp.PI) * wp.float64(step % wp.int64(case.cycle)) / wp.float64(case.cycle)
        return wp.cos(phase), wp.sin(phase)

    @wp.func
    def integrate(case: Case, p: Particles, inertial: vec3, h: real, drift: vec3):
        """Kick over ``h``, drift over dt, predict the velocities for the next step, and clear the forces.

        Leapfrog: half_velocity is exact at half steps; velocity = half_velocity + a dt / 2 is the prediction that the
        dashpots and the springs' history of the next step see.

        Parameters
        ----------
        inertial : vec3 [m/s^2]
            Minus the enclosure's acceleration.
        drift : vec3 [m]
            Any common displacement since the neighbour list was made.

        Returns
        -------
        work : float64 [J]
            Of the inertial force over ``h``.
        travel2 : real [m^2]
            Largest square of a displacement, less ``drift``, since the list was made.
        mean_velocity : vec3 [m/s]
        """
        work = wp.float64(0.0)
        travel2 = real(0.0)
        mean_velocity = vec3()
        body = case.gravity + inertial
        half = real(0.5) * case.dt
        for i in range(case.first, case.first + case.count):
            acceleration = p.force[i] * p.inverse_mass[i] + body
            before = p.half_velocity[i]
            after = before + h * acceleration
            work += wp.float64(wp.dot(inertial, before + after) * real(0.5) * h / p.inverse_mass[i])
            x = p.position[i] + case.dt * after
            p.position[i] = x
            p.half_velocity[i] = after
            p.velocity[i] = after + half * acceleration

            turning = p.torque[i] * p.inverse_inertia[i]
            spin = p.half_spin[i] + h * turning
            p.half_spin[i] = spin
            p.spin[i] = spin + half * turning

            p.force[i] = vec3()
            p.torque[i] = vec3()
            mean_velocity += after
            moved = x - p.listed[i] - drift
            travel2 = wp.max(travel2, wp.dot(moved, moved))
        return work, travel2, mean_velocity / real(case.count)

    @wp.func
    def kick(case: Case, p: Particles, inertial: vec3, h: real):
        """Bring the velocities from the half step before to the whole step; returns the inertial work [J]."""
        work = wp.float64(0.0)
        body = case.gravity + inertial
        for i in range(case.first, case.first + case.count):
            before = p.half_velocity[i]
            after = before + h * (p.force[i] * p.inverse_mass[i] + body)
            work += wp.float64(wp.dot(inertial, before + after) * real(0.5) * h / p.inverse_mass[i])
            p.half_velocity[i] = after
            p.half_spin[i] = p.half_spin[i] + h * p.torque[i] * p.inverse_inertia[i]
        return work

    return enclosure_phase, integrate, kick
