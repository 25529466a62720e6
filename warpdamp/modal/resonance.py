"""A mode with dampers on it, each as hard shaken as its own place moves, and each with the mass that it is felt with.

With phi_c the mass-normalised shapes of the structure without particles and m_c = m' - j m'' the damper's complex mass,

    w^2 (1 + sum_c phi_c^2 m_c(f, Gamma |phi_c / phi_1|)) = w_0^2 (1 + 2 j zeta_0),

solved for the real frequency f and the damping ratio at Gamma of the first damper.  One damper: ``frf.ModalModel``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .apparent_mass import ComplexMass

CLOSE, MOST = 1e-10, 200
"""Part of the frequency that a step still changes at the end, and how many steps there are at most: each takes the
masses at the frequency before, which change little with it."""


@dataclass(frozen=True)
class LoadedMode:
    """One mode of a structure and the dampers on it.

    Parameters
    ----------
    frequency, damping_ratio : of the structure with its dampers empty [Hz], [-]
    amplitude : (dampers,) array, mass-normalised shape at each damper [kg^-0.5]
    dampers : complex mass of each
    """

    frequency: float
    damping_ratio: float
    amplitude: np.ndarray
    dampers: Sequence[ComplexMass]

    def at(self, gamma) -> tuple[np.ndarray, np.ndarray]:
        """Natural frequency [Hz] and damping ratio at Gammas of the first damper; NaN outside what is known of any.

        Parameters
        ----------
        gamma : (...) array [-]

        Raises
        ------
        ModalError
            If the mode is outside the frequencies of a card.
        """
        gamma = np.asarray(gamma, float)
        own = [gamma * part for part in np.abs(self.amplitude / self.amplitude[0])]
        moved = [damper for damper, phi in zip(self.dampers, self.amplitude, strict=True) if phi]
        known = np.isfinite(gamma)
        for damper, phi, its in zip(self.dampers, self.amplitude, own, strict=True):
            known &= damper.within(its) if phi else True  # on its node a damper is not shaken, and adds nothing
        answer = np.full((2, *gamma.shape), np.nan)
        if known.any():
            found = self._solved([its[known] for its in own])
            for damper in moved:
                damper.require_modes_at(found.real)
            answer[..., known] = found.real, found.imag
        return answer[0], answer[1]

    def _solved(self, own: list[np.ndarray]) -> np.ndarray:
        """Frequency + j damping ratio at known Gammas of every damper."""
        frequency, before = np.full(own[0].shape, self.frequency), 0.0
        square = np.empty(own[0].shape, complex)
        for _ in range(MOST):
            felt = sum(
                phi**2 * damper(frequency, its)
                for phi, damper, its in zip(self.amplitude, self.dampers, own, strict=True)
                if phi
            )
            square = self.frequency**2 * (1 + 2j * self.damping_ratio) / (1 + felt)
            frequency, before = np.sqrt(square.real), frequency
            if np.all(np.abs(frequency - before) <= CLOSE * frequency):
                break
        return frequency + 0.5j * square.imag / square.real
