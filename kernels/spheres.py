"""Contact geometry of spheres: where two of them meet, or one and a wall of the cavity, and how their surfaces move.

This is all that ``pairs.py`` and ``cylinder.py`` ask of a shape: whether two bodies touch, their ``Touch``, and the
``Motion`` of one surface past the other.

The walls stand still (the frame is the enclosure's) and are rigid bodies of their own material: R* = R, m* = m.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .particles import particles
from .structs import FLOOR, LID, SIDE, types


@functools.cache
def spheres(effects):
    """Return the contact geometry of spheres for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Case, Particle, Touch, Motion = t.Case, t.Particle, t.Touch, t.Motion
    properties = particles(effects)
    radius_of, inverse_mass_of = properties.radius_of, properties.inverse_mass_of
    reduced_radius, reduced_mass, lever_arm = properties.reduced_radius, properties.reduced_mass, properties.lever_arm
    curvature, wall_curvature = properties.curvature, properties.wall_curvature

    @wp.func
    def pair_within(case: Case, p: wp.array(dtype=Particle), i: int, j: int, margin: real):
        """Whether the surfaces of two particles are nearer than ``margin``; with none: whether they overlap."""
        branch = p[i].position - p[j].position
        reach = radius_of(case, p, i) + radius_of(case, p, j) + margin
        return wp.dot(branch, branch) < reach * reach

    @wp.func
    def pair_touch(case: Case, p: wp.array(dtype=Particle), i: int, j: int, branch: vec3):
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
    def pair_motion(case: Case, p: wp.array(dtype=Particle), i: int, j: int, touch: Touch, since: real):
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
    def wall_touches(case: Case, p: wp.array(dtype=Particle), i: int, wall: int, x: vec3):
        """Whether a particle with its centre at ``x`` overlaps a wall."""
        radius = radius_of(case, p, i)
        reach = case.radius - radius
        touches = x[0] * x[0] + x[1] * x[1] > reach * reach
        if wall == FLOOR:
            touches = x[2] - radius < real(0.0)
        if wall == LID:
            touches = case.height - x[2] - radius < real(0.0)
        return touches

    @wp.func
    def wall_touch(case: Case, p: wp.array(dtype=Particle), i: int, wall: int, x: vec3):
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
    def wall_motion(case: Case, p: wp.array(dtype=Particle), i: int, wall: int, touch: Touch, since: real):
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

    return SimpleNamespace(
        pair_within=pair_within,
        pair_touch=pair_touch,
        pair_motion=pair_motion,
        wall_touches=wall_touches,
        wall_touch=wall_touch,
        wall_motion=wall_motion,
    )
