"""Host structure of the enclosure: modal oscillators that advance together with the particles.

Each mode r, mass-normalised, with phi its amplitude at the damper in the direction of the drive,

    q'' + 2 zeta w q' + w^2 q = phi (F + R),     x = sum phi q,

F the force applied there, R that of the particles on the enclosure.  Leapfrog as for the particles; the damping acts on
the mean of the velocities before and after, which needs no iteration.

Where the base moves, with acceleration a along the direction, q and x are relative to it:

    q'' + 2 zeta w q' + w^2 q = phi R - Gamma a,     Gamma = phi^T M d,     acceleration of the enclosure a + x'',

d the displacement of the structure that follows the base like a rigid body.  In the base's frame the inertial forces
do the work -a (sum Gamma q' + P) per second, P = p + m x' the momentum of the particles there, p that in the enclosure.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .structs import types


@functools.cache
def structure(effects):
    """Return ``answer``, ``modal_energy``, ``enclosure_place`` and ``record`` for the given effects."""
    t = types(effects)
    real = t.real
    Case, HostStructure = t.Case, t.HostStructure

    @wp.func
    def excitation(case: Case, host: HostStructure, step: wp.int64):
        """Return the force at the damper [N] and the base's acceleration [m/s^2], of which one is zero.

        A harmonic part, and samples with straight lines between.
        """
        phase = real(2.0) * real(wp.PI) * real(step % wp.int64(case.cycle)) / real(case.cycle)
        value = case.excitation * wp.sin(phase)
        if case.samples > 1:
            place = real(step) * case.dt / case.sample_step
            k = wp.min(wp.int32(place), case.samples - 2)
            part = wp.min(place - real(k), real(1.0))
            first = host.signal[case.first_sample + k]
            value += first + part * (host.signal[case.first_sample + k + 1] - first)
        if case.base_moves == 1:
            return real(0.0), value
        return value, real(0.0)

    @wp.func
    def answer(case: Case, host: HostStructure, step: wp.int64, reaction: real, h: real, drift: real):
        """Advance the modes' velocities over ``h`` and their places over ``drift``.

        Returns
        -------
        acceleration, base : real [m/s^2]
            Of the enclosure and of the structure's base along the direction.
        force_work, loss : float64 [J]
            Of the excitation, less what the base does by the particles' momentum p; and by the structure's own damping.
        """
        force, base = excitation(case, host, step)
        acceleration = base
        force_work = wp.float64(0.0)
        loss = wp.float64(0.0)
        for r in range(case.first_mode, case.first_mode + case.modes):
            mode = host.modes[r]
            before = mode.velocity
            push = mode.amplitude * (force + reaction) - mode.participation * base - mode.stiffness * mode.position
            after = (before * (real(1.0) - h * mode.damping) + h * push) / (real(1.0) + h * mode.damping)
            mean = real(0.5) * (before + after)
            acceleration += mode.amplitude * (after - before) / h
            carried = mode.participation + case.particle_mass * mode.amplitude
            force_work += wp.float64((mode.amplitude * force - carried * base) * mean * h)
            loss += wp.float64(real(2.0) * mode.damping * mean * mean * h)
            host.modes[r].velocity = after
            host.modes[r].position = mode.position + drift * after
        return acceleration, base, force_work, loss

    @wp.func
    def modal_energy(case: Case, host: HostStructure, offset: real):
        """Energy of the modes [J], and the enclosure's place [m] and velocity [m/s] along its direction.

        Positions are taken ``offset`` seconds back, where the velocities are.
        """
        energy = wp.float64(0.0)
        place = real(0.0)
        velocity = real(0.0)
        for r in range(case.first_mode, case.first_mode + case.modes):
            mode = host.modes[r]
            q = mode.position - offset * mode.velocity
            energy += wp.float64(real(0.5) * (mode.velocity * mode.velocity + mode.stiffness * q * q))
            place += mode.amplitude * q
            velocity += mode.amplitude * mode.velocity
        return energy, place, velocity

    @wp.func
    def enclosure_place(case: Case, host: HostStructure):
        """x along the direction [m]."""
        place = real(0.0)
        for r in range(case.first_mode, case.first_mode + case.modes):
            place += host.modes[r].amplitude * host.modes[r].position
        return place

    @wp.func
    def record(case: Case, host: HostStructure, step: wp.int64, place: real, acceleration: real, reaction: real):
        """Keep the enclosure's place, its acceleration and the particles' force on it every so many steps."""
        if case.record > 0 and step % wp.int64(case.record) == wp.int64(0):
            k = wp.int32(step / wp.int64(case.record))
            if k < case.records:
                host.records[case.first_record + k] = wp.vec3d(
                    wp.float64(place), wp.float64(acceleration), wp.float64(reaction)
                )

    return SimpleNamespace(answer=answer, modal_energy=modal_energy, enclosure_place=enclosure_place, record=record)
