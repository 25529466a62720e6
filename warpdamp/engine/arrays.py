"""States to the device's arrays and back.

On the device the particles of a large bed are numbered row by row and layer by layer, so that the neighbours of one
after the other lie one after the other, too, as a processor expects; their own numbers come back when a state is read.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import warp as wp

from ..scene.particles import State
from .device import DEVICE

FEWEST_ORDERED = 1000
"""Smaller beds lie in the processor's cache however they are numbered, and keep their own order."""


def numbering(position: np.ndarray) -> np.ndarray:
    """Order in which the device numbers particles: by layers, rows and places along a row, (n,) indices.

    Parameters
    ----------
    position : (n, 3) array
    """
    if len(position) < FEWEST_ORDERED:
        return np.arange(len(position), dtype=np.int32)
    low = position.min(axis=0)
    width = position.max(axis=0) - low
    spacing = float(np.prod(width) / len(position)) ** (1 / 3) or 1.0
    cell = ((position - low) / spacing).astype(np.int64)
    return np.lexsort((cell[:, 0], cell[:, 1], cell[:, 2])).astype(np.int32)


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

    def _set(self, column: np.ndarray, values: list[np.ndarray]) -> None:
        """Fill a column of the device, one array a case, in the device's order."""
        for first, own, order in zip(self.first, values, self.order, strict=False):
            column[first : first + len(order)] = own[order]

    def particles(self, masses: list[np.ndarray]) -> wp.array:
        """The array of particles, of the given ``masses`` in each case [kg]."""
        particles = wp.zeros(len(self), dtype=self.types.Particle, device=DEVICE)
        columns = particles.numpy()  # the device's own memory: large beds are not copied
        radius = [s.radius for s in self.states]
        for name in columns.dtype.names:
            if name == "inverse_mass":
                own = [1 / m for m in masses]
            elif name == "inverse_inertia":
                own = [2.5 / (m * r**2) for m, r in zip(masses, radius, strict=True)]
            elif name in ("force", "torque", "listed"):
                continue
            else:
                own = [getattr(s, name.removeprefix("half_")) for s in self.states]
            self._set(columns[name], own)
        return particles

    def contacts(self, laws: dict[str, list]):
        """The struct of contacts that the states remember, with tables of ``laws``."""
        numbered = [_numbered(s, order) for s, order in zip(self.states, self.order, strict=True)]
        pairs = np.concatenate([p + first for (p, _, _), first in zip(numbered, self.first[:-1], strict=True)])
        start = np.concatenate([[0], np.cumsum(np.bincount(pairs[:, 0], minlength=len(self)))])
        c = self.types.Contacts()
        c.start, c.partner = self.array(start, wp.int32), self.array(pairs[:, 1], wp.int32)
        known = self.types.Contacts.vars
        for name in known.keys() & laws.keys():
            setattr(c, name, wp.array(laws[name], dtype=self.types.Law, device=DEVICE))
        if "pair" in known:
            c.pair = wp.zeros(len(pairs), dtype=self.types.History, device=DEVICE)
            c.wall = wp.zeros(3 * len(self), dtype=self.types.History, device=DEVICE)
            pair, wall = c.pair.numpy(), c.wall.numpy().reshape(len(self), 3)
            of_pairs = _columns(*(np.concatenate([own[k] for own in numbered]) for k in (1, 2)))
            of_walls = [_columns(s.wall_history, s.wall_roll) for s in self.states]
            for name in pair.dtype.names:
                pair[name] = of_pairs[name]
                self._set(wall[name], [own[name] for own in of_walls])
        return c

    def listed(self, k: int, contacts, part: int = 10_000) -> Iterator[np.ndarray]:
        """Pairs in the neighbour list of case ``k``, (m, 2), in its own numbers, of ``part`` particles at a time."""
        first, last, order = self.first[k], self.first[k + 1], self.order[k]
        start, partner = contacts.start.numpy(), contacts.partner.numpy()
        for low in range(first, last, part):
            high = min(low + part, last)
            owner = np.repeat(np.arange(low, high), np.diff(start[low : high + 1]))
            yield order[np.stack([owner, partner[start[low] : start[high]]], axis=1) - first]

    def state(self, k: int, particles, contacts) -> State:
        """State of case ``k``; what no effect asks for stays as it was at the start."""
        before, first, last = self.states[k], self.first[k], self.first[k + 1]
        n = last - first
        back = np.argsort(self.order[k])
        own = particles.numpy()[first:last]

        def of_particles(name, start):
            return own[name][back].astype(float, copy=False) if name in own.dtype.names else start.copy()

        wall_history, wall_roll = np.zeros((n, 3, 4)), np.zeros((n, 3, 3))
        if "wall" in self.types.Contacts.vars:
            walls = contacts.wall.numpy()[3 * first : 3 * last].reshape(n, 3)
            wall_history, wall_roll = _recalled(walls, back)
        return State(
            position=of_particles("position", before.position),
            velocity=of_particles("half_velocity", before.velocity),
            spin=of_particles("half_spin", before.spin),
            radius=before.radius.copy(),
            species=before.species.copy(),
            wall_history=wall_history,
            wall_roll=wall_roll,
            **self._touching(k, contacts),
        )

    def _touching(self, k: int, contacts) -> dict[str, np.ndarray]:
        """The pairs of case ``k`` that touch, and what they remember."""
        if "pair" not in self.types.Contacts.vars:
            return {"pairs": np.zeros((0, 2), np.int32), "pair_history": np.zeros((0, 4))}
        first, last = self.first[k], self.first[k + 1]
        start = contacts.start.numpy()[first : last + 1]
        memory = contacts.pair.numpy()
        rows = start[0] + np.flatnonzero(memory["radius"][start[0] : start[-1]] > 0)
        owner = np.searchsorted(start, rows, side="right") - 1
        pairs = self.order[k][np.stack([owner, contacts.partner.numpy()[rows] - first], axis=1)]
        turned = _orientation(pairs)
        history, roll = _recalled(memory, rows)
        history[:, :3] *= turned
        return {"pairs": np.sort(pairs, axis=1), "pair_history": history, "pair_roll": turned * roll}


def _columns(history: np.ndarray, roll: np.ndarray) -> dict[str, np.ndarray]:
    """Views of a state's (..., 4) histories and (..., 3) rolls, by their names on the device."""
    return {"radius": history[..., 3], "stretch": history[..., :3], "roll": roll}


def _recalled(memory: np.ndarray, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Histories and rolls of a state from the device's ``memory`` of contacts, in an order."""
    shape = (len(order), *memory.shape[1:])
    history, roll = np.zeros((*shape, 4)), np.zeros((*shape, 3))
    columns = _columns(history, roll)
    for name in memory.dtype.names:  # one after the other: large beds are not copied whole
        columns[name][...] = memory[name][order]
    return history, roll


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
