"""Contact forces of a step: of all pairs and walls, entered into the ledger."""

import functools

import warp as wp

from .cylinder import wall_contacts
from .ledger import ledger
from .motion import motion
from .pairs import pair_contacts
from .structs import types

NEARBY = wp.constant(0.1)
"""Pairs nearer than this part of the neighbour list's extra reach are searched every step, the others now and then."""


@functools.cache
def forces_of_contacts(effects, count: int):
    """Return ``contact_forces`` for the given effects, ``count`` contacts side by side."""
    t = types(effects)
    real, vec3, Losses, Row = t.real, t.vec3, t.Losses, t.Row
    Case, Particle, Contacts = t.Case, t.Particle, t.Contacts
    pair_forces = pair_contacts(effects, count).pair_forces
    wall_forces = wall_contacts(effects, count).wall_forces
    enclosure_phase, _, _ = motion(effects)
    book = ledger(effects, count)
    tally, add_impulses = book.tally, book.add_impulses

    @wp.func
    def contact_forces(
        case: Case,
        p: wp.array(dtype=Particle),
        c: Contacts,
        nearby: int,
        step: wp.int64,
        h: real,
        since: real,
        row: Row,
    ):
        """Contact forces of a step, added to the ledger.

        ``nearby`` is the end of the nearby pairs.  The step stands for ``h`` seconds and comes ``since`` seconds after
        the last one.  Returns the force on the enclosure [N], sin(w t), and the row.
        """
        pair_losses, largest = pair_forces(case, p, c, nearby, h, since)
        reaction = vec3()
        wall_losses = Losses()
        if wp.static(effects.enclosure):
            reaction, wall_losses, wall_largest, pressed = wall_forces(case, p, c, h, since)
            largest = wp.max(largest, wall_largest)
            if wp.static(effects.indicators):
                row = add_impulses(row, pressed, h)
        cosine, sine = enclosure_phase(case, step)
        row = tally(case, row, pair_losses, wall_losses, largest, reaction, cosine, sine, h)
        return reaction, sine, row

    return contact_forces
