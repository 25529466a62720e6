"""Spheroids by radius and aspect: semi-axes, inertia, how long they touch, and which ones are refused.

A spheroid is given by the radius r of the sphere of its volume and by its aspect alpha = a / b, so that its mass does
not depend on its aspect: a = r alpha^(2/3), b = r alpha^(-1/3), a b^2 = r^3.  With d1, d2 as semi-axes this is eq. 18
of the paper; with diameters, d2 would be twice as much.  Aspects above 1 are prolate, below 1 oblate.
"""

from __future__ import annotations

import numpy as np

LEAST_ASPECT, MOST_ASPECT = 0.25, 4.0
"""Aspects between which Newton's method finds common normals from its first guess.

Of 20,000 pairs near each other none failed; at 0.2 and 5 a few did, and pairs that are apart were taken to overlap.
"""


def semi_axes(radius, aspect) -> tuple[np.ndarray, np.ndarray]:
    """Semi-axes of spheroids along and across their axes, a = r alpha^(2/3) and b = r alpha^(-1/3) [m].

    Parameters
    ----------
    radius : (...) array
        Of the spheres of the same volumes, r [m].
    aspect : (...) array
        alpha = a / b [-].

    Returns
    -------
    a, b : (...) arrays
        [m].

    Examples
    --------
    >>> from warpdamp.scene.aspect import semi_axes
    >>> a, b = semi_axes(3.73e-3, 2.0)
    >>> round(1e3 * float(a), 2), round(1e3 * float(b), 2)  # [mm]
    (5.92, 2.96)
    """
    radius, aspect = np.asarray(radius, float), np.asarray(aspect, float)
    return radius * aspect ** (2 / 3), radius * aspect ** (-1 / 3)


def spheroid_inertia(mass, radius, aspect) -> tuple[np.ndarray, np.ndarray]:
    """Moments of inertia of solid spheroids, I_t = m (a^2 + b^2) / 5 across and I_a = 2 m b^2 / 5 along the axis.

    Parameters
    ----------
    mass, radius, aspect : (...) arrays
        [kg], [m], [-]; see ``semi_axes``.

    Returns
    -------
    I_t, I_a : (...) arrays
        [kg m^2].
    """
    a, b = semi_axes(radius, aspect)
    return mass * (a**2 + b**2) / 5, 2 / 5 * mass * b**2


def flattest_radius(radius, aspect) -> np.ndarray:
    """Largest radius of curvature of spheroids' surfaces, max(a, b)^2 / min(a, b) [m].

    Parameters
    ----------
    radius, aspect : (...) arrays
        [m], [-]; see ``semi_axes``.

    Returns
    -------
    (...) array
        [m].
    """
    a, b = semi_axes(radius, aspect)
    return np.maximum(a, b) ** 2 / np.minimum(a, b)


def shortest_contact_share(aspect: float) -> float:
    """Shortest contact time of a spheroid over that of the sphere of its volume, at one speed [-].

    A contact of mass m and radius R takes m^(2/5) R^(-1/5); off the axis and at the flat sides both tell, so the
    smallest over all tilts against a plane is looked for.  Two spheroids give the same to 0.1 %.

    Parameters
    ----------
    aspect : float
        [-].

    Returns
    -------
    float

    Examples
    --------
    >>> from warpdamp.scene.aspect import shortest_contact_share
    >>> [round(shortest_contact_share(aspect), 2) for aspect in (0.5, 0.7, 1.0, 1.4, 2.0, 2.5)]
    [0.71, 0.87, 1.0, 0.92, 0.77, 0.7]
    """
    a, b = semi_axes(1.0, aspect)
    cosine = np.linspace(0, 1, 201)
    height = np.sqrt(b**2 + (a**2 - b**2) * cosine**2)
    beyond = (height / a + a / height) / 2 - 1
    radius = (1 + beyond / (3 + 0.29 * beyond)) * a * b**2 / height**2  # as in ``kernels/elliptic.py``
    lever2 = ((a**2 - b**2) * cosine / height) ** 2 * (1 - cosine**2)
    mass = 1 / (1 + 5 * lever2 / (a**2 + b**2))
    return float(np.min(mass**0.4 / radius**0.2))


def allowed_aspects(radius: float, side: float) -> tuple[float, float]:
    """Aspects between which a spheroid touches the inside of a cylinder in one place at the most [-].

    It rolls inside the cylinder, and cannot rest on two of its ends, where its largest radius of curvature is below
    the cylinder's (Blaschke's rolling theorem): r alpha^(5/3) < Rc if prolate, r alpha^(-4/3) < Rc if oblate.

    Parameters
    ----------
    radius : float
        Of the sphere of the same volume, r [m].
    side : float
        Radius of the cylinder, Rc [m].

    Returns
    -------
    lowest, highest : float
        Excluded themselves.

    Examples
    --------
    >>> from warpdamp.scene.aspect import allowed_aspects
    >>> [round(aspect, 3) for aspect in allowed_aspects(3.73e-3, 0.02)]
    [0.284, 2.739]
    """
    return (radius / side) ** (3 / 4), (side / radius) ** (3 / 5)


def two_ends_at_the_side(radius, aspect, side: float) -> str:
    """Sentence that refuses a spheroid that might touch the side at both ends at once; empty if none can.

    Parameters
    ----------
    radius, aspect : (n,) arrays
        [m], [-]; see ``semi_axes``.  Spheres are never refused.
    side : float
        Radius of the cavity [m].

    Returns
    -------
    str
    """
    radius, aspect = np.broadcast_arrays(np.asarray(radius, float), np.asarray(aspect, float))
    with np.errstate(over="ignore"):  # whatever aspect a user writes
        flattest = np.where(aspect == 1, 0.0, flattest_radius(radius, aspect))
    k = int(np.argmax(flattest))
    if flattest[k] < side:
        return ""
    low, high = allowed_aspects(float(radius[k]), side)
    return (
        f"a spheroid of aspect {aspect[k]:g} might touch the side at both ends at once: its largest radius of "
        f"curvature, {1e3 * flattest[k]:.3g} mm, is not below the cavity's radius, {1e3 * side:g} mm; take an aspect "
        f"above {low:.3f} and below {high:.3f}, smaller particles, or a wider cavity"
    )


def refused_shape(radius, aspect, side: float | None) -> str:
    """Sentence that refuses a shape of which contacts would be missed; empty if all are right.

    Parameters
    ----------
    radius, aspect : (n,) arrays
        [m], [-]; see ``semi_axes``.
    side : float or None
        Radius of the cavity [m]; None: no side is there.

    Returns
    -------
    str
    """
    ends = "" if side is None else two_ends_at_the_side(radius, aspect, side)
    return ends or too_flat_or_long(aspect)


def too_flat_or_long(aspect) -> str:
    """Sentence that refuses a spheroid whose contacts might be missed or taken for deep ones; empty if there is none.

    Parameters
    ----------
    aspect : (n,) array
        [-].

    Returns
    -------
    str
    """
    aspect = np.atleast_1d(np.asarray(aspect, float))
    outside = (aspect < LEAST_ASPECT) | (aspect > MOST_ASPECT)
    if not outside.any():
        return ""
    return (
        f"contacts of spheroids are found reliably at aspects from {LEAST_ASPECT:g} to {MOST_ASPECT:g}, not at "
        f"{aspect[np.argmax(outside)]:g}: take a shape between"
    )
