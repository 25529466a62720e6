"""Contacts between particles and the cylindrical cavity: side, floor and lid.

The walls stand still (the frame is the enclosure's) and are rigid bodies of their own material: R* = R, m* = m.
A particle in an edge touches two walls, each with its own history.
"""

import functools

import warp as wp

from .contact import contact_law
from .data import types

FLOOR, LID = wp.constant(1), wp.constant(2)  # 0 is the side


@functools.cache
def wall_contacts(effects):
    """Return ``wall_forces`` and ``wall_energy`` for the given effects."""
    t = types(effects.real)
    real, vec3, vec4 = t.real, t.vec3, t.vec4
    Case, Particles, Contacts = t.Case, t.Particles, t.Contacts
    contact, normal_energy, tangential_energy = contact_law(effects)

    @wp.func
    def wall_gap(case: Case, wall: int, x: vec3, radius: real):
        """Distance between the particle's surface and a wall (negative: overlap) and the wall's inward normal."""
        if wall == FLOOR:
            return x[2] - radius, vec3(real(0.0), real(0.0), real(1.0))
        if wall == LID:
            return case.height - x[2] - radius, vec3(real(0.0), real(0.0), real(-1.0))
        reach = case.radius - radius
        rho2 = x[0] * x[0] + x[1] * x[1]
        if rho2 <= reach * reach:
            return real(1.0), vec3()  # clear of the side: how far does not matter
        rho = wp.sqrt(rho2)
        return reach - rho, vec3(-x[0] / rho, -x[1] / rho, real(0.0))

    @wp.func
    def wall_forces(case: Case, p: Particles, c: Contacts, h: real, since: real):
        """Add all wall forces and torques of a case.

        The step stands for ``h`` seconds, and comes ``since`` seconds after the last one.  Returns the force on the
        enclosure [N], the losses [J] and the largest overlap over R.
        """
        reaction = vec3()
        losses = wp.vec4d()
        largest = real(0.0)
        for i in range(case.first, case.first + case.count):
            x = p.position[i]
            radius = p.radius[i]
            for wall in range(3):
                gap, normal = wall_gap(case, wall, x, radius)
                if gap < real(0.0):
                    spin = p.spin[i]
                    half_spin = p.half_spin[i]
                    passing = p.half_velocity[i]
                    passing -= wp.dot(passing, normal) * normal
                    arm = radius + gap
                    f, history, lost = contact(
                        case.wall_law,
                        real(1.0) / radius,
                        p.inverse_mass[i],
                        -gap,
                        normal,
                        p.velocity[i] - arm * wp.cross(spin, normal),
                        since * (passing - arm * wp.cross(half_spin, normal)),
                        real(0.5) * since * wp.dot(half_spin, normal),
                        c.wall_history[3 * i + wall],
                        h,
                    )
                    p.force[i] += f
                    p.torque[i] += arm * wp.cross(f, normal)
                    reaction -= f
                    c.wall_history[3 * i + wall] = history
                    losses += wp.vec4d(lost)
                    largest = wp.max(largest, -gap / radius)
                else:
                    history = c.wall_history[3 * i + wall]
                    if history[3] > real(0.0):
                        losses[3] += wp.float64(tangential_energy(case.wall_law, history))
                        c.wall_history[3 * i + wall] = vec4()
        return reaction, losses, largest

    @wp.func
    def wall_energy(case: Case, p: Particles, c: Contacts, offset: real):
        """Elastic energy (normal, tangential) [J] in the wall contacts, positions taken ``offset`` seconds back."""
        normal = wp.float64(0.0)
        tangential = wp.float64(0.0)
        for i in range(case.first, case.first + case.count):
            x = p.position[i] - offset * p.half_velocity[i]
            radius = p.radius[i]
            for wall in range(3):
                gap, _normal = wall_gap(case, wall, x, radius)
                if gap < real(0.0):
                    normal += wp.float64(normal_energy(case.wall_law, real(1.0) / radius, -gap))
                tangential += wp.float64(tangential_energy(case.wall_law, c.wall_history[3 * i + wall]))
        return normal, tangential

    return wall_forces, wall_energy
