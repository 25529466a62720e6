"""Transfer of states to the device's arrays and back.

On the device the particles of a large bed are numbered row by row and layer by layer, so that the neighbours of one
after the other lie one after the other, too, as a processor expects; their own numbers come back when a state is read.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import warp as wp

from ..kernels.structs import WALLS
from ..scene.particles import ContactHistory, State

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
    """Transfer of a batch's particles between states and the device's arrays.

    Parameters
    ----------
    types : structs of the device, see ``kernels.structs.types``
    states : list of State
    device : where the arrays lie
    """

    def __init__(self, types, states: list[State], device: str):
        self.types = types
        self.device = device
        self.states = states
        self.first = np.concatenate([[0], np.cumsum([len(s) for s in states])]).astype(np.int32)
        self.order = [numbering(s.position) for s in states]

    def __len__(self) -> int:
        return int(self.first[-1])

    def array(self, values, dtype) -> wp.array:
        """Array of values on the device; it may share their memory, so that a large bed is not copied."""
        return wp.array(np.ascontiguousarray(values), dtype=dtype, device=self.device, copy=False)

    def _set(self, column: np.ndarray, values: list[np.ndarray]) -> None:
        """Fill a column of the device, one array a case, in the device's order."""
        for first, given, order in zip(self.first, values, self.order, strict=False):
            column[first : first + len(order)] = given[order]

    def particles(self, masses: list[np.ndarray]) -> wp.array:
        """Array of particles, of the given ``masses`` in each case [kg]."""
        particles = np.zeros(len(self), dtype=self.types.Particle.numpy_dtype())
        constants = [state.constants(mass) for state, mass in zip(self.states, masses, strict=True)]
        for name in particles.dtype.names:
            plain = name.removeprefix("half_")
            if name in constants[0]:
                self._set(particles[name], [values[name] for values in constants])
            elif hasattr(self.states[0], plain):
                self._set(particles[name], [getattr(state, plain) for state in self.states])
        return self.array(particles, self.types.Particle)

    def contacts(self, laws: dict[str, list]):
        """Struct of the states' contact histories, with tables of ``laws``."""
        known = self.types.Contacts.vars
        states = [_placed(s) for s in self.states] if "normal" in self.types.History.vars else self.states
        numbered = [_numbered(s, order) for s, order in zip(states, self.order, strict=True)]
        pairs = np.concatenate([p + first for (p, _), first in zip(numbered, self.first[:-1], strict=True)])
        start = np.concatenate([[0], np.cumsum(np.bincount(pairs[:, 0], minlength=len(self)))])
        c = self.types.Contacts()
        c.start, c.owner, c.partner = (self.array(a, wp.int32) for a in (start, pairs[:, 0], pairs[:, 1]))
        c.nearby, c.touching = (wp.empty(len(pairs), dtype=wp.int32, device=self.device) for _ in range(2))
        c.touching_walls = wp.empty(WALLS * len(self), dtype=wp.int32, device=self.device)
        for name in known.keys() & laws.keys():
            setattr(c, name, wp.array(laws[name], dtype=self.types.Law, device=self.device))
        if "pair" in known:
            dtype = self.types.History.numpy_dtype()
            pair, wall = np.zeros(len(pairs), dtype), np.zeros((len(self), WALLS), dtype)
            for name in pair.dtype.names:
                pair[name] = np.concatenate([getattr(history, name) for _, history in numbered])
                self._set(wall[name], [getattr(s.wall_history, name) for s in states])
            c.pair, c.wall = (self.array(memory.ravel(), self.types.History) for memory in (pair, wall))
        return c

    def listed(self, k: int, contacts, part: int = 10_000) -> Iterator[np.ndarray]:
        """Pairs in the neighbour list of case ``k``, (m, 2), in its own numbers, of ``part`` particles at a time."""
        first, last, order = self.first[k], self.first[k + 1], self.order[k]
        start, owner, partner = (array.numpy() for array in (contacts.start, contacts.owner, contacts.partner))
        for low in range(first, last, part):
            listed = slice(start[low], start[min(low + part, last)])
            yield order[np.stack([owner[listed], partner[listed]], axis=1) - first]

    def state(self, k: int, particles, contacts) -> State:
        """State of case ``k``; what no effect requires stays as it was at the start."""
        before, first, last = self.states[k], self.first[k], self.first[k + 1]
        back = np.argsort(self.order[k])
        now = particles.numpy()[first:last]

        def of_particles(name, start):
            return now[name][back].astype(float, copy=False) if name in now.dtype.names else copied(start)

        def copied(array):
            return array.copy() if array.flags.writeable else array

        wall_history = None
        if "wall" in self.types.Contacts.vars:
            walls = contacts.wall.numpy()[WALLS * first : WALLS * last].reshape(last - first, WALLS)
            wall_history = _recalled(walls, back)
        return replace(
            before,
            position=of_particles("position", before.position),
            velocity=of_particles("half_velocity", before.velocity),
            spin=of_particles("half_spin", before.spin),
            radius=copied(before.radius),
            species=copied(before.species),
            axis=of_particles("axis", before.axis),
            aspect=copied(before.aspect),
            wall_history=wall_history,
            **self._touching(k, particles, contacts),
        )

    def _touching(self, k: int, particles, contacts) -> dict:
        """The pairs of case ``k`` that touch, and what they remember."""
        if "pair" not in self.types.Contacts.vars:
            return {"pairs": np.zeros((0, 2), np.int32), "pair_history": None}
        first, last = self.first[k], self.first[k + 1]
        start = contacts.start.numpy()[first : last + 1]
        memory = contacts.pair.numpy()
        rows = start[0] + np.flatnonzero(memory["radius"][start[0] : start[-1]] > 0)
        numbers = np.stack([contacts.owner.numpy()[rows], contacts.partner.numpy()[rows]], axis=1)
        pairs = self.order[k][numbers - first]
        position = particles.numpy()["position"]
        between = position[numbers[:, 0]] - position[numbers[:, 1]] if "arm" in memory.dtype.names else None
        history = _recalled(memory, rows).seen_from_the_other(pairs[:, 0] > pairs[:, 1], between)
        return {"pairs": np.sort(pairs, axis=1), "pair_history": history}


