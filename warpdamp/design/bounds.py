"""Bounds that a design problem has before anything is simulated: eqs 1, 2 and 5-11 of the paper alone.

A damper takes at most what an ideal impact damper of its mass takes (eq. 5: effectiveness 1), so that

    zeta <= (2 / pi) m phi(m)^2 + inherent damping

at every amplitude, phi that of the structure with the mass m on it.  That is a bound for beds, which hit a wall as one
inelastic body; a single elastic sphere in resonance with its cavity may take more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..modal.damping import damping_of_effectiveness
from ..scene.scene import STANDARD_GRAVITY
from .problem import Design, Problem

LARGEST_MASS, MOST_ROUNDS, ROUNDED = 1e4, 60, 1e-6
"""Mass [kg] beyond which none is looked for; steps towards the least one, and the relative change that ends them."""

NARROW = 0.1
"""Clearance, in diameters of a particle, below which beds do not travel as one body: they differ by half of it."""

BEYOND = 1.3
"""Part of the largest clearance up to which the collision optimum may lie."""


@dataclass(frozen=True)
class Bounds:
    """What is known before anything is simulated.

    Parameters
    ----------
    least_mass : [kg] of particles that any damper needs; 0 where no damping is asked for
    gamma : (m, 2) range of Gamma at the damper in each mode
    frequency : (m,) of the target's modes with the least mass [Hz]
    clearance : (m, 2) at which the collision optimum lies at the lower and the upper end of the range [m] (eq. 1)
    motion : fluidisation or collision
    why : sentence
    """

    least_mass: float
    gamma: np.ndarray
    frequency: np.ndarray
    clearance: np.ndarray
    motion: str
    why: str


def collision_clearance(gamma, frequency):
    """Clearance [m] at which two-sided collision has its optimum at Gamma: h = Gamma g / (4 pi f^2) (eq. 1)."""
    return np.asarray(gamma) * STANDARD_GRAVITY / (4 * math.pi * np.asarray(frequency) ** 2)


def largest_damping(mass: float, amplitude, inherent):
    """Damping ratio that no damper of a mass [kg] exceeds, of modes of amplitude phi [kg^-0.5] (eqs 5-11)."""
    return damping_of_effectiveness(1.0, mass, np.asarray(amplitude)) + np.asarray(inherent)


def least_mass(problem: Problem, design: Design) -> float:
    """Mass of particles [kg] below which no damper at a design's place reaches the target in every mode.

    From an empty damper on: the mass that the shapes need is too little for the shapes that it makes, so that the steps
    rise to the least one, or beyond every mass.

    Returns
    -------
    float
        Infinite where no mass does: the structure then moves with the damper.
    """
    wanted, mass = problem.target.damping, 0.0
    for _ in range(MOST_ROUNDS):
        _, amplitude, inherent = _modes_at(problem, design, mass)
        needed = float(np.max((wanted - inherent) / damping_of_effectiveness(1.0, 1.0, amplitude)))
        if needed <= mass * (1 + ROUNDED):
            return max(mass, 0.0)
        if needed > LARGEST_MASS:
            break
        mass = needed
    return math.inf


def _modes_at(problem: Problem, design: Design, mass: float):
    from dataclasses import replace

    modes = problem.modes(replace(design, mass=mass))
    return modes.frequency, modes.amplitude, modes.inherent_damping


def gamma_range(problem: Problem, design: Design, mass: float) -> np.ndarray:
    """Range of Gamma at the damper in each mode, (m, 2).

    Of a force F at the damper: a structure damped as wanted answers with phi^2 F / (2 zeta g) at the upper end, and one
    that an ideal damper damps at the lower end.  A base's acceleration A is a force (participation) A / phi.
    """
    target = problem.target
    _, amplitude, inherent = _modes_at(problem, design, mass)
    if target.over == "gamma":
        return np.tile(np.array(target.gamma, float), (len(amplitude), 1))
    low, high = _forces(problem, design, amplitude)
    most = np.maximum(largest_damping(mass, amplitude, inherent), target.damping)
    per_force = amplitude**2 / (2 * STANDARD_GRAVITY)
    return np.stack([per_force * low / most, per_force * high / target.damping], axis=1)


def _forces(problem: Problem, design: Design, amplitude) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest force at the damper in each mode [N]."""
    target = problem.target
    if target.over == "force":
        return tuple(np.full(len(amplitude), end) for end in target.force)
    participation = problem.participation(design)
    return tuple(participation * end / amplitude for end in target.base)


