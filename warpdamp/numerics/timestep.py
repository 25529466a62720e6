"""Time step: from the shortest contact expected, and a whole number of steps to a cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..scene.contact import impact_time, strongest_dashpot
from ..scene.effects import Device, Effects, Precision, called_for
from ..scene.particles import State
from ..scene.scene import Scene
from ..scene.shape import aspects, shape_of
from ..scene.sphere import sphere_volume
from .limits import FEWEST_STEPS_PER_CONTACT, FEWEST_STEPS_PER_CYCLE, STEPS_PER_CONTACT

STEPS_PER_DASHPOT = 45
"""Dashpots of strength b (see ``scene.contact.dashpot``) take this times b steps a contact: they act on predicted
velocities, and with fewer a bed of restitution 0.2 and below gains energy from them."""


@dataclass(frozen=True)
class Numerics:
    """Numerical choices of a simulation.

    Parameters
    ----------
    precision : of the motion
    steps_per_contact : steps to the shortest contact expected
    forced : effects forced on or off, as sorted pairs (name, whether)
    device : "cpu" or "cuda"; its round-off is its own, so beds and cases of one are not taken for those of the other
    """

    precision: Precision = "float64"
    steps_per_contact: float = STEPS_PER_CONTACT
    forced: tuple[tuple[str, bool], ...] = ()
    device: Device = "cpu"

    def effects(self, scene: Scene, grains) -> Effects:
        """Effects that the scene requires, with those that are forced."""
        return called_for(scene, grains, precision=self.precision, device=self.device).forced(dict(self.forced))


def expected_speed(scene: Scene, radius) -> float:
    """Speed of the fastest relative impact to be expected [m/s].

    Twice the enclosure's peak speed (a particle thrown back by a wall moving at full speed, met by another at rest),
    and what a fall through the free height of the cavity adds.

    Parameters
    ----------
    scene : Scene
    radius : (n,) array
        [m].

    Returns
    -------
    float
        [m/s].
    """
    driven = 2 * scene.drive.speed if scene.drive else 2 * scene.host.speed if scene.host else 0.0
    if scene.enclosure is None:
        return driven
    fill = np.sum(sphere_volume(np.asarray(radius))) / scene.enclosure.volume
    free_height = scene.enclosure.height * max(0.05, 1 - fill / 0.64)
    return driven + math.sqrt(2 * float(np.linalg.norm(scene.gravity)) * free_height)


def shortest_contact(scene: Scene, grains, speed: float) -> float:
    """Shortest contact time at a relative speed, of any two particles, or of one and the wall [s].

    Parameters
    ----------
    scene : Scene
    grains : State, Grains, or anything with ``radius`` and ``species``
    speed : float
        [m/s].

    Returns
    -------
    float
        [s].
    """
    radius, species, aspect = np.asarray(grains.radius), np.asarray(grains.species), aspects(grains)
    times = []
    of_aspect = shape_of(grains).contact_share
    share = {k: min(map(of_aspect, set(aspect[species == k].tolist()))) for k in set(species.tolist())}
    smallest = {k: float(np.min(radius[species == k])) for k in set(species.tolist())}
    for i, a in smallest.items():
        material, mass = scene.materials[i], float(scene.mass(a, i))
        for j, b in smallest.items():
            other, other_mass = scene.materials[j], float(scene.mass(b, j))
            reduced = a * b / (a + b), mass * other_mass / (mass + other_mass)
            time = impact_time(material, other, scene.pair_surface(i, j), *reduced, speed)
            times.append(min(share[i], share[j]) * time)
        if scene.enclosure:
            times.append(share[i] * impact_time(material, scene.wall, scene.wall_surface(i), a, mass, speed))
    return min(times)


def longest_step(scene: Scene, grains, speed: float, *, steps_per_contact: float) -> float:
    """Largest step that resolves the shortest contact at a relative speed, and the dashpots [s].

    Parameters
    ----------
    scene : Scene
    grains : State, Grains, or anything with ``radius`` and ``species``
    speed : float
        [m/s].
    steps_per_contact : float

    Returns
    -------
    float
        [s].
    """
    fewest = max(steps_per_contact, STEPS_PER_DASHPOT * strongest_dashpot(scene))
    return shortest_contact(scene, grains, speed) / fewest


def contact_step(scene: Scene, grains, *, steps_per_contact: float = STEPS_PER_CONTACT) -> float:
    """Largest step for the fastest impact expected [s].

    Parameters
    ----------
    scene : Scene
    grains : State, Grains, or anything with ``radius`` and ``species``
    steps_per_contact : float

    Returns
    -------
    float
        [s].

    Raises
    ------
    ValueError
        If nothing moves and nothing makes it move: then no step follows.
    """
    speed = expected_speed(scene, grains.radius)
    if speed == 0:
        raise ValueError("without gravity and without a drive nothing moves: give the scene one of them, or a step")
    return longest_step(scene, grains, speed, steps_per_contact=steps_per_contact)


def steps_per_cycle(scene: Scene, grains, *, steps_per_contact: float = STEPS_PER_CONTACT) -> int:
    """Smallest whole number of steps a cycle that are no longer than ``contact_step``, at least fifty.

    Parameters
    ----------
    scene : Scene
        With a drive.
    grains : State, Grains, or anything with ``radius`` and ``species``
    steps_per_contact : float

    Returns
    -------
    int
    """
    dt = contact_step(scene, grains, steps_per_contact=steps_per_contact)
    return max(FEWEST_STEPS_PER_CYCLE, math.ceil(1 / (scene.drive.frequency * dt)))


def check_step(scene: Scene, state: State, dt: float) -> None:
    """Refuse a step that does not resolve the fastest contact expected from a given state.

    Parameters
    ----------
    scene : Scene
    state : State
    dt : float
        [s].

    Raises
    ------
    ValueError
        If the step is too large; names the contact time and the largest step allowed.
    """
    if not dt > 0:
        raise ValueError(f"the step must be positive, got {dt:g} s")
    if scene.enclosure is None and len(state) == 1:
        return  # nothing to meet
    moving = 2 * float(np.max(np.linalg.norm(state.velocity, axis=1), initial=0.0))
    speed = max(moving, expected_speed(scene, state.radius))
    if speed == 0:
        return  # nothing moves, and nothing makes it move
    longest = longest_step(scene, state, speed, steps_per_contact=FEWEST_STEPS_PER_CONTACT)
    if dt > longest:
        shortest = shortest_contact(scene, state, speed)
        raise ValueError(
            f"a step of {dt:.3g} s does not resolve the shortest contact expected, {shortest:.3g} s at "
            f"{speed:.3g} m/s: take at most {longest:.2g} s"
        )
