"""Effects of a scene: the frozen choice that kernels are compiled for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, make_dataclass, replace
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from .scene import Scene

Precision = Literal["float64", "float32"]
Device = Literal["cpu", "cuda"]

WALLS = ("side", "floor", "lid")


@dataclass(frozen=True)
class Effect:
    """An effect: when a scene requires it, and what the code outside the kernels needs to know of it.

    Parameters
    ----------
    called_for : function of (Scene, grains)
        Whether a scene of these particles requires it.
    keys : tuple of str
        Keys of the configuration that require it, the last where the others are absent; without any, not explained.
    forcible : bool
        Whether it may be forced on or off; others are the scene's geometry and content, or not to be left out.
    needs : tuple of str
        Effects that it cannot be without.
    idle_without : tuple of str
        Effects without which it changes nothing.
    in_memory : bool
        Whether the structs on the device depend on it.
    usual : bool
        Whether the paper's damper has it.
    because : str
        Put before its keys where it is on.
    counted : (attribute of the grains, name of one, name of several) or None
        It is on where the particles differ in this.
    """

    called_for: Callable[[Scene, object], bool]
    keys: tuple[str, ...] = ()
    forcible: bool = False
    needs: tuple[str, ...] = ()
    idle_without: tuple[str, ...] = ()
    in_memory: bool = True
    usual: bool = True
    because: str = ""
    counted: tuple[str, str, str] | None = None


def _friction(scene: Scene, _grains) -> bool:
    return any(surface.friction > 0 for surface in scene.surfaces())


def _rotation(scene: Scene, grains) -> bool:
    return _friction(scene, grains) or _spheroids(scene, grains)


def _dashpots(scene: Scene, _grains) -> bool:
    return any(surface.restitution < 1 for surface in scene.surfaces())


def _rolling(scene: Scene, grains) -> bool:
    return _friction(scene, grains) and any(surface.rolling_friction > 0 for surface in scene.surfaces())


def _gravity(scene: Scene, _grains) -> bool:
    return any(scene.gravity)


def _wall(name: str) -> Effect:
    def called_for(scene: Scene, _grains) -> bool:
        return bool(scene.enclosure and getattr(scene.enclosure, name))

    return Effect(called_for, (f"damper.enclosure.{name}", "damper.enclosure"), in_memory=False)


def _sizes(_scene: Scene, grains) -> bool:
    return len(set(grains.radius)) > 1


def _spheroids(_scene: Scene, grains) -> bool:
    return any(aspect != 1 for aspect in getattr(grains, "aspect", ()))


def _materials(scene: Scene, _grains) -> bool:
    return len(scene.materials) > 1


def _indicators(scene: Scene, _grains) -> bool:
    return scene.drive is not None and scene.enclosure is not None


def _structure(scene: Scene, _grains) -> bool:
    return scene.host is not None


def _always(_scene: Scene, _grains) -> bool:
    return True


def _contact(name: str) -> tuple[str, str]:
    return f"contact.{name}", f"contact.walls.{name}"


EFFECTS = {
    "friction": Effect(_friction, _contact("friction"), forcible=True),
    "rotation": Effect(
        _rotation,
        _contact("friction"),
        forcible=True,
        idle_without=("friction",),
        because="friction, and any force on spheroids, turns particles: ",
    ),
    "dashpots": Effect(_dashpots, _contact("restitution"), forcible=True),
    "rolling": Effect(
        _rolling,
        _contact("rolling_friction"),
        forcible=True,
        needs=("rotation",),
        idle_without=("friction",),
        usual=False,
    ),
    "gravity": Effect(_gravity, ("excitation.gravity",), forcible=True),
    **{name: _wall(name) for name in WALLS},
    "sizes": Effect(_sizes, ("damper.particles",), usual=False, counted=("radius", "radius", "radii")),
    "materials": Effect(_materials, ("damper.particles",), usual=False, counted=("species", "material", "materials")),
    "spheroids": Effect(_spheroids, ("damper.particles",), needs=("rotation",), usual=False),
    "channels": Effect(_always, ("effects.ledger",), forcible=True, in_memory=False),
    "indicators": Effect(_indicators, ("effects.indicators", "excitation.gamma"), forcible=True, in_memory=False),
    "guards": Effect(_always, in_memory=False),
    "structure": Effect(_structure, usual=False),
}
"""Effects by name, in the order of the fields of ``Effects``; ``precision`` and ``device`` are not among them."""

NOT_MODELLED = (
    "the structure's answer to the damper (the enclosure's motion is prescribed)",
    "air, cohesion, liquid bridges, electrostatic charge",
    "wear, breakage, plastic flow and heating of the particles",
    "particles other than spheres and spheroids; friction against spinning about the normal",
    "flexibility of the enclosure's walls",
)
"""What no effect of a study covers."""

FORCIBLE = tuple(name for name, effect in EFFECTS.items() if effect.forcible)
"""Effects that may be forced on or off."""

_Switches = make_dataclass("_Switches", [(name, bool, effect.usual) for name, effect in EFFECTS.items()], frozen=True)


@dataclass(frozen=True)
class Effects(_Switches):
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
    spheroids : bool
        Whether particles are spheroids; they turn whatever their contacts are like, so ``rotation`` is on with them.
    channels : bool
        Whether the ledger keeps losses by channel, or only their sum.
    indicators : bool
        Whether it also keeps indicators of the regime of motion: impulses on floor and lid, displacements over a cycle.
    guards : bool
        Whether every step checks that the state is finite, and every launch that all particles are in the cavity.
    structure : bool
        Whether the enclosure is fixed to a structure that answers, instead of moving as prescribed.
    precision : "float64" or "float32"
        Of the motion; the ledger is always float64.
    device : "cpu" or "cuda"
        What the kernels run on.
    """

    precision: Precision = "float64"
    device: Device = "cpu"

    def __post_init__(self):
        if self.spheroids:
            object.__setattr__(self, "rotation", True)

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
        """Whether contacts have a history."""
        return self.friction or self.rolling or self.spheroids

    @property
    def alike(self) -> bool:
        """Whether all particles of a case have one mass."""
        return not (self.sizes or self.materials)

    @property
    def in_memory(self) -> Effects:
        """The effects that the structs depend on: all others on, any wall for all three, whatever the device."""
        others = [name for name, effect in EFFECTS.items() if not effect.in_memory]
        return replace(self, device="cpu", **{name: self.enclosure if name in WALLS else True for name in others})

    def forced(self, choices: dict[str, bool]) -> Effects:
        """Effects with some of them forced on or off.

        An effect that needs another goes with it: rolling resistance with rotation.

        Parameters
        ----------
        choices : dict of bool
            Whether each effect is on, by its name.

        Returns
        -------
        Effects

        Raises
        ------
        ValueError
            If an effect cannot be forced, and says which can; if spheroids are to be kept from turning.
        """
        for name in choices:
            if name not in FORCIBLE:
                raise ValueError(f"'{name}' cannot be forced; choose from {', '.join(FORCIBLE)}")
        if self.spheroids and not choices.get("rotation", True):
            raise ValueError("spheroids turn whatever touches them: 'rotation' cannot be forced off, but for spheres")
        effects = replace(self, **choices)
        lacking = [name for name, effect in EFFECTS.items() if not all(getattr(effects, need) for need in effect.needs)]
        return replace(effects, **dict.fromkeys(lacking, False))


def called_for(scene: Scene, grains, *, precision: Precision = "float64", device: Device = "cpu") -> Effects:
    """Effects that a scene requires, and no others.

    Parameters
    ----------
    scene : Scene
    grains : State, Grains, or anything with ``radius`` and ``species``
    precision : "float64" or "float32"
    device : "cpu" or "cuda"

    Returns
    -------
    Effects
    """
    on = {name: effect.called_for(scene, grains) for name, effect in EFFECTS.items()}
    return Effects(**on, precision=precision, device=device)


def covering(choices: list[Effects]) -> Effects:
    """Fewest effects with which each of several scenes can be simulated.

    Parameters
    ----------
    choices : list of Effects

    Returns
    -------
    Effects

    Raises
    ------
    ValueError
        If the precisions or the devices differ.
    """
    if len({(effects.precision, effects.device) for effects in choices}) > 1:
        raise ValueError("the cases of a batch must all have one precision and one device")
    return replace(choices[0], **{name: any(getattr(effects, name) for effects in choices) for name in EFFECTS})
