"""Contacts of a batch one by one, between two steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from ..kernels.probe import probe
from ..kernels.structs import WALLS
from .batch import Batch


@dataclass(frozen=True)
class Touching:
    """Contacts of a case at one moment.

    Parameters
    ----------
    pairs : (m, 2) array
        Particles i and j of each; j = -1, -2, -3 is the side, the floor, the lid.
    force : (m, 3) array
        Force on i [N].
    lost : (n,) array
        Energy that each particle loses in the step that follows [J]; a pair's loss is shared by its two, a wall's falls
        to the particle.
    """

    pairs: np.ndarray
    force: np.ndarray
    lost: np.ndarray


class Probe:
    """Probe of a batch of one case; looking changes nothing of what comes after.

    Parameters
    ----------
    batch : Batch
        Of one case.

    Raises
    ------
    ValueError
        If there are more.
    """

    def __init__(self, batch: Batch):
        if len(batch.cases) != 1:
            raise ValueError(f"a probe looks at one case, and the batch has {len(batch.cases)}")
        self._batch = batch
        self._pairs, self._walls = probe(batch.effects)
        self._count = len(batch.cases[0].state)
        self._order = batch._transfer.order[0]
        self._wall_force, self._wall_lost = self._outputs(WALLS * self._count)
        self._pair_force, self._pair_lost = self._outputs(0)

    def _outputs(self, n: int):
        t, device = self._batch._types, self._batch._device
        return wp.empty(n, dtype=t.vec3, device=device), wp.empty(n, dtype=wp.float64, device=device)

    def _look(self) -> int:
        """Fill the arrays with what is there now; returns the number of pairs listed."""
        b = self._batch
        inputs = [b._constants, b._group, b._particles, self._copied(b._contacts)]
        listed = len(b._contacts.owner)
        if listed > len(self._pair_lost):
            self._pair_force, self._pair_lost = self._outputs(2 * listed)
        wp.launch(self._pairs, listed, [*inputs, self._pair_force, self._pair_lost], device=b._device)
        if b.effects.enclosure:
            wp.launch(self._walls, WALLS * self._count, [*inputs, self._wall_force, self._wall_lost], device=b._device)
        return listed

    def _copied(self, contacts):
        """The contacts, with histories of their own where looking would write to them."""
        if "normal" not in self._batch._types.History.vars:
            return contacts
        copy = self._batch._types.Contacts()
        for name in self._batch._types.Contacts.vars:
            value = getattr(contacts, name)
            setattr(copy, name, wp.clone(value) if name in ("pair", "wall") else value)
        return copy

    def lost(self) -> np.ndarray:
        """Energy that each particle loses in the step that follows, (n,) [J]."""
        return self._lost(self._look())

    def _lost(self, listed: int) -> np.ndarray:
        c, n = self._batch._contacts, self._count
        half = 0.5 * self._pair_lost.numpy()[:listed]
        ends = (c.owner.numpy(), c.partner.numpy())
        ordered = sum(np.bincount(end, half, minlength=n) for end in ends)
        if self._batch.effects.enclosure:
            ordered = ordered + self._wall_lost.numpy().reshape(n, WALLS).sum(axis=1)
        lost = np.empty(n)
        lost[self._order] = ordered
        return lost

    def touching(self) -> Touching:
        """Contacts that press now, pairs first."""
        listed = self._look()
        c, order = self._batch._contacts, self._order
        pairs = np.stack([order[c.owner.numpy()], order[c.partner.numpy()]], axis=1).reshape(-1, 2)
        force = self._pair_force.numpy()[:listed]
        if self._batch.effects.enclosure:
            place = np.arange(WALLS * self._count)
            at_walls = np.stack([order[place // WALLS], -1 - place % WALLS], axis=1)
            pairs, force = np.concatenate([pairs, at_walls]), np.concatenate([force, self._wall_force.numpy()])
        pressing = np.any(force != 0, axis=1)
        return Touching(pairs[pressing], force[pressing].astype(float), self._lost(listed))
