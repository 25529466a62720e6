"""Steady response to a constant harmonic force by harmonic balance: every branch, followed by pseudo-arclength.

One harmonic, one point: the force on the point, amplitude F, and its motion Re(a exp(j (w t + phi))) balance when

    Z(f, a) a exp(j phi) = F,        Z = structure(f) + damper(f, a),        w = 2 pi f,

Z being the force that unit motion takes.  The motion may be a displacement (Z a dynamic stiffness, as of Duffing's
oscillator) or an acceleration (Z a dynamic mass, as of a granular damper): whichever the damper's force depends on.
The solutions are the level curve ``ln(a |Z| / F) = 0`` in the plane (f, a).  Its crossings of the lines of a grid start
the continuation, so a branch is found, detached ones too, unless it fits inside one cell.  A curve that leaves the grid
is cut there: an antiresonance without damping, where the motion vanishes, cuts a curve in two.

Stability follows from the amplitude's own slow motion.  With w replaced by w - j d/dt in the structure, the balance
becomes Z A - j Z_w dA/dt = F, and a state is stable where the eigenvalues of the linearised equation have negative real
parts.  Folds are where their product passes zero, which is where the force at a fixed frequency, ``a |Z|``, is
stationary in a.  The damper is taken to follow the amplitude at once: a bed that remembers is beyond a describing
function.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import ModalError

Impedance = Callable[[np.ndarray], np.ndarray]
"""Complex force per motion at frequencies [Hz]."""
DescribingFunction = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Complex force per motion at frequencies [Hz] and amplitudes, arrays of one shape."""

LONGEST_STEP, SHORTEST_STEP = 0.5, 1e-5
"""Steps of the continuation, in cells of the grid."""
SHARPEST_TURN = np.cos(np.radians(12))
"""Cosine of the largest angle between the tangents at successive points."""


@dataclass(frozen=True)
class Branch:
    """Branch of the response: solutions in the order in which the curve is followed.

    Parameters
    ----------
    frequency : (n,) array [Hz]
    amplitude : (n,) array, of the motion
    phase : (n,) array, of the motion against the force [rad]
    stable : (n,) array of bool
    closed : whether the curve returns to its start: a detached branch
    """

    frequency: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray
    stable: np.ndarray
    closed: bool

    @property
    def folds(self) -> np.ndarray:
        """Numbers of the points at which the frequency turns back."""
        step = np.diff(self.frequency)
        return np.flatnonzero(step[1:] * step[:-1] < 0) + 1


def branches(structure: Impedance, damper: DescribingFunction, force: float, frequency, amplitude) -> list[Branch]:
    """Branches of the response in the window of a grid, longest first.

    Parameters
    ----------
    structure : callable
        Force per unit motion at a frequency [Hz].
    damper : callable
        Force per unit motion at a frequency [Hz] and an amplitude.
    force : float
        Amplitude F [N].
    frequency, amplitude : increasing arrays
        Lines of the grid, [Hz] and of the motion.  Dense where the response is sharp: the continuation steps by at most
        half a cell.

    Returns
    -------
    list of Branch

    Raises
    ------
    ModalError
        If the continuation stalls, at a point that the message names.
    """
    plane = _Plane(structure, damper, force, np.asarray(frequency, float), np.asarray(amplitude, float))
    found: list[tuple[np.ndarray, bool]] = []
    seeds = plane.crossings()
    while len(seeds):
        seed, seeds = plane.corrected(seeds[0]), seeds[1:]
        if seed is None or any(_distance(seed[None], line)[0] < 0.05 for line, _ in found):
            continue
        line, closed = plane.followed(seed)
        found.append((line, closed))
        seeds = seeds[_distance(seeds, line) > 0.2] if len(seeds) else seeds
    found.sort(key=lambda pair: -len(pair[0]))
    return [_branch(plane, line, closed) for line, closed in found]


def is_stable(structure: Impedance, damper: DescribingFunction, frequency, amplitude) -> np.ndarray:
    """Whether states on the response are stable, from the slow equations of the amplitude.

    With c = 1 / (j Z_w) and p = c (Z + a Z_a), q = j c Z the Jacobian is [[Re p, Re q], [Im p, Im q]].

    Parameters
    ----------
    structure, damper : callables
        See ``branches``.
    frequency, amplitude : (n,) arrays
        [Hz] and of the motion.

    Returns
    -------
    (n,) array of bool
    """
    f, a = np.asarray(frequency, float), np.asarray(amplitude, float)
    df, da = 1e-6 * f, 1e-6 * a
    z = structure(f) + damper(f, a)
    z_w = (structure(f + df) - structure(f - df)) / (4 * np.pi * df)
    z_a = (damper(f, a + da) - damper(f, a - da)) / (2 * da)
    p, q = (z + a * z_a) / (1j * z_w), z / z_w
    return (p.real + q.imag < 0) & (p.real * q.imag - q.real * p.imag > 0)


def _branch(plane, line, closed) -> Branch:
    f, a = plane.values(line.T)
    return Branch(f, a, -np.angle(plane.impedance(f, a)), is_stable(plane.structure, plane.damper, f, a), closed)


def _distance(points, line) -> np.ndarray:
    """Distance of each of ``points`` (n, 2) from a polyline (m, 2)."""
    start, along = line[:-1], np.diff(line, axis=0)
    best = np.full(len(points), np.inf)
    for begin, way in zip(start, along, strict=True):
        part = np.clip((points - begin) @ way / max(way @ way, 1e-300), 0, 1)
        best = np.minimum(best, np.hypot(*(points - begin - part[:, None] * way).T))
    return best


