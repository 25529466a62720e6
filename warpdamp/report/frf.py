"""Figures of frequency responses, and of modal properties over Gamma, from Datasets alone."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

LABEL = "accelerance [m s$^{-2}$ N$^{-1}$]"
WINDOW = 5.0
"""Half-widths of the broadest resonance shown on each side of a mode."""


def families(frf: xr.Dataset) -> Figure:
    """Figure of the accelerance at controlled Gamma, one panel a mode, lines coloured by Gamma."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    modes = frf.sizes["mode"]
    figure = Figure(figsize=(3.6 * modes + 1.0, 3.4), layout="constrained", dpi=150)
    axes = figure.subplots(1, modes, squeeze=False)[0]
    gamma = frf["gamma"].values
    colours = ScalarMappable(Normalize(gamma.min(), gamma.max()), colormaps["viridis"])
    size = np.hypot(frf["accelerance_real"], frf["accelerance_imaginary"])
    for k, ax in enumerate(axes):
        mode = frf.isel(mode=k)
        low, high = _window(mode["resonance_frequency"].values, mode["resonance_damping_ratio"].values)
        shown = size.sel(frequency=slice(low, high))
        for curve, value in zip(shown.transpose("gamma", "frequency").values, gamma, strict=True):
            ax.semilogy(shown["frequency"], curve, color=colours.to_rgba(value), lw=1)
        ax.set_xlim(low, high)
        ax.set_title(f"mode {int(frf['mode'][k])}", fontsize=10)
        _dress(ax, "frequency [Hz]")
    axes[0].set_ylabel(LABEL)
    figure.colorbar(colours, ax=list(axes), label="Γ [-]")
    figure.suptitle(frf.attrs.get("title", ""), fontsize=11)
    return figure


def force_curves(*responses: xr.Dataset) -> Figure:
    """Figure of the response at constant force, one panel a Dataset, lines coloured by the force.

    Dashed where unstable, thin where Gamma lies outside the range of the damper's results.
    """
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.8 * len(responses) + 0.4, 3.6), layout="constrained", dpi=150)
    axes = figure.subplots(1, len(responses), squeeze=False)[0]
    for ax, response in zip(axes, responses, strict=True):
        forces = np.unique(response["force"])
        colours = colormaps["plasma"](np.linspace(0, 0.85, len(forces)))
        for force, colour in zip(forces, colours, strict=True):
            of_force = response.isel(point=response["force"].values == force)
            label = f"{force:g} N"
            for number in np.unique(of_force["branch"]):
                branch = of_force.isel(point=of_force["branch"].values == number)
                _branch(ax, branch, colour, label)
                label = None
        _dress(ax, "frequency [Hz]")
        ax.set_yscale("log")
        ax.legend(fontsize=7)
    axes[0].set_ylabel("Γ of the response [-]")
    figure.suptitle(responses[0].attrs.get("title", ""), fontsize=11)
    return figure


def _branch(ax, branch, colour, label) -> None:
    f, level = branch["excitation_frequency"].values, branch["response_gamma"].values
    stable, known = branch["stable"].values.astype(bool), branch["within_range"].values.astype(bool)
    kind = 2 * stable + known
    cuts = np.concatenate([[0], np.flatnonzero(np.diff(kind)) + 1, [len(f) - 1]])
    for first, last in itertools.pairwise(cuts):
        piece = slice(first, last + 1)
        style = "-" if stable[first] else "--"
        ax.plot(f[piece], level[piece], style, color=colour, lw=1.3 if known[first] else 0.5, label=label)
        label = None


def against_gamma(corrected: xr.Dataset, fitted: xr.Dataset | None = None) -> Figure:
    """Figure of every mode's natural frequency and damping ratio over Gamma: corrected, not, and fitted to FRFs."""
    from matplotlib.figure import Figure

    modes = corrected.sizes["mode"]
    figure = Figure(figsize=(3.6 * modes + 0.4, 5.6), layout="constrained", dpi=150)
    rows = figure.subplots(2, modes, squeeze=False, sharex=True)
    gamma = corrected["gamma"].values
    for k in range(modes):
        mode = corrected.isel(mode=k)
        frequency, damping = rows[:, k]
        error = mode["corrected_natural_frequency_standard_error"]
        frequency.errorbar(gamma, mode["corrected_natural_frequency"], error, color="C0", capsize=2, lw=1, marker=".")
        frequency.axhline(float(mode["natural_frequency"]), color="C1", ls=":", label="particles as a rigid mass")
        frequency.axhline(float(mode["empty_natural_frequency"]), color="0.5", ls="--", label="no particles")
        error = mode["damping_ratio_standard_error"]
        damping.errorbar(gamma, mode["damping_ratio"], error, color="C1", ls=":", capsize=2, lw=1, label="by energy")
        damping.plot(gamma, mode["corrected_damping_ratio"], "C0.-", lw=1, label="by energy, corrected")
        if fitted is not None:
            _fitted(frequency, damping, fitted.sel(mode=mode["mode"]))
        frequency.set_title(f"mode {int(mode['mode'])}", fontsize=10)
        damping.set_ylim(bottom=0)
        _dress(damping, "Γ [-]")
        frequency.grid(alpha=0.3)
    rows[0, 0].set_ylabel("natural frequency [Hz]")
    rows[1, 0].set_ylabel("damping ratio [-]")
    rows[0, 0].legend(fontsize=7)
    rows[1, 0].legend(fontsize=7)
    figure.suptitle(corrected.attrs.get("title", ""), fontsize=11)
    return figure


def fitted_curves(fitted: xr.Dataset) -> Figure:
    """Figure of every mode's frequency and damping over Gamma, as fitted to FRFs by every method."""
    from matplotlib.figure import Figure

    modes = fitted.sizes["mode"]
    figure = Figure(figsize=(3.6 * modes + 0.4, 5.6), layout="constrained", dpi=150)
    rows = figure.subplots(2, modes, squeeze=False, sharex=True)
    for k in range(modes):
        _fitted(*rows[:, k], fitted.isel(mode=k))
        rows[0, k].set_title(f"mode {int(fitted['mode'][k])}", fontsize=10)
        rows[1, k].set_ylim(bottom=0)
        _dress(rows[1, k], "Γ [-]")
        rows[0, k].grid(alpha=0.3)
    rows[0, 0].set_ylabel("natural frequency [Hz]")
    rows[1, 0].set_ylabel("damping ratio [-]")
    rows[0, 0].legend(fontsize=7)
    figure.suptitle(fitted.attrs.get("title", ""), fontsize=11)
    return figure


def _fitted(frequency, damping, fitted) -> None:
    """Hollow marks, one kind a method."""
    for marker, method in zip("^sDo", fitted["fit"].values, strict=True):
        fit = fitted.sel(fit=method)
        style = {"marker": marker, "ls": "", "ms": 4, "mfc": "none", "mew": 0.8, "label": f"fit: {method}"}
        frequency.plot(fit["gamma"], fit["fitted_frequency"], **style)
        damping.plot(fit["gamma"], fit["fitted_damping_ratio"], **style)


def _window(frequency, damping) -> tuple[float, float]:
    reach = WINDOW * float(np.max(damping * frequency))
    return float(np.min(frequency)) - reach, float(np.max(frequency)) + reach


def _dress(ax, label) -> None:
    ax.set_xlabel(label)
    ax.grid(alpha=0.3)
