"""Plastic block between floor and lid of a shaken enclosure under gravity: momentum and work by cycle."""

from __future__ import annotations

import numpy as np

from warpdamp.scene.scene import STANDARD_GRAVITY

STEPS, CYCLES, DISCARDED = 3000, 24, 12
"""Steps of a cycle; cycles, and those left out at the start."""


def exchange(frequency: float, gamma: np.ndarray, clearance: float) -> tuple[np.ndarray, np.ndarray]:
    """Momentum that a block exchanges with floor and lid, and how well in time; their product is its effectiveness.

    The block takes the velocity of the wall that it meets, and keeps it until the wall recedes.

    Parameters
    ----------
    frequency : [Hz]
    gamma : (n,) amplitudes of acceleration over gravity
    clearance : [m]

    Returns
    -------
    momentum : (n,)
        Mean impulse of floor and lid in a cycle over 2 m V, V the largest speed of the enclosure.
    timing : (n,)
        Work of these impulses over what they would do at the largest speed.
    """
    speed = gamma * STANDARD_GRAVITY / (2 * np.pi * frequency)
    dt = 1 / (frequency * STEPS)
    height, velocity = np.zeros((2, len(gamma)))  # seen from the enclosure
    impulses, work = np.zeros((2, len(gamma)))
    for step in range(CYCLES * STEPS):
        phase = 2 * np.pi * (step + 0.5) / STEPS
        velocity = velocity + STANDARD_GRAVITY * (gamma * np.sin(phase) - 1) * dt
        height = height + velocity * dt
        floor, lid = np.where(height < 0, -velocity, 0.0), np.where(height > clearance, velocity, 0.0)
        velocity = np.where((height < 0) | (height > clearance), 0.0, velocity)
        height = np.clip(height, 0.0, clearance)
        if step >= DISCARDED * STEPS:
            impulses += floor + lid
            work += (floor - lid) * speed * np.cos(phase)
    ideal = 4 * speed * (CYCLES - DISCARDED)
    return impulses / ideal, work / (impulses * speed)
