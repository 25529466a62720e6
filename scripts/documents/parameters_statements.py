"""Every statement of the paper's sections 4.1 to 4.4, in other words, and what the studies say of it."""

from __future__ import annotations

import re

import numpy as np
from parameters_checks import louder, resonances
from parameters_data import effects
from parameters_materials import (
    alike_when_stiff,
    dashpots_when_soft,
    friction_at_collision,
    friction_is_chief,
    friction_towards_convection,
    less_transport,
    more_friction_by_restitution,
    proportional,
)
from parameters_shapes import beyond, denser, fluidised, higher, known
from parameters_verdicts import HOLDS, IN_PART, NOT, OPEN, every, said
from shared import DOCS

from warpdamp.numerics.regression import straight_line


def fluidisation_line() -> tuple[str, str]:
    """Line of the optimum of fluidisation over the frequency, beside 3 - 0.0037 f."""
    found = effects("frequency", "frequency")
    if found is None:
        return OPEN, ""
    level, error = (found[n].sel(response="gamma_fluidisation") for n in ("level", "level_standard_error"))
    line = straight_line(found["frequency"].values, level.values, error.values)
    words = (
        f"Γ_f = ({line.intercept:.2f} ± {line.intercept_standard_error:.2f}) + ({line.slope:.4f} ± "
        f"{line.slope_standard_error:.4f}) f, chi^2 {line.scatter:.1f} per degree of freedom, "
        f"{int(np.isfinite(level).sum())} of {level.size} frequencies have one; the paper's: 3 − 0.0037 f"
    )
    near = abs(line.slope + 0.0037) < 3 * line.slope_standard_error
    near &= abs(line.intercept - 3) < 3 * line.intercept_standard_error
    return (HOLDS if near else IN_PART if line.slope < 0 else NOT), words


def collision_line() -> tuple[str, str]:
    """Line of the optimum of collision over f^2, from docs/gamma_c.md."""
    path = DOCS / "gamma_c.md"
    found = re.search(r"\*\*Gamma_c = \(([\d.]+) ± ([\d.]+)\) f\^2 \+ \(([-\d.]+) ± ([\d.]+)\)\*\*", path.read_text())
    if not found:
        return OPEN, ""
    slope, error, intercept, other = map(float, found.groups())
    words = (
        f"Γ_c = ({slope:.5f} ± {error:.5f}) f^2 + ({intercept:.2f} ± {other:.2f}), straight; the paper's slope: 0.0029"
    )
    return (HOLDS if abs(slope - 0.0029) < 3 * error else IN_PART), words + " ([gamma_c.md](gamma_c.md))"


def separately_affected() -> tuple[str, str]:
    """Factors whose verdicts differ between the two optima."""
    rows = [
        ("restitution", "restitution"),
        ("friction", "friction"),
        ("modulus", "youngs_modulus"),
        ("density", "density"),
    ]
    rows = [(s, k) for s, k in rows if effects(s, k) is not None]
    words = []
    for study, key in rows:
        places = [said(study, key, f"gamma_{which}")[0] for which in ("fluidisation", "collision")]
        heights = [said(study, key, f"effectiveness_{which}")[0] for which in ("fluidisation", "collision")]
        words.append(f"{study}: Γ {places[0]} / {places[1]}, ε {heights[0]} / {heights[1]}")
    differ = any(len(set(part.split(" Γ ")[1].split(", ε ")[0].split(" / "))) > 1 for part in words)
    text = "; ".join(words) + " (fluidisation / collision).  That the curve is the sum of two was not tested"
    return (IN_PART if differ else NOT) if rows else OPEN, text


