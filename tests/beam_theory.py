"""Timoshenko's beam with point masses anywhere, solved exactly: an independent reference for the modes.

A transfer matrix carries (w, psi, M, V) along the beam, and natural frequencies are where the conditions of both ends can
be met.  w deflection, psi rotation of the section, V = kappa G A (w' - psi), M = E I psi'; hence
M' = -V - rho I omega^2 psi and V' = -rho A omega^2 w.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import simpson
from scipy.linalg import expm
from scipy.optimize import brentq

FREE = {"clamped": [2, 3], "pinned": [1, 3], "free": [0, 1]}
"""What an end leaves free of (w, psi, M, V); the others vanish there."""


@dataclass(frozen=True)
class Section:
    """Area [m^2], second moment of area [m^4], shear coefficient [-]."""

    area: float
    second_moment: float
    shear: float


def rectangle(width, depth, nu):
    """Cowper 1966, doi:10.1115/1.3625046: kappa = 10 (1 + nu) / (12 + 11 nu)."""
    return Section(width * depth, width * depth**3 / 12, 10 * (1 + nu) / (12 + 11 * nu))


def circle(diameter, nu):
    """Cowper 1966: kappa = 6 (1 + nu) / (7 + 6 nu)."""
    return Section(math.pi / 4 * diameter**2, math.pi / 64 * diameter**4, 6 * (1 + nu) / (7 + 6 * nu))


def tube(diameter, wall, nu):
    """Cowper 1966, with m = inner over outer radius."""
    inner = diameter - 2 * wall
    m2 = (inner / diameter) ** 2
    shear = 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)
    return Section(math.pi / 4 * (diameter**2 - inner**2), math.pi / 64 * (diameter**4 - inner**4), shear)


@dataclass(frozen=True)
class Timoshenko:
    """A beam of some length [m]; ``masses`` are (mass [kg], position [m], rotary inertia [kg m^2])."""

    length: float
    section: Section
    material: object
    supports: tuple
    masses: tuple = ()

    def modes(self, count, stations=101):
        """Frequencies (count,) [Hz] of the lowest modes that bend, and on each piece between masses its positions
        (stations,) and mass-normalised deflections (count, stations) [kg^-0.5].
        """
        omega = self._roots(count)
        lines = [self._shape(w, stations) for w in omega]
        place = np.concatenate([np.linspace(a, b, stations) for a, b in self._pieces()])
        return omega / (2 * math.pi), place, np.array(lines)

    def _carry(self, omega, length):
        """(..., 4, 4) matrices that carry the state along a length."""
        a, i = self.section.area, self.section.second_moment
        rho, e, g = self.material.density, self.material.youngs_modulus, self.material.shear_modulus
        rates = np.zeros((*np.shape(omega), 4, 4))
        rates[..., 0, 1], rates[..., 0, 3] = 1, 1 / (self.section.shear * g * a)
        rates[..., 1, 2] = 1 / (e * i)
        rates[..., 2, 1], rates[..., 2, 3] = -rho * i * omega**2, -1
        rates[..., 3, 0] = -rho * a * omega**2
        return expm(rates * length)

    def _pieces(self):
        return list(itertools.pairwise(sorted({0.0, *(position for _, position, _ in self.masses), self.length})))

    def _at(self, place):
        """Mass and rotary inertia at a place."""
        here = [(m, j) for m, position, j in self.masses if position == place]
        return np.sum(here, axis=0) if here else np.zeros(2)

    def _jump(self, omega, place):
        """What the masses at a place do to shear force and moment."""
        mass, inertia = self._at(place)
        matrix = np.zeros((*np.shape(omega), 4, 4)) + np.eye(4)
        matrix[..., 3, 0], matrix[..., 2, 1] = -mass * omega**2, -inertia * omega**2
        return matrix

    def _ends(self, omega):
        """(..., 2, 2) from what the first end leaves free to what the last one holds: singular in a mode."""
        through = self._jump(omega, 0.0)
        for start, end in self._pieces():
            through = self._jump(omega, end) @ self._carry(omega, end - start) @ through
        held = [k for k in range(4) if k not in FREE[self.supports[1]]]
        return through[..., held, :][..., FREE[self.supports[0]]]

    def _roots(self, count):
        """Angular frequencies, bracketed in steps of a tenth of the dimensionless wave number: a mode adds about pi."""
        a, i = self.section.area, self.section.second_moment
        scale = math.sqrt(self.material.youngs_modulus * i / (self.material.density * a)) / self.length**2
        grid = scale * (0.1 * np.arange(3, 32 * (count + 3))) ** 2
        sign = np.sign(np.linalg.det(self._ends(grid)))
        found = np.flatnonzero(sign[1:] * sign[:-1] < 0)[:count]
        assert len(found) == count
        return np.array(
            [
                brentq(lambda w: np.linalg.det(self._ends(np.float64(w))), *grid[k : k + 2], xtol=1e-9 * grid[k])
                for k in found
            ]
        )

    def _shape(self, omega, stations):
        """Deflections where int rho A w^2 + rho I psi^2 dx + sum (m w^2 + J psi^2) = 1."""
        a, i, rho = self.section.area, self.section.second_moment, self.material.density
        state = np.zeros(4)
        state[FREE[self.supports[0]]] = np.linalg.svd(self._ends(omega))[2][-1]
        total, lines = self._at(0.0) @ state[:2] ** 2, []
        state = self._jump(omega, 0.0) @ state
        for start, end in self._pieces():
            step = self._carry(omega, (end - start) / (stations - 1))
            states = [state]
            for _ in range(stations - 1):
                states.append(step @ states[-1])
            w, psi = np.array(states)[:, :2].T
            total += simpson(rho * a * w**2 + rho * i * psi**2, dx=(end - start) / (stations - 1))
            total += self._at(end) @ states[-1][:2] ** 2
            state = self._jump(omega, end) @ states[-1]
            lines.append(w)
        return np.concatenate(lines) / math.sqrt(total)
