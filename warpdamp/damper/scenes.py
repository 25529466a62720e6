"""Scenes in which a bed is prepared, and what kernels are compiled for meanwhile; nothing here starts Warp."""

from __future__ import annotations

from dataclasses import replace

from ..scene.effects import Effects
from ..scene.scene import STANDARD_GRAVITY, Drive, Scene, Surface
from .case import Request


def frictionless(scene: Scene) -> Scene:
    """Scene without sliding and rolling friction; restitutions stay."""

    def bare(surfaces):
        if isinstance(surfaces, Surface):
            return Surface(surfaces.restitution, 0.0)
        return tuple(bare(surface) for surface in surfaces)

    return replace(scene, particle_contact=bare(scene.particle_contact), wall_contact=bare(scene.wall_contact))


def upright_scenes(scene: Scene) -> list[Scene]:
    """The scene under standard gravity along the axis, down and up."""
    return [replace(scene, gravity=(0.0, 0.0, pull)) for pull in (-STANDARD_GRAVITY, STANDARD_GRAVITY)]


def effects(request: Request) -> set[Effects]:
    """Sets of effects that kernels are compiled for while a bed is made."""
    scenes = [request.scene, *upright_scenes(request.scene)]
    if request.preparation == "compacted":
        bare = frictionless(request.scene)
        scenes += [bare.driven(None), *(scene.driven(Drive(1.0, 1.0)) for scene in (request.scene, bare))]
    return {request.numerics.effects(scene, request.grains) for scene in scenes}
