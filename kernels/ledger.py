"""The energy ledger: what a case has lost, gained and stored, and the first harmonic of the enclosure's reaction.

All sums are float64 whatever the precision of the motion.  Losses come from the contacts' own formulas, stored energies
from the state, the work input from the inertial force; nothing is computed as a remainder, so the residual

    work_input - change of stored energy - losses

is an independent check of every run.
"""

import functools

import warp as wp

from .cylinder import wall_contacts
from .data import COLUMNS, types
from .pairs import pair_contacts

_AT = {name: wp.constant(k) for k, name in enumerate(COLUMNS)}
WALL = _AT["wall_normal_dashpot"]
WORK = _AT["work_input"]
COSINE = _AT["reaction_cosine"]
SINE = _AT["reaction_sine"]
LARGEST = _AT["largest_overlap"]
STORED = _AT["kinetic_translation"]

Row = wp.types.vector(len(COLUMNS), wp.float64)


@functools.cache
def ledger(effects):
    """Return ``stored`` for the given effects."""
    t = types(effects.real)
    real = t.real
    Case, Particles, Contacts = t.Case, t.Particles, t.Contacts
    _, pair_energy = pair_contacts(effects)
    _, wall_energy = wall_contacts(effects)

    @wp.func
    def stored(case: Case, p: Particles, c: Contacts, row: Row, offset: real):
        """Fill in the stored energies, positions taken ``offset`` seconds back (velocities and springs lie there)."""
        translation = wp.float64(0.0)
        rotation = wp.float64(0.0)
        gravity = wp.float64(0.0)
        for i in range(case.first, case.first + case.count):
            v = p.half_velocity[i]
            spin = p.half_spin[i]
            mass = real(1.0) / p.inverse_mass[i]
            x = p.position[i] - offset * v
            translation += wp.float64(real(0.5) * mass * wp.dot(v, v))
            rotation += wp.float64(real(0.5) * wp.dot(spin, spin) / p.inverse_inertia[i])
            gravity -= wp.float64(mass * wp.dot(case.gravity, x))
        normal, tangential = pair_energy(case, p, c, offset)
        wall_normal = wp.float64(0.0)
        wall_tangential = wp.float64(0.0)
        if wp.static(effects.enclosure):
            wall_normal, wall_tangential = wall_energy(case, p, c, offset)
        row[STORED] = translation
        row[STORED + 1] = rotation
        row[STORED + 2] = gravity
        row[STORED + 3] = normal + wall_normal
        row[STORED + 4] = tangential + wall_tangential
        return row

    return stored
