"""What a scene calls for: the frozen choice that kernels are compiled for."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from .scene import Scene

Precision = Literal["float64", "float32"]

FORCIBLE = ("friction", "rotation", "dashpots", "rolling", "gravity", "channels", "indicators")
"""Effects that may be forced on or off; the others are the scene's geometry and content."""


@dataclass(frozen=True)
class Effects:
    """Effects that are compiled into the kernels; one that is off costs nothing: no branch, no array.

    Parameters
    ----------
    friction : bool
        Coulomb friction, with the history of the tangential spring.
    rotation : bool
        Whether particles turn.
    dashpots : bool
        Whether contacts lose energy along the normal (and, with friction, across it).
    rolling : bool
        Rolling resistance.
    gravity : bool
    side, floor, lid : bool
        Walls of the cavity that are there.
    sizes : bool
        Whether radii differ within a case.
    materials : bool
        Whether the particles of a case are of more than one material.
    channels : bool
        Whether the ledger keeps losses by channel, or only their sum.
    indicators : bool
        Whether it also keeps what tells the regime of motion: impulses on floor and lid, displacements over a cycle.
    guards : bool
        Whether every step checks that the state is finite, and every launch that all particles are in the cavity.
    structure : bool
        Whether the enclosure is fixed to a structure that answers, instead of moving as prescribed.
    precision : "float64" or "float32"
        Of the motion; the ledger is always float64.
    """

    friction: bool = True
    rotation: bool = True
    dashpots: bool = True
    rolling: bool = False
    gravity: bool = True
    side: bool = True
    floor: bool = True
    lid: bool = True
    sizes: bool = False
    materials: bool = False
    channels: bool = True
    indicators: bool = True
    guards: bool = True
    structure: bool = False
    precision: Precision = "float64"

    @property
    def real(self):
        """The Warp scalar type of the motion."""
        import warp as wp

        return wp.float64 if self.precision == "float64" else wp.float32

    @property
    def enclosure(self) -> bool:
        """Whether there is any wall."""
        return self.side or self.floor or self.lid

    @property
    def history(self) -> bool:
        """Whether contacts remember anything."""
        return self.friction or self.rolling

    @property
    def alike(self) -> bool:
        """Whether all particles of a case have one mass."""
        return not (self.sizes or self.materials)

    def forced(self, choices: dict[str, bool]) -> Effects:
        """The same with some effects forced on or off.

        Rolling resistance needs rotation: forcing rotation off takes it along.

        Raises
        ------
        ValueError
            If an effect cannot be forced.
        """
        for name in choices:
            if name not in FORCIBLE:
                raise ValueError(f"'{name}' cannot be forced; choose from {', '.join(FORCIBLE)}")
        effects = replace(self, **choices)
        return effects if effects.rotation else replace(effects, rolling=False)


def called_for(scene: Scene, grains, *, precision: Precision = "float64") -> Effects:
    """The effects that a scene calls for, and no other.

    Parameters
    ----------
    scene : Scene
    grains : anything with ``radius`` and ``species``, as a State
    precision : "float64" or "float32"
    """
    surfaces = scene.surfaces()
    friction = any(s.friction > 0 for s in surfaces)
    rolling = any(s.rolling_friction > 0 for s in surfaces)
    cavity = scene.enclosure
    return Effects(
        friction=friction,
        rotation=friction,  # rolling resistance alone turns nothing that does not turn
        dashpots=any(s.restitution < 1 for s in surfaces),
        rolling=friction and rolling,
        gravity=any(scene.gravity),
        side=bool(cavity and cavity.side),
        floor=bool(cavity and cavity.floor),
        lid=bool(cavity and cavity.lid),
        sizes=len(set(np.asarray(grains.radius).tolist())) > 1,
        materials=len(scene.materials) > 1,
        indicators=scene.drive is not None and cavity is not None,
        structure=scene.mount is not None,
        precision=precision,
    )


def covering(every: list[Effects]) -> Effects:
    """The fewest effects with which each of several scenes can be simulated.

    Raises
    ------
    ValueError
        If the precisions differ.
    """
    if len({effects.precision for effects in every}) > 1:
        raise ValueError("the cases of a batch must all have one precision")
    switches = [field.name for field in fields(Effects) if field.name != "precision"]
    return replace(every[0], **{name: any(getattr(effects, name) for effects in every) for name in switches})
