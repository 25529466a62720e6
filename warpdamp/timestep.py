"""The step: from the shortest contact expected, and a whole number of steps to a cycle."""

from __future__ import annotations

import math

import numpy as np

from .law import contact_constants, dashpot
from .scene import Scene, State

STEPS_PER_CONTACT = 20
"""Restitution then comes out within 2 % and a bed's ledger closes to 0.3 % (docs/verification)."""

FEWEST_STEPS_PER_CONTACT = 10
"""Below this a contact is not resolved and a forced step is refused."""

HERTZ_DURATION = 2.943275
"""tc v / d_max of an elastic Hertz contact, (4/5) sqrt(pi) Gamma(2/5) / Gamma(9/10)."""


def contact_time(modulus: float, radius: float, mass: float, speed: float) -> float:
    """Duration [s] of an elastic Hertz impact: tc = 2.943 d_max / v, d_max = (15 m* v^2 / (16 E* sqrt(R*)))^(2/5)."""
    overlap = (15 * mass * speed**2 / (16 * modulus * math.sqrt(radius))) ** 0.4
    return HERTZ_DURATION * overlap / speed


def expected_speed(scene: Scene, radius) -> float:
    """Fastest relative impact to be expected [m/s].

    Twice the enclosure's peak speed (a particle thrown back by a wall moving at full speed, met by another at rest),
    and what a fall through the free height of the cavity adds.
    """
    driven = 2 * scene.drive.speed if scene.drive else 0.0
    if scene.enclosure is None:
        return driven
    fill = np.sum(4 / 3 * np.pi * np.asarray(radius) ** 3) / scene.enclosure.volume
    free_height = scene.enclosure.height * max(0.0, 1 - fill / 0.64)
    return driven + math.sqrt(2 * float(np.linalg.norm(scene.gravity)) * free_height)


def shortest_contact(scene: Scene, radius, speed: float) -> float:
    """Shortest contact time [s] at a relative ``speed``: two of the smallest spheres, or one and the wall.

    A restitution below about 0.15 takes a dashpot with b > 1, which acts b times as fast as the spring.
    """
    smallest = float(np.min(radius))
    mass = float(scene.mass(smallest))
    pair = contact_constants(scene.particle, scene.particle, scene.particle_contact)["modulus"]
    wall = contact_constants(scene.particle, scene.wall, scene.wall_contact)["modulus"]
    return min(
        contact_time(pair, smallest / 2, mass / 2, speed) / max(1.0, dashpot(scene.particle_contact.restitution)),
        contact_time(wall, smallest, mass, speed) / max(1.0, dashpot(scene.wall_contact.restitution)),
    )


def contact_step(scene: Scene, radius, *, steps_per_contact: float = STEPS_PER_CONTACT) -> float:
    """Largest step [s] that resolves the shortest contact expected."""
    return shortest_contact(scene, radius, expected_speed(scene, radius)) / steps_per_contact


def steps_per_cycle(scene: Scene, radius, *, steps_per_contact: float = STEPS_PER_CONTACT) -> int:
    """Smallest whole number of steps a cycle that are no longer than ``contact_step``."""
    dt = contact_step(scene, radius, steps_per_contact=steps_per_contact)
    return math.ceil(1 / (scene.drive.frequency * dt))


def check_step(scene: Scene, state: State, dt: float) -> None:
    """Refuse a step that does not resolve the fastest contact expected from a given state.

    Raises
    ------
    ValueError
        Names the contact time and the largest step allowed.
    """
    if not dt > 0:
        raise ValueError(f"the step must be positive, got {dt:g} s")
    if scene.enclosure is None and len(state) == 1:
        return  # nothing to meet
    moving = 2 * float(np.max(np.linalg.norm(state.velocity, axis=1), initial=0.0))
    speed = max(moving, expected_speed(scene, state.radius))
    if speed == 0:
        return  # nothing moves, and nothing makes it move
    shortest = shortest_contact(scene, state.radius, speed)
    if dt > shortest / FEWEST_STEPS_PER_CONTACT:
        raise ValueError(
            f"a step of {dt:.3g} s does not resolve the shortest contact expected, {shortest:.3g} s at "
            f"{speed:.3g} m/s: take at most {shortest / FEWEST_STEPS_PER_CONTACT:.2g} s"
        )
