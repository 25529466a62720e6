"""Contacts between particles: geometry of two spheres, and the sum over the neighbour list."""

import functools

import warp as wp

from .contact import contact_law
from .data import types
from .grains import grains


@functools.cache
def pair_contacts(effects):
    """Return ``pair_forces`` and ``pair_energy`` for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Losses, Motion, History = t.Losses, t.Motion, t.History
    Case, Particles, Contacts = t.Case, t.Particles, t.Contacts
    contact, parted, elastic_energy, remembered_energy = contact_law(effects)
    g = grains(effects)
    radius_of, reduced_radius, reduced_mass = g.radius_of, g.reduced_radius, g.reduced_mass
    lever_arm, pair_law = g.lever_arm, g.pair_law

    @wp.func
    def pair_motion(
        case: Case, p: Particles, i: int, j: int, branch: vec3, distance: real, normal: vec3, arm: real, since: real
    ):
        """How i's surface moves past j's; what the effects do not ask for stays zero."""
        motion = Motion()
        if wp.static(effects.dashpots):
            motion.velocity = p.velocity[i] - p.velocity[j]
            if wp.static(effects.rotation):
                motion.velocity -= wp.cross(arm * p.spin[i] + (distance - arm) * p.spin[j], normal)
        if wp.static(effects.friction):
            # across the branch of the half step, as the two turn about each other
            passed = since * (p.half_velocity[i] - p.half_velocity[j])
            between = branch - real(0.5) * passed
            motion.slid = passed - wp.dot(passed, between) / (distance * distance) * between
            if wp.static(effects.rotation):
                motion.slid -= since * wp.cross(arm * p.half_spin[i] + (distance - arm) * p.half_spin[j], normal)
                motion.turned = real(0.5) * since * wp.dot(p.half_spin[i] + p.half_spin[j], normal)
        if wp.static(effects.rolling):
            radius = reduced_radius(case, p, i, j)
            motion.rolled = since * radius * wp.cross(p.half_spin[i] - p.half_spin[j], normal)
            if wp.static(effects.dashpots):
                motion.rolling = radius * wp.cross(p.spin[i] - p.spin[j], normal)
        return motion

    @wp.func
    def pair_history(c: Contacts, k: int):
        """What the pair's contact remembers."""
        old = History()
        if wp.static(effects.history):
            old.radius = c.pair_radius[k]
        if wp.static(effects.friction):
            old.stretch = c.pair_stretch[k]
        if wp.static(effects.rolling):
            old.roll = c.pair_roll[k]
        return old

    @wp.func
    def remember(c: Contacts, k: int, history: History):
        """Store what the pair's contact remembers."""
        if wp.static(effects.history):
            c.pair_radius[k] = history.radius
        if wp.static(effects.friction):
            c.pair_stretch[k] = history.stretch
        if wp.static(effects.rolling):
            c.pair_roll[k] = history.roll

    @wp.func
    def pair_forces(case: Case, p: Particles, c: Contacts, h: real, since: real):
        """Add all pair forces and torques of a case; return its losses [J] and its largest overlap over R*.

        The step stands for ``h`` seconds, and comes ``since`` seconds after the last one.

        The lever arms share the distance of the centres in the ratio of the radii, so that angular momentum is kept
        to round-off.  Non-touching pairs add nothing: sums do not depend on how long ago the list was made.
        """
        losses = Losses()
        largest = real(0.0)
        for i in range(case.first, case.first + case.count):
            x = p.position[i]
            force = vec3()
            torque = vec3()
            for k in range(c.start[i], c.start[i + 1]):
                j = c.partner[k]
                branch = x - p.position[j]
                reach = radius_of(case, p, i) + radius_of(case, p, j)
                distance2 = wp.dot(branch, branch)
                if distance2 < reach * reach:
                    distance = wp.sqrt(distance2)
                    normal = vec3(real(0.0), real(0.0), real(1.0))
                    if distance > real(0.0):
                        normal = (real(1.0) / distance) * branch
                    arm = lever_arm(case, p, i, j, distance)
                    radius = reduced_radius(case, p, i, j)
                    f, rolling, history, lost = contact(
                        pair_law(case, p, i, j),
                        radius,
                        reduced_mass(case, p, i, j),
                        reach - distance,
                        normal,
                        pair_motion(case, p, i, j, branch, distance, normal, arm, since),
                        pair_history(c, k),
                        h,
                    )
                    force += f
                    p.force[j] -= f
                    if wp.static(effects.rotation):
                        moment = wp.cross(f, normal)
                        resisting = radius * wp.cross(normal, rolling)
                        torque += arm * moment + resisting
                        p.torque[j] += (distance - arm) * moment - resisting
                    remember(c, k, history)
                    losses += lost
                    largest = wp.max(largest, (reach - distance) / radius)
                elif wp.static(effects.history):
                    if c.pair_radius[k] > real(0.0):
                        losses += parted(pair_law(case, p, i, j), pair_history(c, k))
                        remember(c, k, History())
            p.force[i] += force
            if wp.static(effects.rotation):
                p.torque[i] += torque
        return losses, largest

    @wp.func
    def pair_energy(case: Case, p: Particles, c: Contacts, offset: real):
        """Elastic energy (normal, tangential, rolling) [J] of the pairs, positions taken ``offset`` seconds back."""
        stored = wp.vec3d()
        for i in range(case.first, case.first + case.count):
            x = p.position[i] - offset * p.half_velocity[i]
            for k in range(c.start[i], c.start[i + 1]):
                j = c.partner[k]
                reach = radius_of(case, p, i) + radius_of(case, p, j)
                overlap = reach - wp.length(x - p.position[j] + offset * p.half_velocity[j])
                if overlap > real(0.0):
                    radius = reduced_radius(case, p, i, j)
                    stored[0] += wp.float64(elastic_energy(pair_law(case, p, i, j), radius, overlap))
                if wp.static(effects.history):
                    tangential, rolling = remembered_energy(pair_law(case, p, i, j), pair_history(c, k))
                    stored[1] += wp.float64(tangential)
                    stored[2] += wp.float64(rolling)
        return stored

    return pair_forces, pair_energy
