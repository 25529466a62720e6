"""Checks of what the studies say: density alone, no gravity, resonance of the bed, and the rules of the verdicts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from parameters_data import FACTORS, FAST, SLOW, cells, difference_of, effects, results
from shared import table

from warpdamp.analysis.effects import SURE, Verdict, effect_of
from warpdamp.analysis.regimes import Regime, regime
from warpdamp.numerics.regression import straight_line
from warpdamp.scene.paper import COUNT, PMMA
from warpdamp.scene.scene import STANDARD_GRAVITY
from warpdamp.status import Status

SURELY = (Verdict.HIGHER, Verdict.LOWER)


@dataclass(frozen=True)
class Exponent:
    """Exponent of the damping over the density, with the ends of its 95 % interval, and where that is."""

    where: str
    value: tuple[float, float, float]

    @property
    def one(self) -> bool:
        """Whether the interval has 1 in it."""
        return self.value[1] <= 1 <= self.value[2]

    def __str__(self):
        return "{}: {:.3f} ({:.3f} to {:.3f})".format(self.where, *self.value)


def density_exponents() -> list[Exponent]:
    """Slopes of log damping over log density, at both optima and at fixed amplitudes at which all levels move alike.

    The damping is the effectiveness times the particles' mass, so that its exponent is one and that of the
    effectiveness.
    """
    runs, found = results("density"), effects("density", "density")
    if runs is None:
        return []
    exponents = []
    for response, name, frequency in (
        ("effectiveness_fluidisation", "at Γ_f of each density", FAST),
        ("effectiveness_collision", "at Γ_c of each density", SLOW),
    ):
        cell = found.sel(response=response, frequency=frequency)
        ends = (1 + np.log2(1 + float(cell[f"effect{end}"])) for end in ("", "_low", "_high"))
        exponents.append(Exponent(f"{frequency:g} Hz {name}", tuple(ends)))
    tops = found["level"].sel(response="gamma_fluidisation")
    kinds = regime(runs)
    x = np.log(runs["density"].values / np.exp(np.log(runs["density"].values).mean()))
    for frequency in runs["frequency"].values:
        kind = kinds.sel(frequency=frequency).transpose("gamma", "density", "seed").values
        eps = runs["effectiveness"].sel(frequency=frequency).transpose("gamma", "density", "seed").values
        collides = kind == int(Regime.TWO_SIDED_COLLISION)
        alike = np.isfinite(eps).all(axis=(1, 2)) & (collides == collides[:, :1, :1]).all(axis=(1, 2))
        beyond = runs["gamma"].values > np.nanmax([1.0, *tops.sel(frequency=frequency).values])
        for own, name in (
            (alike & collides[:, 0, 0], "in collision"),
            (alike & beyond & ~collides[:, 0, 0], "above Γ_f"),
        ):
            if own.any():
                slope = np.tensordot(x, np.log(eps[own]).mean(axis=0), 1) / np.sum(x**2)
                gammas = ", ".join(f"{g:g}" for g in runs["gamma"].values[own])
                exponents.append(Exponent(f"{frequency:g} Hz {name}, at Γ {gammas}", difference_of(1 + slope)))
    return exponents


def no_gravity() -> list[str]:
    """Optimum of collision without gravity against that with it, from compacted beds and from suspended particles."""
    runs, loose = results("gravity"), results("gravity_suspended")
    if runs is None:
        return []
    at = effects("gravity", "gravity").sel(frequency=SLOW)
    lines = []
    for response, name in (("effectiveness_collision", "ε_c"), ("gamma_collision", "Γ_c")):
        level, error = (at[n].sel(response=response) for n in ("level", "level_standard_error"))
        pair = effect_of(runs.sel(gravity=[0.0, 9.81], frequency=[SLOW]), "gravity")
        change = pair.sel(response=response, frequency=SLOW)
        # of log(with / without), turned round
        ends = (1 / (1 + float(change[f"change{end}"])) - 1 for end in ("", "_high", "_low"))
        lines.append(
            f"- compacted beds: {name} {float(level.sel(gravity=0)):.3g} ± {float(error.sel(gravity=0)):.2g} without, "
            f"{float(level.sel(gravity=9.81)):.3g} ± {float(error.sel(gravity=9.81)):.2g} with gravity: "
            "{:+.1f} % ({:+.1f} to {:+.1f}) without it".format(*(100 * end for end in ends))
        )
    lid = (runs["lid_impulse"] / runs["floor_impulse"]).sel(frequency=SLOW, gamma=6.0).mean("seed")
    shown = ", ".join(f"{float(v):.2f} at {g:.4g} m/s²" for g, v in zip(runs["gravity"].values, lid, strict=True))
    lines.append(
        f"- what differs: impulse on the lid over that on the floor at Γ 6 is {shown}: gravity takes from the blow on "
        "the lid, and without it both walls are hit alike"
    )
    return lines if loose is None else [*lines, suspended(loose, runs.sel(gravity=0.0))]


def suspended(loose: xr.Dataset, compacted: xr.Dataset) -> str:
    """Curve of suspended particles beside that of compacted beds, both without gravity."""
    own, other = (part["effectiveness"].sel(frequency=SLOW).mean("seed") for part in (loose, compacted))
    known = own.notnull().values
    curve = ", ".join(
        f"Γ {g:g}: {float(a):.2f} ({float(b):.2f} from compacted beds)"
        for g, a, b in zip(
            own["gamma"].values[known], own.values[known], other.sel(gamma=own["gamma"].values[known]), strict=True
        )
    )
    status = loose["status"].sel(frequency=SLOW).values[known]
    drifting = float(np.mean(status == int(Status.DRIFTING)))
    return (
        f"- suspended particles, without gravity: effectiveness {curve}; {100 * drifting:.0f} % of these runs still "
        "drift after their 32 cycles, so that this is how such a bed starts, not where it ends"
    )


def scaled_frequency(frequency, *, density=1.0, modulus=1.0, count=1.0, gravity=1.0):
    """Frequency [Hz] at which the paper's bed is as near to its resonance as one with these ratios to it.

    Hertz's contacts under the bed's own weight carry sound at c ~ E^(1/3) rho^(-1/2) p^(1/6) (Walton 1987,
    doi:10.1016/0022-5096(87)90036-6), p ~ rho g h, and the bed resounds at c / h.
    """
    return frequency * density ** (1 / 3) * modulus ** (-1 / 3) * count ** (5 / 6) * gravity ** (-1 / 6)


RATIOS = (
    ("density", "density", "density", PMMA.density, "kg/m^3", 1.0),
    ("modulus", "youngs_modulus", "modulus", PMMA.youngs_modulus, "MPa", 1e-6),
    ("bed_depth", "count", "count", COUNT, "particles", 1.0),
    ("gravity", "gravity", "gravity", STANDARD_GRAVITY, "m/s^2", 1.0),
)


@dataclass(frozen=True)
class Resonance:
    """Optimum of fluidisation of another bed, and what the line over the frequency says of its scaled frequency."""

    arm: str
    frequency: float
    measured: float
    error: float
    expected: float
    spread: float

    @property
    def off(self) -> float:
        """Difference in standard errors."""
        return (self.measured - self.expected) / np.hypot(self.error, self.spread)


def resonances() -> list[Resonance]:
    """Other beds at 280 Hz against the line of the paper's bed over the frequency; Γ in terms of the arm's gravity."""
    over = effects("frequency", "frequency")
    if over is None:
        return []
    over = over.sel(response="gamma_fluidisation")
    line = straight_line(over["frequency"].values, over["level"].values, over["level_standard_error"].values)
    known = np.isfinite(over["level"].values)
    centre = np.average(over["frequency"].values[known], weights=over["level_standard_error"].values[known] ** -2.0)
    middle = line.intercept + line.slope * centre
    own = float(np.sum(over["level_standard_error"].values[known] ** -2.0) ** -0.5)
    found = []
    for study, key, ratio, reference, unit, shown in RATIOS:
        level = effects(study, key)
        if level is None:
            continue
        level = level.sel(response="gamma_fluidisation", frequency=FAST)
        for value, measured, error in zip(
            level[key].values, level["level"].values, level["level_standard_error"].values, strict=True
        ):
            times = float(value) / reference
            if not np.isfinite(measured) or abs(times - 1) < 0.01 or times == 0:
                continue
            scaled = scaled_frequency(FAST, **{ratio: times})
            weight = times if ratio == "gravity" else 1.0
            expected = middle + line.slope * (scaled - centre)
            spread = float(np.hypot(own, line.slope_standard_error * (scaled - centre)))
            arm = f"{study.replace('_', ' ')} {shown * value:.4g} {unit}"
            found.append(Resonance(arm, scaled, measured / weight, error / weight, expected, spread))
    return found


def louder() -> list[tuple[float, float, tuple[float, float, float]]]:
    """Apparent mass over the particles' at the lowest amplitude of each frequency: (f, Gamma, value with interval)."""
    runs = results("frequency")
    if runs is None:
        return []
    ratio, found = runs["apparent_mass"] / runs["particle_mass"], []
    for frequency in runs["frequency"].values:
        own = ratio.sel(frequency=frequency).dropna("gamma", how="all").isel(gamma=0)
        found.append((float(frequency), float(own["gamma"]), difference_of(own.values)))
    return found


