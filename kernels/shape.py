"""Shape of the particles: what everything else asks of it.

========================  ============================================================================================
``reach_of``              radius about a particle's centre within which the grid looks for its partners
``pair_listed``           whether a pair belongs into the neighbour list
``pair_near``             whether the pair at a place of the list is nearer than a margin, or touched a step ago
``pair_touch``            where two particles meet
``pair_touch_back``       the same some time back, where the velocities and the springs of a ledger row lie
``pair_motion``           how their surfaces move past each other
``pair_loads``            force and torques of what the contact law gives
``wall_near`` ...         the same of one particle and a wall
``with_place``            a contact's history with where it was
``turn``, ``kick_spin``   rotation over a step, and its first half
``rotational_energy``     its energy
``pace2``                 square of how fast the gap to another particle may close
========================  ============================================================================================

Another shape is another file that answers all of this.
"""

import functools

from .spheres import spheres
from .spheroids import spheroids


@functools.cache
def shape(effects):
    """Return the geometry and the rotation of the particles for the given effects."""
    return spheroids(effects) if effects.spheroids else spheres(effects)
