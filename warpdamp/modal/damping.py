"""From energy per cycle to modal damping: the chain of the paper's eqs 4-11.

The whole chain is the identity zeta = (2 / pi) eps m phi^2, m the mass of the particles.
"""

from __future__ import annotations

import math


def strain_energy(displacement, amplitude, frequency):
    """Largest strain energy of the structure in a cycle [J] (eqs 9-11).

    Parameters
    ----------
    displacement : X, at the damper [m]
    amplitude : mass-normalised mode shape phi at the damper [kg^-0.5]
    frequency : natural frequency [Hz]
    """
    scale = displacement / amplitude
    return 0.5 * scale**2 * (2 * math.pi * frequency) ** 2


def damping_ratio(energy, displacement, amplitude, frequency):
    """zeta = E / (4 pi E_strain) (eq. 6) [-], from the energy dissipated per cycle [J]."""
    return energy / (4 * math.pi * strain_energy(displacement, amplitude, frequency))


def normalised_damping(energy, speed, total_mass):
    """Energy per cycle over 0.5 m_total v^2 [-], v = Gamma g / w (eq. 19 with the square on the speed alone)."""
    return energy / (0.5 * total_mass * speed**2)
