"""The contact law: Hertz-Mindlin with Tsuji's dashpots and Coulomb friction.

With overlap d, contact radius a = sqrt(R* d) and reduced mass m* (a wall: R* = R, m* = m):

    Fn = max(4/3 E* a d + 2 sqrt(5/6) b sqrt(Sn m*) vn, 0),   Sn = 2 E* a
    Ft = St xi - 2 sqrt(5/6) b sqrt(St m*) vt,                 St = 8 G* a,   |Ft| <= mu Fn

where vn is the approach speed, vt the slip velocity, and the stretch xi follows d(xi)/dt = -vt (Hertz; Mindlin 1949;
Tsuji, Tanaka & Ishida 1992, doi:10.1016/0032-5910(92)88030-L).  Dry grains do not pull: without tension the impulse of
sliding friction is mu times that of the normal force, (1 + e) m* vn, which the pull of the textbook's dashpot raises by
3 % at e = 0.5.  Its b is found so that a bounce still returns the restitution asked for; see
``warpdamp/scene/contact.py``.

Tangential history
    The spring's stretch xi is stored with the contact radius of the same moment.  When a contact unloads, St falls and
    xi is kept, so the force falls with St (Thornton, Cummins & Cleary 2013, doi:10.1016/j.powtec.2012.08.012); when it
    loads, the force is kept.  Either way stored energy can only be given up, never created.
    Like the positions, and unlike the velocities, the stretch lives at whole steps: it advances by the way that the
    surfaces slid past each other since the last step, at the half-step velocities and in the plane of that half step.
    So the spring is integrated as the positions are, and neither heats nor cools a bed of sticking contacts.  (Advanced
    by velocities predicted for the whole step it feeds a jammed bed; taken at the end of the step alone it would lose
    30 % of a tangential swing at 20 steps a contact.)

Rolling resistance
    The elastic-plastic spring and dashpot of Ai, Chen, Rotter & Ooi (2011, doi:10.1016/j.powtec.2010.09.030) in the
    form of a second friction: the way rolled, R* (spin_i - spin_j) x n, stretches a spring as stiff as the tangential
    one, with a dashpot as strong, its force at most mu_r Fn.  Its moment is R* times that: at most mu_r R* Fn.

Energy
    The work of friction between two steps is the mean of its force at both times the way slid.  Less the change of the
    stored energy it splits into what loading and unloading give up (history) and what slides (slip); dashpots lose
    their coefficient times the square of the predicted velocity.  Each loss is non-negative by its own formula.

Vectors
    The compiler computes several contacts side by side with the code below (``lanes.py``).  It gives that up, and half
    the speed with it, where a branch loads, stores, calls or returns (arithmetic alone becomes a selection), or a loop
    has bounds that are not constants.  ``tests/kernels/test_lanes.py`` asks it.
"""

import functools

import warp as wp

from .bounds import bounds
from .structs import types


