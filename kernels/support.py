"""Support functions of spheroids: how far one reaches in a direction, and where it is nearest to another or to a wall.

A spheroid of semi-axes a along its unit axis u and b across it reaches, from its centre and along the unit vector n,

    h(n) = sqrt(b^2 + e c^2),   e = a^2 - b^2,   c = n.u,     at its point  s(n) = (b^2 n + e c u) / h,

with the matrix of radii of curvature W(n) = (b^2 / h) P + (e b^2 / h^3) p p^T, P = 1 - n n^T, p = P u.

Two of them, i and j, their centres r = x_i - x_j apart, are separated along n by the gap g(n) = n.r - h_i - h_j; any n
with a positive one proves that they do not touch.  The largest gap is their distance or, if negative, minus their
overlap, and its n is the common normal, from j to i: there P (r - s_i - s_j) = 0, so the nearest points of both
surfaces lie on one line along n, and a change of the gap is the work of a force along it.

Newton's step towards it, (W_i + W_j + g P) step = P (r - s_i - s_j), is solved in closed form in the plane of p = P u_i
and q = P u_j.  The new normal (1 - t^2 / 4, t) / (1 + t^2 / 4), t the step, has length 1 without a root.

The first guess (A_i + A_j)^-1 r, A = b^2 + e u u^T, is the normal of the contact function of Perram and Wertheim (1985,
doi:10.1016/0021-9991(85)90171-8) at one half.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .structs import types

MOST = wp.constant(12)
"""Newton steps at the most; six were needed from the first guess at any aspect from 0.25 to 4; beyond, not all end."""


@functools.cache
def support(effects):
    """Return what finds normals of spheroids for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Case, Pose, Facing, Bent = t.Case, t.Pose, t.Facing, t.Bent
    SMALL2 = wp.constant(real(1e-7))  # square of a step after which the normal is known to about 1e-7

    @wp.func
    def height(across2: real, excess: real, cosine: real):
        """How far a spheroid reaches along a direction, ``cosine`` that of its angle with the axis [m]."""
        return wp.sqrt(across2 + excess * cosine * cosine)

    @wp.func
    def separation(pose: Pose, n: vec3):
        """Gap along n: if positive, the two do not touch."""
        h_i = height(pose.across2_i, pose.excess_i, wp.dot(n, pose.axis_i))
        h_j = height(pose.across2_j, pose.excess_j, wp.dot(n, pose.axis_j))
        return wp.dot(n, pose.branch) - h_i - h_j

    @wp.func
    def facing(pose: Pose, n: vec3):
        """The two along the direction n."""
        f = Facing()
        f.normal = n
        f.cosine_i = wp.dot(n, pose.axis_i)
        f.cosine_j = wp.dot(n, pose.axis_j)
        f.along = wp.dot(n, pose.branch)
        f.height_i = height(pose.across2_i, pose.excess_i, f.cosine_i)
        f.height_j = height(pose.across2_j, pose.excess_j, f.cosine_j)
        both = real(1.0) / (f.height_i * f.height_j)
        f.inverse_i = both * f.height_j
        f.inverse_j = both * f.height_i
        f.gap = f.along - f.height_i - f.height_j
        return f

    @wp.func
    def bent(pose: Pose, f: Facing):
        """Numbers of W_i + W_j + g P = flat P + beta_i p p^T + beta_j q q^T; ``whole`` is its trace less flat."""
        w = Bent()
        w.pp = real(1.0) - f.cosine_i * f.cosine_i
        w.qq = real(1.0) - f.cosine_j * f.cosine_j
        w.pq = wp.dot(pose.axis_i, pose.axis_j) - f.cosine_i * f.cosine_j
        w.beta_i = pose.excess_i * pose.across2_i * f.inverse_i * f.inverse_i * f.inverse_i
        w.beta_j = pose.excess_j * pose.across2_j * f.inverse_j * f.inverse_j * f.inverse_j
        flat = pose.across2_i * f.inverse_i + pose.across2_j * f.inverse_j + f.gap
        w.whole = flat + w.beta_i * w.pp + w.beta_j * w.qq
        w.determinant = flat * w.whole + w.beta_i * w.beta_j * (w.pp * w.qq - w.pq * w.pq)
        return w

    @wp.func
    def step(pose: Pose, f: Facing):
        """Newton's step from a direction, times the determinant, and the determinant."""
        w = bent(pose, f)
        tilt_i = pose.excess_i * f.cosine_i * f.inverse_i
        tilt_j = pose.excess_j * f.cosine_j * f.inverse_j
        slope_i = wp.dot(pose.branch, pose.axis_i) - f.cosine_i * f.along - tilt_i * w.pp - tilt_j * w.pq
        slope_j = wp.dot(pose.branch, pose.axis_j) - f.cosine_j * f.along - tilt_i * w.pq - tilt_j * w.qq
        on_i = -w.whole * tilt_i - w.beta_i * slope_i
        on_j = -w.whole * tilt_j - w.beta_j * slope_j
        on_n = w.whole * f.along + on_i * f.cosine_i + on_j * f.cosine_j
        return w.whole * pose.branch + on_i * pose.axis_i + on_j * pose.axis_j - on_n * f.normal, w.determinant

    @wp.func
    def stepped(n: vec3, scaled: vec3, determinant: real):
        """The unit vector turned from n by a step that is ``scaled`` by a determinant."""
        determinant2 = determinant * determinant
        quarter = real(0.25) * wp.dot(scaled, scaled)
        over = real(1.0) / (determinant2 + quarter)
        return (over * (determinant2 - quarter)) * n + (over * determinant) * scaled

    @wp.func
    def first_guess(pose: Pose):
        parallel = wp.dot(pose.axis_i, pose.axis_j)
        along_i = wp.dot(pose.axis_i, pose.branch)
        along_j = wp.dot(pose.axis_j, pose.branch)
        across2 = pose.across2_i + pose.across2_j
        first = across2 + pose.excess_i
        second = across2 + pose.excess_j
        over = real(1.0) / (first * second - pose.excess_i * pose.excess_j * parallel * parallel)
        on_i = over * pose.excess_i * (second * along_i - pose.excess_j * parallel * along_j)
        on_j = over * pose.excess_j * (first * along_j - pose.excess_i * parallel * along_i)
        guess = pose.branch - on_i * pose.axis_i - on_j * pose.axis_j
        return (real(1.0) / wp.length(guess)) * guess

    @wp.func
    def closest(pose: Pose, margin: real):
        """The two along their common normal, from the first guess; or along any n with a gap above ``margin``."""
        f = facing(pose, first_guess(pose))
        k = wp.int32(0)
        while k < MOST and f.gap <= margin:
            scaled, determinant = step(pose, f)
            size2 = wp.dot(scaled, scaled)
            determinant2 = determinant * determinant
            if size2 > real(0.25) * determinant2:
                scaled *= real(0.5) * wp.abs(determinant) / wp.sqrt(size2)  # steps of half a radian at the most
            f = facing(pose, stepped(f.normal, scaled, determinant))
            k += 1
            if size2 < SMALL2 * determinant2:
                k = MOST
        return f

    @wp.func
    def refined(pose: Pose, n: vec3):
        """The two along their common normal, from that of the time step before: one step without a branch, for lanes.

        What it leaves is of the order of the square of the normal's turn in a time step, 1e-4 of a radian.
        """
        f = facing(pose, n)
        scaled, determinant = step(pose, f)
        return facing(pose, stepped(n, scaled, determinant))

    @wp.func
    def outward_step(x: vec3, axis: vec3, across2: real, excess: real, out: vec3):
        """Distance from the z axis along the horizontal unit vector ``out``, and its derivatives.

        The distance f(out) = out.x + h(out) of the spheroid's shadow has the slope z = t.x + e c (u.t) / h, t across
        ``out``, and the second derivative rho - f, rho = (b^2 / h) (1 + e (u.t)^2 / h^2) the shadow's radius of
        curvature.  Returns f, z and f - rho.
        """
        sideways = out[0] * axis[1] - out[1] * axis[0]
        cosine = out[0] * axis[0] + out[1] * axis[1]
        inverse = real(1.0) / height(across2, excess, cosine)
        distance = out[0] * x[0] + out[1] * x[1] + (across2 + excess * cosine * cosine) * inverse
        slope = out[0] * x[1] - out[1] * x[0] + excess * cosine * sideways * inverse
        shadow = across2 * inverse * (real(1.0) + excess * inverse * inverse * sideways * sideways)
        return distance, slope, distance - shadow

    @wp.func
    def outward_stepped(out: vec3, slope: real, stiffness: real):
        """The horizontal unit vector turned by Newton's step slope / stiffness."""
        return stepped(out, slope * vec3(-out[1], out[0], real(0.0)), stiffness)

    @wp.func
    def is_clear(case: Case, distance: real, slope: real, flattest: real):
        """Whether f and f' along any direction prove that the spheroid does not touch the side.

        With rho the largest radius of curvature of its surface f'' <= rho - f, so f nowhere exceeds that solution of
        y'' = rho - y which starts as f does: it rises by f'^2 / (2 (f - rho)) at the most.
        """
        room = (distance - flattest) * (case.radius - distance)
        return distance < case.radius and distance > flattest and real(0.5) * slope * slope < room

    @wp.func
    def outermost(case: Case, x: vec3, axis: vec3, across2: real, excess: real, flattest: real):
        """Distance of a spheroid's farthest point from the z axis, and the direction of that, from the radial one.

        Or any direction that proves the spheroid clear of the side.
        """
        out = (real(1.0) / wp.sqrt(x[0] * x[0] + x[1] * x[1])) * vec3(x[0], x[1], real(0.0))
        distance, slope, stiffness = outward_step(x, axis, across2, excess, out)
        k = wp.int32(0)
        while k < MOST and not is_clear(case, distance, slope, flattest):
            slope2 = slope * slope
            stiffness2 = stiffness * stiffness
            out = outward_stepped(out, slope, stiffness)
            distance, slope, stiffness = outward_step(x, axis, across2, excess, out)
            k += 1
            if slope2 < SMALL2 * stiffness2:
                k = MOST
        return distance, out

    return SimpleNamespace(
        height=height,
        separation=separation,
        bent=bent,
        closest=closest,
        refined=refined,
        outward_step=outward_step,
        outward_stepped=outward_stepped,
        is_clear=is_clear,
        outermost=outermost,
    )
