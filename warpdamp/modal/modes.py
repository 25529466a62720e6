"""Modes of a structure, as the damper's point on it sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Modes:
    """Mass-normalised modes.

    Parameters
    ----------
    number : (m,) array of mode numbers, 1 the lowest of its family
    frequency : (m,) array [Hz]
    amplitude : (m,) array [kg^-0.5]
        Mass-normalised mode shape phi at the damper, in the direction of the excitation.
    station : (s,) array [m]
        Positions along the structure.
    shape : (m, s) array [kg^-0.5]
        Mode shapes there.
    """

    number: np.ndarray
    frequency: np.ndarray
    amplitude: np.ndarray
    station: np.ndarray
    shape: np.ndarray

    @property
    def modal_mass(self) -> np.ndarray:
        """1 / phi^2 [kg], the mass that each mode shows at the damper's point."""
        return 1 / self.amplitude**2

    def pick(self, numbers) -> Modes:
        """The modes of the given numbers, in that order.

        Raises
        ------
        ValueError
            If there is no such mode, or if the damper sits on its node.
        """
        rows = []
        for number in numbers:
            found = np.flatnonzero(self.number == number)
            if not len(found):
                raise ValueError(f"there is no mode {number}: choose from {', '.join(map(str, self.number))}")
            row = found[0]
            if abs(self.amplitude[row]) < 1e-3 * np.max(np.abs(self.shape[row])):
                raise ValueError(f"mode {number} has a node where the damper sits: the damper cannot damp it")
            rows.append(row)
        return Modes(self.number[rows], self.frequency[rows], self.amplitude[rows], self.station, self.shape[rows])
