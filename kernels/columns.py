"""Names of the kernels: the columns of a ledger row, and the status of a case.

Names only: neither Warp nor any other module is needed to know them.
"""

from enum import IntEnum

LOSSES = ("normal_dashpot", "tangential_dashpot", "slip", "history", "rolling")
"""Channels in which contacts lose energy."""

PLACES = ("particle", "wall")
"""Where contacts are: between particles or at the walls."""

CHANNELS = {f"{place}_{name}": f"{place} {name.replace('_', ' ')}" for place in PLACES for name in LOSSES}
"""Columns of losses, and what each holds: by place and by each of ``LOSSES``."""

TOTALS = {f"{place}_total": f"{place} contacts, all channels" for place in PLACES}
"""The same where the ledger keeps no channels."""

EVERY_LOSS = CHANNELS | TOTALS
"""Every column of losses that a ledger may have."""

STORES = (
    "kinetic_translation",
    "kinetic_rotation",
    "gravity",
    "elastic_normal",
    "elastic_tangential",
    "elastic_rolling",
)

IMPULSES = ("floor_impulse", "lid_impulse")
"""Normal impulses on walls [N s]."""

INDICATORS = (*IMPULSES, "displacement")
"""Indicators of the regime of motion: ``IMPULSES``, and the particles' root mean square displacement over the last
cycle, less the common one [m].  The last is of the moment."""

STRUCTURE = ("force_work", "structure_loss", "structure_energy", "frame_energy")
"""With a structure: work of the force on it, its losses, its energy, and what the particles' kinetic and gravitational
energy in the laboratory exceeds that in the enclosure's frame by.  The last two are of the moment.

Where the base moves, all are in the base's frame, and the work is that of the inertial forces there."""


class KernelStatus(IntEnum):
    """Status of a case on the device; its ``sentence`` says what went wrong."""

    OK = 0
    NOT_FINITE = 1
    ESCAPED = 2

    @property
    def sentence(self) -> str:
        """Description of what went wrong."""
        return {
            KernelStatus.OK: "nothing went wrong",
            KernelStatus.NOT_FINITE: "the state is not finite",
            KernelStatus.ESCAPED: "a particle has left the cavity",
        }[self]


def losses(effects) -> tuple[str, ...]:
    """Names of the losses that the contacts of each place keep apart."""
    return LOSSES if effects.channels else ("total",)


def loss_columns(effects) -> tuple[str, ...]:
    """Names of the columns of losses: first those between particles, then as many at the walls."""
    return tuple(CHANNELS if effects.channels else TOTALS)


def columns(effects) -> tuple[str, ...]:
    """Names of a ledger row's columns: losses by channel or in total, indicators and the structure's if there are any.

    All are energies [J], except: reaction_* = integral of the reaction along the drive times cos, sin [N s];
    largest_overlap = overlap over the reduced radius.  All but ``STORES`` accumulate from step 0.
    """
    return (
        *loss_columns(effects),
        "work_input",
        "reaction_cosine",
        "reaction_sine",
        "largest_overlap",
        *STORES,
        *(INDICATORS if effects.indicators else ()),
        *(STRUCTURE if effects.structure else ()),
    )
