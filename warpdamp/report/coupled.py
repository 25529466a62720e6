"""Figures of coupled runs, from their Dataset alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..scene.scene import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

CURVES = {"accelerance": "accelerance [m s$^{-2}$ N$^{-1}$]", "transmissibility": "transmissibility [-]"}
"""What may be read off a signal with many frequencies, and how its axis is called."""


def answers(runs: xr.Dataset) -> Figure:
    """Figure of acceleration over time for each level (first seed, first damper), and of what is read off the records.

    That is damping and frequency over Gamma with one mode and a harmonic signal (steady windows) or a release, the
    accelerance with any other force, the transmissibility with any other motion of the base.
    """
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    curve = next((name for name in CURVES if f"{name}_real" in runs), None)
    panels = 3 if "window_gamma" in runs else 2 if curve else 1
    figure = Figure(figsize=(4.4 * panels, 3.6), layout="constrained", dpi=150)
    axes = figure.subplots(1, panels, squeeze=False)[0]
    colours = colormaps["viridis"](np.linspace(0, 0.85, runs.sizes["level"]))
    first = runs["structure_acceleration"].isel(seed=0) / STANDARD_GRAVITY
    first = first.isel(damper=0) if "damper" in first.dims else first
    for k in np.argsort(runs["level"].values)[::-1]:  # the largest behind
        axes[0].plot(runs["time"], first.isel(level=k), lw=0.5, color=colours[k], label=f"{float(runs['level'][k]):g}")
    axes[0].set(xlabel="time [s]", ylabel="acceleration / g [-]")
    if runs.sizes["level"] > 1:
        axes[0].legend(title="level", fontsize=7)
    if panels == 3:
        driven = "applied_force" in runs or "base_acceleration" in runs
        for ax, name, label in (
            (axes[1], "window_damping_ratio", "damping ratio [-]"),
            (axes[2], "window_frequency", "natural frequency [Hz]"),
        ):
            _predicted(ax, runs, name.replace("window", "predicted"))
            for k in range(runs.sizes["level"]):
                level_runs = runs.isel(level=k)
                shown = level_runs["window_steady"] == 1 if driven else level_runs[name].notnull()
                gamma, value = (level_runs[n].where(shown).values.ravel() for n in ("window_gamma", name))
                ax.plot(gamma, value, ".", ms=3, color=colours[k])
            ax.set(xlabel="Γ [-]", ylabel=label)
            _within_reason(ax, runs[name].values)
    elif panels == 2:
        size = np.hypot(runs[f"{curve}_real"], runs[f"{curve}_imaginary"])
        size = size if "level" in size.dims else size.expand_dims("level")
        for k in range(size.sizes["level"]):
            axes[1].semilogy(size["frequency"], size.isel(level=k), lw=0.8, color=colours[k])
        axes[1].set(xlabel="frequency [Hz]", ylabel=CURVES[curve])
    for ax in axes:
        ax.grid(alpha=0.3)
    figure.suptitle(runs.attrs.get("title", ""), fontsize=11)
    return figure


def _predicted(ax, runs: xr.Dataset, name: str) -> None:
    """Line of what the dampers' cards predict, where they were given."""
    if name not in runs:
        return
    gamma, value = runs["window_gamma"].values.ravel(), runs[name].values.ravel()
    known = np.isfinite(value)
    order = np.argsort(gamma[known])
    ax.plot(gamma[known][order], value[known][order], "k-", lw=0.8, label="predicted by the cards")
    ax.legend(fontsize=7)


def _within_reason(ax, values: np.ndarray) -> None:
    """Leave out the few readings of a dying motion that would flatten all others."""
    if not np.isfinite(values).any():
        return
    low, high = np.nanpercentile(values, [2, 98])
    margin = 0.1 * (high - low) or 0.1 * abs(high) or 1.0
    ax.set_ylim(low - margin, high + margin)
