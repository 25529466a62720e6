"""Several modes of one accelerance at once, with residuals for the modes below and above the data, by least squares.

    A = sum C_r w^2 / (w^2 - w_r^2 - j loss_r) + below - above w^2,

loss_r = 2 zeta_r w_r^2 of structural damping, 2 zeta_r w_r w of viscous; each point is weighed by its own size.

References
----------
Kaufman, A variable projection method for solving separable nonlinear least squares problems, BIT 15 (1975) 49-57,
doi:10.1007/BF01932995.
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
    unknowns = 2 * count + 2 * (count + 2)
    if 2 * len(f) <= unknowns:
        raise ModalError(f"{len(f)} points cannot tell {unknowns} unknowns: fit fewer modes or give more points")
    model = _Model(f, a, start, damping)
    found = solve(
        lambda p: _parts(model.misfit(p)), np.ones(2 * count), lambda p: _parts(model.slopes_of_misfit(p)),
        xtol=1e-12, ftol=1e-12, max_nfev=MOST_EVALUATIONS,
    )  # fmt: skip
    if not found.success:
        raise ModalError(f"the least-squares fit did not end: {found.message}")
    value, constant, columns = found.x * model.scale, model.constants(found.x), model.columns(found.x)
    slopes = np.concatenate([_parts(part) for part in (model.slopes(found.x), columns, 1j * columns)], axis=1)
    variance = 2 * found.cost / (2 * len(f) - unknowns)
    error = np.sqrt(variance * np.diag(np.linalg.pinv(slopes.T @ slopes))[: 2 * count]) * model.scale
    fitted = columns @ constant * np.abs(a)
    owner = np.argmin(np.abs(f[:, None] - value[:count]), axis=1)
    return [
        Fit(
            *map(float, value[[r, count + r]]),
            complex(constant[r]),
            *map(float, error[[r, count + r]]),
            quality=quality(a[owner == r], fitted[owner == r]),
        )
        for r in range(count)
    ]


class _Model:
    """Accelerance over its own size as columns times constants; frequencies and ratios p over those of the start."""

    def __init__(self, f: np.ndarray, a: np.ndarray, start: list[Fit], damping: Damping):
        self.f, self.size, self.damping = f[:, None], np.abs(a)[:, None], damping
        self.wanted = a / np.abs(a)
        self.scale = np.array([g.frequency for g in start] + [g.damping_ratio for g in start])

    def _modes(self, p):
        """Frequencies, ratios, frequency in the damping term, and f^2 / (f^2 - f_r^2 - j loss_r)."""
        own, zeta = np.split(p * self.scale, 2)
        of = own if self.damping is Damping.STRUCTURAL else self.f
        return own, zeta, of, self.f**2 / (self.f**2 - own**2 - 2j * zeta * own * of)

    def columns(self, p) -> np.ndarray:
        """(n, m + 2): the modes, and residuals below and above."""
        residuals = np.concatenate([np.ones_like(self.f), -((self.f / self.f[-1]) ** 2)], axis=1)
        return np.concatenate([self._modes(p)[-1], residuals], axis=1) / self.size

    def constants(self, p) -> np.ndarray:
        return np.linalg.lstsq(self.columns(p), self.wanted, rcond=None)[0]

    def misfit(self, p) -> np.ndarray:
        return self.columns(p) @ self.constants(p) - self.wanted

    def slopes(self, p) -> np.ndarray:
        """(n, 2 m) derivatives of columns times constants, the constants held."""
        own, zeta, of, modes = self._modes(p)
        doubled = 2 if self.damping is Damping.STRUCTURAL else 1  # f_r stands twice in the loss
        by_frequency, by_ratio = 2 * own + 2j * zeta * of * doubled, 2j * own * of
        each = (modes / self.f) ** 2 * self.constants(p)[: len(own)] / self.size
        return np.concatenate([each * by_frequency, each * by_ratio], axis=1) * self.scale

    def slopes_of_misfit(self, p) -> np.ndarray:
        """Slopes less their part that the constants absorb; its change is of second order (Kaufman 1975)."""
        q, _ = np.linalg.qr(self.columns(p))
        slopes = self.slopes(p)
        return slopes - q @ (q.conj().T @ slopes)


def _parts(values):
    """Real and imaginary parts, one below the other."""
    return np.concatenate([values.real, values.imag])
