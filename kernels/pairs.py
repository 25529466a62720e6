"""Contacts between particles: geometry of two spheres, and the sum over the neighbour list."""

import functools

import warp as wp

from .bounds import bounds
from .contact import contact_law
from .data import types
from .grains import grains


@functools.cache
def pair_contacts(effects):
    """Return ``pair_forces`` and ``pair_energy`` for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Losses, Motion, History = t.Losses, t.Motion, t.History
    Case, Particle, Contacts = t.Case, t.Particle, t.Contacts
    contact, parted, elastic_energy, remembered_energy = contact_law(effects)
    g = grains(effects)
    radius_of, reduced_radius, reduced_mass = g.radius_of, g.reduced_radius, g.reduced_mass
    lever_arm, pair_law, curvature = g.lever_arm, g.pair_law, g.curvature
    at_least = bounds(real).at_least

    @wp.func
    def pair_motion(
        case: Case,
        p: wp.array(dtype=Particle),
        i: int,
        j: int,
        distance: real,
        normal: vec3,
        arm: real,
        since: real,
    ):
        """How i's surface moves past j's; what the effects do not ask for stays zero."""
        motion = Motion()
        if wp.static(effects.dashpots):
            motion.velocity = p[i].velocity - p[j].velocity
            if wp.static(effects.rotation):
                motion.velocity -= wp.cross(arm * p[i].spin + (distance - arm) * p[j].spin, normal)
        if wp.static(effects.friction):
            # across the branch of the half step, as the two turn about each other
            passed = since / distance * (p[i].half_velocity - p[j].half_velocity)
            between = normal - real(0.5) * passed
            motion.tilted = passed - wp.dot(passed, between) * between
            motion.slid = distance * motion.tilted
            if wp.static(effects.rotation):
                motion.slid -= since * wp.cross(arm * p[i].half_spin + (distance - arm) * p[j].half_spin, normal)
                motion.turned = real(0.5) * since * wp.dot(p[i].half_spin + p[j].half_spin, normal)
        if wp.static(effects.rolling):
            radius = reduced_radius(case, p, i, j)
            motion.rolled = since * radius * wp.cross(p[i].half_spin - p[j].half_spin, normal)
            if wp.static(effects.dashpots):
                motion.rolling = radius * wp.cross(p[i].spin - p[j].spin, normal)
        return motion

    @wp.func
    def pair_forces(case: Case, p: wp.array(dtype=Particle), c: Contacts, h: real, since: real):
        """Add all pair forces and torques of a case; return its losses [J] and its largest overlap over R*.

        The step stands for ``h`` seconds, and comes ``since`` seconds after the last one.

        The lever arms share the distance of the centres in the ratio of the radii, so that angular momentum is kept
        to round-off.  Non-touching pairs add nothing: sums do not depend on how long ago the list was made.
        """
        losses = Losses()
        largest = real(0.0)
        for i in range(case.first, case.first + case.count):
            x = p[i].position
            force = vec3()
            torque = vec3()
            for k in range(c.start[i], c.start[i + 1]):
                j = c.partner[k]
                branch = x - p[j].position
                reach = radius_of(case, p, i) + radius_of(case, p, j)
                distance2 = wp.dot(branch, branch)
                if distance2 < reach * reach:
                    distance = wp.sqrt(distance2)
                    normal = (real(1.0) / distance) * branch
                    arm = lever_arm(case, p, i, j, distance)
                    radius = reduced_radius(case, p, i, j)
                    old = History()
                    if wp.static(effects.history):
                        old = c.pair[k]
                    f, rolling, history, lost = contact(
                        pair_law(case, p, c, i, j),
                        radius,
                        reduced_mass(case, p, i, j),
                        reach - distance,
                        normal,
                        pair_motion(case, p, i, j, distance, normal, arm, since),
                        old,
                        h,
                    )
                    force += f
                    p[j].force -= f
                    if wp.static(effects.rotation):
                        moment = wp.cross(f, normal)
                        resisting = radius * wp.cross(normal, rolling)
                        torque += arm * moment + resisting
                        p[j].torque += (distance - arm) * moment - resisting
                    if wp.static(effects.history):
                        c.pair[k] = history
                    losses += lost
                    largest = at_least(largest, (reach - distance) * curvature(case, p, i, j))
                elif wp.static(effects.history):
                    if c.pair[k].radius > real(0.0):
                        losses += parted(pair_law(case, p, c, i, j), c.pair[k])
                        c.pair[k] = History()
            p[i].force += force
            if wp.static(effects.rotation):
                p[i].torque += torque
        return losses, largest

    @wp.func
    def pair_energy(case: Case, p: wp.array(dtype=Particle), c: Contacts, offset: real):
        """Elastic energy (normal, tangential, rolling) [J] of the pairs, positions taken ``offset`` seconds back."""
        stored = wp.vec3d()
        for i in range(case.first, case.first + case.count):
            x = p[i].position - offset * p[i].half_velocity
            for k in range(c.start[i], c.start[i + 1]):
                j = c.partner[k]
                reach = radius_of(case, p, i) + radius_of(case, p, j)
                overlap = reach - wp.length(x - p[j].position + offset * p[j].half_velocity)
                if overlap > real(0.0):
                    radius = reduced_radius(case, p, i, j)
                    stored[0] += wp.float64(elastic_energy(pair_law(case, p, c, i, j), radius, overlap))
                if wp.static(effects.history):
                    tangential, rolling = remembered_energy(pair_law(case, p, c, i, j), c.pair[k])
                    stored[1] += wp.float64(tangential)
                    stored[2] += wp.float64(rolling)
        return stored

    return pair_forces, pair_energy
