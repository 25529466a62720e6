"""The paper's appendix A: a host mode carrying a damper on a spring, by real and by complex modes.

M = m_h [[1, 0], [0, r_m (1 - j (4 / pi) eps)]] (eq. 26), K = k_h [[1 + r_k, -r_k], [-r_k, r_k]] (eq. 27); the even mode
is the lower one.  In units of m_h and k_h throughout.
"""

from __future__ import annotations

import math

import numpy as np


def complex_mode(mass_ratio: float, stiffness_ratio: float, effectiveness: float = 1.0) -> complex:
    """Eigenvalue w^2 (1 + j eta) of the even mode [k_h / m_h], of K u = w^2 (1 + j eta) M u.

    Parameters
    ----------
    mass_ratio, stiffness_ratio : float
        r_m and r_k [-].
    effectiveness : float
        eps [-].

    Returns
    -------
    complex
    """
    stiffness, mass = _matrices(mass_ratio, stiffness_ratio)
    loss = np.diag([0.0, 4 / math.pi * effectiveness * mass_ratio])
    values = np.linalg.eigvals(np.linalg.solve(mass - 1j * loss, stiffness))
    return complex(values[np.argmin(values.real)])


def real_mode(mass_ratio: float, stiffness_ratio: float, effectiveness: float = 1.0) -> tuple[float, float]:
    """Square of the undamped even mode's frequency [k_h / m_h], and its damping ratio by eq. 6, zeta = m'' phi^2 / 2.

    Parameters
    ----------
    mass_ratio, stiffness_ratio : float
        r_m and r_k [-].
    effectiveness : float
        eps [-].

    Returns
    -------
    square, damping_ratio : float
    """
    from scipy.linalg import eigh

    stiffness, mass = _matrices(mass_ratio, stiffness_ratio)
    values, shapes = eigh(stiffness, mass)
    return float(values[0]), float(2 / math.pi * effectiveness * mass_ratio * shapes[1, 0] ** 2)


def pole_damping(square: complex) -> float:
    """Damping ratio of the free decay exp(s t), -Re s / |s| with s = j w sqrt(1 + j eta) [-].

    Parameters
    ----------
    square : complex
        w^2 (1 + j eta), as from ``complex_mode``.

    Returns
    -------
    float
    """
    s = 1j * np.sqrt(square)
    return float(abs(s.real) / abs(s))


def energy_damping(square: complex) -> float:
    """Half the loss factor, eta / 2 [-].

    That is the energy lost per cycle over 4 pi times the kinetic energy, as eq. 6 counts it.

    Parameters
    ----------
    square : complex
        w^2 (1 + j eta), as from ``complex_mode``.

    Returns
    -------
    float
    """
    return square.imag / square.real / 2


def rigid_damping(mass_ratio: float, effectiveness: float = 1.0) -> float:
    """Damping ratio with a rigid spring, (2 / pi) eps r_m / (1 + r_m) [-].

    Parameters
    ----------
    mass_ratio : float
        r_m [-].
    effectiveness : float
        eps [-].

    Returns
    -------
    float
    """
    return 2 / math.pi * effectiveness * mass_ratio / (1 + mass_ratio)


def _matrices(mass_ratio, stiffness_ratio):
    k = stiffness_ratio
    return np.array([[1 + k, -k], [-k, k]]), np.diag([1.0, mass_ratio])
