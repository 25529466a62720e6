"""Contacts side by side: ``LANES`` of them in a loop that the compiler turns into vector instructions.

The law is written once, for one contact.  ``pairs.py`` and ``cylinder.py`` go through the contacts of a step in three
stages:

1. search, without branches (which contacts touch is hard to foresee): note the places of those that touch, or did so
   a step ago;
2. compute, ``LANES`` at a time: a loop that calls the law and writes to local vectors and matrices only;
3. add, in the order of the list: forces, histories and losses, so that the order of every sum follows from the state.

The last few contacts are filled up to ``LANES`` with copies of the last one, which are computed and never added.  A
loop over one lane is the scalar code.

What the second stage calls keeps to the rules at the head of ``contact.py``; its results are kept in local vectors and
matrices, for neither an array nor a vector inside a struct is one to the compiler.
"""

import functools
from types import SimpleNamespace

import warp as wp

from .options import LANES
from .structs import types


def lanes_for(effects) -> int:
    """How many contacts are computed side by side.

    One where vectors do not pay: threads of other devices are lanes themselves, and three floats of single precision
    are returned as one vector, which the compiler does not widen.
    """
    return LANES if effects.precision == "float64" and effects.device == "cpu" else 1


@wp.func
def natural(i: int):
    """An index that is not negative: spares the code that counts negative ones from the end."""
    return i & 0x7FFFFFFF


CONTIGUOUS = "__builtin_assume(a.strides[0] == sizeof(*a.data));"


@wp.func_native(CONTIGUOUS)
def contiguous(a: wp.array(dtype=wp.int32)):
    """Promise that an array is contiguous: spares a multiplication at each index."""


@functools.cache
def lanes(effects, count: int):
    """Return what ``count`` contacts side by side are kept in, for the given effects."""
    t = types(effects)
    vec3, History = t.vec3, t.History
    channels = t.Losses._length_
    vectors = [name for name in History.vars if name != "radius"]
    Fields = wp.types.vector(1 + 3 * len(vectors), t.real)
    first = {name: wp.constant(1 + 3 * k) for k, name in enumerate(vectors)}  # places of the vectors in Fields
    STRETCH, ROLL, NORMAL, ARM = (first.get(name) for name in ("stretch", "roll", "normal", "arm"))

    @wp.func
    def to_fields(history: History):
        """The numbers of a history, one after the other."""
        fields = Fields()
        fields[0] = history.radius
        for x in range(3):
            if wp.static("stretch" in vectors):
                fields[STRETCH + x] = history.stretch[x]
            if wp.static("roll" in vectors):
                fields[ROLL + x] = history.roll[x]
            if wp.static("normal" in vectors):
                fields[NORMAL + x] = history.normal[x]
                fields[ARM + x] = history.arm[x]
        return fields

    @wp.func
    def from_fields(fields: Fields):
        """The history of these numbers."""
        history = History()
        history.radius = fields[0]
        if wp.static("stretch" in vectors):
            history.stretch = vec3(fields[STRETCH], fields[STRETCH + 1], fields[STRETCH + 2])
        if wp.static("roll" in vectors):
            history.roll = vec3(fields[ROLL], fields[ROLL + 1], fields[ROLL + 2])
        if wp.static("normal" in vectors):
            history.normal = vec3(fields[NORMAL], fields[NORMAL + 1], fields[NORMAL + 2])
            history.arm = vec3(fields[ARM], fields[ARM + 1], fields[ARM + 2])
        return history

    return SimpleNamespace(
        LANES=wp.constant(count),
        LOSSES=wp.constant(channels),
        FIELDS=wp.constant(Fields._length_),
        Scalars=wp.types.vector(count, t.real),
        Vectors=wp.types.matrix((count, 3), t.real),
        Lost=wp.types.matrix((channels, count), wp.float64),
        Fields=Fields,
        Kept=wp.types.matrix((Fields._length_, count), t.real),
        to_fields=to_fields,
        from_fields=from_fields,
    )


@functools.cache
def promises(effects):
    """Return ``contiguous_contacts`` for the given effects."""
    t = types(effects)
    History, Contacts = t.History, t.Contacts

    @wp.func_native(CONTIGUOUS)
    def contiguous_histories(a: wp.array(dtype=History)): ...

    @wp.func
    def contiguous_contacts(c: Contacts):
        """Promise that all arrays of the contacts are contiguous."""
        contiguous(c.start)
        contiguous(c.partner)
        contiguous(c.owner)
        contiguous(c.nearby)
        contiguous(c.touching)
        contiguous(c.touching_walls)
        if wp.static(effects.history):
            contiguous_histories(c.pair)
            contiguous_histories(c.wall)

    return contiguous_contacts
