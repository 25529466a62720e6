"""Host structures of enclosures: modal oscillators that advance together with the particles.

Each mode r, mass-normalised, with phi_c its amplitude at enclosure c in the direction of the drive,

    q'' + 2 zeta w q' + w^2 q = phi_1 F + sum_c phi_c R_c,     x_c = sum_r phi_c q,

F the force applied at the first enclosure, R_c that of the particles on enclosure c.  Leapfrog as for the particles;
the damping acts on the mean of the velocities before and after, which needs no iteration.

Where the base moves, with acceleration a along the direction, q and x are relative to it:

    q'' + 2 zeta w q' + w^2 q = sum_c phi_c R_c - Gamma a,     Gamma = phi^T M d,     acceleration of c: a + x_c'',

d the displacement of the structure that follows the base like a rigid body.  In the base's frame the inertial forces
do the work -a (sum Gamma q' + sum P_c) per second, P = p + m x' the momentum of the particles in an enclosure, p that
relative to it.

Enclosures of one structure are cases one after the other.  The structure's own state, work and losses are kept once,
with the first of them.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .structs import types


@functools.cache
def structure(effects):
    """Return what host structures do, for the given effects."""
    t = types(effects)
    real = t.real
    Case, Mode, HostStructure = t.Case, t.Mode, t.HostStructure

    @wp.func
    def excitation(case: Case, host: HostStructure, step: wp.int64):
        """Return the force at the first enclosure [N] and the base's acceleration [m/s^2], of which one is zero.

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
    def swung(mode: Mode, load: real, base: real, h: real, drift: real):
        """Mode after a step ``h`` under a modal ``load``, its place after ``drift``; and its mean velocity."""
        before = mode.velocity
        push = load - mode.participation * base - mode.stiffness * mode.position
        after = (before * (real(1.0) - h * mode.damping) + h * push) / (real(1.0) + h * mode.damping)
        mean = real(0.5) * (before + after)
        mode.change = after - before
        mode.velocity = after
        mode.position = mode.position + drift * after
        return mode, mean

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
        for r in range(case.modes):
            amplitude = host.amplitudes[case.first_amplitude + r]
            mode, mean = swung(host.modes[case.first_mode + r], amplitude * (force + reaction), base, h, drift)
            acceleration += amplitude * mode.change / h
            carried = mode.participation + case.particle_mass * amplitude
            force_work += wp.float64((amplitude * force - carried * base) * mean * h)
            loss += wp.float64(real(2.0) * mode.damping * mean * mean * h)
            host.modes[case.first_mode + r] = mode
        return acceleration, base, force_work, loss

    @wp.func
    def answer_to_all(
        cases: wp.array(dtype=Case), first: int, host: HostStructure, step: wp.int64, h: real, drift: real
    ):
        """The same for a structure of several enclosures, with the reactions noted in ``host.enclosures``.

        ``first`` is the number of the first of them.  Returns what ``answer`` does but accelerations of enclosures.
        """
        case = cases[first]
        force, base = excitation(case, host, step)
        force_work = wp.float64(0.0)
        loss = wp.float64(0.0)
        for r in range(case.modes):
            load = host.amplitudes[case.first_amplitude + r] * force
            worked_on = load - host.modes[case.first_mode + r].participation * base
            for k in range(first, first + case.enclosures):
                amplitude = host.amplitudes[cases[k].first_amplitude + r]
                load += amplitude * host.enclosures[k].reaction
                worked_on -= cases[k].particle_mass * amplitude * base
            mode, mean = swung(host.modes[case.first_mode + r], load, base, h, drift)
            force_work += wp.float64(worked_on * mean * h)
            loss += wp.float64(real(2.0) * mode.damping * mean * mean * h)
            host.modes[case.first_mode + r] = mode
        return base, force_work, loss

    @wp.func
    def enclosure_acceleration(case: Case, host: HostStructure, base: real, h: real):
        """Acceleration of an enclosure along the direction, its base's included, over the step ``h`` [m/s^2]."""
        acceleration = base
        for r in range(case.modes):
            acceleration += host.amplitudes[case.first_amplitude + r] * host.modes[case.first_mode + r].change / h
        return acceleration

    @wp.func
    def modal_energy(case: Case, host: HostStructure, offset: real):
        """Energy of the modes [J], and the enclosure's place [m] and velocity [m/s] along its direction.

        Positions are taken ``offset`` seconds back, where the velocities are.  The energy is that of the structure at
        its first enclosure, zero at the others.
        """
        energy = wp.float64(0.0)
        place = real(0.0)
        velocity = real(0.0)
        for r in range(case.modes):
            mode = host.modes[case.first_mode + r]
            amplitude = host.amplitudes[case.first_amplitude + r]
            q = mode.position - offset * mode.velocity
            if case.enclosures > 0:
                energy += wp.float64(real(0.5) * (mode.velocity * mode.velocity + mode.stiffness * q * q))
            place += amplitude * q
            velocity += amplitude * mode.velocity
        return energy, place, velocity

    @wp.func
    def enclosure_place(case: Case, host: HostStructure):
        """x along the direction [m]."""
        place = real(0.0)
        for r in range(case.modes):
            place += host.amplitudes[case.first_amplitude + r] * host.modes[case.first_mode + r].position
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

    return SimpleNamespace(
        answer=answer,
        answer_to_all=answer_to_all,
        enclosure_acceleration=enclosure_acceleration,
        modal_energy=modal_energy,
        enclosure_place=enclosure_place,
        record=record,
    )
