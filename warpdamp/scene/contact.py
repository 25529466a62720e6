"""Constants of the contact law from materials and surfaces; the law itself is ``kernels/contact.py``."""

from __future__ import annotations

import functools
import math

from .scene import Material, Surface

LEAST_RESTITUTION = 1e-3
"""A dashpot that lets nothing rebound would be infinitely strong: restitutions below are taken as this."""


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
