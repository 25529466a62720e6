"""Answer to a design problem: lines to read, and a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PERCENT = 100.0
TICKS = (1, 1.5, 2, 3, 4, 5, 6, 8)
"""Ticks of a logarithmic axis in every decade: ranges are often shorter than one."""


def lines(answer) -> list[str]:
    """The answer in words."""
    verified, design, problem = answer.verified, answer.design, answer.problem
    wanted, low, high = problem.target.damping, *verified.probability_interval
    span = f"{low:.3f} to {high:.3f} without one of {len(verified.damping)} packings"
    probability = f"P = {verified.probability:.3f} ({span})"
    if wanted is None:
        found = ["the best damper found:"]
    elif answer.claimed:
        found = [f"the target of {PERCENT * wanted:.3g} % is met with {probability}:"]
    else:
        asked = f"{problem.design.confidence:g} was asked for"
        found = [f"no claim: the best found meets {PERCENT * wanted:.3g} % with {probability}, and {asked}:"]
    found += [f"  {path[-1]} {_shown(value)}" for path, value in design.values.items()]
    least = verified.least
    found.append(
        f"  particles {1e3 * design.mass:.4g} g; least damping over the range {PERCENT * least.least:.3g} % (95 %: "
        f"{PERCENT * least.interval[0]:.3g} to {PERCENT * least.interval[1]:.3g} %); force on the structure "
        f"{least.force:.3g} N"
    )
    found.append(f"motion: {answer.bounds.motion}: {answer.bounds.why}")
    if answer.bounds.least_mass:
        found.append(
            f"bound: at least {1e3 * answer.bounds.least_mass:.4g} g of particles, whatever the damper (eqs 5-11)"
        )
    found.append("Γ at the damper, damping [%] of each mode, mean over the fresh packings:")
    for mode in np.unique(verified.drives.mode):
        of = verified.drives.mode == mode
        points = zip(verified.drives.gamma[of], verified.mean[of], verified.interval[of], strict=True)
        curve = ", ".join(f"{g:.3g}: {PERCENT * m:.3g} ± {PERCENT * i:.2g}" for g, m, i in points)
        found.append(f"  {verified.drives.frequency[of][0]:.4g} Hz: {curve}")
    found += _tolerances(answer.sensitivity)
    for k, one in enumerate(answer.runners_up, 1):
        values = ", ".join(f"{path[-1]} {_shown(value)}" for path, value in one.design.values.items())
        found.append(
            f"runner-up {k}: {1e3 * one.design.mass:.4g} g, least {PERCENT * one.least:.3g} %, "
            f"P {one.probability:.2f} (not simulated again): {values}"
        )
    found.append(f"{answer.cases} cases; {answer.attempts} designs simulated again")
    return found


def _tolerances(sensitivity) -> list[str]:
    if sensitivity is None:
        return []
    found = [f"with all of these anywhere in their ranges the target is met with P = {sensitivity.probability:.3f}:"]
    found += [
        f"  {one.name} {_shown(one.value)}, range {_shown(one.range[0])} to {_shown(one.range[1])}: "
        f"the claim holds from {_shown(one.kept[0])} to {_shown(one.kept[1])}"
        for one in sensitivity.tolerances
    ]
    return [*found, *map("  {}".format, left_out(sensitivity))]


def left_out(sensitivity) -> list[str]:
    """What a Monte Carlo of tolerances did without, in words; empty if nothing."""
    found = []
    if sensitivity.impossible:
        found.append(
            f"{sensitivity.impossible} of {sensitivity.samples} designs drawn from these ranges cannot be, and were "
            "left out: a particle more or a cavity as small does not fit"
        )
    if sensitivity.failed:
        found.append(f"{sensitivity.failed} of {sensitivity.cases} cases simulated there gave no result: left out")
    return found


def _shown(value) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


def picture(answer) -> Figure:
    """Damping over Gamma of the damper chosen with its intervals, and the front of damping against mass."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullLocator

    figure = Figure(figsize=(11, 4.2), layout="constrained", dpi=110)
    curve, front = figure.subplots(1, 2)
    verified, wanted = answer.verified, answer.problem.target.damping
    for mode in np.unique(verified.drives.mode):
        of = verified.drives.mode == mode
        gamma, label = verified.drives.gamma[of], f"{verified.drives.frequency[of][0]:.1f} Hz"
        curve.plot(gamma, PERCENT * verified.damping[:, of].T, color="0.8", lw=0.7, zorder=1)
        curve.errorbar(
            gamma, PERCENT * verified.mean[of], PERCENT * verified.interval[of], marker="o", capsize=3, label=label
        )
    curve.set(xscale="log", xlabel="Γ at the damper", ylabel="damping ratio [%]", title="the damper chosen")
    best = answer.front
    mass, least = (np.array(values) for values in zip(*((o.design.mass, o.least) for o in best), strict=True))
    spread = np.array([[o.least - o.interval[0], o.interval[1] - o.least] for o in best]).T
    front.errorbar(
        1e3 * mass, PERCENT * least, PERCENT * np.maximum(spread, 0), marker="s", capsize=2, label="front (emulator)"
    )
    front.plot(1e3 * answer.design.mass, PERCENT * verified.least.least, "k*", ms=12, label="chosen")
    if answer.bounds.least_mass:
        front.axvline(1e3 * answer.bounds.least_mass, color="tab:red", ls=":", label="least mass of eqs 5-11")
    front.set(
        xscale="log", xlabel="mass of the particles [g]", ylabel="least damping over the range [%]", title="front"
    )
    for ax in (curve, front):
        if wanted is not None:
            ax.axhline(PERCENT * wanted, color="k", lw=0.8, ls="--", label="target")
        ax.xaxis.set_major_locator(LogLocator(subs=TICKS))
        ax.xaxis.set_major_formatter("{x:g}")
        ax.xaxis.set_minor_locator(NullLocator())
        ax.legend(fontsize=8)
        ax.grid(alpha=0.3)
    return figure