def find_bounds(problem: Problem, designs: list[Design]) -> Bounds:
    """Bounds of a problem, from a sample of designs that its variables and limits allow.

    Raises
    ------
    ConfigError
        If the target is impossible, with the number that says so.
    """
    if not designs:
        raise problem.error(
            "variables", "no combination of them can be: particles do not fit, or the envelope is too small"
        )
    places: dict[tuple, Design] = {}
    for design in designs:
        places.setdefault(tuple(v for path, v in design.values.items() if path[0] == "structure"), design)
    needed = {place: 0.0 for place in places}
    if problem.target.damping is not None:
        needed = {place: least_mass(problem, design) for place, design in places.items()}
        _refuse_impossible(problem, designs, min(needed.values()))
    best = min(needed, key=needed.get)
    design, mass = places[best], needed[best] or min(d.mass for d in designs)
    if not any(map(problem.light_enough, designs)):
        least = 1e3 * min(d.mass for d in designs)
        raise problem.error("limits.mass", f"the variables allow no less than {least:.4g} g of particles")
    frequency, amplitude, inherent = _modes_at(problem, design, mass)
    gamma = gamma_range(problem, design, mass)
    _refuse_force(problem, gamma, amplitude, inherent)
    clearance = np.stack([collision_clearance(gamma[:, k], frequency) for k in (0, 1)], axis=1)
    free = [d.clearance(d.packing) for d in designs]
    available = max(min(free), NARROW * 2 * min(d.radius for d in designs)), max(free)
    motion, why = _motion(problem, gamma, frequency, clearance, available)
    return Bounds(needed[best], gamma, frequency, clearance, motion, why)


def _refuse_impossible(problem: Problem, designs: list[Design], needed: float) -> None:
    wanted, limits = problem.target.damping, problem.design.limits
    if needed == 0.0:
        raise problem.error(
            "target.damping", f"the structure has {100 * wanted:.3g} % without a damper: there is nothing to design"
        )
    if math.isinf(needed):
        raise problem.error(
            "target.damping",
            f"no mass of particles gives {100 * wanted:.3g} % here: an ideal damper of any mass stays below (eqs 5-11)",
        )
    at_least = f"{100 * wanted:.3g} % takes at least {1e3 * needed:.4g} g of particles, whatever the damper (eqs 5-11)"
    if limits.mass is not None and needed > limits.mass:
        raise problem.error(
            "limits.mass", f"the target is impossible: {at_least}, and {1e3 * limits.mass:.4g} g are allowed"
        )
    heaviest = max(design.mass for design in designs)
    if needed > heaviest:
        raise problem.error(
            "variables", f"the target is impossible: {at_least}, and the variables allow {1e3 * heaviest:.4g} g"
        )


def _refuse_force(problem: Problem, gamma, amplitude, inherent) -> None:
    """Refuse a limit of force below what the damping itself takes: F = 2 (zeta - inherent) Gamma g / phi^2."""
    limit, wanted = problem.design.limits.force, problem.target.damping
    if limit is None or wanted is None:
        return
    force = float(np.max(2 * (wanted - inherent) * gamma[:, 1] * STANDARD_GRAVITY / amplitude**2))
    if force > limit:
        raise problem.error(
            "limits.force",
            f"the target is impossible: {100 * wanted:.3g} % at Γ {gamma[:, 1].max():.3g} takes a force of "
            f"{force:.3g} N on the structure (eqs 6-11), and {limit:.3g} N are allowed",
        )


def _motion(problem: Problem, gamma, frequency, clearance, available) -> tuple[str, str]:
    """Motion that suits the range, and why."""
    middle = np.sqrt(clearance[:, 0] * clearance[:, 1])
    k = int(np.argmax(middle))
    wanted = f"at {frequency[k]:.4g} Hz the collision optimum lies in the middle of Γ {gamma[k, 0]:.3g} to " + (
        f"{gamma[k, 1]:.3g} with a clearance of {1e3 * middle[k]:.3g} mm (eq. 1)"
    )
    there = f"the variables allow {1e3 * available[0]:.3g} to {1e3 * available[1]:.3g} mm (eq. 2)"
    if not problem.gravity():
        return "collision", f"{wanted}; {there}; without gravity along the motion nothing fluidises"
    if available[0] <= middle[k] <= available[1] * BEYOND:
        return "collision", f"{wanted}; {there}"
    side = "less" if middle[k] < available[0] else "more"
    return "fluidisation", f"{wanted}, {side} than there is: {there}"
