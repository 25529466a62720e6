"""Memory that particles take on the device, from the structs themselves; nothing here starts a device."""

from __future__ import annotations

import warp as wp

from ..kernels.structs import PER_PAIR, PER_PARTICLE


def particle_bytes(types, pairs: float) -> float:
    """Memory of a particle on the device with ``pairs`` listed pairs [bytes].

    Parameters
    ----------
    types : structs of the device, see ``kernels.structs.types``
    pairs : listed pairs over particles
    """
    size = {name: wp.types.type_size_in_bytes(array.type.dtype) for name, array in types.Contacts.vars.items()}
    contacts = sum(count * size.get(name, 0) for name, count in PER_PARTICLE.items())
    lists = pairs * sum(size.get(name, 0) for name in PER_PAIR)
    numbers = 2 * wp.types.type_size_in_bytes(wp.int32)  # of its case, and of its partners
    start = wp.types.type_size_in_bytes(types.vec3) if "displacement" in types.columns else 0
    return types.Particle.numpy_dtype()["itemsize"] + contacts + lists + numbers + start
