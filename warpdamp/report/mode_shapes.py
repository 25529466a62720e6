"""Figures of mode shapes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import ModalError
from ..modes import Modes

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def shapes(modes: Modes, title: str = "") -> Figure:
    """Figure of displacement along the direction of the excitation, one panel a mode, the damper marked.

    A curve where the points lie on a line, as a beam's do; elsewhere the points, seen along the direction in which they
    extend least, in the colour of their displacement.

    Raises
    ------
    ModalError
        If the modes are known at one point only.
    """
    from matplotlib.figure import Figure

    if len(modes.point) == 1:
        raise ModalError("modes that are known at the damper only have no shape to draw")
    order = np.argsort(-np.ptp(modes.point, axis=0))
    extent = np.ptp(modes.point, axis=0)[order]
    draw = _curve if extent[1] < 1e-6 * extent[0] else _map
    n = len(modes.number)
    columns = min(n, 3)
    rows = -(-n // columns)
    figure = Figure(figsize=(3.4 * columns + 0.4, 2.4 * rows + 0.4), layout="constrained", dpi=150)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for k, ax in enumerate(axes):
        if k >= n:
            ax.set_visible(False)
            continue
        draw(ax, modes, k, order)
        ax.set_title(f"mode {modes.number[k]}, {modes.frequency[k]:.4g} Hz", fontsize=10)
    figure.suptitle(title, fontsize=11)
    return figure


def _curve(ax, modes: Modes, k: int, order) -> None:
    along = modes.point[:, order[0]]
    place = np.argsort(along)
    ax.plot(1e3 * along[place], (modes.shape[k] @ np.asarray(modes.direction))[place], lw=1.4)
    ax.plot(1e3 * along[modes.damper], modes.amplitude[k], "s", ms=6, color="C3", label="damper")
    ax.axhline(0, color="0.7", lw=0.8, zorder=0)
    ax.set_xlabel(f"{'xyz'[order[0]]} [mm]")
    ax.set_ylabel("φ [kg$^{-½}$]")


def _map(ax, modes: Modes, k: int, order) -> None:
    across, up = sorted(order[:2])
    place = 1e3 * modes.point
    value = modes.shape[k] @ np.asarray(modes.direction)
    most = np.max(np.abs(value))
    dots = ax.scatter(place[:, across], place[:, up], c=value, cmap="RdBu_r", vmin=-most, vmax=most, s=12)
    ax.plot(place[modes.damper, across], place[modes.damper, up], "s", ms=8, mfc="none", mec="k", label="damper")
    ax.figure.colorbar(dots, ax=ax, label="φ [kg$^{-½}$]")
    ax.set_aspect("equal")
    ax.set_xlabel(f"{'xyz'[across]} [mm]")
    ax.set_ylabel(f"{'xyz'[up]} [mm]")
