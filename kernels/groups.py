"""Groups of kernels that are compiled together, by name: Warp is not needed to know them."""

from dataclasses import dataclass, replace
from enum import Enum

from ..scene.effects import Effects


class Group(Enum):
    """What kernels are for."""

    STEPS = "steps"
    READING = "reading"
    SEARCH = "search"


@dataclass(frozen=True)
class Kernels:
    """Kernels of one group for a set of effects."""

    effects: Effects
    group: Group


def kernels_for(effects: Effects) -> tuple[Kernels, ...]:
    """All kernels that cases of these effects launch, the slowest to compile first; the search is shared."""
    searched = replace(effects.in_memory, device=effects.device)
    return Kernels(effects, Group.STEPS), Kernels(effects, Group.READING), Kernels(searched, Group.SEARCH)
