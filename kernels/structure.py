"""Host structure of the enclosure: modal oscillators that advance together with the particles.

Each mode r, mass-normalised, with phi its amplitude at the damper in the direction of the drive,

    q'' + 2 zeta w q' + w^2 q = phi (F + R),     x = sum phi q,

F the force applied there, R that of the particles on the enclosure.  Leapfrog as for the particles; the damping acts on
the mean of the velocities before and after, which needs no iteration.
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
    Case, Mount = t.Case, t.Mount

    @wp.func
    def applied_force(case: Case, mount: Mount, step: wp.int64):
        """Force on the structure at the damper [N]: a harmonic part, and samples with straight lines between."""
        phase = real(2.0) * real(wp.PI) * real(step % wp.int64(case.cycle)) / real(case.cycle)
        force = case.force * wp.sin(phase)
        if case.samples > 1:
            place = real(step) * case.dt / case.sample_step
            k = wp.min(wp.int32(place), case.samples - 2)
            part = wp.min(place - real(k), real(1.0))
            first = mount.force[case.first_sample + k]
            force += first + part * (mount.force[case.first_sample + k + 1] - first)
        return force

    @wp.func
    def answer(case: Case, mount: Mount, step: wp.int64, reaction: real, h: real, drift: real):
        """Advance the modes' velocities over ``h`` and their places over ``drift``.

        Returns
        -------
        acceleration : real [m/s^2]
            Of the enclosure along its direction.
        force_work, loss : float64 [J]
            Of the applied force, and by the structure's own damping.
        """
        force = applied_force(case, mount, step)
        acceleration = real(0.0)
        force_work = wp.float64(0.0)
        loss = wp.float64(0.0)
        for r in range(case.first_mode, case.first_mode + case.modes):
            mode = mount.modes[r]
            before = mode.velocity
            push = mode.amplitude * (force + reaction) - mode.stiffness * mode.position
            after = (before * (real(1.0) - h * mode.damping) + h * push) / (real(1.0) + h * mode.damping)
            mean = real(0.5) * (before + after)
            acceleration += mode.amplitude * (after - before) / h
            force_work += wp.float64(mode.amplitude * mean * force * h)
            loss += wp.float64(real(2.0) * mode.damping * mean * mean * h)
            mount.modes[r].velocity = after
            mount.modes[r].position = mode.position + drift * after
        return acceleration, force_work, loss

    @wp.func
    def modal_energy(case: Case, mount: Mount, offset: real):
        """Energy of the modes [J], and the enclosure's place [m] and velocity [m/s] along its direction.

        Positions are taken ``offset`` seconds back, where the velocities are.
        """
        energy = wp.float64(0.0)
        place = real(0.0)
        velocity = real(0.0)
        for r in range(case.first_mode, case.first_mode + case.modes):
            mode = mount.modes[r]
            q = mode.position - offset * mode.velocity
            energy += wp.float64(real(0.5) * (mode.velocity * mode.velocity + mode.stiffness * q * q))
            place += mode.amplitude * q
            velocity += mode.amplitude * mode.velocity
        return energy, place, velocity

    @wp.func
    def enclosure_place(case: Case, mount: Mount):
        """x along the direction [m]."""
        place = real(0.0)
        for r in range(case.first_mode, case.first_mode + case.modes):
            place += mount.modes[r].amplitude * mount.modes[r].position
        return place

    @wp.func
    def record(case: Case, mount: Mount, step: wp.int64, place: real, acceleration: real, reaction: real):
        """Keep the enclosure's place, its acceleration and the particles' force on it every so many steps."""
        if case.record > 0 and step % wp.int64(case.record) == wp.int64(0):
            k = wp.int32(step / wp.int64(case.record))
            if k < case.records:
                mount.records[case.first_record + k] = wp.vec3d(
                    wp.float64(place), wp.float64(acceleration), wp.float64(reaction)
                )

    return SimpleNamespace(answer=answer, modal_energy=modal_energy, enclosure_place=enclosure_place, record=record)
