"""Structs of the device: what a case is, what a particle carries, what a contact remembers.

A field that no effect of the scene needs does not exist: structs are made for the effects, as kernels are.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .columns import IMPULSES, columns, losses

SIDE, FLOOR, LID = wp.constant(0), wp.constant(1), wp.constant(2)
WALLS = wp.constant(3)
"""What wall w does to particle i is remembered in ``Contacts.wall[WALLS * i + w]``."""

PER_PARTICLE = {"start": 1, "touching_walls": WALLS, "wall": WALLS}
"""Arrays of ``Contacts`` with so many elements for each particle."""

PER_PAIR = ("owner", "partner", "nearby", "touching", "pair")
"""Those with one for each pair of the neighbour list."""

SCRATCH = ("nearby", "touching", "touching_walls")
"""Those that mean nothing outside a launch."""


@functools.cache
def types(effects):
    """Structs and vectors for the given effects."""
    # Warp shares kernels of equal code, so effects of equal structs must share those, too
    shared = structs(effects.in_memory)
    lost = wp.types.vector(len(losses(effects)), wp.float64)
    row = wp.types.vector(len(columns(effects)), wp.float64)
    impulses = wp.types.vector(len(IMPULSES), effects.real)
    return SimpleNamespace(**vars(shared), Losses=lost, Row=row, Impulses=impulses, columns=columns(effects))


@functools.cache
def structs(effects):
    """Structs for the given effects; see ``Effects.in_memory`` for those that do not matter."""
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
        """Constants of a case."""

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
            enclosures: wp.int32  # of its structure, which are the cases from here on; 0: on that of a case before
            first_mode: wp.int32  # its structure's modes are first_mode .. first_mode + modes - 1
            modes: wp.int32
            first_amplitude: wp.int32  # and their amplitudes at its enclosure are those from first_amplitude on
            particle_mass: real  # of all its particles [kg]
            excitation: real  # amplitude of the harmonic force on it [N], or of the base's acceleration [m/s^2]
            base_moves: wp.int32  # 1: the excitation is the base's acceleration; 0: a force at the first enclosure
            first_sample: wp.int32  # the excitation's samples are first_sample .. first_sample + samples - 1
            samples: wp.int32
            sample_step: real  # [s] between them
            record: wp.int32  # steps between records; 0: none
            first_record: wp.int32
            records: wp.int32
        else:
            acceleration: real  # amplitude of the drive [m/s^2]
        if not effects.sizes:
            particle_radius: real  # of every particle [m]
            particle_curvature: real  # one over it
        if effects.alike:
            inverse_mass: real  # of every particle [1/kg]
            inverse_inertia: real
        if effects.materials:
            species: wp.int32  # how many
            first_law: wp.int32  # its laws are first_law + species_i species + species_j
            first_wall_law: wp.int32  # and first_wall_law + species_i
        else:
            particle_law: Law
            wall_law: Law

    @wp.struct
    class Particle:
        """State of a particle, side by side in memory: a contact touches few cache lines."""

        position: vec3  # at n
        half_velocity: vec3  # at n - 1/2
        if effects.spheroids:
            axis: vec3  # unit vector, at n
            half_momentum: vec3  # angular, at n - 1/2
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
        if effects.spheroids:
            across2: real  # b^2 [m^2], b the semi-axis across the axis
            excess: real  # a^2 - b^2 [m^2], a the one along it
            reach: real  # the larger of them [m]
            tilt: real  # |a - b|: longest lever of a normal [m]
            flattest: real  # largest radius of curvature of its surface [m]
            inverse_transverse: real  # 1 / I_t
            inverse_axial: real  # 1 / I_a
        if effects.materials:
            species: wp.int32

    @wp.struct
    class History:
        """History of a contact: its values at the last step."""

        radius: real  # contact radius a [m]; 0: there was no contact
        if effects.friction:
            stretch: vec3  # of the tangential spring [m]
        if effects.rolling:
            roll: vec3  # of the rolling spring [m]
        if effects.spheroids:
            normal: vec3  # of the last step, or one that kept the two apart
            arm: vec3  # from i's centre to the contact at the last step [m]

    @wp.struct
    class Contacts:
        """Neighbour list (pairs i < j sorted by i, then j), and what each contact remembers; in a mixture, the laws."""

        start: wp.array(dtype=wp.int32)  # pairs of i: start[i] .. start[i + 1] - 1
        owner: wp.array(dtype=wp.int32)  # i of every pair
        partner: wp.array(dtype=wp.int32)  # and j
        nearby: wp.array(dtype=wp.int32)  # places of the pairs that may touch within the next steps
        touching: wp.array(dtype=wp.int32)  # places of the pairs that touch, noted anew every step
        touching_walls: wp.array(dtype=wp.int32)  # and of the walls
        if effects.history:
            pair: wp.array(dtype=History)
            wall: wp.array(dtype=History)  # at WALLS i + (SIDE, FLOOR or LID)
        if effects.materials:
            laws: wp.array(dtype=Law)
            wall_laws: wp.array(dtype=Law)

    @wp.struct
    class Mode:
        """Mode of the host structure, mass-normalised."""

        stiffness: real  # w^2 [1/s^2]
        damping: real  # zeta w [1/s]
        participation: real  # Gamma, of a base that moves along the direction [kg^0.5]
        position: real  # q at n [m kg^0.5]
        velocity: real  # at n - 1/2
        change: real  # of the velocity over the last step

    @wp.struct
    class Enclosure:
        """What a step notes of an enclosure on a structure, from the contacts' forces to the motion."""

        reaction: real  # the particles' force on it along the direction [N]
        place: real  # x along the direction [m]
        nearby: wp.int32  # end of the pairs that may touch
        way: real  # the longest that a particle may have gone since they were noted [m]

    @wp.struct
    class HostStructure:
        """Host structures of all cases: their modes, what moves them, and records."""

        count: wp.int32  # of modes of all cases together
        if effects.structure:
            modes: wp.array(dtype=Mode)
            amplitudes: wp.array(dtype=real)  # phi at every enclosure along the direction, by its modes [kg^-0.5]
            enclosures: wp.array(dtype=Enclosure)  # one a case
            signal: wp.array(dtype=real)  # samples of forces [N] and of bases' accelerations [m/s^2]
            records: wp.array(dtype=wp.vec3d)  # place [m], acceleration [m/s^2] of the enclosure, reaction [N]

    @wp.struct
    class Touch:
        """Geometry of a contact of i with a particle or a wall: what the contact law needs of the shapes."""

        overlap: real  # [m]; not positive: they are apart
        normal: vec3  # from the partner to i
        if effects.spheroids:
            place_i: vec3  # of the contact, from i's centre [m]
            place_j: vec3  # and from j's
            rolling_radius: real  # R* of the spheres of their volumes [m]
            gradient: vec3  # force on i of the change of R* over half of the energy [1/m]
            couple: vec3  # and its couple beside that force
        else:
            distance: real  # of the centres, or of the centre and the wall [m]
            arm_i: real  # distance of i's centre from the contact along the normal [m]
            arm_j: real  # and of j's
        radius: real  # R* [m]
        curvature: real  # 1 / R* [1/m]
        mass: real  # m* [kg]

    @wp.struct
    class Pose:
        """Two spheroids as they lie; see ``support.py``."""

        branch: vec3  # from j's centre to i's
        axis_i: vec3
        axis_j: vec3
        across2_i: real  # b^2
        across2_j: real
        excess_i: real  # a^2 - b^2
        excess_j: real

    @wp.struct
    class Facing:
        """Two spheroids along a direction."""

        normal: vec3
        cosine_i: real  # with i's axis
        cosine_j: real
        along: real  # branch.normal
        height_i: real
        height_j: real
        inverse_i: real  # 1 / height_i
        inverse_j: real
        gap: real

    @wp.struct
    class Bent:
        """Sum of two spheroids' matrices of radii of curvature and of their gap, in the tangent plane."""

        pp: real  # squares of the axes' parts in the plane, and their product
        qq: real
        pq: real
        beta_i: real
        beta_j: real
        whole: real
        determinant: real

    @wp.struct
    class Motion:
        """Motion of i's surface relative to its partner's; what no effect needs stays zero and costs nothing."""

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
        Enclosure=Enclosure,
        HostStructure=HostStructure,
        Motion=Motion,
        Touch=Touch,
        Pose=Pose,
        Facing=Facing,
        Bent=Bent,
        History=History,
    )
