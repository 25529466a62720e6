"""Spheroids: where two of them meet, or one and a wall of the cavity, and how their surfaces move.

``shape.py`` says what each function is for, ``support.py`` how normals are found, ``elliptic.py`` what is elastic.

A pair that does not touch remembers a normal that keeps the two apart: a gap along it proves that they do, and only
where there is none is the common normal looked for, from a first guess that depends on nothing but how the two lie.  A
pair that touches goes on from its normal of the step before.  So no result depends on when a list was made.

With the contact at r_i from i's centre and r_j from j's, in the middle of the overlap (shared in the ratio of the radii
of the spheres of their volumes), k = r x n its lever and I_t the moment of inertia across the axis, the mass that the
common normal feels is

    1 / m* = 1 / m_i + 1 / m_j + |k_i|^2 / I_t,i + |k_j|^2 / I_t,j,     |k| = |e c| sqrt(1 - c^2) / h

so that an impact off centre returns the restitution asked for, too.

Surfaces slide by the way that they went since the last step, with velocities and arms of the half step between: with
those of the whole step, spinning particles would be out of balance to first order.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .contact import contact_law
from .elliptic import elliptic
from .lanes import natural
from .particles import particles
from .structs import FLOOR, LID, SIDE, WALLS, types
from .support import support
from .tops import tops


@functools.cache
def spheroids(effects):
    """Return the geometry and the rotation of spheroids for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Case, Particle, Contacts, History = t.Case, t.Particle, t.Contacts, t.History
    Law, Touch, Motion, Pose, Facing = t.Law, t.Touch, t.Motion, t.Pose, t.Facing
    properties = particles(effects)
    radius_of, inverse_mass_of, lever_arm = properties.radius_of, properties.inverse_mass_of, properties.lever_arm
    reduced_radius = properties.reduced_radius
    _, _, elastic_energy, _ = contact_law(effects)
    g = support(effects)
    height, separation, bent, closest, refined = g.height, g.separation, g.bent, g.closest, g.refined
    outward_step, outward_stepped, outermost, is_clear = g.outward_step, g.outward_stepped, g.outermost, g.is_clear
    e = elliptic(effects)
    pair_radius, pair_gradient, wall_radius = e.pair_radius, e.pair_gradient, e.wall_radius
    rotation = tops(effects)
    axis_back = rotation.axis_back

    @wp.func
    def reach_of(_case: Case, p: wp.array(dtype=Particle), i: int):
        return p[i].reach

    @wp.func
    def pair_listed(case: Case, p: wp.array(dtype=Particle), i: int, j: int):
        """Whether the spheres that hold two particles are nearer than the list's extra reach."""
        branch = p[i].position - p[j].position
        reach = p[i].reach + p[j].reach + case.skin
        return wp.dot(branch, branch) < reach * reach

    @wp.func
    def pose_of(p: wp.array(dtype=Particle), i: int, j: int, branch: vec3, axis_i: vec3, axis_j: vec3):
        pose = Pose()
        pose.branch = branch
        pose.axis_i = axis_i
        pose.axis_j = axis_j
        pose.across2_i = p[i].across2
        pose.across2_j = p[j].across2
        pose.excess_i = p[i].excess
        pose.excess_j = p[j].excess
        return pose

    @wp.func
    def pose_now(p: wp.array(dtype=Particle), i: int, j: int):
        return pose_of(p, i, j, p[i].position - p[j].position, p[i].axis, p[j].axis)

    @wp.func
    def pair_near(_case: Case, p: wp.array(dtype=Particle), c: Contacts, k: int, margin: real):
        """1 if the gap of the pair at place k of the list is below ``margin``, or it touched a step ago; else 0."""
        near = wp.where(c.pair[k].radius > real(0.0), 1, 0)
        if near == 0:
            pose = pose_now(p, natural(c.owner[k]), natural(c.partner[k]))
            near = wp.where(separation(pose, c.pair[k].normal) > margin, 0, 1)
            if near == 1:
                f = closest(pose, margin)
                c.pair[k].normal = f.normal
                near = wp.where(f.gap > margin, 0, 1)
        return near

    @wp.func
    def pair_mass(case: Case, p: wp.array(dtype=Particle), i: int, j: int, f: Facing):
        lever_i = p[i].excess * f.cosine_i * f.inverse_i
        lever_j = p[j].excess * f.cosine_j * f.inverse_j
        turning_i = lever_i * lever_i * (real(1.0) - f.cosine_i * f.cosine_i) * p[i].inverse_transverse
        turning_j = lever_j * lever_j * (real(1.0) - f.cosine_j * f.cosine_j) * p[j].inverse_transverse
        return real(1.0) / (inverse_mass_of(case, p, i) + inverse_mass_of(case, p, j) + turning_i + turning_j)

    @wp.func
    def touch_along(case: Case, p: wp.array(dtype=Particle), i: int, j: int, pose: Pose, f: Facing):
        """Where two particles meet that face each other along their common normal."""
        touch = Touch()
        touch.overlap = -f.gap
        touch.normal = f.normal
        lever = lever_arm(case, p, i, j, touch.overlap)
        on_n = lever - f.inverse_i * pose.across2_i
        touch.place_i = on_n * f.normal - (f.inverse_i * pose.excess_i * f.cosine_i) * pose.axis_i
        touch.place_j = touch.place_i + pose.branch
        curvature, radius, slopes = pair_radius(pose, f)
        touch.curvature = curvature
        touch.radius = radius
        touch.rolling_radius = reduced_radius(case, p, i, j)
        touch.mass = pair_mass(case, p, i, j, f)
        gradient, couple = pair_gradient(pose, f, bent(pose, f), slopes, lever)
        touch.gradient = gradient
        touch.couple = couple
        return touch

    @wp.func
    def pair_touch(case: Case, p: wp.array(dtype=Particle), i: int, j: int, old: History):
        """Where two particles meet, from the normal that is remembered."""
        pose = pose_now(p, i, j)
        return touch_along(case, p, i, j, pose, refined(pose, old.normal))

    @wp.func
    def pair_touch_back(case: Case, p: wp.array(dtype=Particle), i: int, j: int, x: vec3, offset: real):
        """Where two particles met ``offset`` seconds back, i's centre at ``x``; any place if they did not."""
        branch = x - p[j].position + offset * p[j].half_velocity
        pose = pose_of(p, i, j, branch, axis_back(p, i, offset), axis_back(p, j, offset))
        return touch_along(case, p, i, j, pose, closest(pose, real(0.0)))

    @wp.func
    def since_last(touch: Touch, old: History):
        """Change of the normal since the last step, the normal in the middle, and the arm there; none if new."""
        last = wp.where(old.radius > real(0.0), old.normal, touch.normal)
        arm = wp.where(old.radius > real(0.0), old.arm, touch.place_i)
        tilted = touch.normal - last
        between = touch.normal - real(0.5) * tilted
        return tilted - wp.dot(tilted, between) * between, between, real(0.5) * (touch.place_i + arm)

    @wp.func
    def pair_motion(case: Case, p: wp.array(dtype=Particle), i: int, j: int, touch: Touch, old: History, since: real):
        """How i's surface moves past j's; what the effects do not ask for stays zero."""
        motion = Motion()
        if wp.static(effects.dashpots):
            motion.velocity = p[i].velocity - p[j].velocity
            motion.velocity += wp.cross(p[i].spin, touch.place_i) - wp.cross(p[j].spin, touch.place_j)
        if wp.static(effects.friction):
            tilted, between, arm_i = since_last(touch, old)
            passing = p[i].half_velocity - p[j].half_velocity
            arm_j = arm_i + touch.place_j - touch.place_i - (real(0.5) * since) * passing
            passing += wp.cross(p[i].half_spin, arm_i) - wp.cross(p[j].half_spin, arm_j)
            motion.tilted = tilted
            motion.slid = since * (passing - wp.dot(passing, between) * between)
            motion.turned = real(0.5) * since * wp.dot(p[i].half_spin + p[j].half_spin, touch.normal)
        if wp.static(effects.rolling):
            rolled = wp.cross(p[i].half_spin - p[j].half_spin, touch.normal)
            motion.rolled = since * touch.rolling_radius * rolled
            if wp.static(effects.dashpots):
                motion.rolling = touch.rolling_radius * wp.cross(p[i].spin - p[j].spin, touch.normal)
        return motion

    @wp.func
    def half_energy(law: Law, touch: Touch):
        """Half of the elastic energy [J]; none of two that are apart."""
        return wp.where(touch.overlap > real(0.0), real(0.5) * elastic_energy(law, touch), real(0.0))

    @wp.func
    def pair_loads(touch: Touch, law: Law, f: vec3, rolling: vec3):
        """Force on i and torques on i and j of a contact's force and rolling force."""
        half = half_energy(law, touch)
        force = f + half * touch.gradient
        couple = half * touch.couple + touch.rolling_radius * wp.cross(touch.normal, rolling)
        return force, wp.cross(touch.place_i, force) + couple, -wp.cross(touch.place_j, force) - couple

    @wp.func
    def wall_near(case: Case, p: wp.array(dtype=Particle), c: Contacts, i: int, wall: int):
        """1 if a particle touches a wall, or did so a step ago; else 0."""
        place = WALLS * i + wall
        near = wp.where(c.wall[place].radius > real(0.0), 1, 0)
        x = p[i].position
        if wall == SIDE:
            room = case.radius - p[i].reach
            if near == 0 and x[0] * x[0] + x[1] * x[1] > room * room:
                flattest = p[i].flattest
                out = -c.wall[place].normal
                distance, slope, _stiffness = outward_step(x, p[i].axis, p[i].across2, p[i].excess, out)
                known = wp.dot(out, out) > real(0.5)  # at the start it is not
                if not (known and is_clear(case, distance, slope, flattest)):
                    distance, out = outermost(case, x, p[i].axis, p[i].across2, p[i].excess, flattest)
                    c.wall[place].normal = -out
                    near = wp.where(distance > case.radius, 1, 0)
        else:
            rise = wp.where(wall == FLOOR, x[2], case.height - x[2])
            touches = rise * wp.abs(rise) < p[i].across2 + p[i].excess * p[i].axis[2] * p[i].axis[2]
            near |= wp.where(touches, 1, 0)
        return near

    @wp.func
    def wall_touch_along(
        case: Case, p: wp.array(dtype=Particle), i: int, wall: int, x: vec3, axis: vec3, side_normal: vec3
    ):
        """Where a particle with its centre at ``x`` meets a wall; its farthest point is near minus ``side_normal``."""
        across2 = p[i].across2
        excess = p[i].excess
        _distance, slope, steepness = outward_step(x, axis, across2, excess, -side_normal)
        out = outward_stepped(-side_normal, slope, steepness)
        _distance, _slope, stiffness = outward_step(x, axis, across2, excess, out)
        room = case.radius - out[0] * x[0] - out[1] * x[1]
        normal = -out
        if wall == FLOOR:
            room = x[2]
            normal = vec3(real(0.0), real(0.0), real(1.0))
        if wall == LID:
            room = case.height - x[2]
            normal = vec3(real(0.0), real(0.0), real(-1.0))
        cosine = wp.dot(normal, axis)
        h = height(across2, excess, cosine)
        inverse = real(1.0) / h
        touch = Touch()
        touch.overlap = h - room
        touch.normal = normal
        touch.place_i = (touch.overlap - inverse * across2) * normal - (inverse * excess * cosine) * axis
        radius, slope_of_radius = wall_radius(across2, excess, cosine, h)
        touch.radius = radius
        touch.curvature = real(1.0) / radius
        touch.rolling_radius = radius_of(case, p, i)
        lever = inverse * excess * cosine
        turning = lever * lever * (real(1.0) - cosine * cosine) * p[i].inverse_transverse
        touch.mass = real(1.0) / (inverse_mass_of(case, p, i) + turning)
        # round the side the normal turns as the particle moves; floor and lid have one
        tangent = vec3(normal[1], -normal[0], real(0.0))
        sideways = wp.dot(axis, tangent)
        moved = wp.where(wall == SIDE, slope_of_radius * sideways / stiffness, real(0.0))
        touch.gradient = moved * tangent
        # W tangent, less the overlap
        flat = inverse * across2
        curved = flat * (tangent + (excess * inverse * inverse * sideways) * (axis - cosine * normal))
        turned = moved * (curved - touch.overlap * tangent)
        touch.couple = wp.cross(normal, turned) - slope_of_radius * wp.cross(axis, normal)
        return touch

    @wp.func
    def wall_touch(case: Case, p: wp.array(dtype=Particle), i: int, wall: int, old: History):
        """Where a particle meets a wall, from the normal that is remembered."""
        side_normal = old.normal
        if wall != SIDE:
            side_normal = vec3(real(-1.0), real(0.0), real(0.0))
        return wall_touch_along(case, p, i, wall, p[i].position, p[i].axis, side_normal)

    @wp.func
    def wall_touch_back(case: Case, p: wp.array(dtype=Particle), i: int, wall: int, x: vec3, offset: real):
        """Where a particle met a wall ``offset`` seconds back, its centre at ``x``; any place if it did not."""
        axis = axis_back(p, i, offset)
        side_normal = vec3(real(-1.0), real(0.0), real(0.0))
        room = case.radius - p[i].reach
        if wall == SIDE and x[0] * x[0] + x[1] * x[1] > room * room:
            _distance, out = outermost(case, x, axis, p[i].across2, p[i].excess, p[i].flattest)
            side_normal = -out
        return wall_touch_along(case, p, i, wall, x, axis, side_normal)

    @wp.func
    def wall_motion(
        case: Case, p: wp.array(dtype=Particle), i: int, wall: int, touch: Touch, old: History, since: real
    ):
        """How i's surface moves past the wall; what the effects do not ask for stays zero."""
        motion = Motion()
        if wp.static(effects.dashpots):
            motion.velocity = p[i].velocity + wp.cross(p[i].spin, touch.place_i)
        if wp.static(effects.friction):
            tilted, between, arm = since_last(touch, old)
            passing = p[i].half_velocity + wp.cross(p[i].half_spin, arm)
            motion.tilted = tilted
            motion.slid = since * (passing - wp.dot(passing, between) * between)
            motion.turned = real(0.5) * since * wp.dot(p[i].half_spin, touch.normal)
        if wp.static(effects.rolling):
            motion.rolled = since * touch.rolling_radius * wp.cross(p[i].half_spin, touch.normal)
            if wp.static(effects.dashpots):
                motion.rolling = touch.rolling_radius * wp.cross(p[i].spin, touch.normal)
        return motion

    @wp.func
    def wall_loads(touch: Touch, law: Law, f: vec3, rolling: vec3):
        """Force and torque on a particle of its contact's force and rolling force."""
        half = half_energy(law, touch)
        force = f + half * touch.gradient
        couple = half * touch.couple + touch.rolling_radius * wp.cross(touch.normal, rolling)
        return force, wp.cross(touch.place_i, force) + couple

    @wp.func
    def with_place(history: History, touch: Touch):
        """The history with the normal and the arm of this step."""
        placed = history
        placed.normal = touch.normal
        placed.arm = touch.place_i
        return placed

    return SimpleNamespace(
        reach_of=reach_of,
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
        turn=rotation.turn,
        kick_spin=rotation.kick_spin,
        rotational_energy=rotation.rotational_energy,
        pace2=rotation.pace2,
    )
