"""The time loop.  One case is one thread, and the thread runs many steps."""

import functools

import warp as wp

from .cylinder import wall_contacts
from .data import ESCAPED, NOT_FINITE, UNIQUE, types
from .ledger import ledger
from .motion import motion
from .pairs import pair_contacts
from .structure import structure

_NOT_FINITE, _ESCAPED = wp.constant(NOT_FINITE), wp.constant(ESCAPED)


@functools.cache
def stepper(effects):
    """Return the kernels ``advance`` and ``synchronise`` for the given effects."""
    t = types(effects)
    real, vec3, Losses, Row = t.real, t.vec3, t.Losses, t.Row
    Case, Particle, Contacts, Mount = t.Case, t.Particle, t.Contacts, t.Mount
    pair_forces, _ = pair_contacts(effects)
    wall_forces, _, contained = wall_contacts(effects)
    enclosure_phase, integrate, kick = motion(effects)
    book = ledger(effects)
    tally, stored, WORK, FORCE_WORK = book.tally, book.stored, book.WORK, book.FORCE_WORK
    pushed, leave, returned = book.pushed, book.leave, book.returned
    s = structure(effects)
    answer, record, enclosure_place = s.answer, s.record, s.enclosure_place

    @wp.func
    def forces(
        case: Case,
        p: wp.array(dtype=Particle),
        c: Contacts,
        mount: Mount,
        step: wp.int64,
        h: real,
        since: real,
        drift: real,
        row: Row,
    ):
        """All contact forces of a step, tallied, and the structure's answer.

        The step stands for ``h`` seconds and comes ``since`` seconds after the last one; the enclosure's place
        advances over ``drift``.  Returns minus the enclosure's acceleration [m/s^2] and the row.
        """
        pair_losses, largest = pair_forces(case, p, c, h, since)
        reaction = vec3()
        wall_losses = Losses()
        if wp.static(effects.enclosure):
            reaction, wall_losses, wall_largest, on_floor, on_lid = wall_forces(case, p, c, h, since)
            largest = wp.max(largest, wall_largest)
            if wp.static(effects.indicators):
                row = pushed(row, on_floor, on_lid, h)
        cosine, sine = enclosure_phase(case, step)
        row = tally(case, row, pair_losses, wall_losses, largest, reaction, cosine, sine, h)
        if wp.static(effects.structure):
            along = wp.dot(reaction, case.direction)
            place = enclosure_place(case, mount)
            acceleration, force_work, loss = answer(case, mount, step, along, h, drift)
            if drift > real(0.0):
                record(case, mount, step, place, acceleration, along)
            row[FORCE_WORK] += force_work
            row[FORCE_WORK + 1] += loss
            return -acceleration * case.direction, row
        else:
            return case.acceleration * real(sine) * case.direction, row

    @wp.kernel(**UNIQUE)
    def advance(
        cases: wp.array(dtype=Case),
        target: wp.array(dtype=wp.int64),
        p: wp.array(dtype=Particle),
        c: Contacts,
        mount: Mount,
        # in and out:
        steps: wp.array(dtype=wp.int64),
        drifts: wp.array(dtype=vec3),
        left: wp.array(dtype=vec3),
        tallies: wp.array(dtype=Row),
        # out:
        rows: wp.array(dtype=Row),
        status: wp.array(dtype=wp.int32),
    ):
        """Run each case until its target step or until its neighbour list is used up.

        ``left`` holds where the particles were at the end of the last cycle, apart from them: it is seldom looked at.
        """
        n = wp.tid()
        case = cases[n]
        step = steps[n]
        drift = drifts[n]
        row = tallies[n]
        limit2 = real(0.25) * case.skin * case.skin
        travel2 = real(0.0)
        while step < target[n] and travel2 <= limit2:
            h = case.dt
            since = case.dt
            if step == wp.int64(0):
                h = real(0.5) * case.dt  # from the given velocities at step 0 to the half step
                since = real(0.0)
                rows[case.first_row] = stored(case, p, c, mount, row, real(0.0))
                if wp.static(effects.indicators):
                    leave(case, p, left)

            inertial, row = forces(case, p, c, mount, step, h, since, case.dt, row)
            work, travel2, mean_velocity = integrate(case, p, inertial, h, drift)
            row[WORK] += work
            drift += case.dt * mean_velocity
            step += wp.int64(1)
            if wp.static(effects.guards):
                if not wp.isfinite(wp.dot(mean_velocity, mean_velocity)):  # wp.max would drop a NaN: ask for it
                    travel2 = real(wp.inf)
                    status[n] = _NOT_FINITE

            if step % wp.int64(case.cycle) == wp.int64(0):
                cycle = wp.int32(step / wp.int64(case.cycle))
                if wp.static(effects.indicators):
                    row = returned(case, p, left, row)
                    leave(case, p, left)
                if cycle < case.rows:
                    rows[case.first_row + cycle] = stored(case, p, c, mount, row, real(0.5) * case.dt)
        if wp.static(effects.guards and effects.enclosure):
            if status[n] == 0 and not contained(case, p):
                status[n] = _ESCAPED
        steps[n] = step
        drifts[n] = drift
        tallies[n] = row

    @wp.kernel(**UNIQUE)
    def synchronise(
        cases: wp.array(dtype=Case),
        steps: wp.array(dtype=wp.int64),
        # in and out: copies, for the run goes on from its half step
        p: wp.array(dtype=Particle),
        c: Contacts,
        mount: Mount,
        tallies: wp.array(dtype=Row),
    ):
        """Bring velocities, springs and ledger from the half step to the whole one, to be read."""
        n = wp.tid()
        case = cases[n]
        row = tallies[n]
        step = steps[n]
        if step > wp.int64(0):
            h = real(0.5) * case.dt
            inertial, row = forces(case, p, c, mount, step, h, case.dt, real(0.0), row)
            row[WORK] += kick(case, p, inertial, h)
        tallies[n] = stored(case, p, c, mount, row, real(0.0))

    return advance, synchronise
