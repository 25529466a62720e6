"""The energy ledger: what a case has lost, gained and stored, and the first harmonic of the enclosure's reaction.

All sums are float64 whatever the precision of the motion.  Losses come from the contacts' own formulas, stored energies
from the state, the work input from the inertial force; nothing is computed as a remainder, so the residual

    work_input - change of stored energy - losses

is an independent check of every run.
"""

import functools
from enum import IntEnum
from types import SimpleNamespace

import warp as wp

from .columns import IMPULSES, PLACES, columns, losses
from .cylinder import wall_contacts
from .pairs import pair_contacts
from .particles import particles
from .shape import shape
from .structs import types
from .structure import structure


@functools.cache
def ledger(effects, count: int):
    """Return what fills the ledger's rows for the given effects, and the number of each ``Column``.

    ``count`` is that of contacts side by side, so that the functions are those of the forces.
    """
    t = types(effects)
    real, vec3, Losses, Row, Impulses = t.real, t.vec3, t.Losses, t.Row, t.Impulses
    Case, Particle, Contacts, HostStructure = t.Case, t.Particle, t.Contacts, t.HostStructure
    modal_energy = structure(effects).modal_energy
    Column = IntEnum("Column", columns(effects), start=0)
    LOSSES = wp.constant(len(losses(effects)))
    PARTICLE_LOSSES, WALL_LOSSES = (wp.constant(int(Column[f"{place}_{losses(effects)[0]}"])) for place in PLACES)
    IMPULSE = wp.constant(int(Column[IMPULSES[0]]) if effects.indicators else 0)
    WALLS_PRESSED = wp.constant(len(IMPULSES))
    pair_energy = pair_contacts(effects, count).pair_energy
    wall_energy = wall_contacts(effects, count).wall_energy
    inverse_mass_of = particles(effects).inverse_mass_of
    rotational_energy = shape(effects).rotational_energy

    @wp.func
    def tally(
        case: Case,
        row: Row,
        pair_losses: Losses,
        wall_losses: Losses,
        largest: real,
        reaction: vec3,
        cosine: wp.float64,
        sine: wp.float64,
        h: real,
    ):
        """Add what a step's contacts did: losses, deepest overlap, first harmonic of the reaction along the drive."""
        for k in range(LOSSES):
            row[PARTICLE_LOSSES + k] += pair_losses[k]
            row[WALL_LOSSES + k] += wall_losses[k]
        along = wp.float64(wp.dot(reaction, case.direction) * h)
        row[Column.reaction_cosine] += along * cosine
        row[Column.reaction_sine] += along * sine
        row[Column.largest_overlap] = wp.max(row[Column.largest_overlap], wp.float64(largest))
        return row

    @wp.func
    def add_impulses(row: Row, pressed: Impulses, h: real):
        """Add the impulses of the normal forces on walls."""
        for k in range(WALLS_PRESSED):
            row[IMPULSE + k] += wp.float64(pressed[k] * h)
        return row

    @wp.func
    def begin_cycle(case: Case, p: wp.array(dtype=Particle), cycle_start: wp.array(dtype=vec3)):
        """Begin a cycle: remember where every particle is."""
        for i in range(case.first, case.first + case.count):
            cycle_start[i] = p[i].position

    @wp.func
    def cycle_displacement(case: Case, p: wp.array(dtype=Particle), cycle_start: wp.array(dtype=vec3), row: Row):
        """End a cycle: how far the particles have moved from one another, root mean square."""
        common = wp.vec3d()
        square = wp.float64(0.0)
        for i in range(case.first, case.first + case.count):
            moved = wp.vec3d(p[i].position - cycle_start[i])
            common += moved
            square += wp.dot(moved, moved)
        n = wp.float64(case.count)
        row[Column.displacement] = wp.sqrt(wp.max(square - wp.dot(common, common) / n, wp.float64(0.0)) / n)
        return row

    @wp.func
    def stored(case: Case, p: wp.array(dtype=Particle), c: Contacts, host: HostStructure, row: Row, offset: real):
        """Fill in the stored energies, positions taken ``offset`` seconds back (velocities and springs lie there)."""
        momentum = wp.float64(0.0)
        weight = wp.float64(0.0)
        total = wp.float64(0.0)
        translation = wp.float64(0.0)
        rotation = wp.float64(0.0)
        gravity = wp.float64(0.0)
        for i in range(case.first, case.first + case.count):
            v = p[i].half_velocity
            mass = real(1.0) / inverse_mass_of(case, p, i)
            translation += wp.float64(real(0.5) * mass * wp.dot(v, v))
            if wp.static(effects.structure):
                total += wp.float64(mass)
                momentum += wp.float64(mass * wp.dot(v, case.direction))
                if wp.static(effects.gravity):
                    weight += wp.float64(mass * wp.dot(case.gravity, case.direction))
            if wp.static(effects.rotation):
                rotation += wp.float64(rotational_energy(case, p, i))
            if wp.static(effects.gravity):
                gravity -= wp.float64(mass * wp.dot(case.gravity, p[i].position - offset * v))
        elastic = pair_energy(case, p, c, offset)
        if wp.static(effects.enclosure):
            elastic += wall_energy(case, p, c, offset)
        row[Column.kinetic_translation] = translation
        row[Column.kinetic_rotation] = rotation
        row[Column.gravity] = gravity
        row[Column.elastic_normal] = elastic[0]
        row[Column.elastic_tangential] = elastic[1]
        row[Column.elastic_rolling] = elastic[2]
        if wp.static(effects.structure):
            energy, place, velocity = modal_energy(case, host, offset)
            speed = wp.float64(velocity)
            row[Column.structure_energy] = energy
            row[Column.frame_energy] = (
                speed * momentum + wp.float64(0.5) * total * speed * speed - weight * wp.float64(place)
            )
        return row

    @wp.func
    def worked(case: Case, row: Row, work: wp.float64, momentum: wp.vec3d, base: real, h: real):
        """Add the work of the inertial force, and what a base that moves does by the particles' momentum."""
        row[Column.work_input] += work
        if wp.static(effects.structure):
            row[Column.force_work] -= wp.float64(base * h) * wp.dot(momentum, wp.vec3d(case.direction))
        return row

    return SimpleNamespace(
        tally=tally,
        add_impulses=add_impulses,
        begin_cycle=begin_cycle,
        cycle_displacement=cycle_displacement,
        stored=stored,
        worked=worked,
        Column=Column,
    )
