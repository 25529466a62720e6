"""Measurement beside prediction: lines to read, and pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from ..modal.calibrate import Posterior
    from ..modal.measured import Measured

SHOWN = {"damping_ratio": ("damping ratio [%]", 100.0), "frequency": ("frequency [Hz]", 1.0)}


def comparison_lines(residuals: xr.Dataset) -> list[str]:
    """How far measured points lie from the prediction, over the joint standard errors."""
    found = []
    for name, (title, _) in SHOWN.items():
        if name not in residuals:
            continue
        z = residuals[f"{name}_residual"].values
        z = z[np.isfinite(z)]
        outside = residuals.sizes["point"] - len(z)
        if not len(z):
            found.append(f"{title}: no measured point lies within the Gammas that were run")
            continue
        difference = residuals[name] - residuals[f"predicted_{name}"]
        relative = float((difference / residuals[f"predicted_{name}"]).mean())
        found.append(
            f"{title}: {len(z)} points, {100 * relative:+.2g} % from the prediction on average; "
            f"residuals over joint errors: mean {z.mean():+.2g}, root mean square {np.sqrt(np.mean(z**2)):.2g}; "
            f"{np.mean(np.abs(z) <= 1.96):.0%} within the joint 95 % interval"
            + (f"; {outside} outside" if outside else "")
        )
        if not np.isfinite(residuals[f"{name}_standard_error"]).any():
            found.append("  the measurement states no errors: those of the prediction stand alone")
    return found


def calibration_lines(posterior: Posterior, measured: Measured) -> list[str]:
    """What the measurement says of the swept scalars, and how much of the difference their uncertainty explains."""
    used = np.isfinite(measured.values["damping_ratio"])
    value, error = (table["damping_ratio"][used] for table in (measured.values, measured.errors))
    found = ["posterior of the swept scalars, prior even over their ranges:"]
    for name, mean, spread, (low, high) in zip(
        posterior.names, posterior.mean, posterior.standard_deviation, posterior.interval(), strict=True
    ):
        found.append(f"  {name}: {mean:.3g} ± {spread:.2g} (95 %: {low:.3g} to {high:.3g})")
    after = np.sqrt(np.mean(((value - posterior.predicted) / np.hypot(error, posterior.spread)) ** 2))
    share = np.mean(posterior.before**2) / (np.mean(posterior.before**2) + np.mean(error**2))
    found.append(
        f"over their whole ranges the prediction varies by {100 * np.mean(posterior.before):.2g} % of damping, "
        f"{share:.0%} of the variance of both; residuals after calibration: root mean square {after:.2g}"
    )
    if posterior.effective_points < 100:
        found.append(f"the posterior is narrow: {posterior.effective_points:.0f} of its points count; narrow the sweep")
    return found


def overlay(dataset: xr.Dataset, residuals: xr.Dataset) -> Figure:
    """Measured points over the predicted curves, and the residuals below."""
    from matplotlib.figure import Figure

    names = [name for name in SHOWN if name in residuals]
    figure = Figure(figsize=(5.5 * len(names), 6), layout="constrained", dpi=110)
    axes = figure.subplots(2, len(names), squeeze=False, height_ratios=[3, 1], sharex=True)
    for (top, below), name in zip(axes.T, names, strict=True):
        title, factor = SHOWN[name]
        for mode in np.unique(residuals["mode"]):
            of = residuals["mode"].values == mode
            if name == "damping_ratio":
                curve = dataset["damping_ratio"].sel(mode=mode)
                error = dataset["damping_ratio_standard_error"].sel(mode=mode)
                (drawn,) = top.plot(curve["gamma"], factor * curve, label=f"predicted, mode {mode}")
                top.fill_between(
                    curve["gamma"], factor * (curve - 1.96 * error), factor * (curve + 1.96 * error), alpha=0.2
                )
                colour = drawn.get_color()
            else:
                gamma, predicted = residuals["gamma"].values[of], residuals[f"predicted_{name}"].values[of]
                (drawn,) = top.plot(gamma, factor * predicted, "--", label=f"predicted, mode {mode}")
                colour = drawn.get_color()
            gamma, values = residuals["gamma"].values[of], factor * residuals[name].values[of]
            error = factor * np.nan_to_num(residuals[f"{name}_standard_error"].values[of])
            top.errorbar(gamma, values, 1.96 * error, fmt="o", color=colour, capsize=2, label=f"measured, mode {mode}")
            below.plot(gamma, residuals[f"{name}_residual"].values[of], "o", color=colour)
        top.set(ylabel=title)
        below.set(xlabel="Γ", ylabel="residual")
        below.axhspan(-1.96, 1.96, color="0.9", zorder=0)
        top.legend(fontsize=8)
        top.grid(alpha=0.3)
        below.grid(alpha=0.3)
    return figure


def posterior_overlay(posterior: Posterior, measured: Measured) -> Figure:
    """Measured points over the calibrated prediction, and the posterior of each scalar."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.2 * (1 + len(posterior.names)), 4), layout="constrained", dpi=110)
    first, *others = figure.subplots(1, 1 + len(posterior.names), squeeze=False)[0]
    used = np.isfinite(measured.values["damping_ratio"])
    gamma, order = measured.gamma[used], np.argsort(measured.gamma[used])
    value, error = (table["damping_ratio"][used] for table in (measured.values, measured.errors))
    first.errorbar(gamma, 100 * value, 196 * error, fmt="ko", capsize=2, label="measured")
    first.plot(gamma[order], 100 * posterior.predicted[order], "C0-", label="calibrated")
    low, high = (posterior.predicted + sign * 1.96 * posterior.before for sign in (-1, 1))
    first.fill_between(gamma[order], 100 * low[order], 100 * high[order], alpha=0.15, label="whole ranges, 95 %")
    first.set(xlabel="Γ", ylabel="damping ratio [%]")
    first.legend(fontsize=8)
    for ax, name, column in zip(others, posterior.names, posterior.points.T, strict=True):
        ax.hist(column, bins=40, weights=posterior.weights, density=True, color="C0", alpha=0.6)
        ax.set(xlabel=name, ylabel="posterior density")
    for ax in (first, *others):
        ax.grid(alpha=0.3)
    return figure