@dataclass(frozen=True)
class _Plane:
    """The grid's own coordinates, in which a cell is a unit square and sharp peaks are round."""

    structure: Impedance
    damper: DescribingFunction
    force: float
    frequency: np.ndarray
    amplitude: np.ndarray

    def impedance(self, frequency, amplitude):
        """Z at frequencies [Hz] and amplitudes."""
        return self.structure(frequency) + self.damper(frequency, amplitude)

    @cached_property
    def _size(self):
        return np.array([len(self.frequency) - 1, len(self.amplitude) - 1], float)

    @cached_property
    def _maps(self):
        from scipy.interpolate import PchipInterpolator

        return [PchipInterpolator(np.arange(len(line)), np.log(line)) for line in (self.frequency, self.amplitude)]

    def values(self, points):
        """Frequencies and amplitudes at grid coordinates (2, ...)."""
        points = np.clip(points, 0, self._size.reshape(2, *[1] * (np.ndim(points) - 1)))
        return tuple(np.exp(line(place)) for line, place in zip(self._maps, points, strict=True))

    def level(self, points):
        """ln(a |Z| / F) at grid coordinates (2, ...)."""
        f, a = self.values(points)
        return np.log(a * np.abs(self.impedance(f, a)) / self.force)

    def crossings(self) -> np.ndarray:
        """(n, 2) points where the level curve crosses the grid's lines, between neighbours by linear interpolation."""
        count = (self._size + 1).astype(int)
        u, v = np.meshgrid(np.arange(count[0]), np.arange(count[1]), indexing="ij")
        level = self.level(np.array([u, v], float))
        found = []
        for axis in (0, 1):
            near, far = np.moveaxis(level, axis, 0)[:-1], np.moveaxis(level, axis, 0)[1:]
            row, other = np.nonzero((near < 0) != (far < 0))
            part = near[row, other] / (near[row, other] - far[row, other])
            pair = [row + part, other]
            found.append(np.array(pair if axis == 0 else pair[::-1], float).T)
        return np.concatenate(found)

    def _slope(self, point):
        """Level and its gradient."""
        h = 1e-4
        around = point[:, None] + h * np.array([[0, 1, -1, 0, 0], [0, 0, 0, 1, -1]])
        around = np.clip(around, 0, self._size[:, None])
        g = self.level(around)
        return g[0], np.array([(g[k] - g[k + 1]) / (around[j, k] - around[j, k + 1]) for j, k in enumerate((1, 3))])

    def corrected(self, guess, tangent=None):
        """The solution near a guess, by Newton's steps across ``tangent`` or along the gradient, or None."""
        point = guess
        for _ in range(12):
            level, gradient = self._slope(point)
            if not np.isfinite(level) or not gradient.any():
                return None
            if abs(level) < 1e-11:
                return point
            across = gradient if tangent is None else np.array([-tangent[1], tangent[0]])
            if abs(gradient @ across) < 1e-12:
                return None
            move = -level / (gradient @ across) * across
            if np.hypot(*move) > 2 or np.hypot(*(point + move - guess)) > 2:
                return None
            point = np.clip(point + move, 0, self._size)
        return point if abs(self.level(point)) < 1e-7 else None

    def _tangent(self, point, along):
        """Unit tangent of the level curve, on the side of ``along``."""
        _, gradient = self._slope(point)
        tangent = np.array([-gradient[1], gradient[0]]) / np.hypot(*gradient)
        return tangent if tangent @ along >= 0 else -tangent

    def followed(self, seed):
        """Curve through a seed, both ways to the edge of the grid or round to the seed again."""
        first = self._tangent(seed, np.array([1.0, 0.0]))
        ahead, closed = self._one_way(seed, first)
        if closed:
            return ahead, True
        behind, _ = self._one_way(seed, -first)
        return np.concatenate([behind[:0:-1], ahead]), False

    def _one_way(self, seed, tangent):
        """Points from the seed on, and whether they came round."""
        start, line, step, travelled = tangent, [seed], LONGEST_STEP / 4, 0.0
        while True:
            point = line[-1]
            reach, outside = self._inside(point, tangent, step)
            if reach < SHORTEST_STEP:
                return np.array(line), False
            new = self.corrected(point + reach * tangent, tangent)
            new_tangent = None if new is None else self._tangent(new, tangent)
            if new is None or new_tangent @ tangent < SHARPEST_TURN or np.hypot(*(new - point)) > 2 * reach + 1e-9:
                step = min(step, reach) / 2
                if step < SHORTEST_STEP:
                    if np.any((point < 1e-2) | (point > self._size - 1e-2)):  # it leaves the grid along its edge
                        return np.array(line), False
                    f, a = self.values(point)
                    raise ModalError(
                        f"the continuation stalls at {f:.6g} Hz, amplitude {a:.4g}: give a finer grid there"
                    )
                continue
            travelled += np.hypot(*(new - point))
            if travelled > 2 * LONGEST_STEP and _passes(point, new, seed) and new_tangent @ start > 0:
                return np.array([*line, seed]), True
            line.append(new)
            if outside:
                return np.array(line), False
            tangent, step = new_tangent, min(LONGEST_STEP, 1.5 * step)

    def _inside(self, point, tangent, step):
        """The step, shortened to end at the grid's edge, and whether it does."""
        with np.errstate(divide="ignore"):
            room = np.where(tangent > 0, self._size - point, point) / np.abs(tangent)
        return min(step, room.min()), bool(room.min() <= step)


def _passes(point, new, seed) -> bool:
    """Whether the step from ``point`` to ``new`` goes by the seed."""
    way = new - point
    part = (seed - point) @ way / (way @ way)
    return 0 <= part <= 1 and np.hypot(*(point + part * way - seed)) < 0.05
