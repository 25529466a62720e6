"""What is to be said of coupled runs, from their Dataset alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr


def coupled_verdicts(runs: xr.Dataset) -> list[str]:
    """Sentences on coupled runs: what went in and came out at each level, who took the energy, how well it closes."""
    lines = [runs.attrs["left_out"]] if "left_out" in runs.attrs else []
    at_level = [runs.sel(level=level) for level in runs["level"].values]
    lines += [f"level {float(one['level']):g}: {said}" for one in at_level if (said := _in_and_out(one))]
    lines += _beside(runs)
    particles = runs["particle_loss"]
    several = "damper" in particles.dims
    total = particles.sum("damper") if several else particles
    lost = total + runs["structure_loss"]
    shares = [
        100 * float((part / lost).mean()) for part in (particles.transpose("damper", ...) if several else [total])
    ]
    by = " + ".join(f"{share:.3g}" for share in shares)
    whose = f" (dampers 1 to {len(shares)})" if several else ""
    lines.append(
        f"particles took {by} %{whose} of the energy lost; energy of structure and particles closes to "
        f"{100 * float(runs['closure'].max()):.2g} % of it"
    )
    return lines


def _in_and_out(runs: xr.Dataset) -> str:
    """Root mean squares of noise and of its answer, and the peak of the curve, of one level."""
    said = []
    if "response_grms" in runs:
        given, unit = (runs["base_grms"], "g") if "base_grms" in runs else (runs["force_rms"], "N")
        out = runs["response_grms"].mean("seed")
        each = " and ".join(f"{float(value):.3g}" for value in np.atleast_1d(out.values))
        said.append(f"{float(given):.3g} {unit} rms in, {each} g rms out")
    for name, unit in (("transmissibility", ""), ("accelerance", " m s^-2 N^-1")):
        if f"{name}_real" in runs:
            size = np.hypot(runs[f"{name}_real"], runs[f"{name}_imaginary"])
            peak = float(size.idxmax("frequency"))
            said.append(f"{name} at most {float(size.max()):.3g}{unit}, at {peak:.4g} Hz")
    return "; ".join(said)


def compared(runs: xr.Dataset) -> xr.Dataset:
    """Means over the stretches of each level that were read and predicted, and that are steady under a signal.

    Returns
    -------
    xarray.Dataset
        On ``level``: ``count``, ``low`` and ``high`` (Gamma), and the means of the four variables.
    """
    import xarray as xr

    names = ("window_frequency", "predicted_frequency", "window_damping_ratio", "predicted_damping_ratio")
    driven = "applied_force" in runs or "base_acceleration" in runs
    kept = (runs["window_steady"] == 1) | (not driven)
    for name in names:
        kept = kept & runs[name].notnull()
    over = ("seed", "window")
    gamma = runs["window_gamma"].where(kept)
    means = {name: runs[name].where(kept).mean(over) for name in names}
    return xr.Dataset({"count": kept.sum(over), "low": gamma.min(over), "high": gamma.max(over), **means})


def _beside(runs: xr.Dataset) -> list[str]:
    """What was read beside what was predicted, a sentence for each level."""
    if "predicted_frequency" not in runs:
        return []
    lines, both = [], compared(runs)
    for level in both["level"].values:
        one = both.sel(level=level)
        if not int(one["count"]):
            lines.append(f"level {float(level):g}: nothing that was read lies where the cards predict")
            continue
        read, told = (100 * float(one[f"{name}_damping_ratio"]) for name in ("window", "predicted"))
        at, expected = (float(one[f"{name}_frequency"]) for name in ("window", "predicted"))
        lines.append(
            f"level {float(level):g}: at Gamma {float(one['low']):.3g} to {float(one['high']):.3g} damping "
            f"{read:.3g} %, predicted {told:.3g} %; {at:.5g} Hz, predicted {expected:.5g} Hz "
            f"({int(one['count'])} stretches)"
        )
    return lines
