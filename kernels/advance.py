"""Time loop.  One case is one thread, and the thread runs many steps.

Cases that share a structure advance together by ``coupled.py``.
"""

import functools

import warp as wp

from .columns import KernelStatus
from .cylinder import wall_contacts
from .forces import NEARBY, forces_of_contacts
from .lanes import promises
from .ledger import ledger
from .motion import motion
from .options import UNIQUE
from .pairs import pair_contacts
from .structs import types
from .structure import structure

OK, NOT_FINITE, ESCAPED = (wp.constant(int(status)) for status in KernelStatus)


@functools.cache
def stepper(effects, count: int):
    """Return the kernels ``advance`` and ``synchronise`` for the given effects, ``count`` contacts side by side."""
    t = types(effects)
    real, vec3, Row = t.real, t.vec3, t.Row
    Case, Particle, Contacts, HostStructure = t.Case, t.Particle, t.Contacts, t.HostStructure
    nearby_pairs = pair_contacts(effects, count).nearby_pairs
    contained = wall_contacts(effects, count).contained
    contact_forces = forces_of_contacts(effects, count)
    _, integrate, kick = motion(effects)
    book = ledger(effects, count)
    stored, worked, Column = book.stored, book.worked, book.Column
    begin_cycle, cycle_displacement = book.begin_cycle, book.cycle_displacement
    contiguous_contacts = promises(effects)
    s = structure(effects)
    answer, record, enclosure_place = s.answer, s.record, s.enclosure_place

    @wp.func
    def forces(
        case: Case,
        p: wp.array(dtype=Particle),
        c: Contacts,
        nearby: int,
        host: HostStructure,
        step: wp.int64,
        h: real,
        since: real,
        drift: real,
        row: Row,
    ):
        """Contact forces of a step, added to the ledger, and the structure's answer.

        ``nearby`` is the end of the nearby pairs.  The step stands for ``h`` seconds and comes ``since`` seconds after
        the last one; the enclosure's place advances over ``drift`` seconds.  Returns minus the enclosure's acceleration
        and that of the structure's base [m/s^2], and the row.
        """
        reaction, sine, row = contact_forces(case, p, c, nearby, step, h, since, row)
        if wp.static(effects.structure):
            along = wp.dot(reaction, case.direction)
            place = enclosure_place(case, host)
            acceleration, base, force_work, loss = answer(case, host, step, along, h, drift)
            if drift > real(0.0):
                record(case, host, step, place, acceleration, along)
            row[Column.force_work] += force_work
            row[Column.structure_loss] += loss
            return -acceleration * case.direction, base, row
        else:
            return case.acceleration * real(sine) * case.direction, real(0.0), row

    @wp.kernel(**UNIQUE)
    def advance(
        cases: wp.array(dtype=Case),
        p: wp.array(dtype=Particle),
        c: Contacts,
        host: HostStructure,
        # in and out:
        target: wp.array(dtype=wp.int64),
        steps: wp.array(dtype=wp.int64),
        shifts: wp.array(dtype=vec3),
        cycle_start: wp.array(dtype=vec3),
        tallies: wp.array(dtype=Row),
        # out:
        rows: wp.array(dtype=Row),
        status: wp.array(dtype=wp.int32),
    ):
        """Run each case until its target step or until its neighbour list is used up.

        Every step searches only the pairs that may touch before a particle has gone half of ``margin``.

        ``cycle_start`` holds where the particles were at the end of the last cycle, apart from them: it is seldom
        looked at.
        """
        contiguous_contacts(c)
        n = wp.tid()
        case = cases[n]
        step = steps[n]
        shift = shifts[n]
        row = tallies[n]
        limit2 = real(0.25) * case.skin * case.skin
        travel2 = real(0.0)
        margin = real(NEARBY) * case.skin
        way = margin  # the longest that a particle may have gone since the nearby pairs were noted
        nearby = wp.int32(0)
        while step < target[n] and travel2 <= limit2:
            h = case.dt
            since = case.dt
            if step == wp.int64(0):
                h = real(0.5) * case.dt  # from the given velocities at step 0 to the half step
                since = real(0.0)
                rows[case.first_row] = stored(case, p, c, host, row, real(0.0))
                if wp.static(effects.indicators):
                    begin_cycle(case, p, cycle_start)

            if real(2.01) * way > margin:  # a little more than 2, for round-off
                nearby = nearby_pairs(case, p, c, margin)
                way = real(0.0)
            inertial, base, row = forces(case, p, c, nearby, host, step, h, since, case.dt, row)
            work, travel2, fastest2, mean_velocity, momentum = integrate(case, p, inertial, h, shift)
            way += case.dt * wp.sqrt(fastest2)
            row = worked(case, row, work, momentum, base, h)
            shift += case.dt * mean_velocity
            step += wp.int64(1)
            if wp.static(effects.guards):
                if not wp.isfinite(wp.dot(mean_velocity, mean_velocity)):  # wp.max would drop a NaN: ask for it
                    travel2 = real(wp.inf)
                    status[n] = NOT_FINITE

            if step % wp.int64(case.cycle) == wp.int64(0):
                cycle = wp.int32(step / wp.int64(case.cycle))
                if wp.static(effects.indicators):
                    row = cycle_displacement(case, p, cycle_start, row)
                    begin_cycle(case, p, cycle_start)
                if cycle < case.rows:
                    rows[case.first_row + cycle] = stored(case, p, c, host, row, real(0.5) * case.dt)
        if wp.static(effects.guards and effects.enclosure):
            if status[n] == OK and not contained(case, p):
                status[n] = ESCAPED
        if status[n] != OK:
            target[n] = wp.int64(0)  # it stops where it is
        steps[n] = step
        shifts[n] = shift
        tallies[n] = row

    @wp.kernel(**UNIQUE)
    def synchronise(
        cases: wp.array(dtype=Case),
        steps: wp.array(dtype=wp.int64),
        # in and out: copies, for the run goes on from its half step
        p: wp.array(dtype=Particle),
        c: Contacts,
        host: HostStructure,
        tallies: wp.array(dtype=Row),
    ):
        """Bring velocities, springs and ledger from the half step to the whole one, to be read."""
        n = wp.tid()
        case = cases[n]
        row = tallies[n]
        step = steps[n]
        if step > wp.int64(0):
            h = real(0.5) * case.dt
            nearby = nearby_pairs(case, p, c, real(0.0))
            inertial, base, row = forces(case, p, c, nearby, host, step, h, case.dt, real(0.0), row)
            work, momentum = kick(case, p, inertial, h)
            row = worked(case, row, work, momentum, base, h)
        tallies[n] = stored(case, p, c, host, row, real(0.0))

    return advance, synchronise
