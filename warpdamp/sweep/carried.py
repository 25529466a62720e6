"""Legs of the path along which beds are carried through the amplitudes: a dimension that changes no scalar."""

from __future__ import annotations

from ..config.preparation import PreparationConfig, carried_path
from ..config.study import Config
from .axes import CASE, GAMMA, LEG, Axis


def leg_axes(config: Config) -> list[Axis]:
    """The dimension ``leg`` of a configuration that names a path; none for the word ``carried``."""
    named = isinstance(config.preparation, PreparationConfig)
    path = carried_path(config.preparation) if named else ()
    return [Axis(LEG, (), ((),) * len(path))] if path else []


def leg_of(axes: list[Axis], index: tuple[int, ...]) -> int:
    """Leg that a point belongs to, from 0."""
    return next((k for axis, k in zip(axes, index, strict=True) if axis.name == LEG), 0)


def beside_legs(axes: list[Axis], index: tuple[int, ...]) -> tuple[int, ...]:
    """A point's index on the dimensions along which no bed is carried."""
    return tuple(k for axis, k in zip(axes, index, strict=True) if axis.name not in (CASE, LEG))


def refuse_one_amplitude(config: Config, axes: list[Axis], gammas: list[float]) -> None:
    """Refuse to carry beds from one amplitude to the next where there is one.

    Raises
    ------
    ConfigError
    """
    columns = {path: values for axis in axes for path, values in axis.columns().items()}
    preparations = columns.get(("preparation",), [config.preparation])
    amplitudes = set(columns.get(GAMMA, gammas))
    if any(map(carried_path, preparations)) and len(amplitudes) < 2:
        raise config.error(
            "preparation",
            "beds are carried from one amplitude to the next, and excitation.gamma has one, "
            f"{amplitudes.pop():g}: give several, or take loose or compacted beds",
        )
