"""Energy ledger as read on the host: rows of running totals, and differences between them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..kernels.columns import STORES, columns, loss_columns
from ..scene.effects import Effects
from ..scene.scene import Drive


@dataclass(frozen=True)
class Ledger:
    """Energy ledger of one case: running totals at a number of moments.

    Parameters
    ----------
    rows : (moments, columns) array
        See ``warpdamp.kernels.columns.columns``.
    effects : Effects
        They say which columns there are.
    """

    rows: np.ndarray
    effects: Effects = Effects()  # noqa: RUF009 - frozen

    def __getitem__(self, name: str) -> np.ndarray:
        return self.rows[:, columns(self.effects).index(name)]

    @property
    def losses(self) -> tuple[str, ...]:
        """Names of the columns of losses."""
        return loss_columns(self.effects)

    def total(self, names) -> np.ndarray:
        """Sum of the named columns at every moment, (moments,)."""
        every = columns(self.effects)
        return self.rows[:, [every.index(name) for name in names]].sum(axis=1)

    @property
    def dissipated(self) -> np.ndarray:
        """Energy dissipated in all channels since step 0, (moments,) [J]."""
        return self.total(self.losses)

    @property
    def stored(self) -> np.ndarray:
        """Kinetic, gravitational and elastic energy, (moments,) [J]."""
        return self.total(STORES)

    @property
    def residual(self) -> np.ndarray:
        """Work put in, less losses and the gain of the stored energy, since the first moment, (moments,) [J]."""
        balance = self["work_input"] - self.dissipated - self.stored
        return balance - balance[0]

    @property
    def coupled_residual(self) -> np.ndarray:
        """Residual with a structure: work of the force on it, less losses and gains in the laboratory frame [J]."""
        kept = self.stored + self["structure_energy"] + self["frame_energy"]
        balance = self["force_work"] - self["structure_loss"] - self.dissipated - kept
        return balance - balance[0]

    def per_cycle(self) -> np.ndarray:
        """Energy dissipated in each interval between moments, (moments - 1,) [J]."""
        return np.diff(self.dissipated)

    def between(self, first: int, last: int) -> Ledger:
        """Ledger of the moments ``first`` .. ``last``, both included."""
        return Ledger(self.rows[first : last + 1], self.effects)

    def change(self, name: str) -> float:
        """Change of one column from the first moment to the last."""
        return float(self[name][-1] - self[name][0])

    def reaction(self, drive: Drive) -> complex:
        """First harmonic F1 of the force of the particles on the enclosure [N], moments one cycle apart.

        The enclosure is at x = Re(X exp(j w t')), so that -pi X Im(F1) is the work done on the particles per cycle
        and Re(F1) / (w^2 X) the apparent mass.
        """
        time = (len(self.rows) - 1) / drive.frequency
        return complex(self.change("reaction_sine"), self.change("reaction_cosine")) * 2 / time


def maximum_energy(drive: Drive, mass: float) -> float:
    """Energy per cycle of the ideal impact damper, 4 (Gamma g / w)^2 m [J] (eq. 5)."""
    return 4 * drive.speed**2 * mass


def apparent_mass(reaction: complex, drive: Drive) -> float:
    """Apparent mass Re(F1) / (w^2 X) [kg]: what the structure feels in phase with its acceleration."""
    return reaction.real / drive.acceleration


def harmonic_work(reaction: complex, drive: Drive) -> float:
    """Work per cycle of the reaction's first harmonic, -pi X Im(F1) [J]."""
    return -math.pi * drive.displacement * reaction.imag
