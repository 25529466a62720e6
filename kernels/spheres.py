"""Spheres: where two of them meet, or one and a wall of the cavity, how their surfaces move, and how they turn.

``shape.py`` says what each function is for.

The walls stand still (the frame is the enclosure's) and are rigid bodies of their own material: R* = R, m* = m.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .lanes import natural
from .particles import particles
from .structs import FLOOR, LID, SIDE, WALLS, types


@functools.cache
def spheres(effects):
    """Return the geometry and the rotation of spheres for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Case, Particle, Contacts, History = t.Case, t.Particle, t.Contacts, t.History
    Law, Touch, Motion = t.Law, t.Touch, t.Motion
    properties = particles(effects)
    radius_of, inverse_mass_of = properties.radius_of, properties.inverse_mass_of
    inverse_inertia_of = properties.inverse_inertia_of
    reduced_radius, reduced_mass, lever_arm = properties.reduced_radius, properties.reduced_mass, properties.lever_arm
    curvature, wall_curvature = properties.curvature, properties.wall_curvature

    @wp.func
    def pair_within(case: Case, p: wp.array(dtype=Particle), i: int, j: int, margin: real):
        """Whether the surfaces of two particles are nearer than ``margin``; with none: whether they overlap."""
        branch = p[i].position - p[j].position
        reach = radius_of(case, p, i) + radius_of(case, p, j) + margin
        return wp.dot(branch, branch) < reach * reach

    @wp.func
    def pair_listed(case: Case, p: wp.array(dtype=Particle), i: int, j: int):
        return pair_within(case, p, i, j, case.skin)

    @wp.func
    def pair_near(case: Case, p: wp.array(dtype=Particle), c: Contacts, k: int, margin: real):
        """1 if the pair at place k of the list is nearer than ``margin``, or touched a step ago; else 0: no branch."""
        near = wp.where(pair_within(case, p, natural(c.owner[k]), natural(c.partner[k]), margin), 1, 0)
        if wp.static(effects.history):
            near |= wp.where(c.pair[k].radius > real(0.0), 1, 0)
        return near

    @wp.func
    def touch_along(case: Case, p: wp.array(dtype=Particle), i: int, j: int, branch: vec3):
        """Where two particles meet; ``branch`` is the vector from j's centre to i's.

        The lever arms share the distance of the centres in the ratio of the radii, so that angular momentum is kept to
        round-off.
        """
        touch = Touch()
        touch.distance = wp.length(branch)
        touch.normal = (real(1.0) / touch.distance) * branch
        touch.arm_i = lever_arm(case, p, i, j, touch.distance)
        touch.radius = reduced_radius(case, p, i, j)
        touch.mass = reduced_mass(case, p, i, j)
        touch.overlap = radius_of(case, p, i) + radius_of(case, p, j) - touch.distance
        touch.arm_j = touch.distance - touch.arm_i
        touch.curvature = curvature(case, p, i, j)
        return touch

    @wp.func
    def pair_touch(case: Case, p: wp.array(dtype=Particle), i: int, j: int, _old: History):
        return touch_along(case, p, i, j, p[i].position - p[j].position)

    @wp.func
    def pair_touch_back(case: Case, p: wp.array(dtype=Particle), i: int, j: int, x: vec3, offset: real):
        """Where two particles met ``offset`` seconds back, i's centre at ``x``."""
        return touch_along(case, p, i, j, x - p[j].position + offset * p[j].half_velocity)

    @wp.func
    def pair_motion(case: Case, p: wp.array(dtype=Particle), i: int, j: int, touch: Touch, _old: History, since: real):
        """How i's surface moves past j's; what the effects do not ask for stays zero."""
        motion = Motion()
        if wp.static(effects.dashpots):
            motion.velocity = p[i].velocity - p[j].velocity
            if wp.static(effects.rotation):
                motion.velocity -= wp.cross(touch.arm_i * p[i].spin + touch.arm_j * p[j].spin, touch.normal)
        if wp.static(effects.friction):
            # across the branch of the half step, as the two turn about each other
            passed = since / touch.distance * (p[i].half_velocity - p[j].half_velocity)
            between = touch.normal - real(0.5) * passed
            motion.tilted = passed - wp.dot(passed, between) * between
            motion.slid = touch.distance * motion.tilted
            if wp.static(effects.rotation):
                turning = touch.arm_i * p[i].half_spin + touch.arm_j * p[j].half_spin
                motion.slid -= since * wp.cross(turning, touch.normal)
                motion.turned = real(0.5) * since * wp.dot(p[i].half_spin + p[j].half_spin, touch.normal)
        if wp.static(effects.rolling):
            motion.rolled = since * touch.radius * wp.cross(p[i].half_spin - p[j].half_spin, touch.normal)
            if wp.static(effects.dashpots):
                motion.rolling = touch.radius * wp.cross(p[i].spin - p[j].spin, touch.normal)
        return motion

    @wp.func
    def pair_loads(touch: Touch, _law: Law, f: vec3, rolling: vec3):
        """Force on i and torques on i and j of a contact's force and rolling force."""
        moment = wp.cross(f, touch.normal)
        resisting = touch.radius * wp.cross(touch.normal, rolling)
        return f, touch.arm_i * moment + resisting, touch.arm_j * moment - resisting

    @wp.func
    def wall_near(case: Case, p: wp.array(dtype=Particle), c: Contacts, i: int, wall: int):
        """1 if a particle touches a wall, or did so a step ago; else 0: no branch."""
        radius = radius_of(case, p, i)
        x = p[i].position
        reach = case.radius - radius
        touches = x[0] * x[0] + x[1] * x[1] > reach * reach
        if wall == FLOOR:
            touches = x[2] - radius < real(0.0)
        if wall == LID:
            touches = case.height - x[2] - radius < real(0.0)
        near = wp.where(touches, 1, 0)
        if wp.static(effects.history):
            near |= wp.where(c.wall[WALLS * i + wall].radius > real(0.0), 1, 0)
        return near

    @wp.func
    def wall_touch_at(case: Case, p: wp.array(dtype=Particle), i: int, wall: int, x: vec3):
        """Where a particle with its centre at ``x`` meets a wall."""
        radius = radius_of(case, p, i)
        rho = wp.sqrt(x[0] * x[0] + x[1] * x[1])
        gap = case.radius - radius - rho
        normal = vec3(-x[0] / rho, -x[1] / rho, real(0.0))
        if wall == FLOOR:
            gap = x[2] - radius
            normal = vec3(real(0.0), real(0.0), real(1.0))
        if wall == LID:
            gap = case.height - x[2] - radius
            normal = vec3(real(0.0), real(0.0), real(-1.0))
        touch = Touch()
        touch.distance = radius + gap
        touch.normal = normal
        touch.overlap = -gap
        touch.arm_i = touch.distance
        touch.radius = radius
        touch.curvature = wall_curvature(case, p, i)
        touch.mass = real(1.0) / inverse_mass_of(case, p, i)
        return touch

    @wp.func
    def wall_touch(case: Case, p: wp.array(dtype=Particle), i: int, wall: int, _old: History):
        return wall_touch_at(case, p, i, wall, p[i].position)

    @wp.func
    def wall_touch_back(case: Case, p: wp.array(dtype=Particle), i: int, wall: int, x: vec3, _offset: real):
        """Where a particle met a wall ``offset`` seconds back, its centre at ``x``."""
        return wall_touch_at(case, p, i, wall, x)

    @wp.func
    def wall_motion(
        case: Case, p: wp.array(dtype=Particle), i: int, wall: int, touch: Touch, _old: History, since: real
    ):
        """How i's surface moves past the wall; what the effects do not ask for stays zero."""
        motion = Motion()
        if wp.static(effects.dashpots):
            motion.velocity = p[i].velocity
            if wp.static(effects.rotation):
                motion.velocity -= touch.arm_i * wp.cross(p[i].spin, touch.normal)
        if wp.static(effects.friction):
            passing = p[i].half_velocity
            passing -= wp.dot(passing, touch.normal) * touch.normal
            if wall == SIDE:  # its normal turns as the particle goes round
                motion.tilted = -since / (case.radius - touch.arm_i) * vec3(passing[0], passing[1], real(0.0))
            if wp.static(effects.rotation):
                passing -= touch.arm_i * wp.cross(p[i].half_spin, touch.normal)
                motion.turned = real(0.5) * since * wp.dot(p[i].half_spin, touch.normal)
            motion.slid = since * passing
        if wp.static(effects.rolling):
            motion.rolled = since * touch.radius * wp.cross(p[i].half_spin, touch.normal)
            if wp.static(effects.dashpots):
                motion.rolling = touch.radius * wp.cross(p[i].spin, touch.normal)
        return motion

    @wp.func
    def wall_loads(touch: Touch, _law: Law, f: vec3, rolling: vec3):
        """Force and torque on a particle of its contact's force and rolling force."""
        return f, touch.arm_i * wp.cross(f, touch.normal) + touch.radius * wp.cross(touch.normal, rolling)

    @wp.func
    def with_place(history: History, _touch: Touch):
        return history

    @wp.func
    def turn(case: Case, p: wp.array(dtype=Particle), i: int, h: real):
        """Kick a particle's spin over ``h``, predict the next, and clear the torque."""
        turning = inverse_inertia_of(case, p, i) * p[i].torque
        spin = p[i].half_spin + h * turning
        p[i].half_spin = spin
        p[i].torque = vec3()
        if wp.static(effects.dashpots):
            p[i].spin = spin + real(0.5) * case.dt * turning

    @wp.func
    def kick_spin(case: Case, p: wp.array(dtype=Particle), i: int, h: real):
        """Bring a particle's spin from the half step before to the whole step."""
        p[i].half_spin = p[i].half_spin + h * inverse_inertia_of(case, p, i) * p[i].torque

    @wp.func
    def rotational_energy(case: Case, p: wp.array(dtype=Particle), i: int):
        """Energy of a particle's rotation at the half step [J]."""
        spin = p[i].half_spin
        return real(0.5) * wp.dot(spin, spin) / inverse_inertia_of(case, p, i)

    @wp.func
    def pace2(_case: Case, _p: wp.array(dtype=Particle), _i: int, velocity: vec3):
        """Square of how fast a particle's surface may approach another's [m^2/s^2]."""
        return wp.dot(velocity, velocity)

    return SimpleNamespace(
        reach_of=radius_of,
        pair_listed=pair_listed,
        pair_near=pair_near,
        pair_touch=pair_touch,
        pair_touch_back=pair_touch_back,
        pair_motion=pair_motion,
        pair_loads=pair_loads,
        wall_near=wall_near,
        wall_touch=wall_touch,
        wall_touch_back=wall_touch_back,
        wall_motion=wall_motion,
        wall_loads=wall_loads,
        with_place=with_place,
        turn=turn,
        kick_spin=kick_spin,
        rotational_energy=rotational_energy,
        pace2=pace2,
    )
