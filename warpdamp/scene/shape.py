"""Shapes of particles: what the code outside the kernels asks of each; ``kernels/shape.py`` is the same for kernels.

All are bodies that are round about an axis.  A particle is given by the radius of the sphere of its volume, so that its
mass does not depend on its shape, and by its aspect, along over across the axis: 1 is a sphere of whatever shape.

Another shape is another file that answers all fields of ``Shape``, and an entry in ``SHAPES``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .aspect import refused_shape, semi_axes, shortest_contact_share, spheroid_inertia
from .bodies import Bodies
from .spheres import Spheres
from .spheroids import Spheroids


@dataclass(frozen=True)
class Shape:
    """Shape of particles, as functions of arrays of their radii [m] and aspects [-].

    Parameters
    ----------
    semi_axes : function of (radius, aspect)
        Half of the length along the axis, and of the width across [m].
    inertia : function of (mass, radius, aspect)
        Moments of inertia across the axis and along it [kg m^2].
    contact_share : function of one aspect
        Shortest contact time over that of the sphere of the same volume, at one speed [-].
    refused : function of (radius, aspect, radius of the cavity or None)
        Sentence that refuses particles of which contacts would be missed; empty if all are right.
    bodies : subclass of Bodies
        The particles as they lie.
    """

    semi_axes: Callable
    inertia: Callable
    contact_share: Callable[[float], float]
    refused: Callable[..., str]
    bodies: type[Bodies]

    def bounding_radius(self, radius, aspect) -> np.ndarray:
        """Radius of the smallest spheres about the centres that hold the particles [m]."""
        return np.maximum(*self.semi_axes(radius, aspect))

    def inscribed_radius(self, radius, aspect) -> np.ndarray:
        """Radius of the largest spheres about the centres within the particles [m]."""
        return np.minimum(*self.semi_axes(radius, aspect))


SPHERES = Shape(
    semi_axes=semi_axes,
    inertia=spheroid_inertia,
    contact_share=lambda _aspect: 1.0,
    refused=lambda _radius, _aspect, _side: "",
    bodies=Spheres,
)
SPHEROIDS = Shape(
    semi_axes=semi_axes,
    inertia=spheroid_inertia,
    contact_share=shortest_contact_share,
    refused=refused_shape,
    bodies=Spheroids,
)
SHAPES = {"spheroids": SPHEROIDS}
"""Shapes other than spheres, by the effects that they are."""


def aspects(particles) -> np.ndarray:
    """Aspect of each particle, (n,) [-].

    Parameters
    ----------
    particles : State, Grains, or anything with ``radius``
        Without ``aspect``, or with an empty one: spheres.
    """
    given = np.asarray(getattr(particles, "aspect", ()), float)
    return given if len(given) else np.ones(len(particles.radius))


def shape_of(particles) -> Shape:
    """Shape of some particles: that of those that are no spheres, if there are any.

    Parameters
    ----------
    particles : State, Grains, or anything with ``radius``
        As of ``aspects``.
    """
    return SPHERES if np.all(aspects(particles) == 1) else SPHEROIDS


def bodies_of(state) -> Bodies:
    """The particles of a state as they lie [m]; see ``Shape``."""
    shape = shape_of(state)
    return shape.bodies(state.axis, *shape.semi_axes(state.radius, state.aspect))
