"""Contacts one by one, as they are between two steps: their force, and what they lose in the step that follows.

Nothing here moves a particle or a spring.  Where particles are spheroids the search for contacts keeps the directions
that it finds: give it copies of the contacts' histories, and a run that is looked at keeps its bits.
"""

import functools

import warp as wp

from .cylinder import wall_contacts
from .options import UNIQUE
from .pairs import pair_contacts
from .shape import shape
from .structs import FLOOR, LID, SIDE, WALLS, types


@functools.cache
def probe(effects):
    """Return the kernels ``probe_pairs`` and ``probe_walls`` for the given effects."""
    t = types(effects)
    real, vec3, Losses = t.real, t.vec3, t.Losses
    Case, Particle, Contacts = t.Case, t.Particle, t.Contacts
    pair_contact = pair_contacts(effects, 1).pair_contact
    wall_contact = wall_contacts(effects, 1).wall_contact
    s = shape(effects)
    pair_near, wall_near = s.pair_near, s.wall_near
    channels = wp.constant(t.Losses._length_)

    @wp.func
    def total(losses: Losses):
        """Sum over the channels [J]."""
        lost = wp.float64(0.0)
        for channel in range(channels):
            lost += losses[channel]
        return lost

    @wp.kernel(**UNIQUE)
    def probe_pairs(
        cases: wp.array(dtype=Case),
        group: wp.array(dtype=wp.int32),
        p: wp.array(dtype=Particle),
        c: Contacts,
        # out:
        force: wp.array(dtype=vec3),
        lost: wp.array(dtype=wp.float64),
    ):
        """Force on the first particle of every listed pair [N], and the loss of a step [J]; zero where they part."""
        k = wp.tid()
        force[k] = vec3()
        lost[k] = wp.float64(0.0)
        case = cases[group[c.owner[k]]]
        if pair_near(case, p, c, k, real(0.0)) == 1:
            f, _on_i, _on_j, _history, losses, _depth = pair_contact(case, p, c, k, case.dt, case.dt)
            force[k] = f
            lost[k] = total(losses)

    @wp.func
    def there(wall: int):
        """Whether the cavity has a wall."""
        present = wp.bool(False)
        if wp.static(effects.side):
            present = present or wall == SIDE
        if wp.static(effects.floor):
            present = present or wall == FLOOR
        if wp.static(effects.lid):
            present = present or wall == LID
        return present

    @wp.kernel(**UNIQUE)
    def probe_walls(
        cases: wp.array(dtype=Case),
        group: wp.array(dtype=wp.int32),
        p: wp.array(dtype=Particle),
        c: Contacts,
        # out:
        force: wp.array(dtype=vec3),
        lost: wp.array(dtype=wp.float64),
    ):
        """Force of every wall on every particle [N], and the loss of a step [J], at WALLS i + wall."""
        place = wp.tid()
        i = place / WALLS
        force[place] = vec3()
        lost[place] = wp.float64(0.0)
        case = cases[group[i]]
        wall = place - WALLS * i
        if there(wall):
            if wall_near(case, p, c, i, wall) == 1:
                f, _torque, _history, losses, _depth = wall_contact(case, p, c, place, case.dt, case.dt)
                force[place] = f
                lost[place] = total(losses)

    return probe_pairs, probe_walls
