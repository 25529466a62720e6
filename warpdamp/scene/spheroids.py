"""Spheroids as a shape, see ``scene.shape``: how far they reach, and their common normals.

A spheroid of semi-axes a along the unit axis u and b across it reaches, along the unit vector n from its centre,

    h(n) = sqrt(b^2 + e c^2),   e = a^2 - b^2,   c = n.u,     at its point  s(n) = (b^2 n + e c u) / h,

with the matrix of radii of curvature W(n) = (b^2 / h) P + (e b^2 / h^3) p p^T, P = 1 - n n^T, p = P u.  Two of them,
their centres r = x_i - x_j apart, are separated along n by the gap g(n) = n.r - h_i(n) - h_j(n).  The largest gap is
their distance or, if negative, minus their overlap, and its n is the common normal, from j to i.  It is found by
Newton's method on the unit sphere: (W_i + W_j + g P) step = P (r - s_i - s_j).
"""

from __future__ import annotations

import numpy as np

from .bodies import Bodies

MOST_STEPS = 30
"""Newton steps at the most; six were the most from the first guess at overlaps up to 0.6 of a semi-axis."""

LONGEST_STEP = 0.5
"""Longest step, about an angle in radians."""

CLOSE = 1e-7
"""Step after which the normal is known to the square of it."""

HALVINGS = 12
"""How often a step that leads to a smaller gap is halved."""