def resonance_rows():
    """Rows of the table on the resonance."""
    for r in resonances():
        yield (
            r.arm, f"{r.frequency:.0f}", f"{r.measured:.2f} ± {r.error:.2f}", f"{r.expected:.2f} ± {r.spread:.2f}",
            f"{r.off:+.1f}",
        )  # fmt: skip


def rules() -> str:
    """How the rules of the verdicts came out."""
    own = [cell for factor in FACTORS for cell in cells(factor) if cell is not None and np.isfinite(cell["effect"])]
    errors = np.array([abs(np.log1p(float(c["effect"]))) / float(c["paired_standard_error"]) for c in own])
    words = [str(cell["verdict"].item()) for cell in own]
    sure = [e for e, word in zip(errors, words, strict=True) if word in SURELY]
    same = [
        max(abs(float(cell[f"change_{end}"])) for end in ("low", "high"))
        for cell, word in zip(own, words, strict=True)
        if word == Verdict.NOT_AFFECTED
    ]
    ratio = np.array([float(cell["paired_standard_error"] / cell["unpaired_standard_error"]) for cell in own])
    needed = [
        float(cell["packings_needed"]) for cell, word in zip(own, words, strict=True) if word == Verdict.UNDECIDED
    ]
    parts = [
        f"The nearest of the {len(sure)} effects called higher or lower is {min(sure):.1f} standard errors from none "
        f"(asked {SURE:g})."
    ]
    if same:
        parts.append(f"The widest interval of the {len(same)} called not affected ends at {100 * max(same):.1f} %.")
    if needed:
        parts.append(
            f"The {len(needed)} undecided would be decided with {min(needed):.0f} to {max(needed):.0f} packings "
            f"(half of them with at most {np.median(needed):.0f})."
        )
    parts.append(
        f"Paired standard errors over unpaired ones: median {np.median(ratio):.2f}, from {ratio.min():.2f} to "
        f"{ratio.max():.2f}; pairing makes {int((ratio < 1).sum())} of {len(ratio)} smaller."
    )
    return "  ".join(parts)


