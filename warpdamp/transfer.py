"""States to the device's arrays and back.

On the device the particles of a large bed are numbered along a space-filling curve, so that neighbours in space are
neighbours in memory; their own numbers come back when a state is read.
"""

from __future__ import annotations

import numpy as np
import warp as wp

from .device import DEVICE
from .scene import State

FEWEST_ORDERED = 1000
"""Smaller beds lie in the processor's cache however they are numbered, and keep their own order."""

CURVE_BITS = 10  # cells of the curve along each axis: 2^10


def numbering(position: np.ndarray) -> np.ndarray:
    """Order in which the device numbers particles: along Morton's curve, (n,) indices.

    Parameters
    ----------
    position : (n, 3) array
    """
    if len(position) < FEWEST_ORDERED:
        return np.arange(len(position))
    low = position.min(axis=0)
    width = float(np.max(position.max(axis=0) - low)) or 1.0
    cell = np.minimum((position - low) / width * 2**CURVE_BITS, 2**CURVE_BITS - 1).astype(np.int64)
    curve = np.zeros(len(position), np.int64)
    for bit in range(CURVE_BITS):
        for axis in range(3):
            curve |= (cell[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(curve, kind="stable")


class Transfer:
    """Where the particles of a batch's cases lie in its arrays.

    Parameters
    ----------
    types : structs of the device, see ``kernels.data.types``
    states : list of State
    """

    def __init__(self, types, states: list[State]):
        self.types = types
        self.states = states
        self.first = np.concatenate([[0], np.cumsum([len(s) for s in states])]).astype(np.int32)
        self.order = [numbering(s.position) for s in states]

    def __len__(self) -> int:
        return int(self.first[-1])

    def array(self, values, dtype) -> wp.array:
        """On the device."""
        return wp.array(np.ascontiguousarray(values), dtype=dtype, device=DEVICE)

    def of_all(self, values: list[np.ndarray]) -> np.ndarray:
        """One array a case to one for all, in the device's order."""
        return np.concatenate([v[order] for v, order in zip(values, self.order, strict=True)])

    def particles(self, masses: list[np.ndarray]) -> wp.array:
        """The array of particles, of the given ``masses`` in each case [kg]."""
        radius = [s.radius for s in self.states]
        given = {
            "inverse_mass": [1 / m for m in masses],
            "inverse_inertia": [2.5 / (m * r**2) for m, r in zip(masses, radius, strict=True)],
        }
        values = np.zeros(len(self), dtype=self.types.Particle.numpy_dtype())
        for name in values.dtype.names:
            if name not in ("force", "torque", "listed", "returned"):
                field = name.removeprefix("half_")
                each = given[name] if name in given else [getattr(s, field) for s in self.states]
                values[name] = self.of_all(each)
        return wp.array(values, dtype=self.types.Particle, device=DEVICE)

    def contacts(self, laws: dict[str, list]):
        """The struct of contacts that the states remember, with tables of ``laws``."""
        numbered = [_numbered(s, order) for s, order in zip(self.states, self.order, strict=True)]
        pairs = np.concatenate([p + first for (p, _, _), first in zip(numbered, self.first[:-1], strict=True)])
        history = np.concatenate([history for _, history, _ in numbered])
        walls = self.of_all([s.wall_history for s in self.states]).reshape(-1, 4)
        values = {
            "start": np.concatenate([[0], np.cumsum(np.bincount(pairs[:, 0], minlength=len(self)))]),
            "partner": pairs[:, 1],
            "pair_radius": history[:, 3],
            "pair_stretch": history[:, :3],
            "pair_roll": np.concatenate([roll for _, _, roll in numbered]),
            "wall_radius": walls[:, 3],
            "wall_stretch": walls[:, :3],
            "wall_roll": self.of_all([s.wall_roll for s in self.states]).reshape(-1, 3),
        }
        c = self.types.Contacts()
        for name, variable in self.types.Contacts.vars.items():
            dtype = variable.type.dtype
            table = (
                wp.array(laws[name], dtype=dtype, device=DEVICE) if name in laws else self.array(values[name], dtype)
            )
            setattr(c, name, table)
        return c

    def listed(self, k: int, contacts) -> tuple[np.ndarray, slice]:
        """Pairs in the neighbour list of case ``k``, (m, 2), in its own numbers, and where they lie in the list."""
        first, last = self.first[k], self.first[k + 1]
        start = contacts.start.numpy()[first : last + 1]
        rows = slice(start[0], start[-1])
        owner = np.repeat(np.arange(last - first), np.diff(start))
        return self.order[k][np.stack([owner, contacts.partner.numpy()[rows] - first], axis=1)], rows

    def state(self, k: int, particles, contacts) -> State:
        """State of case ``k``; what no effect asks for stays as it was at the start."""
        before, first, last = self.states[k], self.first[k], self.first[k + 1]
        n = last - first
        back = np.argsort(self.order[k])

        own = particles.numpy()[first:last]

        def of_particles(name, start):
            return own[name].astype(float)[back] if name in own.dtype.names else start.copy()

        def of_walls(name, *shape):
            if name not in self.types.Contacts.vars:
                return np.zeros((n, 3, *shape))
            return getattr(contacts, name).numpy()[3 * first : 3 * last].astype(float).reshape(n, 3, *shape)[back]

        pairs, rows = self.listed(k, contacts)

        def of_pairs(name, *shape):
            if name not in self.types.Contacts.vars:
                return np.zeros((len(pairs), *shape))
            return getattr(contacts, name).numpy()[rows].astype(float)

        radius = of_pairs("pair_radius")
        touching = radius > 0
        turned = _orientation(pairs)
        history = np.concatenate([turned * of_pairs("pair_stretch", 3), radius[:, None]], axis=1)
        return State(
            position=of_particles("position", before.position),
            velocity=of_particles("half_velocity", before.velocity),
            spin=of_particles("half_spin", before.spin),
            radius=before.radius.copy(),
            pairs=np.sort(pairs, axis=1)[touching],
            pair_history=history[touching],
            wall_history=np.concatenate([of_walls("wall_stretch", 3), of_walls("wall_radius")[..., None]], axis=2),
            species=before.species.copy(),
            pair_roll=(turned * of_pairs("pair_roll", 3))[touching],
            wall_roll=of_walls("wall_roll", 3),
        )


def _numbered(state: State, order: np.ndarray):
    """The contacts of a state in the device's numbers and order: pairs, histories, rolls."""
    number = np.argsort(order)
    pairs = number[state.pairs]
    turned = _orientation(pairs)
    history = state.pair_history * np.concatenate([turned, turned, turned, np.ones_like(turned)], axis=1)
    pairs, roll = np.sort(pairs, axis=1), turned * state.pair_roll
    rows = np.lexsort((pairs[:, 1], pairs[:, 0]))
    return pairs[rows], history[rows], roll[rows]


def _orientation(pairs: np.ndarray) -> np.ndarray:
    """-1 where the first of a pair comes second, (m, 1): a stretch is seen from the first."""
    return np.where(pairs[:, :1] > pairs[:, 1:], -1.0, 1.0)
