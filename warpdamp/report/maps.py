"""Figures of sweeps: maps over frequency and Gamma, and scattered cases."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.optimum import collision_optimum, optimum
from ..analysis.regimes import Regime, regime
from ..analysis.results import over_packings
from .figures import grid, named, panels

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def _maps(value: xr.DataArray, **style):
    """A map over frequency and Gamma for each combination of the other scalars: figure, axes by panel, last image."""
    chosen = panels(value, [dim for dim in value.dims if dim not in ("frequency", "gamma")])
    figure, axes = grid(len(chosen), width=5.4 if len(chosen) == 1 else 3.8, height=4.2 if len(chosen) == 1 else 3.1)
    frequency = value["frequency"].values
    for ax, panel in zip(axes, chosen, strict=True):
        image = ax.pcolormesh(
            frequency, value["gamma"], value.isel(panel).transpose("gamma", "frequency"), shading="nearest", **style
        )
        ax.set_title(named(value, panel), fontsize=9)
        _frequency_axis(ax, frequency)
    axes[0].set_ylabel("Γ [-]")
    return figure, list(zip(axes, chosen, strict=True)), image


def phase_map(dataset: xr.Dataset) -> Figure:
    """Map of effectiveness over frequency and Gamma, mean over seeds, one panel a combination of the other scalars.

    Dashed: eq. 1 with the clearance measured.  Dotted: the same with gravity along the axis.  Points with error bars:
    the optima found, of fluidisation (circles) and of two-sided collision (squares).
    """
    value, _ = over_packings(dataset, "effectiveness")
    optima = optimum(dataset)
    top = float(np.nanmax(value)) if np.isfinite(value).any() else 1.0
    figure, drawn, image = _maps(value, vmin=0, vmax=top, cmap="viridis")
    for ax, panel in drawn:
        _lines(ax, dataset, panel)
        for name, marker in (("fluidisation", "o"), ("collision", "s")):
            curve = optima.isel({dim: k for dim, k in panel.items() if dim in optima.dims})
            ax.errorbar(
                dataset["frequency"], curve[f"gamma_{name}"], curve[f"gamma_{name}_standard_error"], fmt=marker, ms=4,
                lw=0.8, mfc="none", color="white", label=f"optimum of {name}",
            )  # fmt: skip
        ax.set_ylim(float(dataset["gamma"].min()), float(dataset["gamma"].max()))
    axes = [ax for ax, _ in drawn]
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=7, loc="outside lower center", ncols=2, facecolor="0.4", labelcolor="white")
    figure.colorbar(image, ax=axes, label="effectiveness [-]")
    figure.suptitle(dataset.attrs.get("title", ""), fontsize=11)
    return figure


def regime_map(dataset: xr.Dataset) -> Figure:
    """Map of regimes of motion over frequency and Gamma, one panel a combination of the other scalars.

    Of several seeds the first is shown: labels have no mean.
    """
    from matplotlib.colors import BoundaryNorm, ListedColormap

    label = regime(dataset)
    label = label.isel(seed=0) if "seed" in label.dims else label
    kinds = list(Regime)
    colours = ListedColormap([{"UNKNOWN": "white"}.get(kind.name, f"C{kind.value}") for kind in kinds])
    norm = BoundaryNorm(np.arange(len(kinds) + 1) - 0.5, len(kinds))
    figure, drawn, image = _maps(label, norm=norm, cmap=colours)
    bar = figure.colorbar(image, ax=[ax for ax, _ in drawn], ticks=[kind.value for kind in kinds])
    bar.ax.set_yticklabels([kind.name.lower().replace("_", " ") for kind in kinds])
    figure.suptitle(dataset.attrs.get("title", ""), fontsize=11)
    return figure


def _frequency_axis(ax, frequency: np.ndarray) -> None:
    """Logarithmic where the frequencies are spaced so."""
    ratios = frequency[1:] / frequency[:-1]
    if len(ratios) > 1 and np.ptp(ratios) < 0.01 * ratios.mean():
        ax.set_xscale("log")
        ticks = [t for t in (20, 30, 50, 100, 200, 300, 500, 1000) if frequency[0] <= t <= frequency[-1]]
        ax.set_xticks(ticks, [f"{t}" for t in ticks])
        ax.minorticks_off()
    ax.set_xlabel("excitation frequency [Hz]")


def _lines(ax, dataset, panel) -> None:
    clearance = dataset["clearance"].isel({d: k for d, k in panel.items() if d in dataset["clearance"].dims})
    clearance = float(clearance.mean()) if np.isfinite(clearance).any() else math.nan
    if not math.isfinite(clearance):
        return
    frequency = np.linspace(float(dataset["frequency"].min()), float(dataset["frequency"].max()), 300)
    zero, axial = collision_optimum(frequency, clearance, gravity=False), collision_optimum(frequency, clearance)
    ax.plot(frequency, zero, "w--", lw=1, label=f"eq. 1, clearance {1e3 * clearance:.2f} mm")
    ax.plot(frequency, axial, "w:", lw=1.2, label="the same under gravity")


def scattered(dataset: xr.Dataset) -> Figure:
    """Figure of effectiveness against each of the scalars that change together; colour: Gamma, where it is one."""
    value, _ = over_packings(dataset, "effectiveness")
    names = [
        name for name, c in dataset.coords.items() if c.dims == ("case",) and name != "case" and c.dtype.kind in "iuf"
    ]
    figure, axes = grid(max(1, len(names)))
    for ax, name in zip(axes, names or ["case"], strict=True):
        x, y, gamma = np.broadcast_arrays(*(a.values for a in _aligned(dataset[name], value, dataset["gamma"])))
        points = ax.scatter(x.ravel(), y.ravel(), c=gamma.ravel(), s=12, cmap="viridis")
        ax.set_xlabel(f"{dataset[name].attrs.get('long_name', name)} [{dataset[name].attrs.get('units', '-')}]")
        ax.grid(alpha=0.3)
    axes[0].set_ylabel("effectiveness [-]")
    figure.colorbar(points, ax=list(axes), label="Γ [-]")
    figure.suptitle(dataset.attrs.get("title", ""), fontsize=11)
    return figure


def _aligned(*arrays):
    import xarray as xr

    return xr.broadcast(*arrays)
