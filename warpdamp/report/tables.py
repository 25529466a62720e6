"""Tables and sentences for the terminal after a run."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.accuracy import chance, cheapest, step_errors, systematic
from ..analysis.optimum import MOTIONS, Curves
from ..analysis.results import worst_status
from ..numerics.regression import Maximum
from ..status import MORE_CYCLES, Status
from ..variables import NOT_RUN
from .figures import panels, shown

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table


def modes_table(modes) -> Table:
    """Table of modes: number, frequency, shape at the damper, modal mass and, if any, inherent damping.

    Of a user's mesh also the part by which it lifts the frequency, about.
    """
    damped = int(np.any(modes.inherent_damping > 0))
    meshed = int(modes.mesh_error is not None)
    table = _table(
        "mode", "f [Hz]", "phi [kg^-½]", "modal mass [kg]", *["inherent damping"] * damped, *["f high by"] * meshed
    )
    error = modes.mesh_error if meshed else 0 * modes.frequency
    for number, frequency, amplitude, mass, damping, high in zip(
        modes.number, modes.frequency, modes.amplitude, modes.modal_mass, modes.inherent_damping, error, strict=True
    ):
        own = [f"{100 * damping:.3g} %"] * damped + [f"{100 * high:.2g} %"] * meshed
        table.add_row(f"{number}", f"{frequency:.2f}", f"{amplitude:.4f}", f"{mass:.4f}", *own)
    table.caption = modes.remark or None
    return table


MOST_ROWS = 40


def summary(dataset: xr.Dataset) -> Table:
    """Table of the optima of each curve, by mode or frequency and swept value; without curves, the best cases."""
    if "gamma" not in dataset.dims or "effectiveness" not in dataset:
        return _best(dataset)
    of, lines = ("damping_ratio", "mode") if "damping_ratio" in dataset else ("effectiveness", "frequency")
    curves = Curves(dataset, of)
    outer = list(dict.fromkeys(dim for dim in (lines, *curves.dims) if dim in curves.dims))
    head = ("mode", "f [Hz]", "phi [kg^-½]") if lines == "mode" else ("f [Hz]",) * (lines in outer)
    swept = [dim for dim in outer if dim != lines]
    table = _table(*head, *swept, "fluidisation", "two-sided collision", "largest of the points run")
    table.title = f"optima of the {of.replace('_', ' ')}, ± standard errors"
    for at in panels(curves.mean, outer, MOST_ROWS):
        labels = (shown(curves.mean[name].values[k]) for name, k in at.items() if name != lines)
        optima = curves.optima(at)
        table.add_row(*_line_head(dataset, at), *labels, *(_optimum(optima[m]) for m in MOTIONS), _largest(curves, at))
    rows = math.prod(curves.mean.sizes[dim] for dim in outer)
    remarks = [f"{MOST_ROWS} of {rows} lines"] * (rows > MOST_ROWS)
    remarks += ["one packing: what another would give is not in the errors"] * (curves.packings == 1)
    table.caption = "; ".join(remarks) or None
    return table


def dampers_table(found: xr.Dataset) -> Table:
    """The largest damping of every mode and where it is, and what each of several dampers adds to it."""
    dampers = found.sizes["damper"]
    shares = [f"of damper {k}" for k in range(1, dampers + 1)] if dampers > 1 else []
    table = _table("mode", "f [Hz]", "Γ", "largest damping ratio", *shares)
    for mode in found["mode"].values:
        own = found.sel(mode=mode)
        ratio = own["damping_ratio"]
        head = f"{mode}", f"{float(own['natural_frequency']):.2f}"
        if bool(ratio.isnull().all()):
            table.add_row(*head, "-", "a damper is shaken outside its card at every Γ", *["-"] * len(shares))
            continue
        at = own.isel(gamma=int(ratio.fillna(-1).argmax("gamma")))
        parts = [f"{part:.4g}" for part in at["damper_share"].values] if shares else []
        whole = f"{float(at['damping_ratio']):.4g} ± {float(at['damping_ratio_standard_error']):.1g}"
        table.add_row(*head, f"{float(at['gamma']):g}", whole, *parts)
    return table


def _best(dataset: xr.Dataset) -> Table:
    """Table of the ten cases of highest effectiveness."""
    names = [str(name) for name in dataset.coords if name != "preparation" or dataset[name].ndim]
    table = _table(*names, "effectiveness")
    if "effectiveness" in dataset:
        value = dataset["effectiveness"]
        flat = value.stack(point=value.dims, create_index=False)
        for k in np.argsort(-flat.values)[:10]:
            if np.isfinite(flat.values[k]):
                coords = {name: dataset[name] for name in names}
                at = {d: int(i) for d, i in zip(value.dims, np.unravel_index(k, value.shape), strict=True)}
                cells = (shown(c.isel({d: i for d, i in at.items() if d in c.dims}).values) for c in coords.values())
                table.add_row(*cells, f"{flat.values[k]:.4g}")
    return table


def _optimum(optimum: Maximum | str) -> str:
    """Text of a maximum of the curve fitted, or of why there is none."""
    if isinstance(optimum, str):
        return f"none: {optimum}"
    gamma = f"{optimum.gamma:.3g} ± {optimum.gamma_standard_error:.1g}"
    return f"Γ {gamma}: {optimum.height:.4g} ± {optimum.height_standard_error:.1g}"


def _largest(curves: Curves, at: dict[str, int]) -> str:
    """Text of the largest point of a curve; what may hide a larger one is noted."""
    mean, claimed = curves.mean.isel(at), curves.claimed.isel(at)
    if not np.isfinite(mean).any():
        return "-"
    k = int(mean.fillna(-np.inf).argmax("gamma"))
    gamma, gammas = float(curves.gamma[k]), curves.gamma
    case = {"frequency" if name == "mode" else name: i for name, i in at.items()}
    status = int(worst_status(curves.dataset).isel(case | {"gamma": k}))
    notes = ["the edge of what was run"] * (gamma in (gammas.min(), gammas.max()))
    notes += [Status(status).name.lower().replace("_", " ")] * (status > 0)
    text = f"Γ {gamma:g}: {float(mean[k]):.4g} ± {float(claimed[k]):.1g}"
    return text + (f" ({', '.join(notes)})" if notes else "")


def _line_head(dataset, at):
    if "mode" in at:
        properties = dataset[["natural_frequency", "mode_amplitude"]]
        properties = properties.isel({name: k for name, k in at.items() if name in properties.dims})
        mode = int(dataset["mode"][at["mode"]])
        return f"{mode}", f"{float(properties['natural_frequency']):.2f}", f"{float(properties['mode_amplitude']):.4f}"
    return (f"{float(dataset['frequency'][at['frequency']]):.2f}",) if "frequency" in at else ()


def fits_table(fitted: xr.Dataset) -> Table:
    """Table of the fits of one FRF with errors, quality and band; of several FRFs a row a mode, without errors."""
    several = next((dim for dim in ("gamma", "frf") if dim in fitted.dims), None)
    table = _table("mode", "fit", "f [Hz]", "ζ [%]", "R²") if several is None else _compact(fitted, several)
    table.title = f"natural frequency and {fitted.attrs['damping']} damping ratio ζ [%]"
    for mode in fitted["mode"].values if several is None else ():
        at = fitted.sel(mode=mode)
        for name in fitted["fit"].values:
            row = at.sel(fit=name)
            frequency = _value(row["fitted_frequency"], row["fitted_frequency_standard_error"])
            ratio = _value(100 * row["fitted_damping_ratio"], 100 * row["fitted_damping_ratio_standard_error"])
            table.add_row(f"{mode}", f"{name}", frequency, ratio, f"{float(row['fitted_quality']):.4f}")
    if several is None:
        bands = [f"mode {mode} {_band(fitted.sel(mode=mode))}" for mode in fitted["mode"].values]
        table.caption = f"half-power bands: {'; '.join(bands)}"
    return table


def _compact(fitted: xr.Dataset, several: str) -> Table:
    methods = [str(name) for name in fitted["fit"].values]
    table = _table("mode", {"gamma": "Γ", "frf": "FRF"}[several], "f [Hz]", *methods, "R²")
    for mode, value in itertools.product(fitted["mode"].values, fitted[several].values):
        rows = [fitted.sel({"mode": mode, several: value, "fit": name}) for name in methods]
        best = next((row for row in reversed(rows) if np.isfinite(row["fitted_frequency"])), rows[-1])
        cells = [_value(100 * row["fitted_damping_ratio"], np.nan) for row in rows]
        own = f"{value:g}" if several == "gamma" else f"{value}"
        quality = _value(best["fitted_quality"], np.nan)
        table.add_row(f"{mode}", own, _value(best["fitted_frequency"], np.nan), *cells, quality)
    return table


def _band(at: xr.Dataset) -> str:
    if np.isnan(at["band_start"]):
        return "not fitted"
    return f"{float(at['band_start']):.4g} to {float(at['band_end']):.4g} Hz, {int(at['band_lines'])} lines"


def accuracy_table(runs: xr.Dataset) -> Table:
    """Table of an accuracy study: the cheapest settings for 10, 5, 2 and 1 % at every point, and their cost."""
    tolerances = (0.1, 0.05, 0.02, 0.01)
    table = _table("point", *(f"{100 * t:g} %" for t in tolerances))
    errors = systematic(runs)
    for p in range(runs.sizes["point"]):
        scatter = chance(runs["effectiveness"].isel(point=p).sel(variation="steps_per_contact=24").values)
        steps = step_errors(errors.isel(point=p))
        cells = []
        for tolerance in tolerances:
            best = cheapest(steps, scatter, tolerance)
            cells.append(
                "not reached"
                if best is None
                else f"{best[0]:g} steps, {best[1]} packings x {best[2]} cycles: {best[3]:.2g} core-s"
            )
        table.add_row(f"{float(runs['frequency'][p]):.4g} Hz, Γ {float(runs['gamma'][p]):g}", *cells)
    return table


def _value(value, error) -> str:
    """Text of a number, with its standard error if it has one."""
    if np.isnan(value):
        return "-"
    return f"{float(value):.5g}" + (f" ± {float(error):.1g}" if np.isfinite(error) else "")


def verdicts(dataset: xr.Dataset, *, quick: bool = False) -> list[str]:
    """Sentences on how the cases ended, worst first, and how well the ledger closed.

    ``quick``: of a first look, whose cycles are not those of the configuration.
    """
    remedy = "run without --quick" if quick else MORE_CYCLES
    status = dataset["status"].values
    ran = np.sum(status != NOT_RUN)
    ends = [s for s in reversed(Status) if s != NOT_RUN and np.any(status == s)]
    lines = [f"{np.sum(status == s)} of {ran} cases: {s.meaning.replace(MORE_CYCLES, remedy)}" for s in ends]
    if "within_tolerance" in dataset:
        within = dataset["within_tolerance"].values
        lines.append(
            f"{np.sum(within == 1)} of {np.sum(within != NOT_RUN)} points are within the tolerance, "
            f"with {_packings(dataset)}"
        )
    elif ran < status.size:
        lines.append(f"{status.size - ran} of {status.size} cases: {Status.NOT_RUN.meaning}")
    if "message" in dataset:
        messages = sorted({text for text in dataset["message"].values.ravel() if text})
        lines += [f"  {text}" for text in messages[:5]] + (
            [f"  and {len(messages) - 5} other messages"] if len(messages) > 5 else []
        )
    if "ledger_residual" not in dataset:
        return lines
    if "compaction_settled" in dataset and (stopped := dataset["compaction_settled"] == 0).any():
        of_drive = [dim for dim in ("frequency", "gamma") if dim in stopped.dims]
        count = int(stopped.any(of_drive).sum())
        beds, was = ("bed", "was") if count == 1 else ("beds", "were")
        lines.append(
            f"{count} {beds} {was} still compacting, or not in the state asked for, when the preparation ended"
        )
    residual = dataset["ledger_residual"].values
    if np.isfinite(residual).any():
        lines.append(f"energy ledger: residual at most {100 * np.nanmax(residual):.2g} % of the dissipation")
    return lines


def card_verdicts(part: xr.Dataset) -> list[str]:
    """Sentences on the points of a card whose worst case was not steady, worst first."""
    status = part["status"].values
    ends = [s for s in reversed(Status) if s > Status.STEADY and np.any(status == s)]
    return [f"{np.sum(status == s)} of {status.size} points of the card: {s.meaning}" for s in ends]


def _packings(dataset: xr.Dataset) -> str:
    fewest, most = int(dataset["packings"].min()), int(dataset["packings"].max())
    return f"{fewest} packings each" if fewest == most else f"{fewest} to {most} packings each"


def _table(*columns) -> Table:
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD)
    for column in columns:
        table.add_column(escape(column))
    return table
