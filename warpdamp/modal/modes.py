"""Modes of a structure, as a damper on it sees them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

NODE = 1e-3
"""A damper sits on a node where a mode's shape is below this part of its largest: it adds a millionth there."""


@dataclass(frozen=True)
class Modes:
    """Mass-normalised real modes.

    Parameters
    ----------
    number : (m,) array of mode numbers, 1 the lowest of its family
    frequency : (m,) array [Hz]
    point : (p, 3) array [m]
        Where the shapes are known.
    shape : (m, p, 3) array [kg^-0.5]
        Mode shapes there.
    inherent_damping : (m,) array [-]
        Damping ratios without a damper.
    damper : row of ``point`` where the damper sits
    direction : (3,) unit vector, that of the excitation
    label : (p,) array, names of the points where they have any, as node numbers of a file
    mesh_error : (m,) array [-]
        Parts by which a mesh lifts the frequencies, about; None where no mesh of the user's stands behind them.
    participation : (m, 3) array [kg^0.5] or None
        Gamma = phi^T M d of each mode, d the unit displacement of a structure that follows its base along x, y or z.
    """

    number: np.ndarray
    frequency: np.ndarray
    point: np.ndarray
    shape: np.ndarray
    inherent_damping: np.ndarray
    damper: int = 0
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)
    label: np.ndarray | None = None
    mesh_error: np.ndarray | None = None
    participation: np.ndarray | None = None

    @property
    def amplitude(self) -> np.ndarray:
        """(m,) mass-normalised mode shape phi at the damper, in the direction of the excitation [kg^-0.5]."""
        return self.shape[:, self.damper] @ np.asarray(self.direction)

    @property
    def modal_mass(self) -> np.ndarray:
        """1 / phi^2 [kg], the mass that each mode shows at the damper's point."""
        return 1 / self.amplitude**2

    @property
    def on_node(self) -> np.ndarray:
        """(m,) whether the damper sits on a node of the mode."""
        return np.abs(self.amplitude) < NODE * np.max(np.abs(self.shape), axis=(1, 2))

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
            if self.on_node[row]:
                raise ValueError(f"mode {number} has a node where the damper sits: the damper cannot damp it")
            rows.append(row)
        return replace(
            self,
            number=self.number[rows],
            frequency=self.frequency[rows],
            shape=self.shape[rows],
            inherent_damping=self.inherent_damping[rows],
            mesh_error=None if self.mesh_error is None else self.mesh_error[rows],
            participation=None if self.participation is None else self.participation[rows],
        )

    def at(self, position, direction=None) -> Modes:
        """The same modes as a damper at the point nearest to ``position`` (3,) [m] sees them.

        ``direction`` is that of its excitation (default: unchanged).  Amplitudes come out positive.
        """
        damper = int(np.argmin(np.linalg.norm(self.point - np.asarray(position, float), axis=1)))
        return self.seen_from(damper, self.direction if direction is None else direction)

    def at_label(self, label, direction=None) -> Modes:
        """The same modes as a damper at the point of that name sees them.

        Raises
        ------
        ValueError
            If no point has that name.
        """
        found = np.flatnonzero(self.label == label) if self.label is not None else []
        if not len(found):
            raise ValueError(f"there is no node {label}")
        return self.seen_from(int(found[0]), self.direction if direction is None else direction)

    def seen_from(self, damper: int, direction) -> Modes:
        """The same modes as a damper at row ``damper`` of the points sees them, with positive amplitudes."""
        unit = tuple(float(c) for c in np.asarray(direction, float) / np.linalg.norm(direction))
        sign = np.where(self.shape[:, damper] @ np.asarray(unit) < 0, -1.0, 1.0)
        gamma = None if self.participation is None else sign[:, None] * self.participation
        return replace(self, damper=damper, direction=unit, shape=sign[:, None, None] * self.shape, participation=gamma)

    def with_mass(self, mass: float) -> Modes:
        """The modes of the same structure with a point mass [kg] more at the damper.

        Structural modification in the space of these modes: with q their coordinates and phi their shapes at the
        damper, (W^2 - w^2 (I + m phi phi^T)) q = 0.  Exact when every mode that the damper moves is here; what is
        left out makes the result stiffer, the more so the nearer the top of the set.  Inherent damping goes along as
        viscous modal damping, 2 zeta w.
        """
        from scipy.linalg import eigh

        at = self.shape[:, self.damper]
        omega = 2 * np.pi * self.frequency
        squared, q = eigh(np.diag(omega**2), np.eye(len(omega)) + mass * at @ at.T)
        new = np.sqrt(squared)
        damping = (q**2).T @ (2 * self.inherent_damping * omega) / (2 * new)
        order = np.argsort(np.argsort(self.frequency))  # the loaded modes interlace with the old ones: same rank
        changed = replace(
            self,
            frequency=(new / (2 * np.pi))[order],
            shape=np.einsum("rm,rpc->mpc", q, self.shape)[order],
            inherent_damping=damping[order],
            participation=None if self.participation is None else (q.T @ (self.participation + mass * at))[order],
        )
        return changed.seen_from(self.damper, self.direction)


def mass_normalised(number, shape, modal_mass, place: str, remedy: str) -> np.ndarray:
    """Shapes (m, p, 3) of modal masses (one, or (m,)) scaled to unit modal mass [kg^-0.5].

    Raises
    ------
    ValueError
        If a mode has no modal mass: damping scales with its inverse, and no value of it can be assumed.
    """
    modal_mass = np.asarray(modal_mass, float)
    if modal_mass.ndim and len(modal_mass) != len(number):
        raise ValueError(f"{place}{len(modal_mass)} modal masses for {len(number)} modes")
    modal_mass = np.broadcast_to(modal_mass, len(number))
    without = np.asarray(number)[~(modal_mass > 0)]
    if len(without):
        raise ValueError(
            f"{place}mode{'s' * (len(without) > 1)} {', '.join(map(str, without))} without modal mass: {remedy}"
        )
    return shape / np.sqrt(modal_mass)[:, None, None]
