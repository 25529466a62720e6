"""Figures of an accuracy study: error against cost, and the parts of the error."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..analysis.accuracy import Chance, averaged, chance, cheapest, step_errors, systematic, transient

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MARKERS = {"steps_per_contact": "o-", "stiffness": "s-", "precision": "D", "preparation": "^"}
LABELS = {
    "steps_per_contact": "step (steps per contact)",
    "stiffness": "modulus reduced",
    "precision": "float32",
    "preparation": "loose bed",
}
TOLERANCES = np.geomspace(0.003, 0.2, 40)
PARTS = ("step", "float32 instead of float64", "averaging", "packing")


def work_precision(runs: xr.Dataset) -> Figure:
    """Figure of relative error against core-seconds, log-log, a panel for each point, a line for each choice.

    Systematic choices at the cost of the point's own run with them; averages over cycles and packings at the cost of as
    many; the dashed front is the least cost of any combination.
    """
    from matplotlib.figure import Figure

    errors = systematic(runs)
    n = runs.sizes["point"]
    columns = min(n, 3)
    rows = -(-n // columns)
    figure = Figure(figsize=(4.2 * columns, 3.6 * rows + 0.6), layout="constrained", dpi=120)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for p in range(n):
        _panel(axes[p], runs.isel(point=p), errors.isel(point=p))
    for ax in axes[n:]:
        ax.set_visible(False)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    return figure


def _panel(ax, runs, errors):
    series = runs["effectiveness"].sel(variation="steps_per_contact=24").values
    length, seeds = int(np.isfinite(series[0]).sum()), runs.sizes["seed"]
    per_cycle = float(errors["cost"].sel(variation="steps_per_contact=24"))
    for choice, marker in MARKERS.items():
        picked = [v for v in errors["variation"].values if v.startswith(choice) and not v.endswith("=48")]
        part = errors.sel(variation=picked)
        ax.errorbar(
            part["cost"] * length * seeds,
            np.maximum(abs(part["error"]), 1e-5),
            part["error_standard_error"],
            fmt=marker,
            ms=4,
            lw=1,
            capsize=2,
            label=LABELS[choice],
        )
    counts = [k for k in (5, 10, 20, 40, 80, 160) if k <= length // 4]
    means = np.array(averaged(series, counts))
    if len(means):
        ax.plot(1.5 * means[:, 0] * per_cycle, means[:, 1], "v-", ms=4, lw=1, label="cycles averaged, one bed")
    cuts = [k for k in (0, 2, 5, 10, 20, 40, 80) if k < length // 3]
    ax.plot(
        [(k + length / 2) * per_cycle for k in cuts],
        [transient(series, k) for k in cuts],
        "<-",
        ms=4,
        lw=1,
        label="cycles discarded",
    )
    point = chance(series)
    many = 2 ** np.arange(0, 6)
    ax.plot(many * length * per_cycle, point.packing / np.sqrt(many), ">-", ms=4, lw=1, label="packings averaged")
    steps = step_errors(errors)
    front = [(best[3], t) for t in TOLERANCES if (best := cheapest(steps, point, t)) is not None]
    if front:
        ax.plot(*np.array(front).T, "k--", lw=1, label="cheapest combination")
    ax.set(xscale="log", yscale="log", xlabel="core-seconds", ylabel="relative error", ylim=(2e-4, 1))
    ax.set_title(f"{float(runs['frequency']):.4g} Hz, Γ {float(runs['gamma']):g}", fontsize=10)
    ax.grid(alpha=0.3)


def budget(runs: xr.Dataset) -> Figure:
    """Figure of the parts of a usual answer's error: 24 steps a contact, float64, 60 cycles averaged, three beds."""
    from matplotlib.figure import Figure

    parts = budget_table(runs)
    figure = Figure(figsize=(1.4 * runs.sizes["point"] + 2.5, 3.6), layout="constrained", dpi=120)
    ax = figure.subplots()
    width = 0.8 / len(PARTS)
    for k, name in enumerate(PARTS):
        ax.bar(np.arange(len(parts)) + (k - 1.5) * width, [100 * row[k] for row in parts], width, label=name)
    names = [f"{float(f):.4g} Hz\nΓ {float(g):g}" for f, g in zip(runs["frequency"], runs["gamma"], strict=True)]
    ax.set_xticks(range(len(parts)), names, fontsize=8)
    ax.set_ylabel("error of the mean [%]")
    ax.legend(fontsize=8)
    return figure


def budget_table(runs: xr.Dataset, *, cycles: int = 60, packings: int = 3) -> list[tuple[float, ...]]:
    """Relative errors of ``PARTS`` at every point [-]."""
    errors = systematic(runs)
    table = []
    for p in range(runs.sizes["point"]):
        series = runs["effectiveness"].isel(point=p)
        point: Chance = chance(series.sel(variation="steps_per_contact=24").values)
        at = errors.isel(point=p)
        table.append(
            (
                step_errors(at)[24.0][0],
                abs(float(at["error"].sel(variation="precision=float32"))),
                point.one_cycle / np.sqrt(cycles * packings),
                point.packing / np.sqrt(packings),
            )
        )
    return table
