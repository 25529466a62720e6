"""Contacts between particles: geometry of two spheres, and the sum over the neighbour list."""

import functools

import warp as wp

from .contact import contact_law
from .data import types


@functools.cache
def pair_contacts(effects):
    """Return ``pair_forces`` and ``pair_energy`` for the given effects."""
    t = types(effects.real)
    real, vec3, vec4 = t.real, t.vec3, t.vec4
    Case, Particles, Contacts = t.Case, t.Particles, t.Contacts
    contact, normal_energy, tangential_energy = contact_law(effects)

    @wp.func
    def pair_forces(case: Case, p: Particles, c: Contacts, h: real, since: real):
        """Add all pair forces and torques of a case; return its losses [J] and its largest overlap over R*.

        The step stands for ``h`` seconds, and comes ``since`` seconds after the last one.

        The lever arms share the distance of the centres in the ratio of the radii, so that angular momentum is kept
        to round-off.  Non-touching pairs add nothing: sums do not depend on how long ago the list was made.
        """
        losses = wp.vec4d()
        largest = real(0.0)
        for i in range(case.first, case.first + case.count):
            x = p.position[i]
            v = p.velocity[i]
            spin = p.spin[i]
            half_v = p.half_velocity[i]
            half_spin = p.half_spin[i]
            radius = p.radius[i]
            inverse_mass = p.inverse_mass[i]
            force = vec3()
            torque = vec3()
            for k in range(c.start[i], c.start[i + 1]):
                j = c.partner[k]
                branch = x - p.position[j]
                reach = radius + p.radius[j]
                distance2 = wp.dot(branch, branch)
                if distance2 < reach * reach:
                    distance = wp.sqrt(distance2)
                    normal = vec3(real(0.0), real(0.0), real(1.0))
                    if distance > real(0.0):
                        normal = branch / distance
                    overlap = reach - distance
                    inverse_radius = reach / (radius * p.radius[j])
                    arm_i = radius * distance / reach
                    arm_j = distance - arm_i
                    rolling = arm_i * spin + arm_j * p.spin[j]
                    half_rolling = arm_i * half_spin + arm_j * p.half_spin[j]
                    passing = half_v - p.half_velocity[j]
                    between = branch - real(0.5) * since * passing  # the branch at the half step
                    passing -= between * (wp.dot(passing, between) / wp.dot(between, between))
                    f, history, lost = contact(
                        case.particle_law,
                        inverse_radius,
                        inverse_mass + p.inverse_mass[j],
                        overlap,
                        normal,
                        v - p.velocity[j] - wp.cross(rolling, normal),
                        since * (passing - wp.cross(half_rolling, normal)),
                        real(0.5) * since * wp.dot(half_spin + p.half_spin[j], normal),
                        c.pair_history[k],
                        h,
                    )
                    moment = wp.cross(f, normal)
                    force += f
                    torque += arm_i * moment
                    p.force[j] -= f
                    p.torque[j] += arm_j * moment
                    c.pair_history[k] = history
                    losses += wp.vec4d(lost)
                    largest = wp.max(largest, overlap * inverse_radius)
                else:
                    history = c.pair_history[k]
                    if history[3] > real(0.0):
                        losses[3] += wp.float64(tangential_energy(case.particle_law, history))
                        c.pair_history[k] = vec4()
            p.force[i] += force
            p.torque[i] += torque
        return losses, largest

    @wp.func
    def pair_energy(case: Case, p: Particles, c: Contacts, offset: real):
        """Elastic energy (normal, tangential) [J] in the pair contacts, positions taken ``offset`` seconds back."""
        normal = wp.float64(0.0)
        tangential = wp.float64(0.0)
        for i in range(case.first, case.first + case.count):
            x = p.position[i] - offset * p.half_velocity[i]
            for k in range(c.start[i], c.start[i + 1]):
                j = c.partner[k]
                reach = p.radius[i] + p.radius[j]
                overlap = reach - wp.length(x - p.position[j] + offset * p.half_velocity[j])
                if overlap > real(0.0):
                    inverse_radius = reach / (p.radius[i] * p.radius[j])
                    normal += wp.float64(normal_energy(case.particle_law, inverse_radius, overlap))
                tangential += wp.float64(tangential_energy(case.particle_law, c.pair_history[k]))
        return normal, tangential

    return pair_forces, pair_energy
