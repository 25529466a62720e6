"""The contact law: Hertz-Mindlin with Tsuji's dashpots and Coulomb friction.

With overlap d, contact radius a = sqrt(R* d) and reduced mass m* (a wall: R* = R, m* = m):

    Fn = max(4/3 E* a d + 2 sqrt(5/6) b sqrt(Sn m*) vn, 0),   Sn = 2 E* a
    Ft = St xi - 2 sqrt(5/6) b sqrt(St m*) vt,                 St = 8 G* a,   |Ft| <= mu Fn

where vn is the approach speed, vt the slip velocity, and the stretch xi follows d(xi)/dt = -vt (Hertz; Mindlin 1949;
Tsuji, Tanaka & Ishida 1992, doi:10.1016/0032-5910(92)88030-L).  Dry grains do not pull: without tension the impulse of
sliding friction is mu times that of the normal force, (1 + e) m* vn, which the pull of the textbook's dashpot raises by
3 % at e = 0.5.  Its b is found so that a bounce still returns the restitution asked for; see ``warpdamp/law.py``.

Tangential history
    The spring's stretch xi is stored with the contact radius of the same moment.  When a contact unloads, St falls and
    xi is kept, so the force falls with St (Thornton, Cummins & Cleary 2013, doi:10.1016/j.powtec.2012.08.012); when it
    loads, the force is kept.  Either way stored energy can only be given up, never created.
    Like the positions, and unlike the velocities, the stretch lives at whole steps: it advances by the way that the
    surfaces slid past each other since the last step, at the half-step velocities and in the plane of that half step.
    So the spring is integrated as the positions are, and neither heats nor cools a bed of sticking contacts.  (Advanced
    by velocities predicted for the whole step it feeds a jammed bed; taken at the end of the step alone it would lose
    30 % of a tangential swing at 20 steps a contact.)

Energy
    The work of friction between two steps is the mean of its force at both times the way slid.  Less the change of the
    stored energy it splits into what loading and unloading give up (history) and what slides (slip); dashpots lose
    their coefficient times the square of the predicted velocity.  Each loss is non-negative by its own formula.
"""

import functools

import warp as wp

from .data import types


@functools.cache
def contact_law(effects):
    """Return ``contact``, ``normal_energy`` and ``tangential_energy`` for the given effects."""
    t = types(effects.real)
    real, vec3, vec4 = t.real, t.vec3, t.vec4
    Law = t.Law

    @wp.func
    def turned(stretch: vec3, normal: vec3, angle: real):
        """The stretch carried along with the contact plane (and by ``angle`` about the normal), its length kept."""
        flat = stretch - wp.dot(stretch, normal) * normal
        flat += angle * wp.cross(normal, flat)
        length2 = wp.dot(flat, flat)
        if length2 > real(0.0):
            flat *= wp.sqrt(wp.dot(stretch, stretch) / length2)
        return flat

    @wp.func
    def damped(spring: vec3, viscous: vec3, limit: real):
        """The share of the dashpot's force that friction's limit leaves room for beside the spring's.

        While sliding on, none; when sliding turns round, all: the force has no jump there.
        """
        total = spring + viscous
        limit2 = limit * limit
        share = real(1.0)
        if wp.dot(total, total) > limit2:  # |spring + share viscous| = limit
            along = wp.dot(spring, viscous)
            viscous2 = wp.dot(viscous, viscous)
            room = wp.max(limit2 - wp.dot(spring, spring), real(0.0))
            share = wp.max(wp.sqrt(along * along + viscous2 * room) - along, real(0.0)) / viscous2
        return wp.min(share, real(1.0))

    @wp.func
    def contact(
        law: Law,
        inverse_radius: real,
        inverse_mass: real,
        overlap: real,
        normal: vec3,
        velocity: vec3,
        slid: vec3,
        turn: real,
        history: vec4,
        h: real,
    ):
        """Force on i, the new history, and the energy lost.

        Parameters
        ----------
        law : Law
        inverse_radius, inverse_mass : 1/R* [1/m], 1/m* [1/kg]
        overlap [m], normal, velocity [m/s]
            Velocity of i's surface relative to the partner's, predicted for this step.
        slid : vec3 [m]
            How far i's surface slid past the partner's since the last step.
        turn [rad]
            By how much the two bodies turned about the normal since the last step, in the mean.
        history : (xi [m], a [m])
        h : time that this step stands for [s]

        Returns
        -------
        force : vec3 [N]
        history : vec4
        losses : vec4 [J]
            In the order of ``data.LOSSES``.
        """
        a = wp.sqrt(overlap / inverse_radius)
        root = wp.sqrt(a / inverse_mass)

        approach = -wp.dot(velocity, normal)
        spring_force = real(4.0 / 3.0) * law.modulus * a * overlap
        normal_dashpot = wp.max(law.normal_damping * root * approach, -spring_force)  # no tension
        normal_force = spring_force + normal_dashpot
        limit = law.friction * normal_force

        # the stretch without friction's limit: the force is kept on loading, the stretch on unloading
        old_a = history[3]
        old = vec3(history[0], history[1], history[2])
        kept = wp.min(old_a / a, real(1.0))
        gain = real(0.5) * (real(1.0) + kept)
        trial = turned(kept * old - gain * slid, normal, turn)

        stiffness = real(8.0) * law.shear_modulus * a
        old_stiffness = real(8.0) * law.shear_modulus * old_a
        stretch = trial
        slip = real(0.0)
        trial2 = stiffness * stiffness * wp.dot(trial, trial)
        if trial2 > limit * limit:
            stretch = trial * (limit / wp.sqrt(trial2))
            slid_off = (trial - stretch) / gain
            slip = wp.max(real(0.5) * wp.dot(old_stiffness * old + stiffness * stretch, slid_off), real(0.0))

        old2 = wp.dot(old, old)
        new2 = wp.dot(stretch, stretch)
        given_up = real(0.25) * (old_stiffness - stiffness) * (old2 + new2)
        if old_a < a:
            mean = real(0.5) * (stiffness + old_stiffness)
            given_up = real(0.5) * (
                stiffness * new2 * (stiffness / mean - real(1.0))
                + old_stiffness * old2 * (real(1.0) - old_stiffness / mean)
            )

        slip_velocity = velocity + approach * normal
        damping = law.tangential_damping * root
        share = damped(stiffness * stretch, -damping * slip_velocity, limit)
        tangential_force = stiffness * stretch - share * damping * slip_velocity
        return (
            normal_force * normal + tangential_force,
            vec4(stretch[0], stretch[1], stretch[2], a),
            vec4(
                normal_dashpot * approach * h,
                share * damping * wp.dot(slip_velocity, slip_velocity) * h,
                slip,
                given_up,
            ),
        )

    @wp.func
    def tangential_energy(law: Law, history: vec4):
        """Energy in the tangential spring, St xi^2 / 2 [J]."""
        xi2 = history[0] * history[0] + history[1] * history[1] + history[2] * history[2]
        return real(4.0) * law.shear_modulus * history[3] * xi2

    @wp.func
    def normal_energy(law: Law, inverse_radius: real, overlap: real):
        """Energy of the Hertz spring, 2/5 Fn d = 8/15 E* a d^2 [J]."""
        return real(8.0 / 15.0) * law.modulus * wp.sqrt(overlap / inverse_radius) * overlap * overlap

    return contact, normal_energy, tangential_energy
