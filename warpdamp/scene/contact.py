"""The contact law on the host: its constants from materials and surfaces, and how deep and how long an impact is.

The law itself is ``kernels/contact.py``.
"""

from __future__ import annotations

import functools
import math

from .scene import Material, Scene, Surface

LEAST_RESTITUTION = 1e-3
"""A dashpot that lets nothing rebound would be infinitely strong: restitutions below are taken as this."""

HERTZ_DURATION = 2.943275
"""tc v / d_max of an elastic Hertz contact, (4/5) sqrt(pi) Gamma(2/5) / Gamma(9/10)."""


@functools.cache
def dashpot(restitution: float) -> float:
    """Strength b of the dashpot with which an impact returns the restitution asked for [-].

    Without tension the textbook value -ln e / sqrt(ln^2 e + pi^2) returns 0.566 for 0.52: the pull that it counts on
    at the end is missing.  So b is solved for, once for each restitution.

    Parameters
    ----------
    restitution : float
        e [-], 0 to 1.

    Returns
    -------
    float
        0 for an elastic contact.
    """
    from scipy.optimize import brentq  # half a second, and configurations are read without it

    wanted = max(restitution, LEAST_RESTITUTION)
    if wanted >= 1:
        return 0.0
    return float(brentq(lambda b: _rebound(b) - wanted, 0.0, 20.0, xtol=1e-12))


def _rebound(b: float) -> float:
    """Speed after an impact at speed 1, of the equation of motion in units of k, m*: x'' = -max(F, 0).

    F = x^1.5 + sqrt(5) b x^0.25 x'; the impact is over when F has fallen to zero.
    """
    from scipy.integrate import solve_ivp

    def force(x, rate):
        return x**1.5 + math.sqrt(5) * b * x**0.25 * rate

    def rates(_t, y):
        return y[1], -force(max(y[0], 0.0), y[1])

    def over(_t, y):
        return force(max(y[0], 0.0), y[1]) if y[1] < 0 else 1.0

    over.terminal, over.direction = True, -1
    solved = solve_ivp(rates, (0, 200), (1e-12, 1.0), events=over, method="DOP853", rtol=1e-9, atol=1e-12)
    return -float(solved.y[1, -1])


def contact_constants(one: Material, other: Material, surface: Surface) -> dict:
    """Constants of the contact law between two materials, as ``kernels.structs.Law`` holds them.

    Parameters
    ----------
    one, other : Material
    surface : Surface

    Returns
    -------
    dict of float
        ``modulus`` E* and ``shear_modulus`` G* [Pa]; ``normal_damping`` and ``tangential_damping``
        [Pa^0.5], the factors of the dashpots; ``friction`` and ``rolling_friction`` [-].
    """
    modulus = 1 / sum((1 - m.poissons_ratio**2) / m.youngs_modulus for m in (one, other))
    shear_modulus = 1 / sum((2 - m.poissons_ratio) / m.shear_modulus for m in (one, other))
    damping = 2 * math.sqrt(5 / 6) * dashpot(surface.restitution)
    return {
        "modulus": modulus,
        "shear_modulus": shear_modulus,
        "normal_damping": damping * math.sqrt(2 * modulus),
        "tangential_damping": damping * math.sqrt(8 * shear_modulus),
        "friction": surface.friction,
        "rolling_friction": surface.rolling_friction,
    }


def strongest_dashpot(scene: Scene) -> float:
    """Largest strength b of a scene's dashpots, see ``dashpot`` [-]."""
    return max(dashpot(surface.restitution) for surface in scene.surfaces())


def largest_overlap(modulus: float, radius: float, mass: float, speed: float) -> float:
    """Largest overlap of an elastic Hertz impact, d_max = (15 m* v^2 / (16 E* sqrt(R*)))^(2/5) [m].

    Parameters
    ----------
    modulus, radius, mass : float
        E* [Pa], R* [m], m* [kg] of the pair.
    speed : float
        v [m/s].

    Returns
    -------
    float
        [m].
    """
    return (15 * mass * speed**2 / (16 * modulus * math.sqrt(radius))) ** 0.4


def contact_time(modulus: float, radius: float, mass: float, speed: float) -> float:
    """Duration of an elastic Hertz impact, tc = 2.943 d_max / v with d_max the ``largest_overlap`` [s].

    Parameters
    ----------
    modulus, radius, mass : float
        E* [Pa], R* [m], m* [kg] of the pair.
    speed : float
        v [m/s].

    Returns
    -------
    float
        [s].
    """
    return HERTZ_DURATION * largest_overlap(modulus, radius, mass, speed) / speed


def impact_time(one: Material, other: Material, surface: Surface, radius: float, mass: float, speed: float) -> float:
    """Duration of an elastic impact of two materials [s].

    Parameters
    ----------
    one, other : Material
    surface : Surface
    radius, mass : float
        R* [m], m* [kg] of the pair.
    speed : float
        [m/s].

    Returns
    -------
    float
        [s].
    """
    return contact_time(contact_constants(one, other, surface)["modulus"], radius, mass, speed)


def impact_overlap(scene: Scene, speed: float) -> float:
    """Largest overlap of two equal spheres of any materials that meet at ``speed`` [m/s], over their reduced radius.

    It does not depend on their size.
    """
    overlaps = []
    for i, one in enumerate(scene.materials):
        for j, other in enumerate(scene.materials):
            modulus = contact_constants(one, other, scene.pair_surface(i, j))["modulus"]
            a, b = float(scene.mass(2.0, i)), float(scene.mass(2.0, j))  # reduced radius 1
            overlaps.append(largest_overlap(modulus, 1.0, a * b / (a + b), speed))
    return max(overlaps)


def softening(scene: Scene, speed: float, overlap: float) -> float:
    """Factor on a scene's moduli with which impacts are as deep as is allowed, at most 1 [-].

    Parameters
    ----------
    scene : Scene
    speed : float
        Of the impact [m/s].
    overlap : float
        Allowed, over the reduced radius [-].

    Returns
    -------
    float
        [-].
    """
    return min(1.0, (impact_overlap(scene, speed) / overlap) ** 2.5)