@functools.cache
def contact_law(effects):
    """Return ``contact``, ``parted``, ``elastic_energy`` and ``remembered_energy`` for the given effects."""
    t = types(effects)
    real, vec3, Losses = t.real, t.vec3, t.Losses
    Law, Touch, Motion, History = t.Law, t.Touch, t.Motion, t.History
    at_least, at_most = bounds(real).at_least, bounds(real).at_most
    # a quotient within a kernel is one of float32, whatever it is cast to
    FOUR_THIRDS, EIGHT_FIFTEENTHS = wp.constant(real(4.0 / 3.0)), wp.constant(real(8.0 / 15.0))

    @wp.func
    def carried_along(stretch: vec3, normal: vec3, tilted: vec3, turned: real):
        """The stretch turned with the contact plane and about its normal; its length changes at third order only."""
        flat = stretch - wp.dot(stretch, normal) * (normal - real(0.5) * tilted)
        return (real(1.0) - real(0.5) * turned * turned) * flat + turned * wp.cross(normal, flat)

    @wp.func
    def spring(shear: real, a: real, old_a: real, old: vec3, moved: vec3, normal: vec3, motion: Motion, limit: real):
        """A spring of stiffness ``shear`` a in the contact plane, its force at most ``limit``.

        Returns the new stretch, the energy slid off and the energy given up.
        """
        # without the limit: the force is kept on loading, the stretch on unloading
        kept = wp.where(old_a < a, old_a / a, real(1.0))
        gain = real(0.5) * (real(1.0) + kept)
        stretch = carried_along(kept * old - gain * moved, normal, motion.tilted, motion.turned)

        stiffness = shear * a
        old_stiffness = shear * old_a
        new2 = wp.dot(stretch, stretch)
        slip = real(0.0)
        if stiffness * stiffness * new2 > limit * limit:
            share = limit / (stiffness * wp.sqrt(new2))
            slid_off = (real(1.0) - share) / gain * stretch
            stretch *= share
            new2 *= share * share
            slip = at_least(real(0.5) * wp.dot(old_stiffness * old + stiffness * stretch, slid_off), real(0.0))

        old2 = wp.dot(old, old)
        softened = old_stiffness - stiffness
        unloading = real(0.25) * softened * (old2 + new2)
        loading = real(-0.5) * softened / (stiffness + old_stiffness) * (stiffness * new2 + old_stiffness * old2)
        return stretch, slip, wp.where(softened >= real(0.0), unloading, loading)

    @wp.func
    def damped(spring_force: vec3, viscous: vec3, limit: real):
        """The share of the dashpot's force that the limit leaves room for beside the spring's.

        While sliding on, none; when sliding turns round, all: the force has no jump there.
        """
        total = spring_force + viscous
        limit2 = limit * limit
        viscous2 = wp.dot(viscous, viscous)
        share = real(1.0)
        if wp.dot(total, total) > limit2 and viscous2 > real(0.0):  # |spring + share viscous| = limit
            along = wp.dot(spring_force, viscous)
            room = at_least(limit2 - wp.dot(spring_force, spring_force), real(0.0))
            share = at_least(wp.sqrt(along * along + viscous2 * room) - along, real(0.0)) / viscous2
        return at_most(share, real(1.0))

    @wp.func
    def resistance(
        law: Law,
        a: real,
        root: real,
        old_a: real,
        old: vec3,
        moved: vec3,
        rate: vec3,
        normal: vec3,
        motion: Motion,
        limit: real,
        h: real,
    ):
        """Spring and dashpot in the contact plane against a motion, together at most ``limit``.

        Returns the force, the stretch, and the energy lost to (dashpot, slip, history).
        """
        shear = real(8.0) * law.shear_modulus
        stretch, slip, given_up = spring(shear, a, old_a, old, moved, normal, motion, limit)
        force = shear * a * stretch
        lost = vec3(real(0.0), slip, given_up)
        if wp.static(effects.dashpots):
            damping = law.tangential_damping * root
            share = damped(force, -damping * rate, limit)
            force -= share * damping * rate
            lost[0] = share * damping * wp.dot(rate, rate) * h
        return force, stretch, lost

    @wp.func
    def losses(normal: real, tangential: vec3, rolling: vec3):
        """Energies lost, by channel or in total."""
        rolled = rolling[0] + rolling[1] + rolling[2]
        if wp.static(effects.channels):
            return Losses(
                wp.float64(normal),
                wp.float64(tangential[0]),
                wp.float64(tangential[1]),
                wp.float64(tangential[2]),
                wp.float64(rolled),
            )
        else:
            return Losses(wp.float64(normal + tangential[0] + tangential[1] + tangential[2] + rolled))

    @wp.func
    def contact(
        law: Law,
        radius: real,
        mass: real,
        overlap: real,
        normal: vec3,
        motion: Motion,
        old: History,
        h: real,
    ):
        """Forces on i, what the contact remembers, and the energy lost.

        Parameters
        ----------
        law : Law
        radius, mass : R* [m], m* [kg]
        overlap [m], normal
            The normal points from the partner to i.
        motion : Motion
            Of i's surface relative to the partner's.
        old : History
            Of the step before.
        h : time that this step stands for [s]

        Returns
        -------
        force : vec3 [N]
        rolling_force : vec3 [N]
            Its moment on i is R* normal x rolling_force.
        history : History
        losses : Losses [J]
            In the order of ``columns.LOSSES``, or their sum.
        """
        a = wp.sqrt(radius * overlap)
        normal_force = FOUR_THIRDS * law.modulus * a * overlap
        root = real(0.0)
        approach = real(0.0)
        lost = real(0.0)
        if wp.static(effects.dashpots):
            root = wp.sqrt(mass * a)
            approach = -wp.dot(motion.velocity, normal)
            dashpot = at_least(law.normal_damping * root * approach, -normal_force)  # no tension
            normal_force += dashpot
            lost = dashpot * approach * h

        force = normal_force * normal
        rolling_force = vec3()
        history = History()
        if wp.static(effects.history):
            history.radius = a
        tangential_lost = vec3()
        if wp.static(effects.friction):
            rate = motion.velocity + approach * normal
            limit = law.friction * normal_force
            friction, stretch, tangential_lost = resistance(
                law, a, root, old.radius, old.stretch, motion.slid, rate, normal, motion, limit, h
            )
            force += friction
            history.stretch = stretch
        rolling_lost = vec3()
        if wp.static(effects.rolling):
            limit = law.rolling_friction * normal_force
            rolling_force, roll, rolling_lost = resistance(
                law, a, root, old.radius, old.roll, motion.rolled, motion.rolling, normal, motion, limit, h
            )
            history.roll = roll
        return force, rolling_force, history, losses(lost, tangential_lost, rolling_lost)

    @wp.func
    def remembered_energy(law: Law, old: History):
        """Energy in the springs in the contact plane, St stretch^2 / 2 [J]: (tangential, rolling)."""
        half_stiffness = real(4.0) * law.shear_modulus * old.radius
        tangential = real(0.0)
        rolling = real(0.0)
        if wp.static(effects.friction):
            tangential = half_stiffness * wp.dot(old.stretch, old.stretch)
        if wp.static(effects.rolling):
            rolling = half_stiffness * wp.dot(old.roll, old.roll)
        return tangential, rolling

    @wp.func
    def parted(law: Law, old: History):
        """Stored energy lost by a contact that has ended, as ``losses``."""
        tangential, rolling = remembered_energy(law, old)
        return losses(real(0.0), vec3(real(0.0), real(0.0), tangential), vec3(rolling, real(0.0), real(0.0)))

    @wp.func
    def elastic_energy(law: Law, touch: Touch):
        """Energy of the Hertz spring, 2/5 Fn d = 8/15 E* a d^2 [J]."""
        return EIGHT_FIFTEENTHS * law.modulus * wp.sqrt(touch.radius * touch.overlap) * touch.overlap * touch.overlap

    return contact, parted, elastic_energy, remembered_energy
