"""Contacts between particles: the law at one of them, and the sums over the neighbour list."""

import functools

import warp as wp

from .bounds import bounds
from .contact import contact_law
from .particles import particles
from .spheres import spheres
from .structs import types


@functools.cache
def pair_contacts(effects):
    """Return ``pair_forces`` and ``pair_energy`` for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Losses, History = t.Losses, t.History
    Case, Particle, Contacts = t.Case, t.Particle, t.Contacts
    contact, parted, elastic_energy, remembered_energy = contact_law(effects)
    law_of = particles(effects).pair_law
    shape = spheres(effects)
    pair_touches, pair_touch, pair_motion = shape.pair_touches, shape.pair_touch, shape.pair_motion
    at_least = bounds(real).at_least

    @wp.func
    def pair_contact(
        case: Case, p: wp.array(dtype=Particle), c: Contacts, i: int, j: int, k: int, branch: vec3, h: real, since: real
    ):
        """Forces of a touching pair on its particles; k is its place in the list.

        Returns the force on i, the torques on i and j, the history, the losses and the overlap over R*.
        """
        touch = pair_touch(case, p, i, j, branch)
        old = History()
        if wp.static(effects.history):
            old = c.pair[k]
        f, rolling, history, lost = contact(
            law_of(case, p, c, i, j),
            touch.radius,
            touch.mass,
            touch.overlap,
            touch.normal,
            pair_motion(case, p, i, j, touch, since),
            old,
            h,
        )
        moment = wp.cross(f, touch.normal)
        resisting = touch.radius * wp.cross(touch.normal, rolling)
        on_i = touch.arm_i * moment + resisting
        on_j = touch.arm_j * moment - resisting
        return f, on_i, on_j, history, lost, touch.overlap * touch.curvature

    @wp.func
    def pair_forces(case: Case, p: wp.array(dtype=Particle), c: Contacts, h: real, since: real):
        """Add all pair forces and torques of a case; return its losses [J] and its largest overlap over R*.

        The step stands for ``h`` seconds, and comes ``since`` seconds after the last one.  Pairs that do not touch add
        nothing: sums do not depend on how long ago the list was made.
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
                if pair_touches(case, p, i, j, branch):
                    f, on_i, on_j, history, lost, depth = pair_contact(case, p, c, i, j, k, branch, h, since)
                    force += f
                    p[j].force -= f
                    if wp.static(effects.rotation):
                        torque += on_i
                        p[j].torque += on_j
                    if wp.static(effects.history):
                        c.pair[k] = history
                    losses += lost
                    largest = at_least(largest, depth)
                elif wp.static(effects.history):
                    if c.pair[k].radius > real(0.0):
                        losses += parted(law_of(case, p, c, i, j), c.pair[k])
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
                touch = pair_touch(case, p, i, j, x - p[j].position + offset * p[j].half_velocity)
                if touch.overlap > real(0.0):
                    stored[0] += wp.float64(elastic_energy(law_of(case, p, c, i, j), touch.radius, touch.overlap))
                if wp.static(effects.history):
                    tangential, rolling = remembered_energy(law_of(case, p, c, i, j), c.pair[k])
                    stored[1] += wp.float64(tangential)
                    stored[2] += wp.float64(rolling)
        return stored

    return pair_forces, pair_energy