def _placed(state: State) -> State:
    """The state with normals and arms of contacts that spheres did not keep, for kernels of spheroids."""
    i, j = state.pairs.T
    branch = state.position[i] - state.position[j]
    share = state.radius[i] / (state.radius[i] + state.radius[j])
    pairs = _with_places(state.pair_history, branch, -share[:, None] * branch)
    down = np.tile([0.0, 0.0, 1.0], (len(state), 1))
    normal = np.stack([state.position * [-1, -1, 0], down, -down], axis=1)
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    arm = -state.radius[:, None, None] * normal / np.where(length > 0, length, 1.0)
    return replace(state, pair_history=pairs, wall_history=_with_places(state.wall_history, normal, arm))


def _with_places(history: ContactHistory, normal: np.ndarray, arm: np.ndarray) -> ContactHistory:
    """The history with unit vectors along ``normal`` and with ``arm`` where it knows no normal of a contact."""
    unknown = ((history.radius > 0) & ~np.any(history.normal, axis=-1))[..., None]
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    unit = normal / np.where(length > 0, length, 1.0)
    return replace(history, normal=np.where(unknown, unit, history.normal), arm=np.where(unknown, arm, history.arm))


def _recalled(memory: np.ndarray, order: np.ndarray) -> ContactHistory:
    """Contact history from the device's ``memory``, in an order; what is not kept there is zero."""
    none = ContactHistory.none(len(order), *memory.shape[1:])
    return replace(none, **{name: memory[name][order].astype(float, copy=False) for name in memory.dtype.names})


def _numbered(state: State, order: np.ndarray) -> tuple[np.ndarray, ContactHistory]:
    """The contacts of a state in the device's numbers and order: pairs and histories."""
    number = np.argsort(order)
    pairs = number[state.pairs]
    between = state.position[state.pairs[:, 0]] - state.position[state.pairs[:, 1]]
    history = state.pair_history.seen_from_the_other(pairs[:, 0] > pairs[:, 1], between)
    pairs = np.sort(pairs, axis=1)
    rows = np.lexsort((pairs[:, 1], pairs[:, 0]))
    return pairs[rows], history[rows]