def by_resonance() -> tuple[str, str]:
    """Whether Gamma_f depends on frequency, modulus, density, depth and gravity as the bed's resonance does."""
    found, amplified = resonances(), louder()
    over = effects("frequency", "frequency")
    if not found:
        return OPEN, ""
    off = np.array([r.off for r in found])
    level, error = (over[n].sel(response="gamma_fluidisation") for n in ("level", "level_standard_error"))
    below = [
        f"{f:g} Hz {top:.2f} ± {own:.2f}"
        for f, top, own in zip(over["frequency"].values, level.values, error.values, strict=True)
        if top + 2 * own < 1
    ]
    below += [f"{r.arm} {r.measured:.2f} ± {r.error:.2f}" for r in found if r.measured + 2 * r.error < 1]
    loud = [(f, g, ends) for f, g, ends in amplified if ends[1] > 1]
    alike = float(np.mean(off**2)) < 2 and np.abs(off).max() < 3
    words = (
        f"Γ_f of {len(found)} other beds against the line over f h / c: chi^2 {np.mean(off**2):.1f} a bed, at most "
        f"{np.abs(off).max():.1f} standard errors off (below); Γ_f below 1: {', '.join(below) or 'nowhere surely'}; "
        "apparent over true mass at small amplitudes: "
        + ", ".join(f"{f:g} Hz, Γ {g:g}: {ends[0]:.2f} ({ends[1]:.2f} to {ends[2]:.2f})" for f, g, ends in amplified)
    )
    right = [alike, bool(below), len(loud) > 0]
    return (HOLDS if all(right) else IN_PART if any(right) else NOT), words


def shapes_collide_higher() -> tuple[str, str]:
    """Spheroids against spheres at the optimum of collision."""
    if not known():
        return OPEN, FEW
    state, words = every("sphericity", "elongation", ("gamma_collision", "higher"))
    return state, f"{words}; {higher()}"


def shapes_pack_denser() -> tuple[str, str]:
    """Clearances of spheroids, and what they explain."""
    if not known():
        return OPEN, FEW
    right, words = denser()
    return (HOLDS if right else IN_PART), words


def shapes_resist_shear() -> tuple[str, str]:
    """What the clearance does not explain, and what rolling friction does to spheres."""
    if not known():
        return OPEN, FEW
    above, count, words = beyond()
    rolling = said("shear_resistance", "rolling_friction", "gamma_collision")[1]
    state = HOLDS if above == count else IN_PART if above else NOT
    return state, f"{words}; {above} of {count} above none.  Rolling friction of spheres instead: {rolling}"


def shapes_fluidise_alike() -> tuple[str, str]:
    """Fluidisation of spheroids against spheres."""
    if not known():
        return OPEN, FEW
    state, words = every("sphericity", "elongation", *SAME_FLUIDISATION)
    unlike, other = fluidised()
    return (IN_PART if state == HOLDS and unlike else state), f"{words}; {other}"


FEW = "docs/sphericity.nc has fewer than three packings of all shapes"


def matter_for_fluidisation() -> tuple[str, str]:
    """Depth, modulus and friction on fluidisation."""
    found = [
        said(study, key, response)
        for study, key in (("bed_depth", "count"), ("modulus", "youngs_modulus"), ("friction", "friction"))
        for response in ("gamma_fluidisation", "effectiveness_fluidisation")
    ]
    if not all(verdict for verdict, _ in found):
        return OPEN, ""
    moves = [any(v in ("higher", "lower", "not monotonic") for v, _ in found[k : k + 2]) for k in (0, 2, 4)]
    names = "depth", "modulus", "friction"
    words = "; ".join(f"{name}: {found[2 * k][1]}, {found[2 * k + 1][1]}" for k, name in enumerate(names))
    return (HOLDS if all(moves) else IN_PART if any(moves) else NOT), words


def timing_and_shear() -> tuple[str, str]:
    """Clearance and shear resistance on the optimum of collision."""
    found = [
        said(study, key, response)
        for study, key in (("clearance", "free_height"), ("shear_resistance", "rolling_friction"))
        for response in ("gamma_collision", "effectiveness_collision")
    ]
    if not all(verdict for verdict, _ in found):
        return OPEN, ""
    moves = [any(v in ("higher", "lower") for v, _ in found[k : k + 2]) for k in (0, 2)]
    words = f"clearance: {found[0][1]}, {found[1][1]}; rolling friction: {found[2][1]}, {found[3][1]}"
    return (HOLDS if all(moves) else IN_PART if any(moves) else NOT), words


