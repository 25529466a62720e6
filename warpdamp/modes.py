"""Modes of a structure, as a damper on it sees them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from .errors import ModalError

NODE = 1e-3
"""A damper sits on a node where a mode's shape is below this part of its largest: it adds a millionth there."""

SAME_PLACE = 1e-6
"""Distance [m] within which a place is that of a point, whatever the spacing of the points."""
LOWEST = 0.1
"""Frequency [Hz] below which a mode is a rigid-body motion that was not computed to exactly 0.

It would take a stroke of 25 m to shake a damper at 1 g there.
"""


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
    unmeasured : (q,) array, names of the points of a file at which the shapes are not known
    remark : what was left out of a file, in words; empty where nothing was
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
    unmeasured: np.ndarray = field(default_factory=lambda: np.empty(0, int))
    remark: str = ""
    participation: np.ndarray | None = None

    @property
    def amplitude(self) -> np.ndarray:
        """Mass-normalised mode shape phi at the damper, in the direction of the excitation, (m,) [kg^-0.5]."""
        return self.shape[:, self.damper] @ np.asarray(self.direction)

    @property
    def modal_mass(self) -> np.ndarray:
        """Modal mass 1 / phi^2 that each mode shows at the damper's point, (m,) [kg]."""
        return 1 / self.amplitude**2

    @property
    def on_node(self) -> np.ndarray:
        """Whether the damper sits on a node of each mode, (m,) array of bool."""
        return np.abs(self.amplitude) <= NODE * np.max(np.abs(self.shape), axis=(1, 2))

    @property
    def rigid(self) -> np.ndarray:
        """(m,) whether the mode is a rigid-body motion, or as slow as one."""
        return self.frequency < LOWEST

    @property
    def dampable(self) -> np.ndarray:
        """Numbers of the modes that are vibrations and move the damper.

        Raises
        ------
        ModalError
            If there are none.
        """
        if np.all(self.rigid):
            raise ModalError(f"there are only rigid-body motions (below {LOWEST:g} Hz), which nothing can damp")
        found = self.number[~self.rigid & ~self.on_node]
        if not len(found):
            still = "no mode moves the damper where it sits, along its direction"
            raise ModalError(f"{still}{self._motion(np.flatnonzero(~self.rigid))}: choose another place or direction")
        return found

    def pick(self, numbers) -> Modes:
        """Modes of the given numbers, in that order.

        Raises
        ------
        ModalError
            If there is no such mode, if the damper sits on its node or moves across, or if it is a rigid-body motion.
        """
        rows = []
        for number in numbers:
            found = np.flatnonzero(self.number == number)
            if not len(found):
                raise ModalError(f"there is no mode {number}: choose from {_some(self.number)}")
            row = found[0]
            if self.rigid[row]:
                raise ModalError(
                    f"mode {number} is a rigid-body motion ({self.frequency[row]:.3g} Hz, below {LOWEST:g} Hz): it has "
                    "no resonance to damp"
                )
            if self.on_node[row]:
                raise ModalError(
                    f"mode {number} has a node where the damper sits: the damper cannot damp it{self._motion([row])}"
                )
            rows.append(row)
        return replace(
            self,
            number=self.number[rows],
            frequency=self.frequency[rows],
            shape=self.shape[rows],
            inherent_damping=self.inherent_damping[rows],
            mesh_error=None if self.mesh_error is None else self.mesh_error[rows],
            remark=self._left_out(),
            participation=None if self.participation is None else self.participation[rows],
        )

    def _motion(self, rows) -> str:
        """Which way the modes of some rows move the damper, where they move it across its direction."""
        here = np.abs(self.shape[rows, self.damper])
        if not np.any(here > NODE * np.max(np.abs(self.shape[rows]), axis=(1, 2))[:, None]):
            return ""
        across = ", ".join(f"{x:g}" for x in self.direction)
        return f"; it moves across ({across}) there, most of all along {'xyz'[int(np.argmax(here.max(axis=0)))]}"

    def _left_out(self) -> str:
        """A remark on the rigid-body motions among the modes."""
        slow = self.number[self.rigid]
        if not len(slow):
            return self.remark
        fastest = self.frequency[self.rigid].max()
        said = f"left out: rigid-body motions, modes {_some(slow)} (up to {fastest:.3g} Hz, below {LOWEST:g} Hz)"
        return f"{self.remark}; {said}" if self.remark else said

    def at(self, position, direction=None) -> Modes:
        """Modes as a damper at the point nearest to ``position`` (3,) [m] sees them.

        ``direction`` is that of its excitation (default: unchanged).  Amplitudes come out positive.

        Raises
        ------
        ModalError
            If that point is farther away than it is from its own nearest neighbour.
        """
        position = np.asarray(position, float)
        away = np.linalg.norm(self.point - position, axis=1)
        damper = int(np.argmin(away))
        between = np.linalg.norm(self.point - self.point[damper], axis=1)
        spacing = np.min(between[between > 0], initial=np.inf)
        if away[damper] > max(spacing if np.isfinite(spacing) else 0.0, SAME_PLACE):
            where, near = (" x ".join(f"{1e3 * x:.4g}" for x in place) for place in (position, self.point[damper]))
            raise ModalError(
                f"({where}) mm is far from every point: the nearest, ({near}) mm, is {1e3 * away[damper]:.4g} mm away: "
                "choose a place between the points, or name a node"
            )
        return self.seen_from(damper, self.direction if direction is None else direction)

    def at_label(self, label, direction=None) -> Modes:
        """Modes as a damper at the point named ``label`` sees them.

        Raises
        ------
        ModalError
            If no point has that name, or if nothing was measured there.
        """
        found = np.flatnonzero(self.label == label) if self.label is not None else []
        if not len(found):
            known = "" if self.label is None else f": choose from {_some(self.label)}"
            if label in self.unmeasured:
                raise ModalError(f"node {label} has no data in some of the modes, its motion is not known{known}")
            raise ModalError(f"there is no node {label}{known}")
        return self.seen_from(int(found[0]), self.direction if direction is None else direction)

    def seen_from(self, damper: int, direction) -> Modes:
        """Modes as a damper at row ``damper`` of the points sees them, with positive amplitudes.

        Raises
        ------
        ModalError
            If the direction has no length.
        """
        if not 0 < np.linalg.norm(direction) < np.inf:
            raise ModalError(f"the direction {[*map(float, direction)]} has no length: give x, y, z or a vector")
        unit = tuple(float(c) for c in np.asarray(direction, float) / np.linalg.norm(direction))
        sign = np.where(self.shape[:, damper] @ np.asarray(unit) < 0, -1.0, 1.0)
        gamma = None if self.participation is None else sign[:, None] * self.participation
        return replace(self, damper=damper, direction=unit, shape=sign[:, None, None] * self.shape, participation=gamma)

    def with_mass(self, mass: float) -> Modes:
        """Modes of the structure with a further point mass [kg] at the damper.

        Structural modification in the space of these modes: with q their coordinates and phi their shapes at the
        damper, (W^2 - w^2 (I + m phi phi^T)) q = 0.  Exact when every mode that the damper moves is here; what is
        left out makes the result stiffer, the more so the nearer the top of the set.  Inherent damping goes along as
        viscous modal damping, 2 zeta w.
        """
        from scipy.linalg import eigh

        at = self.shape[:, self.damper]
        omega = 2 * np.pi * self.frequency
        squared, q = eigh(np.diag(omega**2), np.eye(len(omega)) + mass * at @ at.T)
        new = np.sqrt(np.maximum(squared, 0.0))  # rounding moves rigid-body motions off 0
        viscous = (q**2).T @ (2 * self.inherent_damping * omega)
        damping = np.divide(viscous, 2 * new, out=np.zeros_like(new), where=new / (2 * np.pi) > LOWEST)
        order = np.argsort(np.argsort(self.frequency))  # the loaded modes interlace with the old ones: same rank
        changed = replace(
            self,
            frequency=(new / (2 * np.pi))[order],
            shape=np.einsum("rm,rpc->mpc", q, self.shape)[order],
            inherent_damping=damping[order],
            participation=None if self.participation is None else (q.T @ (self.participation + mass * at))[order],
        )
        return changed.seen_from(self.damper, self.direction)


def _some(names) -> str:
    """The first of some names, and how many more there are."""
    listed = ", ".join(map(str, names[:8]))
    return listed if len(names) <= 8 else f"{listed} and {len(names) - 8} more"


def mass_normalised(number, shape, modal_mass, place: str, remedy: str) -> np.ndarray:
    """Shapes (m, p, 3) of modal masses (one, or (m,)) scaled to unit modal mass [kg^-0.5].

    Raises
    ------
    ModalError
        If a mode has no modal mass: damping scales with its inverse, and no value of it can be assumed.
    """
    modal_mass = np.asarray(modal_mass, float)
    if modal_mass.ndim and len(modal_mass) != len(number):
        raise ModalError(f"{place}{len(modal_mass)} modal masses for {len(number)} modes")
    modal_mass = np.broadcast_to(modal_mass, len(number))
    without = np.asarray(number)[~(modal_mass > 0)]
    if len(without):
        raise ModalError(
            f"{place}mode{'s' * (len(without) > 1)} {', '.join(map(str, without))} without modal mass: {remedy}"
        )
    return shape / np.sqrt(modal_mass)[:, None, None]
