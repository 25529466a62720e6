"""Elliptical Hertz contacts of spheroids: the radius R* of the sphere on a plane that is as stiff, and its gradient.

With K the sum of both surfaces' curvature matrices in the plane of contact, exact theory has

    R* = S(Y) / sqrt(det K),   Y = tr K / (2 sqrt(det K)),   S = 1 + (Y - 1) / (3 + 0.29 (Y - 1)),

S for the elliptic integrals (F2^-3 in Johnson, Contact Mechanics, 1985, section 4.2): the force is right to 0.013 % up
to curvatures in the ratio 6.25, to 0.07 % up to 16, to 0.6 % up to 40.

R* depends on the axes and the normal, so the energy U = 8/15 E* sqrt(R*) d^2.5 does besides on the overlap d, and the
forces are its gradient in full: F = dU/dd along the normal, and (U / 2) d(ln R*) for the rest, which is of the order of
d / R* of F.  Without the rest the ledger of a collision would be open by 1e-4 whatever the step.

A spheroid's principal curvatures are mu = h / b^2 round its axis and nu = h^3 / (a b)^2 along its meridian.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .structs import types


@functools.cache
def elliptic(effects):
    """Return ``pair_radius``, ``pair_gradient`` and ``wall_radius`` for the given effects."""
    t = types(effects)
    real, vec3 = t.real, t.vec3
    Pose, Facing, Bent = t.Pose, t.Facing, t.Bent
    SLACK = wp.constant(real(0.29))
    # S = above / below, each a sum of 2 sqrt(det K) and tr K
    ROOT_ABOVE, TRACE_ABOVE = wp.constant(real(2.0 - 0.29)), wp.constant(real(1.0 + 0.29))
    ROOT_BELOW = wp.constant(real(3.0 - 0.29))

    @wp.func
    def pair_radius(pose: Pose, f: Facing):
        """1 / R* [1/m], R* [m], and the slopes of ln R* with c_i = n.u_i, c_j = n.u_j and u_i.u_j."""
        over_i = real(1.0) / (pose.across2_i * (pose.across2_i + pose.excess_i))
        over_j = real(1.0) / (pose.across2_j * (pose.across2_j + pose.excess_j))
        mu_i = over_i * (pose.across2_i + pose.excess_i) * f.height_i
        mu_j = over_j * (pose.across2_j + pose.excess_j) * f.height_j
        nu_i = over_i * f.height_i * f.height_i * f.height_i
        nu_j = over_j * f.height_j * f.height_j * f.height_j
        x = wp.dot(pose.axis_i, pose.axis_j) - f.cosine_i * f.cosine_j
        crossed = pose.excess_i * over_i * pose.excess_j * over_j * f.height_i * f.height_j
        trace = mu_i + nu_i + mu_j + nu_j
        determinant = mu_i * nu_i + mu_j * nu_j + mu_i * mu_j + nu_i * nu_j - crossed * x * x
        root = real(2.0) * wp.sqrt(determinant)
        above = ROOT_ABOVE * root + TRACE_ABOVE * trace
        below = ROOT_BELOW * root + SLACK * trace
        over = real(1.0) / (above * below * root)
        over_both = over * root
        over_root = over * above * below

        by_trace = real(3.0) * root * over_both
        by_determinant = real(-2.0) * (real(1.0) + by_trace * trace) * over_root * over_root
        theta_i = pose.excess_i * f.cosine_i * f.inverse_i * f.inverse_i
        theta_j = pose.excess_j * f.cosine_j * f.inverse_j * f.inverse_j
        shared = mu_i * mu_j + real(3.0) * nu_i * nu_j - crossed * x * x
        turned = real(2.0) * by_determinant * crossed * x
        slope_i = by_determinant * (real(4.0) * mu_i * nu_i + shared) + by_trace * (mu_i + real(3.0) * nu_i)
        slope_j = by_determinant * (real(4.0) * mu_j * nu_j + shared) + by_trace * (mu_j + real(3.0) * nu_j)
        slopes = vec3(theta_i * slope_i + turned * f.cosine_j, theta_j * slope_j + turned * f.cosine_i, -turned)
        return real(0.5) * root * below * below * over_both, real(2.0) * over * above * above, slopes

    @wp.func
    def pair_gradient(pose: Pose, f: Facing, w: Bent, slopes: vec3, lever: real):
        """Force and couple on i of the change of R*, over U / 2 [1/m], [-]; on j the opposite.

        The force is -w with (W_i + W_j + g P) w = L_i p + L_j q, L the ``slopes``.  The couple is beside a force at the
        contact, which lies ``lever`` outside of i's surface along the normal.
        """
        over = real(1.0) / w.determinant
        w_i = over * (w.whole * slopes[0] - w.beta_i * (slopes[0] * w.pp + slopes[1] * w.pq))
        w_j = over * (w.whole * slopes[1] - w.beta_j * (slopes[0] * w.pq + slopes[1] * w.qq))
        rest = pose.across2_i * f.inverse_i - lever
        couple_i = rest * w_i + w.beta_i * (w_i * w.pp + w_j * w.pq) - slopes[0]
        force = (w_i * f.cosine_i + w_j * f.cosine_j) * f.normal - w_i * pose.axis_i - w_j * pose.axis_j
        along = couple_i * pose.axis_i + (rest * w_j) * pose.axis_j
        return force, -wp.cross(f.normal, along) - slopes[2] * wp.cross(pose.axis_i, pose.axis_j)

    @wp.func
    def wall_radius(across2: real, excess: real, cosine: real, h: real):
        """R of a spheroid on a plane [m], and the slope of ln R with c = n.u."""
        along = wp.sqrt(across2 + excess)
        inverse2 = real(1.0) / (h * h)
        longer = along * h * inverse2
        shorter = h / along
        beyond = real(0.5) * (longer + shorter) - real(1.0)
        over = real(1.0) / (real(3.0) + SLACK * beyond)
        share = real(1.0) + beyond * over
        change = real(1.5) * over * over * (shorter - longer) / share
        return share * along * across2 * inverse2, excess * cosine * inverse2 * (change - real(2.0))

    return SimpleNamespace(pair_radius=pair_radius, pair_gradient=pair_gradient, wall_radius=wall_radius)
