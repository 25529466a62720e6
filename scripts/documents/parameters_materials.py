"""The paper's section 4.2: what density, modulus, restitution and friction of the particles do."""

from __future__ import annotations

import numpy as np
from parameters_checks import density_exponents
from parameters_data import FAST, SLOW, change_of, difference_of, effects, losses, nearest, results, shares
from parameters_verdicts import COLLIDED, FLUIDISED, HOLDS, IN_PART, NAMES, NOT, OPEN, curves, percent


def proportional() -> tuple[str, str]:
    """Damping over the particles' mass: at both optima, and at amplitudes at which all densities move alike."""
    found = density_exponents()
    if not found:
        return OPEN, ""
    state = HOLDS if all(e.one for e in found) else IN_PART
    return state, "exponent of the damping over the density: " + "; ".join(map(str, found))


def alike_when_stiff() -> tuple[str, str]:
    """The two highest moduli against each other, and the two lowest."""
    found = effects("modulus", "youngs_modulus")
    if found is None:
        return OPEN, ""
    if found.sizes["youngs_modulus"] < 5:
        return OPEN, "x100 (modulus_stiff) was not run"
    words, right = [], []
    times = found["youngs_modulus"].values / 3.3e9
    for response, f in (("gamma_fluidisation", FAST), ("gamma_collision", SLOW)):
        at = found.sel(response=response, frequency=f)
        level, error = at["level"].values, at["level_standard_error"].values
        steps = [k for k in range(1, level.size) if np.isfinite(level[k - 1 : k + 1]).all()]
        rise = [level[k] / level[k - 1] - 1 for k in steps]
        spread = [np.hypot(*(error[k - 1 : k + 1] / level[k - 1 : k + 1])) for k in steps]
        if len(steps) > 1 and steps[-1] == level.size - 1:
            right.append(abs(rise[-1]) < abs(rise[0]) and abs(rise[-1]) < 2 * spread[-1])
        changes = ", ".join(
            f"{100 * r:+.0f} ± {100 * s:.0f} % to x{times[k]:g}" for r, s, k in zip(rise, spread, steps, strict=True)
        )
        words.append(f"{NAMES[response]} by tenfold modulus: {changes}")
    return (HOLDS if right and all(right) else IN_PART if any(right) else NOT), "; ".join(words)


def dashpots_when_soft() -> tuple[str, str]:
    """Whether dashpots take more where the modulus is low, packing by packing."""
    if results("modulus") is None:
        return OPEN, ""
    words, right = [], []
    for f, gamma in ((FAST, FLUIDISED), (SLOW, COLLIDED)):
        at = nearest(results("modulus"), f, gamma).sortby("youngs_modulus")
        lost = losses(at, "dashpots").transpose("youngs_modulus", "seed").values
        more = difference_of(lost[0] - lost[-1])
        right.append(more[1] > 0)
        ends = at["youngs_modulus"].values[[0, -1]] / 3.3e9
        words.append(
            f"{f:g} Hz, Γ {float(at['gamma']):g}: dashpots {np.nanmean(lost[0]):.3f} at x{ends[0]:g}, "
            f"{np.nanmean(lost[-1]):.3f} at x{ends[1]:g}, difference {parts(more)}"
        )
    return (HOLDS if all(right) else IN_PART if any(right) else NOT), "; ".join(words) + IDEAL


IDEAL = " (in parts of the ideal damper)"


def parts(ends: tuple[float, float, float]) -> str:
    """A difference with its interval."""
    return "{:+.3f} ({:+.3f} to {:+.3f})".format(*ends)


def friction_is_chief(study: str = "restitution", key: str = "restitution") -> tuple[str, str]:
    """Part of friction in the loss at the optimum of collision, in the paper's damper."""
    if results(study) is None:
        return OPEN, ""
    at = nearest(results(study), SLOW, COLLIDED).sortby(key)
    part = shares(at)
    reference = {"restitution": 0.52, "friction": 0.86}[key]
    own = {kind: float(values.sel({key: reference})) for kind, values in part.items()}
    words = (
        f"39.5 Hz, Γ {float(at['gamma']):g}: friction {own['friction']:.2f}, dashpots {own['dashpots']:.2f} of the loss"
    )
    return (HOLDS if own["friction"] > 0.5 else NOT), words


def more_friction_by_restitution() -> tuple[str, str]:
    """Whether the loss by friction rises with the restitution at the optimum of collision, packing by packing."""
    if results("restitution") is None:
        return OPEN, ""
    at = nearest(results("restitution"), SLOW, COLLIDED).sortby("restitution")
    friction, dashpots = (losses(at, kind).transpose("restitution", "seed").values for kind in ("friction", "dashpots"))
    words = "; ".join(
        f"e {e:g}: friction {np.nanmean(a):.3f}, dashpots {np.nanmean(b):.3f}"
        for e, a, b in zip(at["restitution"].values, friction, dashpots, strict=True)
    )
    more = difference_of(friction[-1] - friction[0])
    return (HOLDS if more[1] > 0 else NOT), f"{words}; friction from end to end {parts(more)}" + IDEAL


def less_transport() -> tuple[str, str]:
    """Whether friction keeps particles in place, above the optimum of fluidisation."""
    if results("friction") is None:
        return OPEN, ""
    words, right = [], []
    for gamma in (2.0, 4.0):
        at = nearest(results("friction"), FAST, gamma).sortby("friction")
        moved = (at["cycle_displacement"] / at["displacement"]).transpose("friction", "seed").values
        change = change_of(np.log(moved[-1] / moved[1]))
        right.append(change[2] < 0)
        mu = at["friction"].values
        words.append(f"Γ {float(at['gamma']):g}, friction {mu[1]:g} to {mu[-1]:g}: {percent(*change)}")
    return (
        HOLDS if all(right) else IN_PART if any(right) else NOT,
        "how far particles are from where they began a cycle, 280 Hz: " + "; ".join(words),
    )


def friction_towards_convection() -> tuple[str, str]:
    """Effect of friction above the optimum of fluidisation, where no lid is met."""
    if effects("friction", "friction") is None:
        return OPEN, ""
    rows = curves("friction", "friction", lambda f, gamma: (f > 100 and gamma >= 2) or (f < 100 and gamma >= 8))
    up = [row for row in rows if row[3] > 0]
    down = [row for row in rows if row[4] < 0]
    words = ", ".join(f"{f:g} Hz Γ {g:g}: {percent(e, low, high)}" for f, g, e, low, high in rows)
    state = HOLDS if len(up) == len(rows) else NOT if not up else IN_PART
    return state, f"{len(up)} of {len(rows)} higher, {len(down)} lower, over the range: {words}"


def friction_at_collision() -> tuple[str, str]:
    """Effectiveness near the optimum of collision, of little and of much friction against that of the paper's 0.86."""
    if results("friction") is None:
        return OPEN, ""
    at = nearest(results("friction"), SLOW, COLLIDED).sortby("friction")
    eps = np.log(at["effectiveness"].transpose("friction", "seed"))
    changes = {float(mu): change_of((eps.sel(friction=mu) - eps.sel(friction=0.86)).values) for mu in eps["friction"]}
    words = ", ".join(f"{mu:g}: {percent(*change)}" for mu, change in changes.items() if mu != 0.86)
    little, much = changes[0.2], changes[1.2]
    right = little[2] < 0, much[1] > 0
    state = HOLDS if all(right) else IN_PART if any(right) else NOT
    return state, f"ε at Γ {float(at['gamma']):g} against friction 0.86, by friction {words}"
