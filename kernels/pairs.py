"""Contacts between particles: the law at one of them, and the sums over the neighbour list."""

import functools
from types import SimpleNamespace

import warp as wp

from .bounds import bounds
from .contact import contact_law
from .lanes import lanes, natural
from .particles import particles
from .shape import shape
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
    s = shape(effects)
    pair_near, pair_touch, pair_touch_back = s.pair_near, s.pair_touch, s.pair_touch_back
    pair_motion, pair_loads, with_place = s.pair_motion, s.pair_loads, s.with_place
    at_least = bounds(real).at_least
    side_by_side = lanes(effects, count)
    LANES, LOSSES, FIELDS = side_by_side.LANES, side_by_side.LOSSES, side_by_side.FIELDS
    Scalars, Vectors, Lost = side_by_side.Scalars, side_by_side.Vectors, side_by_side.Lost
    Fields, Kept = side_by_side.Fields, side_by_side.Kept
    to_fields, from_fields = side_by_side.to_fields, side_by_side.from_fields

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
            last += pair_near(case, p, c, k, margin)
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
            last += pair_near(case, p, c, k, real(0.0))
            m += 1
        return first, last

    @wp.func
    def pair_contact(case: Case, p: wp.array(dtype=Particle), c: Contacts, k: int, h: real, since: real):
        """Forces of the pair at place k of the list on its particles; a pair that has parted loses its stored energy.

        Returns the force on i, the torques on i and j, the history, the losses and the overlap over R*.
        """
        i = natural(c.owner[k])
        j = natural(c.partner[k])
        old = History()
        if wp.static(effects.history):
            old = c.pair[k]
        touch = pair_touch(case, p, i, j, old)
        law = law_of(case, p, c, i, j)
        f, rolling, history, lost = contact(
            law,
            touch.radius,
            touch.mass,
            touch.overlap,
            touch.normal,
            pair_motion(case, p, i, j, touch, old, since),
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
        f, on_i, on_j = pair_loads(touch, law, f, rolling)
        return f, on_i, on_j, with_place(history, touch), lost, touch.overlap * touch.curvature

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
        forces, torques_i, torques_j = Vectors(), Vectors(), Vectors()
        depths, kept, lost = Scalars(), Kept(), Lost()
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
                    fields = to_fields(history)
                    for field in range(FIELDS):
                        kept[field, lane] = fields[field]
            used = wp.min(LANES, last - m)
            lane = wp.int32(0)
            while lane < used:
                fields = Fields()
                for field in range(FIELDS):
                    fields[field] = kept[field, lane]
                k = natural(c.touching[m + lane])
                add_pair(p, c, k, forces[lane], torques_i[lane], torques_j[lane], from_fields(fields))
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
                touch = pair_touch_back(case, p, i, j, x, offset)
                if touch.overlap > real(0.0):
                    stored[0] += wp.float64(elastic_energy(law_of(case, p, c, i, j), touch))
                if wp.static(effects.history):
                    tangential, rolling = remembered_energy(law_of(case, p, c, i, j), c.pair[k])
                    stored[1] += wp.float64(tangential)
                    stored[2] += wp.float64(rolling)
        return stored

    return SimpleNamespace(
        nearby_pairs=nearby_pairs, pair_forces=pair_forces, pair_energy=pair_energy, pair_contact=pair_contact
    )
