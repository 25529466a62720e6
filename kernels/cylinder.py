"""Contacts between particles and the cylindrical cavity: side, floor and lid, each of them there or not.

A particle in an edge touches two walls, each with its own history.  A cavity without a lid is an open cup whose side
rises without end; floor and lid reach as far as the particles do.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .bounds import bounds
from .contact import contact_law
from .lanes import lanes, natural
from .particles import particles
from .shape import shape
from .structs import FLOOR, LID, SIDE, WALLS, types


@functools.cache
def wall_contacts(effects, count: int):
    """Return ``wall_forces``, ``wall_energy``, ``contained`` and ``wall_contact`` for the given effects.

    ``count`` contacts are computed side by side.
    """
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Losses, History, Impulses = t.Losses, t.History, t.Impulses
    Case, Particle, Contacts = t.Case, t.Particle, t.Contacts
    contact, parted, elastic_energy, remembered_energy = contact_law(effects)
    law_of = particles(effects).wall_law
    s = shape(effects)
    wall_near, wall_touch, wall_touch_back = s.wall_near, s.wall_touch, s.wall_touch_back
    wall_motion, wall_loads, with_place = s.wall_motion, s.wall_loads, s.with_place
    at_least = bounds(real).at_least
    side_by_side = lanes(effects, count)
    LANES, LOSSES, FIELDS = side_by_side.LANES, side_by_side.LOSSES, side_by_side.FIELDS
    Scalars, Vectors, Lost = side_by_side.Scalars, side_by_side.Vectors, side_by_side.Lost
    Fields, Kept = side_by_side.Fields, side_by_side.Kept
    to_fields, from_fields = side_by_side.to_fields, side_by_side.from_fields

    @wp.func
    def noted(case: Case, p: wp.array(dtype=Particle), c: Contacts, i: int, wall: int, last: int):
        """Note a wall if it touches, or did so a step ago; return the end of the notes."""
        c.touching_walls[last] = WALLS * i + wall
        return last + wall_near(case, p, c, i, wall)

    @wp.func
    def touching_walls(case: Case, p: wp.array(dtype=Particle), c: Contacts):
        """Note the places of the walls that touch, WALLS i + wall; return the first and the end."""
        first = natural(case.first)
        last = WALLS * first
        i = first
        while i < first + case.count:
            if wp.static(effects.side):
                last = noted(case, p, c, i, SIDE, last)
            if wp.static(effects.floor):
                last = noted(case, p, c, i, FLOOR, last)
            if wp.static(effects.lid):
                last = noted(case, p, c, i, LID, last)
            i += 1
        return WALLS * first, last

    @wp.func
    def wall_contact(case: Case, p: wp.array(dtype=Particle), c: Contacts, place: int, h: real, since: real):
        """Contact of a particle with a wall: force, torque, history, losses, overlap over R."""
        i = place / WALLS
        wall = place - WALLS * i
        old = History()
        if wp.static(effects.history):
            old = c.wall[place]
        touch = wall_touch(case, p, i, wall, old)
        law = law_of(case, p, c, i)
        f, rolling, history, lost = contact(
            law,
            touch.radius,
            touch.mass,
            touch.overlap,
            touch.normal,
            wall_motion(case, p, i, wall, touch, old, since),
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
        f, torque = wall_loads(touch, law, f, rolling)
        return f, torque, with_place(history, touch), lost, touch.overlap * touch.curvature

    @wp.func
    def add_wall(p: wp.array(dtype=Particle), c: Contacts, place: int, f: vec3, torque: vec3, history: History):
        """Add what a wall does to its particle, and keep the history."""
        i = place / WALLS
        p[i].force += f
        if wp.static(effects.rotation):
            p[i].torque += torque
        if wp.static(effects.history):
            c.wall[place] = history

    @wp.func
    def pressing(wall: int, f: vec3):
        """Normal forces on the walls of ``columns.IMPULSES`` of which ``wall`` does ``f`` to a particle [N]."""
        return Impulses(wp.where(wall == FLOOR, f[2], real(0.0)), wp.where(wall == LID, -f[2], real(0.0)))

    @wp.func
    def wall_forces(case: Case, p: wp.array(dtype=Particle), c: Contacts, h: real, since: real):
        """Add all wall forces and torques of a case.

        The step stands for ``h`` seconds, and comes ``since`` seconds after the last one.  Returns the force on the
        enclosure [N], the losses [J], the largest overlap over R, and the normal forces on walls [N].
        """
        reaction = vec3()
        losses = Losses()
        largest = real(0.0)
        pressed = Impulses()
        forces, torques = Vectors(), Vectors()
        depths, kept, lost = Scalars(), Kept(), Lost()
        first, last = touching_walls(case, p, c)
        m = first
        while m < last:
            for lane in range(LANES):
                place = natural(c.touching_walls[wp.min(m + lane, last - 1)])
                f, torque, history, loss, depth = wall_contact(case, p, c, place, h, since)
                forces[lane] = f
                torques[lane] = torque
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
                place = natural(c.touching_walls[m + lane])
                f = forces[lane]
                add_wall(p, c, place, f, torques[lane], from_fields(fields))
                reaction -= f
                pressed += pressing(place - WALLS * (place / WALLS), f)
                for channel in range(LOSSES):
                    losses[channel] += lost[channel, lane]
                largest = at_least(largest, depths[lane])
                lane += 1
            m += LANES
        return reaction, losses, largest, pressed

    @wp.func
    def single_energy(case: Case, p: wp.array(dtype=Particle), c: Contacts, i: int, wall: int, x: vec3, offset: real):
        """Elastic energy (normal, tangential, rolling) [J] of a particle with its centre at ``x`` and a wall."""
        stored = wp.vec3d()
        touch = wall_touch_back(case, p, i, wall, x, offset)
        if touch.overlap > real(0.0):
            stored[0] = wp.float64(elastic_energy(law_of(case, p, c, i), touch))
        if wp.static(effects.history):
            tangential, rolling = remembered_energy(law_of(case, p, c, i), c.wall[WALLS * i + wall])
            stored[1] = wp.float64(tangential)
            stored[2] = wp.float64(rolling)
        return stored

    @wp.func
    def wall_energy(case: Case, p: wp.array(dtype=Particle), c: Contacts, offset: real):
        """Elastic energy (normal, tangential, rolling) [J] of the walls, positions taken ``offset`` seconds back."""
        stored = wp.vec3d()
        for i in range(case.first, case.first + case.count):
            x = p[i].position - offset * p[i].half_velocity
            if wp.static(effects.side):
                stored += single_energy(case, p, c, i, SIDE, x, offset)
            if wp.static(effects.floor):
                stored += single_energy(case, p, c, i, FLOOR, x, offset)
            if wp.static(effects.lid):
                stored += single_energy(case, p, c, i, LID, x, offset)
        return stored

    @wp.func
    def contained(case: Case, p: wp.array(dtype=Particle)):
        """Whether every centre is on the inner side of every wall."""
        inside = wp.bool(True)
        for i in range(case.first, case.first + case.count):
            x = p[i].position
            if wp.static(effects.side):
                inside = inside and x[0] * x[0] + x[1] * x[1] <= case.radius * case.radius
            if wp.static(effects.floor):
                inside = inside and x[2] >= real(0.0)
            if wp.static(effects.lid):
                inside = inside and x[2] <= case.height
        return inside

    return SimpleNamespace(
        wall_forces=wall_forces, wall_energy=wall_energy, contained=contained, wall_contact=wall_contact
    )
