"""Time loop of structures with several enclosures.  One structure with all its enclosures is one thread.

A step is the contacts' forces in every enclosure, then the structure's answer to all of them, then the motion in every
enclosure: none sees a structure that has already moved.
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
def coupled_stepper(effects, count: int):
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
    answer, enclosure_acceleration = s.answer_to_all, s.enclosure_acceleration
    record, enclosure_place = s.record, s.enclosure_place

    @wp.func
    def pressed(
        case: Case,
        k: int,
        p: wp.array(dtype=Particle),
        c: Contacts,
        host: HostStructure,
        step: wp.int64,
        h: real,
        since: real,
        row: Row,
    ):
        """Contact forces in enclosure ``k``, and what its structure needs to know of them."""
        reaction, _, row = contact_forces(case, p, c, host.enclosures[k].nearby, step, h, since, row)
        host.enclosures[k].reaction = wp.dot(reaction, case.direction)
        host.enclosures[k].place = enclosure_place(case, host)
        return row

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
        """Run each structure until its target step or until the neighbour list of one of its enclosures is used up."""
        contiguous_contacts(c)
        first = wp.tid()
        last = first + cases[first].enclosures
        for k in range(first, last):
            host.enclosures[k].way = real(NEARBY) * cases[k].skin
            host.enclosures[k].nearby = 0
        step = steps[first]
        failure = wp.int32(OK)
        going = last > first and step < target[first]
        while going:
            h = cases[first].dt
            since = cases[first].dt
            if step == wp.int64(0):
                h = real(0.5) * cases[first].dt  # from the given velocities at step 0 to the half step
                since = real(0.0)
            for k in range(first, last):
                case = cases[k]
                row = tallies[k]
                if step == wp.int64(0):
                    rows[case.first_row] = stored(case, p, c, host, row, real(0.0))
                    if wp.static(effects.indicators):
                        begin_cycle(case, p, cycle_start)
                margin = real(NEARBY) * case.skin
                if real(2.01) * host.enclosures[k].way > margin:  # a little more than 2, for round-off
                    host.enclosures[k].nearby = nearby_pairs(case, p, c, margin)
                    host.enclosures[k].way = real(0.0)
                tallies[k] = pressed(case, k, p, c, host, step, h, since, row)

            base, force_work, loss = answer(cases, first, host, step, h, cases[first].dt)
            step += wp.int64(1)
            going = step < target[first]
            for k in range(first, last):
                case = cases[k]
                row = tallies[k]
                if k == first:
                    row[Column.force_work] += force_work
                    row[Column.structure_loss] += loss
                acceleration = enclosure_acceleration(case, host, base, h)
                record(
                    case, host, step - wp.int64(1), host.enclosures[k].place, acceleration, host.enclosures[k].reaction
                )
                inertial = -acceleration * case.direction
                work, travel2, fastest2, mean_velocity, momentum = integrate(case, p, inertial, h, shifts[k])
                host.enclosures[k].way = host.enclosures[k].way + case.dt * wp.sqrt(fastest2)
                row = worked(case, row, work, momentum, base, h)
                shifts[k] = shifts[k] + case.dt * mean_velocity
                going = going and travel2 <= real(0.25) * case.skin * case.skin
                if wp.static(effects.guards):
                    if not wp.isfinite(wp.dot(mean_velocity, mean_velocity)):  # wp.max would drop a NaN: ask for it
                        going = False
                        failure = NOT_FINITE
                if step % wp.int64(case.cycle) == wp.int64(0):
                    cycle = wp.int32(step / wp.int64(case.cycle))
                    if wp.static(effects.indicators):
                        row = cycle_displacement(case, p, cycle_start, row)
                        begin_cycle(case, p, cycle_start)
                    if cycle < case.rows:
                        rows[case.first_row + cycle] = stored(case, p, c, host, row, real(0.5) * case.dt)
                tallies[k] = row
        for k in range(first, last):
            if wp.static(effects.guards and effects.enclosure):
                if failure == OK and not contained(cases[k], p):
                    failure = ESCAPED
            steps[k] = step
        if failure != OK:
            for k in range(first, last):  # they stop where they are, all that sit on this structure
                status[k] = failure
                target[k] = wp.int64(0)

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
        first = wp.tid()
        last = first + cases[first].enclosures
        step = steps[first]
        h = real(0.5) * cases[first].dt
        if step > wp.int64(0) and last > first:
            for k in range(first, last):
                host.enclosures[k].nearby = nearby_pairs(cases[k], p, c, real(0.0))
                tallies[k] = pressed(cases[k], k, p, c, host, step, h, cases[k].dt, tallies[k])
            base, force_work, loss = answer(cases, first, host, step, h, real(0.0))
            for k in range(first, last):
                case = cases[k]
                row = tallies[k]
                if k == first:
                    row[Column.force_work] += force_work
                    row[Column.structure_loss] += loss
                inertial = -enclosure_acceleration(case, host, base, h) * case.direction
                work, momentum = kick(case, p, inertial, h)
                tallies[k] = worked(case, row, work, momentum, base, h)
        for k in range(first, last):
            tallies[k] = stored(cases[k], p, c, host, tallies[k], real(0.0))

    return advance, synchronise
