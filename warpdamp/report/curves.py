"""Figures of a results Dataset."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.results import over_packings, worst_status
from .figures import grid, named, panels
from .maps import phase_map, scattered

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


MOST_LINES = 8
MANY = 6
"""Frequencies and amplitudes from which a map says more than curves."""


def draw(dataset: xr.Dataset) -> Figure:
    """Figure that suits the dimensions of a Dataset: curves over Gamma, maps, or scattered cases.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If no case is finished.
    """
    if "effectiveness" not in dataset or not np.isfinite(dataset["effectiveness"]).any():
        raise ValueError("no case is finished yet: there is nothing to draw")
    if "gamma" not in dataset.dims or (dataset.sizes["gamma"] == 1 and "case" in dataset.dims):
        return scattered(dataset)
    over_map = {"frequency", "gamma"} <= set(dataset.dims) and "damping_ratio" not in dataset
    if over_map and min(dataset.sizes["frequency"], dataset.sizes["gamma"]) >= MANY:
        return phase_map(dataset)
    return curves(dataset)


def curves(dataset: xr.Dataset) -> Figure:
    """Figure of damping ratio against Gamma, one panel a mode, or of effectiveness, one panel a frequency.

    Error bars are standard errors, hollow points not steady (see ``status``); swept scalars become lines, and where
    there are too many of them, further panels.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results with the dimension ``gamma``.

    Returns
    -------
    matplotlib.figure.Figure
    """
    modal = "damping_ratio" in dataset
    if modal:
        value, error = dataset["damping_ratio"], dataset["damping_ratio_standard_error"]
        first, label = "mode", "damping ratio [-]"
    else:
        value, error = over_packings(dataset, "effectiveness")
        first, label = "frequency", "effectiveness [-]"
    status = worst_status(dataset)
    swept = [dim for dim in value.dims if dim not in (first, "gamma")]
    lines: list[str] = []
    while swept and value.sizes[swept[-1]] * math.prod(value.sizes[d] for d in lines) <= MOST_LINES:
        lines.insert(0, swept.pop())
    if swept and not lines:  # one dimension of many values: some of them
        lines = [swept.pop()]
    outer = [dim for dim in (first, *swept) if dim in value.dims]

    chosen = panels(value, outer)
    figure, axes = grid(len(chosen))
    for ax, panel in zip(axes, chosen, strict=True):
        for choice in panels(value, lines, MOST_LINES):
            at = panel | choice
            case = {"frequency" if name == "mode" else name: k for name, k in at.items()}
            _curve(ax, dataset["gamma"], value.isel(at), error.isel(at), status.isel(case) > 0, named(value, choice))
        ax.set_title(_title(dataset, value, panel), fontsize=10)
        ax.set_xlabel("Γ [-]")
        ax.set_ylim(bottom=0)
        ax.grid(alpha=0.3)
    axes[0].set_ylabel(label)
    if lines:
        axes[0].legend(fontsize=7)
    bed = f" ({dataset['preparation'].item()} bed)" if dataset["preparation"].ndim == 0 else ""
    figure.suptitle(f"{dataset.attrs.get('title', '')}{bed}", fontsize=11)
    return figure


def _curve(ax, gamma, value, error, unsteady, name: str) -> None:
    bar = ax.errorbar(gamma, value, error, marker="o", ms=4, lw=1, capsize=2, label=name or None)
    colour = bar.lines[0].get_color()
    ax.plot(gamma[unsteady], value[unsteady], "o", ms=3, mfc="white", mec=colour, zorder=3)


def _title(dataset, value, panel) -> str:
    rest = {dim: k for dim, k in panel.items() if dim not in ("frequency", "mode")}
    words = [named(value, rest)] if rest else []
    if "frequency" in panel:
        words.insert(0, f"{float(dataset['frequency'][panel['frequency']]):.4g} Hz")
    if "mode" in panel:
        natural_frequency = dataset["natural_frequency"].isel(mode=panel["mode"])
        natural_frequency = natural_frequency.isel({dim: rest.get(dim, 0) for dim in natural_frequency.dims})
        words.insert(0, f"mode {int(dataset['mode'][panel['mode']])}, {float(natural_frequency):.1f} Hz")
    return ", ".join(words)
