"""Contacts between particles and the cylindrical cavity: side, floor and lid, each of them there or not.

The walls stand still (the frame is the enclosure's) and are rigid bodies of their own material: R* = R, m* = m.
A particle in an edge touches two walls, each with its own history.  A cavity without a lid is an open cup whose side
rises without end; floor and lid reach as far as the particles do.
"""

import functools

import warp as wp

from .bounds import bounds
from .contact import contact_law
from .particles import particles
from .structs import FLOOR, LID, SIDE, WALLS, types


@functools.cache
def wall_contacts(effects):
    """Return ``wall_forces``, ``wall_energy`` and ``contained`` for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Losses, Motion, History = t.Losses, t.Motion, t.History
    Case, Particle, Contacts = t.Case, t.Particle, t.Contacts
    contact, parted, elastic_energy, remembered_energy = contact_law(effects)
    g = particles(effects)
    radius_of, inverse_mass_of, law_of = g.radius_of, g.inverse_mass_of, g.wall_law
    wall_curvature, at_least = g.wall_curvature, bounds(real).at_least

    @wp.func
    def side_gap(case: Case, x: vec3, radius: real):
        """Distance between the particle's surface and the side (negative: overlap) and the side's inward normal."""
        reach = case.radius - radius
        rho2 = x[0] * x[0] + x[1] * x[1]
        if rho2 <= reach * reach:
            return real(1.0), vec3()  # clear of the side: how far does not matter
        rho = wp.sqrt(rho2)
        return reach - rho, vec3(-x[0] / rho, -x[1] / rho, real(0.0))

    @wp.func
    def wall_motion(
        case: Case, p: wp.array(dtype=Particle), i: int, wall: int, radius: real, normal: vec3, arm: real, since: real
    ):
        """How i's surface moves past the wall; what the effects do not ask for stays zero."""
        motion = Motion()
        if wp.static(effects.dashpots):
            motion.velocity = p[i].velocity
            if wp.static(effects.rotation):
                motion.velocity -= arm * wp.cross(p[i].spin, normal)
        if wp.static(effects.friction):
            passing = p[i].half_velocity
            passing -= wp.dot(passing, normal) * normal
            if wall == SIDE:  # its normal turns as the particle goes round
                motion.tilted = -since / (case.radius - arm) * vec3(passing[0], passing[1], real(0.0))
            if wp.static(effects.rotation):
                passing -= arm * wp.cross(p[i].half_spin, normal)
                motion.turned = real(0.5) * since * wp.dot(p[i].half_spin, normal)
            motion.slid = since * passing
        if wp.static(effects.rolling):
            motion.rolled = since * radius * wp.cross(p[i].half_spin, normal)
            if wp.static(effects.dashpots):
                motion.rolling = radius * wp.cross(p[i].spin, normal)
        return motion

    @wp.func
    def wall_force(
        case: Case,
        p: wp.array(dtype=Particle),
        c: Contacts,
        i: int,
        wall: int,
        gap: real,
        normal: vec3,
        h: real,
        since: real,
    ):
        """Add what one wall does to one particle; return the force [N], the losses [J] and the overlap over R."""
        f = vec3()
        lost = Losses()
        depth = real(0.0)
        if gap < real(0.0):
            radius = radius_of(case, p, i)
            arm = radius + gap
            old = History()
            if wp.static(effects.history):
                old = c.wall[WALLS * i + wall]
            f, rolling, history, lost = contact(
                law_of(case, p, c, i),
                radius,
                real(1.0) / inverse_mass_of(case, p, i),
                -gap,
                normal,
                wall_motion(case, p, i, wall, radius, normal, arm, since),
                old,
                h,
            )
            p[i].force += f
            if wp.static(effects.rotation):
                p[i].torque += arm * wp.cross(f, normal) + radius * wp.cross(normal, rolling)
            if wp.static(effects.history):
                c.wall[WALLS * i + wall] = history
            depth = -gap * wall_curvature(case, p, i)
        elif wp.static(effects.history):
            if c.wall[WALLS * i + wall].radius > real(0.0):
                lost = parted(law_of(case, p, c, i), c.wall[WALLS * i + wall])
                c.wall[WALLS * i + wall] = History()
        return f, lost, depth

    @wp.func
    def wall_forces(case: Case, p: wp.array(dtype=Particle), c: Contacts, h: real, since: real):
        """Add all wall forces and torques of a case.

        The step stands for ``h`` seconds, and comes ``since`` seconds after the last one.  Returns the force on the
        enclosure [N], the losses [J], the largest overlap over R, and the normal forces on floor and lid [N].
        """
        reaction = vec3()
        losses = Losses()
        largest = real(0.0)
        on_floor = real(0.0)
        on_lid = real(0.0)
        for i in range(case.first, case.first + case.count):
            x = p[i].position
            radius = radius_of(case, p, i)
            if wp.static(effects.side):
                gap, normal = side_gap(case, x, radius)
                f, lost, depth = wall_force(case, p, c, i, SIDE, gap, normal, h, since)
                reaction -= f
                losses += lost
                largest = at_least(largest, depth)
            if wp.static(effects.floor):
                up = vec3(real(0.0), real(0.0), real(1.0))
                f, lost, depth = wall_force(case, p, c, i, FLOOR, x[2] - radius, up, h, since)
                reaction -= f
                on_floor += f[2]
                losses += lost
                largest = at_least(largest, depth)
            if wp.static(effects.lid):
                down = vec3(real(0.0), real(0.0), real(-1.0))
                f, lost, depth = wall_force(case, p, c, i, LID, case.height - x[2] - radius, down, h, since)
                reaction -= f
                on_lid -= f[2]
                losses += lost
                largest = at_least(largest, depth)
        return reaction, losses, largest, on_floor, on_lid

    @wp.func
    def single_energy(case: Case, p: wp.array(dtype=Particle), c: Contacts, i: int, wall: int, gap: real):
        """Elastic energy (normal, tangential, rolling) [J] of one particle and one wall."""
        stored = wp.vec3d()
        if gap < real(0.0):
            stored[0] = wp.float64(elastic_energy(law_of(case, p, c, i), radius_of(case, p, i), -gap))
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
            radius = radius_of(case, p, i)
            if wp.static(effects.side):
                gap, _normal = side_gap(case, x, radius)
                stored += single_energy(case, p, c, i, SIDE, gap)
            if wp.static(effects.floor):
                stored += single_energy(case, p, c, i, FLOOR, x[2] - radius)
            if wp.static(effects.lid):
                stored += single_energy(case, p, c, i, LID, case.height - x[2] - radius)
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

    return wall_forces, wall_energy, contained