def checks_section() -> list[str]:
    """Blocks of the document."""
    exponents = density_exponents()
    weightless, resonance = no_gravity(), list(resonance_rows())
    blocks = ["### The rules", rules()]
    if exponents:
        blocks += [
            "### Damping over density",
            "Exponent of the damping over the density, from slopes of log-log with 95 % intervals over packings: of "
            "the heights of both optima, and at fixed amplitudes, those at which all densities collide with both walls "
            "and those above all their Γ_f:",
            "\n".join(f"- {exponent}" for exponent in exponents),
            "At fixed amplitudes above Γ_f the exponent has a second cause: Γ_f falls with the density, so that a "
            "heavier bed is further beyond its optimum at the same Γ.",
        ]
    if weightless:
        blocks += [
            "### Without gravity",
            "The optimum of collision at 39.5 Hz without gravity, against that of compacted beds with it:",
            "\n".join(weightless),
        ]
    if resonance:
        blocks += [
            "### Resonance of the bed",
            "If the frequency comes in over the bed's resonance, Γ_f depends on it over f h / c only, where c is the "
            "speed of sound in the bed: c ~ E^(1/3) ρ^(-1/3) (g h)^(1/6) for Hertz's contacts under the bed's own "
            "weight (Walton 1987, doi:10.1016/0022-5096(87)90036-6).  Γ_f of other beds at 280 Hz, in units of their "
            "own gravity, beside the line of the paper's bed over the frequency at their scaled frequency; nothing is "
            "fitted to them:",
            table(["bed", "scaled frequency [Hz]", "Γ_f", "of the line", "difference in standard errors"], resonance),
        ]
    return blocks
