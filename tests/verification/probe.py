"""The contact law of the kernels on a prescribed path, without any particle."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdamp import Effects
from warpdamp.kernels.contact import contact_law
from warpdamp.kernels.options import UNIQUE
from warpdamp.kernels.structs import types

effects = Effects()
t = types(effects)
Law, History, Motion, Losses = t.Law, t.History, t.Motion, t.Losses
contact, _, _, remembered_energy = contact_law(effects)


@wp.kernel(**UNIQUE)
def along_path(
    law: Law,
    radius: wp.float64,
    mass: wp.float64,
    h: wp.float64,
    overlap: wp.array(dtype=wp.float64),
    approach: wp.array(dtype=wp.float64),
    sliding: wp.array(dtype=wp.float64),
    # out:
    force: wp.array(dtype=wp.vec2d),
    losses: wp.array(dtype=Losses),
    stored: wp.array(dtype=wp.float64),
):
    normal = wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(1.0))
    history = History()
    for n in range(overlap.shape[0]):
        motion = Motion()
        motion.velocity = wp.vec3d(sliding[n], wp.float64(0.0), -approach[n])
        motion.slid = wp.vec3d(sliding[n] * h, wp.float64(0.0), wp.float64(0.0))
        f, _rolling, history, lost = contact(law, radius, mass, overlap[n], normal, motion, history, h)
        force[n] = wp.vec2d(f[2], f[0])
        losses[n] = lost
        tangential, _roll = remembered_energy(law, history)
        stored[n] = tangential


@dataclass
class Path:
    """What the law gave along a path: place (n, 2), force (n, 2) [N], and the energies [J]."""

    place: np.ndarray
    force: np.ndarray
    net_work: float
    largest_store: float
    unbalanced: float


def probe(constants, places, *, h, radius, mass) -> Path:
    """Follow ``places`` (n + 1, 2) of (overlap, tangential place) [m] in steps of ``h`` [s], each at its middle."""
    law = Law()
    for name in Law.vars:
        setattr(law, name, constants[name])
    middle, rate = (places[1:] + places[:-1]) / 2, np.diff(places, axis=0) / h
    n = len(middle)
    force = wp.zeros(n, dtype=wp.vec2d, device="cpu")
    losses = wp.zeros(n, dtype=Losses, device="cpu")
    stored = wp.zeros(n, dtype=wp.float64, device="cpu")
    given = [wp.array(np.ascontiguousarray(a), dtype=wp.float64, device="cpu") for a in (middle[:, 0], *rate.T)]
    wp.launch(along_path, 1, [law, radius, mass, h, *given, force, losses, stored], device="cpu")
    f, lost, kept = force.numpy(), losses.numpy(), stored.numpy()
    before = np.concatenate([[0.0], f[:-1, 1]])
    tangential = -(before + f[:, 1]) / 2 * rate[:, 1] * h
    normal = f[:, 0] * rate[:, 0] * h
    balance = np.cumsum(tangential) - kept - np.cumsum(lost[:, 1:].sum(axis=1))
    return Path(
        place=middle, force=f, net_work=float(tangential.sum() + normal.sum()),
        largest_store=float(max(np.max(kept), 0.4 * np.max(f[:, 0] * middle[:, 0]))), unbalanced=float(np.abs(balance).max()),
    )  # fmt: skip