class Spheroids(Bodies):
    """Spheroids about their centres, of semi-axes ``along`` and ``across`` their unit axes u."""

    @property
    def excess(self) -> np.ndarray:
        """e = a^2 - b^2, (n,)."""
        return self.along**2 - self.across**2

    def height(self, normal: np.ndarray) -> np.ndarray:
        """Support h(n) along unit vectors, (n,)."""
        return np.sqrt(self.across**2 + self.excess * dot(normal, self.axis) ** 2)

    def point(self, normal: np.ndarray) -> np.ndarray:
        """Points s(n) that reach farthest along unit vectors, from the centres, (n, 3)."""
        tilt = self.excess * dot(normal, self.axis)
        return ((self.across**2)[:, None] * normal + tilt[:, None] * self.axis) / self.height(normal)[:, None]

    def common_normal(self, apart, other: Spheroids, *, to_the_end: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Common normals with others, and gaps along them; see ``Bodies``, and the head of this file."""
        normal = _first_guess(apart, self, other)
        gap = _gap(apart, self, other, normal)
        active = np.arange(len(apart)) if to_the_end else np.flatnonzero(gap <= 0)
        for _ in range(MOST_STEPS):
            if not len(active):
                break
            pairs = apart[active], self[active], other[active]
            step = _newton_step(*pairs, normal[active], gap[active])
            close = np.linalg.norm(step, axis=1) < CLOSE
            normal[active], gap[active] = _climb(*pairs, normal[active], gap[active], step)
            active = active[~close & (to_the_end | (gap[active] <= 0))]
        return normal, gap

    def farthest_from_axis(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance from the z axis of their farthest points, and the directions of these, (n,), (n, 3).

        Maximises f(e) = e.x + h(e) over horizontal unit vectors, by Newton's method for the angle.
        """
        angle = np.arctan2(position[:, 1], position[:, 0])
        still = np.zeros_like(angle)
        for _ in range(MOST_STEPS):
            outward = np.stack([np.cos(angle), np.sin(angle), still], axis=1)
            sideways = np.stack([-outward[:, 1], outward[:, 0], still], axis=1)
            h = self.height(outward)
            turn = dot(sideways, self.axis)
            slope = dot(sideways, position) + self.excess * dot(outward, self.axis) * turn / h
            shadow = self.across**2 / h * (1 + self.excess * turn**2 / h**2)  # its radius of curvature
            distance = dot(outward, position) + h
            step = slope / np.maximum(distance - shadow, 0.2 * self.inscribed)
            if np.max(np.abs(step)) < CLOSE:
                break
            angle = angle + np.clip(step, -LONGEST_STEP, LONGEST_STEP)
        return distance, outward


def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Scalar products of (n, 3) arrays, (n,)."""
    return np.einsum("ij,ij->i", one, other)


def _gap(apart, one: Spheroids, other: Spheroids, normal) -> np.ndarray:
    return dot(normal, apart) - one.height(normal) - other.height(normal)


def _first_guess(apart, one: Spheroids, other: Spheroids) -> np.ndarray:
    """(A_i + A_j)^-1 r, A = b^2 + e u u^T: the normal of the contact function of Perram and Wertheim (1985) at 1/2."""
    across = one.across**2 + other.across**2
    parallel = dot(one.axis, other.axis)
    first, second = across + one.excess, across + other.excess
    determinant = first * second - one.excess * other.excess * parallel**2
    along_i, along_j = dot(one.axis, apart), dot(other.axis, apart)
    y_i = one.excess * (second * along_i - other.excess * parallel * along_j) / determinant
    y_j = other.excess * (first * along_j - one.excess * parallel * along_i) / determinant
    guess = apart - y_i[:, None] * one.axis - y_j[:, None] * other.axis
    length = np.linalg.norm(guess, axis=1)
    guess[length == 0] = (1.0, 0.0, 0.0)  # centres that coincide
    return guess / np.where(length == 0, 1.0, length)[:, None]


def _newton_step(apart, one: Spheroids, other: Spheroids, n, gap) -> np.ndarray:
    """Step in the tangent plane, (m, 3).

    Inverted in the plane that p_i and p_j span; where g makes the matrix indefinite, at deep overlaps, without g.
    """
    h_i, h_j = one.height(n), other.height(n)
    c_i, c_j = dot(n, one.axis), dot(n, other.axis)
    p, q = one.axis - c_i[:, None] * n, other.axis - c_j[:, None] * n
    pp, qq, pq = dot(p, p), dot(q, q), dot(p, q)
    beta_i, beta_j = one.excess * one.across**2 / h_i**3, other.excess * other.across**2 / h_j**3
    minor = beta_i * beta_j * (pp * qq - pq**2)
    both = beta_i * pp + beta_j * qq
    curved = one.across**2 / h_i + other.across**2 / h_j
    flat = curved + gap
    indefinite = (flat * (flat + both) + minor <= 0) | (2 * flat + both <= 0)
    flat = np.where(indefinite, curved, flat)
    whole = flat + both
    determinant = flat * whole + minor
    slope = apart - one.point(n) - other.point(n)
    slope = slope - dot(n, slope)[:, None] * n
    pt, qt = dot(p, slope), dot(q, slope)
    # (flat + beta_i p p^T + beta_j q q^T)^-1 in two dimensions: the adjugate over the determinant
    step = whole[:, None] * slope - (beta_i * pt)[:, None] * p - (beta_j * qt)[:, None] * q
    step /= determinant[:, None]
    length = np.linalg.norm(step, axis=1)
    return step * np.minimum(1.0, LONGEST_STEP / np.maximum(length, LONGEST_STEP))[:, None]


def _climb(apart, one: Spheroids, other: Spheroids, normal, gap, step) -> tuple[np.ndarray, np.ndarray]:
    """Normals after steps, halved where the gap would fall, and their gaps."""
    fresh = _turned(normal, step)
    higher = _gap(apart, one, other, fresh)
    size = one.inscribed + other.inscribed
    for _ in range(HALVINGS):
        falls = np.flatnonzero(higher < gap - 1e-14 * size)
        if not len(falls):
            break
        step[falls] *= 0.5
        fresh[falls] = _turned(normal[falls], step[falls])
        higher[falls] = _gap(apart[falls], one[falls], other[falls], fresh[falls])
    return fresh, higher


def _turned(normal, step) -> np.ndarray:
    """Unit vectors turned by steps in their tangent planes; by 2 atan(|step| / 2)."""
    quarter = 0.25 * dot(step, step)[:, None]
    return ((1 - quarter) * normal + step) / (1 + quarter)
