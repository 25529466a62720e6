"""Contacts between particles: the law at one of them, and the sums over the neighbour list."""

import functools

import warp as wp

from .bounds import bounds
from .contact import contact_law
from .lanes import lanes, natural
from .particles import particles
from .spheres import spheres
from .structs import types


@functools.cache
def pair_contacts(effects, count: int):
    """Return ``nearby_pairs``, ``pair_forces``, ``pair_energy``, ``pair_contact``, ``count`` contacts side by side."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Losses, History = t.Losses, t.History
    Case, Particle, Contacts = t.Case, t.Particle, t.Contacts
    contact, parted, elastic_energy, remembered_energy = contact_law(effects)
    law_of = particles(effects).pair_law
    shape = spheres(effects)
    pair_within, pair_touch, pair_motion = shape.pair_within, shape.pair_touch, shape.pair_motion
    at_least = bounds(real).at_least
    side_by_side = lanes(effects, count)
    LANES, LOSSES = side_by_side.LANES, side_by_side.LOSSES
    Scalars, Vectors, Lost = side_by_side.Scalars, side_by_side.Vectors, side_by_side.Lost

    @wp.func
    def is_near(case: Case, p: wp.array(dtype=Particle), c: Contacts, k: int, margin: real):
        """1 if the pair at place k of the list is nearer than ``margin``, or touched a step ago; else 0: no branch."""
        near = wp.where(pair_within(case, p, natural(c.owner[k]), natural(c.partner[k]), margin), 1, 0)
        if wp.static(effects.history):
            near |= wp.where(c.pair[k].radius > real(0.0), 1, 0)
        return near

    @wp.func
    def nearby_pairs(case: Case, p: wp.array(dtype=Particle), c: Contacts, margin: real):
        """Note the places of the pairs nearer than ``margin``; return the end of the notes.

        No other can touch before two particles have gone half as far each.
        """
        first = natural(c.start[case.first])
        end = c.start[case.first + case.count]
        last = first
        k = first
        while k < end:  # half the instructions of a range
            c.nearby[last] = k
            last += is_near(case, p, c, k, margin)
            k += 1
        return last

    @wp.func
    def touching_pairs(case: Case, p: wp.array(dtype=Particle), c: Contacts, end: int):
        """Note the places of the pairs that touch, or did so a step ago; return the first and the end of the notes."""
        first = natural(c.start[case.first])
        last = first
        m = first
        while m < end:
            k = natural(c.nearby[m])
            c.touching[last] = k
            last += is_near(case, p, c, k, real(0.0))
            m += 1
        return first, last

    @wp.func
    def pair_contact(case: Case, p: wp.array(dtype=Particle), c: Contacts, k: int, h: real, since: real):
        """Forces of the pair at place k of the list on its particles; a pair that has parted loses its stored energy.

        Returns the force on i, the torques on i and j, the history, the losses and the overlap over R*.
        """
        i = natural(c.owner[k])
        j = natural(c.partner[k])
        touch = pair_touch(case, p, i, j, p[i].position - p[j].position)
        law = law_of(case, p, c, i, j)
        old = History()
        if wp.static(effects.history):
            old = c.pair[k]
        f, rolling, history, lost = contact(
            law,
            touch.radius,
            touch.mass,
            touch.overlap,
            touch.normal,
            pair_motion(case, p, i, j, touch, since),
            old,
            h,
        )
        if touch.overlap <= real(0.0):
            f = vec3()
            rolling = vec3()
            history = History()
            lost = Losses()
            if wp.static(effects.history):
                lost = parted(law, old)
        moment = wp.cross(f, touch.normal)
        resisting = touch.radius * wp.cross(touch.normal, rolling)
        on_i = touch.arm_i * moment + resisting
        on_j = touch.arm_j * moment - resisting
        return f, on_i, on_j, history, lost, touch.overlap * touch.curvature

    @wp.func
    def add_pair(p: wp.array(dtype=Particle), c: Contacts, k: int, f: vec3, on_i: vec3, on_j: vec3, history: History):
        """Add a pair's forces and torques to its particles, and keep its history."""
        i = natural(c.owner[k])
        j = natural(c.partner[k])
        p[i].force += f
        p[j].force -= f
        if wp.static(effects.rotation):
            p[i].torque += on_i
            p[j].torque += on_j
        if wp.static(effects.history):
            c.pair[k] = history

    @wp.func
    def pair_forces(case: Case, p: wp.array(dtype=Particle), c: Contacts, end: int, h: real, since: real):
        """Add all pair forces and torques of a case; return its losses [J] and its largest overlap over R*.

        ``end`` is that of the nearby pairs.  The step stands for ``h`` seconds, and comes ``since`` seconds after the
        last one.  Sums run over the pairs that touch, in the order of the list: they do not depend on how long ago it
        was made.
        """
        losses = Losses()
        largest = real(0.0)
        forces, torques_i, torques_j, stretches, rolls = Vectors(), Vectors(), Vectors(), Vectors(), Vectors()
        radii, depths, lost = Scalars(), Scalars(), Lost()
        first, last = touching_pairs(case, p, c, end)
        m = first
        while m < last:
            for lane in range(LANES):
                k = natural(c.touching[wp.min(m + lane, last - 1)])
                f, on_i, on_j, history, loss, depth = pair_contact(case, p, c, k, h, since)
                forces[lane] = f
                torques_i[lane] = on_i
                torques_j[lane] = on_j
                for channel in range(LOSSES):
                    lost[channel, lane] = loss[channel]
                depths[lane] = depth
                if wp.static(effects.history):
                    radii[lane] = history.radius
                if wp.static(effects.friction):
                    stretches[lane] = history.stretch
                if wp.static(effects.rolling):
                    rolls[lane] = history.roll
            used = wp.min(LANES, last - m)
            lane = wp.int32(0)
            while lane < used:
                history = History()
                if wp.static(effects.history):
                    history.radius = radii[lane]
                if wp.static(effects.friction):
                    history.stretch = stretches[lane]
                if wp.static(effects.rolling):
                    history.roll = rolls[lane]
                k = natural(c.touching[m + lane])
                add_pair(p, c, k, forces[lane], torques_i[lane], torques_j[lane], history)
                for channel in range(LOSSES):
                    losses[channel] += lost[channel, lane]
                largest = at_least(largest, depths[lane])
                lane += 1
            m += LANES
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
                    stored[0] += wp.float64(elastic_energy(law_of(case, p, c, i, j), touch))
                if wp.static(effects.history):
                    tangential, rolling = remembered_energy(law_of(case, p, c, i, j), c.pair[k])
                    stored[1] += wp.float64(tangential)
                    stored[2] += wp.float64(rolling)
        return stored

    return nearby_pairs, pair_forces, pair_energy, pair_contact
