"""Pictures of a Dataset; knows nothing else."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def curves(dataset: xr.Dataset) -> Figure:
    """Damping ratio against Gamma, one panel a mode, or effectiveness, one panel a frequency.

    Error bars are standard errors, hollow points not steady (see ``status``); swept scalars become lines.
    """
    from matplotlib.figure import Figure

    modal = "damping_ratio" in dataset
    if modal:
        value, error = dataset["damping_ratio"], dataset["damping_ratio_standard_error"]
        panels, label = "mode", "damping ratio [-]"
    else:
        value = dataset["effectiveness"].mean("seed")
        error = np.sqrt((dataset["effectiveness_standard_error"] ** 2).sum("seed")) / dataset.sizes["seed"]
        panels, label = "frequency", "effectiveness [-]"
    swept = [dim for dim in value.dims if dim not in (panels, "gamma")]

    n = value.sizes[panels]
    columns = min(n, 4)
    rows = -(-n // columns)
    figure = Figure(figsize=(3.6 * columns + 0.4, 3.0 * rows + 0.4), layout="constrained", dpi=150)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for k, ax in enumerate(axes):
        if k >= n:
            ax.set_visible(False)
            continue
        panel = {panels: k}
        for choice in _choices(value, swept):
            at = panel | choice
            name = ", ".join(f"{dim} {value[dim].values[i]:g}" for dim, i in choice.items())
            bar = ax.errorbar(
                dataset["gamma"], value.isel(at), error.isel(at), marker="o", ms=4, lw=1, capsize=2, label=name or None
            )
            unsteady = dataset["status"].max("seed").isel({"frequency": k} | choice) > 0
            line = bar.lines[0]
            ax.plot(
                dataset["gamma"][unsteady],
                value.isel(at)[unsteady],
                "o",
                ms=3,
                mfc="white",
                mec=line.get_color(),
                zorder=3,
            )
        ax.set_title(_title(dataset, panels, k, swept), fontsize=10)
        ax.set_xlabel("Γ [-]")
        ax.set_ylim(bottom=0)
        ax.grid(alpha=0.3)
    axes[0].set_ylabel(label)
    if swept:
        axes[0].legend(fontsize=7)
    figure.suptitle(f"{dataset.attrs.get('title', '')} ({dataset['preparation'].item()} bed)", fontsize=11)
    return figure


def _choices(value, swept):
    for index in itertools.product(*(range(value.sizes[dim]) for dim in swept)):
        yield dict(zip(swept, index, strict=True))


def _title(dataset, panels, k, swept) -> str:
    if panels == "frequency":
        return f"{float(dataset['frequency'][k]):.4g} Hz"
    frequency = float(dataset["natural_frequency"].isel(mode=k, **{d: 0 for d in swept}))
    return f"mode {int(dataset['mode'][k])}, {frequency:.1f} Hz"


def save(figure: Figure, path: Path) -> None:
    """Write a picture whole or not at all, in the format of its suffix."""
    import os

    part = path.with_name(f".{path.name}.part")
    figure.savefig(part, format=path.suffix[1:])
    os.replace(part, path)
