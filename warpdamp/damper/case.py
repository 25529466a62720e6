"""Inputs of a bed and of a case, a bed that is ready, and the recipe by which beds are compacted."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import asdict, dataclass, replace
from typing import Literal

from ..errors import PackingError
from ..numerics.limits import STEPS_PER_CONTACT
from ..numerics.timestep import Numerics
from ..scene.effects import Effects, called_for
from ..scene.particles import Grains, State
from ..scene.scene import Scene
from ..version import PHYSICS_VERSION

Preparation = Literal["loose", "compacted"]


GROWN = 1.003
"""Beds are made with radii this much larger, so that the true ones start apart and release no energy."""

SHAKING_GAMMA = 6.0
SHAKING_AMPLITUDE = 0.11  # of a diameter
SHAKING_CYCLES, KEEPING_CYCLES = 24, 4  # without and with friction
PATIENCE, MOST_BLOCKS = 5, 24
STILL = 0.01  # of a diameter
SOFT_OVERLAP = 0.02  # of the reduced radius

REACHED = 5e-5
"""A clearance asked for is reached within this [m]."""

MOST_TRIES = 60
"""Blocks of shaking after which a bed that has not the clearance asked for is left as near as it came."""

MILDEST = 1.5
"""Gamma below which shaking hardly changes a bed."""

GOLDEN = 0.618033988749895
"""Multiples of it, less their whole parts, spread evenly between 0 and 1 without ever coming back: the Gammas by which
a bed is brought to a clearance."""

RECIPE = (
    *(GROWN, SHAKING_GAMMA, SHAKING_AMPLITUDE, SHAKING_CYCLES, KEEPING_CYCLES),
    *(PATIENCE, MOST_BLOCKS, STILL, SOFT_OVERLAP, REACHED, MOST_TRIES, MILDEST, GOLDEN),
)
"""A part of every bed's key, so that beds made by another recipe are not taken for these."""


@dataclass(frozen=True)
class Request:
    """Inputs that determine a bed.

    Parameters
    ----------
    scene : Scene
        Its drive does not matter.
    grains : Grains
    seed : int
        Seed of the random placement.
    preparation : "loose" or "compacted"
    clearance, packing_fraction : [m], [-] or None
        One of the two that a bed is to be compacted to, instead of until neither changes.
    settling_time : [s] or None
        A fixed time to settle in, as in the paper, instead of until at rest.
    numerics : Numerics
        A study may take fewer steps a contact than usual, a bed is not made with fewer: compacting takes half of them.

    Examples
    --------
    >>> from warpdamp import Cylinder, Grains, Material, Request, Scene, Surface
    >>> pmma, surface = Material(920, 3.3e9, 0.37), Surface(0.52, 0.86)
    >>> scene = Scene(pmma, pmma, surface, surface, Cylinder(0.04, 0.04))
    >>> one, other = (Request(scene, Grains.alike(3.73e-3, 120), seed, "compacted") for seed in (1, 2))
    >>> one.key() == other.key()
    False
    """

    scene: Scene
    grains: Grains
    seed: int
    preparation: Preparation = "compacted"
    settling_time: float | None = None
    numerics: Numerics = Numerics()  # noqa: RUF009 - frozen
    clearance: float | None = None
    packing_fraction: float | None = None

    def __post_init__(self):
        if self.asked and (self.preparation == "loose" or len(self.asked) > 1):
            raise PackingError(
                "a clearance or a packing fraction, one of the two, is for a compacted bed; a loose one has its own",
                "preparation",
            )
        for name, value in self.asked.items():
            if not value > 0:
                raise PackingError(f"a {name.replace('_', ' ')} must be positive, got {value:g}", "preparation")
        if self.preparation == "compacted" and self.settling_time is not None:
            raise PackingError("a fixed settling_time is for a loose bed: ask for preparation: loose", "preparation")
        steps = max(self.numerics.steps_per_contact, STEPS_PER_CONTACT)
        object.__setattr__(self, "numerics", replace(self.numerics, steps_per_contact=steps))

    @property
    def asked(self) -> dict[str, float]:
        """State that the bed is to be brought to: ``clearance`` [m] or ``packing_fraction`` by name, or empty."""
        values = {name: getattr(self, name) for name in ("clearance", "packing_fraction")}
        return {name: value for name, value in values.items() if value is not None}

    def key(self) -> str:
        """Hash of the inputs, the recipe, and the version of the physics."""
        values = asdict(self) | {"scene": asdict(self.scene.driven(None)), "physics": PHYSICS_VERSION, "recipe": RECIPE}
        values["grains"] = self.grains.given()  # beds of spheres keep the keys that they had before other shapes
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:24]


@dataclass(frozen=True)
class Packing:
    """Prepared bed at rest.

    Parameters
    ----------
    state : State
    clearance : float [m]
        How far its centre of mass travels between rest on the floor and rest against the lid.
    blocks : int
        Blocks of shaking that it took (0: loose).
    settled : bool
        Whether the rule that ends its preparation was met; false if it was still compacting after the last block.
    """

    state: State
    clearance: float
    blocks: int
    settled: bool = True


@dataclass(frozen=True)
class Criteria:
    """Criteria by which a case ends.

    Parameters
    ----------
    standard_error : float
        Standard error asked for, relative to the energy per cycle [-].
    fewest, most : int
        Cycles to run.
    fixed : bool
        Average over the last two thirds of ``most`` cycles instead, whatever the series does.
    slack : float
        Drift and imbalance that do not matter, relative to the energy per cycle [-].
    """

    standard_error: float = 0.02
    fewest: int = 30
    most: int = 1000
    fixed: bool = False
    slack: float = 0.0


@dataclass(frozen=True)
class Spec:
    """Case of a study, ready to be run.

    Parameters
    ----------
    index : position in the study's axes
    scene : Scene, with its drive
    steps_per_cycle : int
    bed : Request
    """

    index: tuple[int, ...]
    scene: Scene
    steps_per_cycle: int
    bed: Request

    @property
    def dt(self) -> float:
        """Time step [s]."""
        return 1 / (self.scene.drive.frequency * self.steps_per_cycle)

    @property
    def effects(self) -> Effects:
        """Effects that the case's kernels are compiled for."""
        return self.bed.numerics.effects(self.scene, self.bed.grains)

    @property
    def forced_off(self) -> list[str]:
        """Effects that the scene requires and the user forced off."""
        called = called_for(self.scene, self.bed.grains)
        return [name for name, on in self.bed.numerics.forced if not on and getattr(called, name)]

    def cost(self, criteria: Criteria) -> float:
        """Particle-steps of the case, at the least."""
        return self.steps_per_cycle * len(self.bed.grains) * criteria.fewest


PAPER_SETTLING, PAPER_SHAKING = 0.2, 0.3
"""Times of the paper's own recipe [s]; the last two thirds of the shaking are averaged."""


def paper_criteria(frequency: float) -> Criteria:
    """Criteria of the paper at a frequency [Hz]: the whole cycles within 0.3 s, and at least six."""
    cycles = max(6, math.floor(PAPER_SHAKING * frequency))
    return Criteria(fewest=cycles, most=cycles, fixed=True)
