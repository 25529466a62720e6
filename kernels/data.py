"""The nouns of the device: what a case is, what a particle carries, what a contact remembers.

A field that no effect of the scene needs does not exist: structs are made for the effects, as kernels are.
"""

import functools
from dataclasses import replace
from types import SimpleNamespace

import warp as wp

LOSSES = ("normal_dashpot", "tangential_dashpot", "slip", "history", "rolling")
"""Channels in which contacts lose energy."""

STORES = (
    "kinetic_translation",
    "kinetic_rotation",
    "gravity",
    "elastic_normal",
    "elastic_tangential",
    "elastic_rolling",
)

UNIQUE = {
    "module": "unique",
    "enable_backward": False,
    "module_options": {
        "cpu_compiler_flags": f"{wp.config.cpu_compiler_flags} "
        "-ffp-contract=fast -freciprocal-math -fno-signed-zeros -mreassociate"
    },
}
"""How every kernel is compiled: on its own, without an adjoint, free to fuse, to reorder and to use reciprocals (a
seventh of the time), but not to forget about NaN."""

OK = 0
NOT_FINITE = 1
ESCAPED = 2


INDICATORS = ("floor_impulse", "lid_impulse", "displacement")
"""What tells the regime of motion: normal impulses on floor and lid [N s], and the particles' root mean square
displacement over the last cycle, less the common one [m].  The last is of the moment."""

STRUCTURE = ("force_work", "structure_loss", "structure_energy", "frame_energy")
"""With a structure: work of the force on it, its own losses, its energy, and what the particles' kinetic and
gravitational energy in the laboratory exceeds that in the enclosure's frame by.  The last two are of the moment."""


def columns(effects):
    """Names of a ledger row's columns: losses by channel or in total, indicators and the structure's if there are any.

    All are energies [J], except: reaction_* = integral of the reaction along the drive times cos, sin [N s];
    largest_overlap = overlap over the reduced radius.  All but ``STORES`` accumulate from step 0.
    """
    losses = LOSSES if effects.channels else ("total",)
    return (
        *(f"particle_{name}" for name in losses),
        *(f"wall_{name}" for name in losses),
        "work_input",
        "reaction_cosine",
        "reaction_sine",
        "largest_overlap",
        *STORES,
        *(INDICATORS if effects.indicators else ()),
        *(STRUCTURE if effects.structure else ()),
    )


@functools.cache
def types(effects):
    """Structs and vectors for the given effects."""
    # Warp shares kernels of equal code, so effects of equal structs must share those, too
    wall = effects.enclosure
    own = structs(replace(effects, channels=True, indicators=True, guards=True, side=wall, floor=wall, lid=wall))
    losses = wp.types.vector(len(LOSSES) if effects.channels else 1, wp.float64)
    row = wp.types.vector(len(columns(effects)), wp.float64)
    return SimpleNamespace(**vars(own), Losses=losses, Row=row)


