"""Device code of warpdamp: physics in ``@wp.func``, scheduling in ``@wp.kernel``, one stage a file.

Every stage is a factory ``stage(effects)`` that is cached on its frozen argument, so one set of effects is one set of
functions, compiled once.  Conventions used throughout:

- SI units; the frame is the enclosure's, its origin at the centre of the cavity's floor, z along its axis.
- A contact normal points from the partner (particle j or wall) to particle i, so it pushes i; overlap is positive in
  contact; a relative velocity is that of i's surface against the partner's.
- Positions and the tangential springs are known at whole steps n, velocities at half steps n - 1/2.

These modules must not use ``from __future__ import annotations``: Warp reads the annotation objects.
"""
