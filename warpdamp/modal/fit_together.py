"""Several modes of one accelerance at once, with residuals for the modes below and above the data, by least squares.

    A = sum C_r w^2 / (w^2 - w_r^2 - j loss_r) + below - above w^2,

loss_r = 2 zeta_r w_r^2 of structural damping, 2 zeta_r w_r w of viscous; each point is weighed by its own size.
"""

from __future__ import annotations

import numpy as np

from ..errors import ModalError
from .fit import Damping, Fit, quality

MOST_EVALUATIONS = 100
"""Steps of the iteration; it ends in about ten where there are modes."""


def least_squares(frequency, accelerance, start: list[Fit], damping: Damping = Damping.STRUCTURAL) -> list[Fit]:
    """Several modes at once, with residuals for the modes below and above the data.

    Frequencies and damping ratios are sought; modal constants and residuals, complex as a damper at one point makes
    them, are linear and solved for on the way (variable projection).

    Parameters
    ----------
    frequency, accelerance : (n,) arrays [Hz], [m s^-2 N^-1]
        Of all modes' bands together.
    start : first guesses
    damping : structural or viscous

    Raises
    ------
    ModalError
        If there are fewer points than unknowns, or if the iteration does not end.
    """
    from scipy.optimize import least_squares as solve

    f, a = np.asarray(frequency, float), np.asarray(accelerance, complex)
    count = len(start)
    scale = np.array([g.frequency for g in start] + [g.damping_ratio for g in start])
    unknowns = 2 * count + 2 * (count + 2)
    if 2 * len(f) <= unknowns:
        raise ModalError(f"{len(f)} points cannot tell {unknowns} unknowns: fit fewer modes or give more points")
    wanted = a / np.abs(a)

    def columns(p):
        own, zeta = p[:count] * scale[:count], p[count:] * scale[count:]
        loss = 2j * zeta * own * (own if damping is Damping.STRUCTURAL else f[:, None])
        modes = f[:, None] ** 2 / (f[:, None] ** 2 - own**2 - loss)
        residuals = np.stack([np.ones(len(f)), -((f / f[-1]) ** 2)], axis=1)
        return np.concatenate([modes, residuals], axis=1) / np.abs(a)[:, None]

    def constants(p):
        return np.linalg.lstsq(columns(p), wanted, rcond=None)[0]

    def misfit(p):
        return _parts(columns(p) @ constants(p) - wanted)

    found = solve(misfit, np.ones(2 * count), xtol=1e-12, ftol=1e-12, max_nfev=MOST_EVALUATIONS)
    if not found.success:
        raise ModalError(f"the least-squares fit did not end: {found.message}")
    value, constant = found.x * scale, constants(found.x)
    moved = [_parts((columns(found.x + h) - columns(found.x - h)) @ constant / 2e-7) for h in 1e-7 * np.eye(2 * count)]
    every = columns(found.x)
    slopes = np.concatenate([np.stack(moved, axis=1), _parts(every), _parts(1j * every)], axis=1)
    variance = 2 * found.cost / (2 * len(f) - unknowns)
    error = np.sqrt(variance * np.diag(np.linalg.pinv(slopes.T @ slopes))[: 2 * count]) * scale
    fitted, owner = every @ constant * np.abs(a), np.argmin(np.abs(np.log(f[:, None] / value[:count])), axis=1)
    return [
        Fit(
            *map(float, value[[r, count + r]]),
            complex(constant[r]),
            *map(float, error[[r, count + r]]),
            quality=quality(a[owner == r], fitted[owner == r]),
        )
        for r in range(count)
    ]


def _parts(values):
    """Real and imaginary parts, one below the other."""
    return np.concatenate([values.real, values.imag])
