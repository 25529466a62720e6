"""The paper's damper: 120 spheres of PMMA in a closed cylinder of 40 x 40 mm, shaken near the first mode of its beam.

What measurements, documents and tests of the package stand on; a study takes its damper from YAML.
"""

from __future__ import annotations

from .scene import STANDARD_GRAVITY, Cylinder, Drive, Material, Scene, Surface

COUNT, RADIUS = 120, 3.73e-3
"""Spheres, and the radius of each [m]."""
PMMA = Material(density=920, youngs_modulus=3.3e9, poissons_ratio=0.37)
SURFACE = Surface(restitution=0.52, friction=0.86)
CAVITY = Cylinder(diameter=0.040, height=0.040)
FREQUENCY, GAMMA = 46.0, 6.0
"""The drive [Hz], and its acceleration over standard gravity."""
STEPS_PER_CYCLE = 10_870
"""The paper's step, 2 us, made a whole part of the cycle."""


def damper(
    frequency: float = FREQUENCY,
    gamma: float = GAMMA,
    *,
    surface: Surface = SURFACE,
    cavity: Cylinder = CAVITY,
    gravity: float = STANDARD_GRAVITY,
) -> Scene:
    """Scene of the damper shaken at a frequency [Hz] and Gamma, at rest for Gamma 0; gravity [m/s^2] points down."""
    drive = Drive(frequency, gamma * STANDARD_GRAVITY) if gamma else None
    return Scene(PMMA, PMMA, surface, surface, cavity, (0.0, 0.0, -gravity), drive)
