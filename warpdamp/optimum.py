"""Where a damping curve peaks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Peak:
    """A maximum of a curve over Gamma: where, how high, and the standard error of its height."""

    gamma: float
    height: float
    standard_error: float


def peaks(gamma, height, standard_error) -> list[Peak]:
    """Maxima of a noisy curve that stand out of the dips beside them by more than two standard errors, by Gamma.

    A curve without any has one, its largest point; points that are not finite are left out.
    """
    from scipy.signal import find_peaks

    order = np.argsort(np.asarray(gamma, float))
    gamma, height, standard_error = (np.asarray(a, float)[order] for a in (gamma, height, standard_error))
    known = np.isfinite(height)
    if not known.any():
        return []
    gamma, height, standard_error = gamma[known], height[known], standard_error[known]
    low = height.min() - 1.0
    found, traits = find_peaks(np.concatenate([[low], height, [low]]), prominence=0)
    found -= 1
    bases = np.minimum(traits["prominences"], height[found] - height.min())
    kept = [k for k, prominence in zip(found, bases, strict=True) if prominence > 2 * standard_error[k]]
    kept = kept or [int(np.argmax(height))]
    return [Peak(float(gamma[k]), float(height[k]), float(standard_error[k])) for k in kept]
