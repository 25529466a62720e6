"""Constants of the contact law from materials and surfaces; the law itself is ``kernels/contact.py``."""

from __future__ import annotations

import math

from .scene import Material, Surface


def dashpot(restitution: float) -> float:
    """b = -ln e / sqrt(ln^2 e + pi^2), 1 at e = 0 (Tsuji et al. 1992, doi:10.1016/0032-5910(92)88030-L)."""
    if restitution == 0:
        return 1.0
    log = math.log(restitution)
    return -log / math.hypot(log, math.pi)


def contact_constants(one: Material, other: Material, surface: Surface) -> dict:
    """E*, G*, the dashpots' factors and friction of two materials, as ``kernels.data.Law`` holds them."""
    modulus = 1 / sum((1 - m.poissons_ratio**2) / m.youngs_modulus for m in (one, other))
    shear_modulus = 1 / sum((2 - m.poissons_ratio) / m.shear_modulus for m in (one, other))
    damping = 2 * math.sqrt(5 / 6) * dashpot(surface.restitution)
    return {
        "modulus": modulus,
        "shear_modulus": shear_modulus,
        "normal_damping": damping * math.sqrt(2 * modulus),
        "tangential_damping": damping * math.sqrt(8 * shear_modulus),
        "friction": surface.friction,
    }
