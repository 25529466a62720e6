"""Spheres: their volume and moment of inertia."""

from __future__ import annotations

import math


def sphere_volume(radius):
    """Volume of spheres, 4 pi R^3 / 3 [m^3].

    Parameters
    ----------
    radius : float or array
        R [m].

    Returns
    -------
    float or array
        [m^3].
    """
    return 4 / 3 * math.pi * radius**3


def inverse_sphere_inertia(mass, radius):
    """Inverse of the moment of inertia of solid spheres about their centres, 5 / (2 m R^2) [1/(kg m^2)].

    Parameters
    ----------
    mass, radius : float or array
        m [kg], R [m].

    Returns
    -------
    float or array
        [1/(kg m^2)].
    """
    return 2.5 / (mass * radius**2)
