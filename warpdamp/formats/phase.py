"""Complex mode shapes that are real but for a phase.

Modal phase collinearity of a shape psi, 1 where all its points move in phase or in antiphase:
|sum psi^2|^2 / (sum |psi|^2)^2, and the phase of the real shape it is nearest to, arg(sum psi^2) / 2.  Without the mean
taken off, so that a single point and a rigid translation have one, too; J.-N. Juang and R. S. Pappa 1985, J. Guid.
Control Dyn. 8, 620, doi:10.2514/3.20031, who introduced it, take it off.
"""

from __future__ import annotations

import numpy as np

LEAST = 0.99
"""Of a shape that may be taken as real: what is dropped is 5 % of it, root mean square."""


def collinearity(shape: np.ndarray) -> float:
    """Modal phase collinearity of a complex shape of any size; it must move something."""
    shape = shape / np.abs(shape).max()
    return float(np.abs(np.sum(shape**2)) ** 2 / np.sum(np.abs(shape) ** 2) ** 2)


def turned_real(shape: np.ndarray) -> tuple[np.ndarray, complex]:
    """The real shape nearest to a complex one, and the phase factor e^{i alpha} it was turned back by."""
    phase = np.exp(0.5j * np.angle(np.sum((shape / np.abs(shape).max()) ** 2)))
    return (shape / phase).real, phase
