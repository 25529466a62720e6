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
    The stretch lives at half steps, like the velocities: the force of step n is the mean of the spring before and after
    it, so that a sticking contact neither gains nor loses energy (first-order forms lose 30 % of a tangential swing at
    20 steps per contact).  The velocity at n is a prediction, however, and the lag would feed the spring by
    (w dt)^4/8 a step; a numerical dashpot of twice that size outweighs it.

Energy
    Each loss below is non-negative by its own formula, and together with the stored energies they equal -F . v dt of
    the step exactly in the tangential direction and to second order in the normal one.
"""

import functools

import warp as wp

from .data import types


@functools.cache
def contact_law(effects):
    """Return ``contact`` and ``stored`` for the given effects."""
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
    def friction(stiffness: real, damping: real, limit: real, held: vec3, trial: vec3, velocity: vec3, h: real):
        """Tangential force, the stretch after the step, and the energy lost to dashpot and slip.

        ``held`` and ``trial`` are the stretch before the step and after it without friction's limit.  First the spring
        is cut to the limit, then as much of the dashpot is added as the limit leaves room for: while sliding on, none;
        when sliding turns round, all, so that the force has no jump there.
        """
        limit2 = limit * limit
        stretch = trial
        spring = real(0.5) * stiffness * (held + trial)
        slip = real(0.0)
        trial2 = stiffness * stiffness * wp.dot(trial, trial)
        spring2 = wp.dot(spring, spring)
        if trial2 > limit2:
            size = wp.sqrt(trial2)
            stretch = trial * (limit / size)
            spring = stiffness * stretch
            spring2 = limit2
            jump = stretch - held
            slip = limit * (size - limit) / stiffness + real(0.5) * stiffness * wp.dot(jump, jump)
        elif spring2 > limit2:  # turning back, while the limit fell below the spring's force
            cut = limit / wp.sqrt(spring2)
            slip = real(0.5) * stiffness * (real(1.0) - cut) * (wp.dot(held, held) - wp.dot(trial, trial))
            spring *= cut
            spring2 = limit2

        viscous = -damping * velocity
        total = spring + viscous
        share = real(1.0)
        if wp.dot(total, total) > limit2:  # |spring + share viscous| = limit
            along = wp.dot(spring, viscous)
            viscous2 = wp.dot(viscous, viscous)
            share = wp.max(wp.sqrt(along * along + viscous2 * (limit2 - spring2)) - along, real(0.0)) / viscous2
            total = spring + share * viscous
        return total, stretch, share * damping * wp.dot(velocity, velocity) * h, slip

    @wp.func
    def contact(
        law: Law,
        inverse_radius: real,
        inverse_mass: real,
        overlap: real,
        normal: vec3,
        velocity: vec3,
        spin: real,
        history: vec4,
        h: real,
    ):
        """Force on i, the new history, and the energy lost in a step of length ``h``.

        Parameters
        ----------
        law : Law
        inverse_radius, inverse_mass : 1/R* [1/m], 1/m* [1/kg]
        overlap [m], normal, velocity [m/s]
            Velocity of i's surface relative to the partner's.
        spin [rad/s]
            Mean spin of the two bodies about the normal.
        history : (xi [m], a [m])

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
        spring = real(4.0 / 3.0) * law.modulus * a * overlap
        normal_dashpot = wp.max(law.normal_damping * root * approach, -spring)  # no tension
        normal_force = spring + normal_dashpot

        old_a = history[3]
        stretch = vec3(history[0], history[1], history[2])
        held = turned(stretch, normal, spin * h)
        if old_a < a:
            held *= old_a / a
        slip_velocity = velocity + approach * normal
        trial = held - h * slip_velocity

        stiffness = real(8.0) * law.shear_modulus * a
        lag = real(1.75) * stiffness * stiffness * inverse_mass * h * h * h
        tangential_force, stretch_after, dashpot_loss, slip_loss = friction(
            stiffness,
            law.tangential_damping * root + lag,
            law.friction * normal_force,
            held,
            trial,
            slip_velocity,
            h,
        )
        given_up = real(4.0) * law.shear_modulus * (old_a * wp.dot(stretch, stretch) - a * wp.dot(held, held))
        return (
            normal_force * normal + tangential_force,
            vec4(stretch_after[0], stretch_after[1], stretch_after[2], a),
            vec4(normal_dashpot * approach * h, dashpot_loss, slip_loss, given_up),
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
