"""The nouns of the device: what a case is, what a particle carries, what a contact remembers."""

import functools
from types import SimpleNamespace

import warp as wp

LOSSES = ("normal_dashpot", "tangential_dashpot", "slip", "history")
STORES = ("kinetic_translation", "kinetic_rotation", "gravity", "elastic_normal", "elastic_tangential")
COLUMNS = (
    *(f"particle_{name}" for name in LOSSES),
    *(f"wall_{name}" for name in LOSSES),
    "work_input",
    "reaction_cosine",
    "reaction_sine",
    "largest_overlap",
    *STORES,
)
"""One row of the ledger [J], except: reaction_* = integral of the reaction along the drive times cos, sin [N s];
largest_overlap = overlap over the reduced radius.  All but ``STORES`` accumulate from step 0."""

OK = 0
NOT_FINITE = 1
ESCAPED = 2


@functools.cache
def types(real):
    """Structs in the precision ``real`` (``wp.float64`` or ``wp.float32``)."""
    vec3 = wp.types.vector(3, real)
    vec4 = wp.types.vector(4, real)

    @wp.struct
    class Law:
        """Contact constants of two materials; see ``contact.py``."""

        modulus: real  # E* [Pa]
        shear_modulus: real  # G* [Pa]
        normal_damping: real  # 2 sqrt(5/6) b sqrt(2 E*)
        tangential_damping: real  # 2 sqrt(5/6) b sqrt(8 G*)
        friction: real

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
        radius: real  # of the cavity [m]
        height: real  # of the cavity [m]
        gravity: vec3  # [m/s^2]
        direction: vec3  # unit vector of the drive
        acceleration: real  # amplitude of the drive [m/s^2]
        particle_law: Law
        wall_law: Law

    @wp.struct
    class Particles:
        """Arrays over all particles of all cases of a batch."""

        position: wp.array(dtype=vec3)  # at n
        velocity: wp.array(dtype=vec3)  # predicted for n
        spin: wp.array(dtype=vec3)  # predicted for n
        half_velocity: wp.array(dtype=vec3)  # at n - 1/2
        half_spin: wp.array(dtype=vec3)  # at n - 1/2
        force: wp.array(dtype=vec3)
        torque: wp.array(dtype=vec3)
        radius: wp.array(dtype=real)
        inverse_mass: wp.array(dtype=real)
        inverse_inertia: wp.array(dtype=real)
        listed: wp.array(dtype=vec3)  # position when the neighbour list was made

    @wp.struct
    class Contacts:
        """Neighbour list (pairs i < j sorted by i, then j) and what each contact remembers.

        A history is (xi, a): the tangential spring's stretch xi [m] and the contact radius a [m] of the last step;
        a = 0 where there was no contact.
        """

        start: wp.array(dtype=wp.int32)  # pairs of i: start[i] .. start[i + 1] - 1
        partner: wp.array(dtype=wp.int32)
        pair_history: wp.array(dtype=vec4)
        wall_history: wp.array(dtype=vec4)  # 3 i + (0 side, 1 floor, 2 lid)

    return SimpleNamespace(real=real, vec3=vec3, vec4=vec4, Law=Law, Case=Case, Particles=Particles, Contacts=Contacts)
