"""Panels, labels and saving of figures."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..files import whole_file

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

PICTURES = (".png", ".pdf", ".svg")
"""Suffixes of pictures."""

MOST_PANELS = 12


Panel = dict[str, int]


def panels(value: xr.DataArray, dims: list[str], most: int = MOST_PANELS) -> list[Panel]:
    """Indices along some dimensions, one dict a panel, evenly thinned where there are more than ``most``."""
    sizes = [range(value.sizes[dim]) for dim in dims]
    choices = [dict(zip(dims, index, strict=True)) for index in itertools.product(*sizes)]
    if len(choices) <= most:
        return choices
    return [choices[k] for k in np.unique(np.linspace(0, len(choices) - 1, most).round().astype(int))]


def shown(value) -> str:
    """Coordinate value as the text of a label."""
    value = np.asarray(value)
    return f"{float(value):.3g}" if value.dtype.kind in "iuf" else str(value)


def named(value: xr.DataArray, panel: Panel) -> str:
    """Label of a panel: its coordinates and their values."""
    return ", ".join(f"{dim} {shown(value[dim].values[k])}" for dim, k in panel.items())


def grid(n: int, *, width: float = 3.8, height: float = 3.1):
    """Figure of ``n`` panels, and their axes."""
    from matplotlib.figure import Figure

    columns = min(n, 4)
    rows = -(-n // columns)
    figure = Figure(figsize=(width * columns + 0.6, height * rows + 0.5), layout="constrained", dpi=150)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in axes[n:]:
        ax.set_visible(False)
    return figure, axes[:n]


def save(figure: Figure, path: Path) -> None:
    """Write a figure whole or not at all, in the format of its suffix."""
    with whole_file(path) as part:
        figure.savefig(part, format=path.suffix[1:])