@functools.cache
def structs(effects):
    """Structs for the given effects; ``channels``, ``indicators``, ``guards`` and the choice of walls do not matter."""
    real = effects.real
    vec3 = wp.types.vector(3, real)

    @wp.struct
    class Law:
        """Contact constants of two materials; see ``contact.py``."""

        modulus: real  # E* [Pa]
        if effects.dashpots:
            normal_damping: real  # 2 sqrt(5/6) b sqrt(2 E*)
        if effects.history:
            shear_modulus: real  # G* [Pa]
        if effects.history and effects.dashpots:
            tangential_damping: real  # 2 sqrt(5/6) b sqrt(8 G*)
        if effects.friction:
            friction: real
        if effects.rolling:
            rolling_friction: real

    @wp.struct
    class Case:
        """What stays constant while a case runs."""

        first: wp.int32  # its particles are first .. first + count - 1
        count: wp.int32
        first_row: wp.int32  # its ledger rows start here
        rows: wp.int32  # and are so many
        cycle: wp.int32  # steps per cycle of the drive (a row is written at the end of each)
        dt: real  # [s]
        skin: real  # extra reach of the neighbour list [m]
        if effects.enclosure:
            radius: real  # of the cavity [m]
            height: real  # of the cavity [m]
        if effects.gravity:
            gravity: vec3  # [m/s^2]
        direction: vec3  # unit vector of the drive
        if effects.structure:
            first_mode: wp.int32  # its modes are first_mode .. first_mode + modes - 1
            modes: wp.int32
            force: real  # amplitude of the harmonic force on it [N]
            first_sample: wp.int32  # its force's samples are first_sample .. first_sample + samples - 1
            samples: wp.int32
            sample_step: real  # [s] between them
            record: wp.int32  # steps between records; 0: none
            first_record: wp.int32
            records: wp.int32
        else:
            acceleration: real  # amplitude of the drive [m/s^2]
        if not effects.sizes:
            grain_radius: real  # of every particle [m]
            grain_curvature: real  # one over it
        if effects.alike:
            inverse_mass: real  # of every particle [1/kg]
            inverse_inertia: real
        if effects.materials:
            species: wp.int32  # how many
            first_law: wp.int32  # its laws are first_law + species_i species + species_j
            first_wall_law: wp.int32  # and first_wall_law + species_i
        else:
            grain_law: Law
            wall_law: Law

    @wp.struct
    class Particle:
        """What a particle carries, side by side in memory: a contact touches few cache lines."""

        position: vec3  # at n
        half_velocity: vec3  # at n - 1/2
        if effects.rotation:
            half_spin: vec3  # at n - 1/2
        if effects.dashpots:
            velocity: vec3  # predicted for n
        if effects.rotation and effects.dashpots:
            spin: vec3  # predicted for n
        force: vec3
        if effects.rotation:
            torque: vec3
        listed: vec3  # position when the neighbour list was made
        if effects.sizes:
            radius: real
        if not effects.alike:
            inverse_mass: real
            inverse_inertia: real
        if effects.materials:
            species: wp.int32

    @wp.struct
    class History:
        """What a contact remembers of the last step."""

        radius: real  # contact radius a [m]; 0: there was no contact
        if effects.friction:
            stretch: vec3  # of the tangential spring [m]
        if effects.rolling:
            roll: vec3  # of the rolling spring [m]

    @wp.struct
    class Contacts:
        """Neighbour list (pairs i < j sorted by i, then j), and what each contact remembers; in a mixture, the laws."""

        start: wp.array(dtype=wp.int32)  # pairs of i: start[i] .. start[i + 1] - 1
        partner: wp.array(dtype=wp.int32)
        if effects.history:
            pair: wp.array(dtype=History)
            wall: wp.array(dtype=History)  # 3 i + (0 side, 1 floor, 2 lid)
        if effects.materials:
            laws: wp.array(dtype=Law)
            wall_laws: wp.array(dtype=Law)

    @wp.struct
    class Mode:
        """A mode of the structure, mass-normalised."""

        stiffness: real  # w^2 [1/s^2]
        damping: real  # zeta w [1/s]
        amplitude: real  # phi at the damper along the direction [kg^-0.5]
        position: real  # q at n [m kg^0.5]
        velocity: real  # at n - 1/2

    @wp.struct
    class Mount:
        """What the enclosure is fixed to: the modes of all cases, their forces, and records of what happened."""

        count: wp.int32  # of modes of all cases together
        if effects.structure:
            modes: wp.array(dtype=Mode)
            force: wp.array(dtype=real)  # [N]
            records: wp.array(dtype=wp.vec3d)  # place [m], acceleration [m/s^2] of the enclosure, reaction [N]

    @wp.struct
    class Motion:
        """Of i's surface relative to its partner's; what no effect needs stays zero and costs nothing."""

        velocity: vec3  # predicted for this step [m/s]
        slid: vec3  # how far since the last step [m]
        tilted: vec3  # change of the normal since the last step
        turned: real  # of both about the normal since the last step, in the mean [rad]
        rolling: vec3  # R* (spin_i - spin_j) x normal, predicted for this step [m/s]
        rolled: vec3  # how far since the last step [m]

    return SimpleNamespace(
        real=real,
        vec3=vec3,
        Law=Law,
        Case=Case,
        Particle=Particle,
        Contacts=Contacts,
        Mode=Mode,
        Mount=Mount,
        Motion=Motion,
        History=History,
    )