BOTH = ("gamma_fluidisation", "gamma_collision")
HEIGHTS = ("effectiveness_fluidisation", "effectiveness_collision")
SAME_FLUIDISATION = (("gamma_fluidisation", "not affected"), ("effectiveness_fluidisation", "not affected"))
MOTION = "[gamma_c.md](gamma_c.md): in flight the bed is thicker than at rest, and the lid's push comes early"
STATEMENTS = (
    ("4.1 a", "Γ_c lies higher for spheroids than for spheres.", shapes_collide_higher),
    ("4.1 b", "One cause: spheroids pack denser and leave more clearance.", shapes_pack_denser),
    ("4.1 c", "The other cause: they resist shear more, so that more amplitude is needed.", shapes_resist_shear),
    ("4.1 d", "Fluidisation does not depend on the shape.", shapes_fluidise_alike),
    ("4.2.1 a", "The damping is proportional to the particles' mass in all modes.", proportional),
    (
        "4.2.1 b", "The density hardly moves Γ_c.",
        lambda: every("density", "density", ("gamma_collision", "not affected")),
    ),
    (
        "4.2.1 c", "Γ_f falls slightly with the density.",
        lambda: every("density", "density", ("gamma_fluidisation", "lower")),
    ),
    (
        "4.2.2 a", "Γ_f and Γ_c rise with the modulus.",
        lambda: every("modulus", "youngs_modulus", *((name, "higher") for name in BOTH)),
    ),
    ("4.2.2 b", "The stiffer, the less it matters: x10 and x100 are alike.", alike_when_stiff),
    (
        "4.2.2 c", "Soft particles damp more round both optima.",
        lambda: every("modulus", "youngs_modulus", *((name, "lower") for name in HEIGHTS)),
    ),
    ("4.2.2 d", "... because their contacts deform more, and lose more by it.", dashpots_when_soft),
    (
        "4.2.3 a", "Restitution does not matter for fluidisation.",
        lambda: every("restitution", "restitution", *SAME_FLUIDISATION),
    ),
    (
        "4.2.3 b", "More restitution gives more loss round the optimum of collision.",
        lambda: every("restitution", "restitution", ("effectiveness_collision", "higher")),
    ),
    ("4.2.3 c", "Sliding between particles is the chief mechanism.", friction_is_chief),
    ("4.2.3 d", "More restitution means more sliding contacts, more loss by friction.", more_friction_by_restitution),
    ("4.2.4 a", "Friction raises the damping from fluidisation on towards convection.", friction_towards_convection),
    ("4.2.4 a'", "... likely because it retards the transport of particles.", less_transport),
    ("4.2.4 b", "Round the optimum of collision little friction lowers it, much raises it.", friction_at_collision),
    ("4.2.4 c", "Friction is what dissipates in collision.", lambda: friction_is_chief("friction", "friction")),
    ("4.3 a", "Γ_c is a straight line over f^2, of slope 0.0029, as eq. 20 has it.", collision_line),
    ("4.3 b", "Γ_f is a straight line over f: 3 − 0.0037 f.", fluidisation_line),
    ("4.3 c", "The curve is made of two independent ones, one for each motion.", separately_affected),
    ("4.4.1 a", "Bed depth, compressibility and friction decide fluidisation.", matter_for_fluidisation),
    ("4.4.1 b", "The frequency may come in by resonance of the bed, which would take Γ_f below 1.", by_resonance),
    (
        "4.4.2 a", "At the optimum the bed meets both walls as a compact body at the largest relative speed.",
        lambda: (IN_PART, MOTION),
    ),
    ("4.4.2 b", "What moves the timing of the collisions or the shear resistance decides collision.", timing_and_shear),
)  # fmt: skip


def rows():
    """Number, statement, verdict and figures of each."""
    for number, statement, check in STATEMENTS:
        verdict, words = check()
        yield number, statement, verdict if verdict == OPEN else f"**{verdict}**", words or "-"
