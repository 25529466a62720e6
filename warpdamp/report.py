"""What a person reads in the terminal after a run."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .maps import panels, shown
from .optimum import peaks
from .packing import MOST_BLOCKS
from .plot import over_seeds
from .steady import Status

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table


def modes_table(modes) -> Table:
    """Number, frequency, shape at the damper and modal mass of each mode."""
    table = _table("mode", "f [Hz]", "phi [kg^-½]", "modal mass [kg]")
    for number, frequency, amplitude, mass in zip(
        modes.number, modes.frequency, modes.amplitude, modes.modal_mass, strict=True
    ):
        table.add_row(f"{number}", f"{frequency:.2f}", f"{amplitude:.4f}", f"{mass:.4f}")
    return table


MOST_ROWS = 40


def summary(dataset: xr.Dataset) -> Table:
    """Per mode or frequency, and swept value: f, phi and the peaks of the curve; without curves, the best cases."""
    if "gamma" not in dataset.dims or "effectiveness" not in dataset:
        return _best(dataset)
    modal = "damping_ratio" in dataset
    if modal:
        value, error, lines = dataset["damping_ratio"], dataset["damping_ratio_standard_error"], "mode"
    else:
        (value, error), lines = over_seeds(dataset, "effectiveness"), "frequency"
    status = dataset["status"].max("seed") if "seed" in dataset["status"].dims else dataset["status"]
    outer = [dim for dim in (lines, *value.dims) if dim in value.dims and dim != "gamma"]
    outer = list(dict.fromkeys(outer))
    swept = [dim for dim in outer if dim != lines]
    head = ("mode", "f [Hz]", "phi [kg^-½]") if modal else ("f [Hz]",) * (lines in outer)
    table = _table(*head, *swept, "peaks of the damping ratio" if modal else "peaks of the effectiveness")
    for at in panels(value, outer, MOST_ROWS):
        found = peaks(dataset["gamma"], value.isel(at), error.isel(at))
        case = status.isel({"frequency" if name == "mode" else name: k for name, k in at.items()})
        text = ", ".join(_peak(p, dataset["gamma"].values, case.sel(gamma=p.gamma)) for p in found)
        own = {name: shown(value[name].values[k]) for name, k in at.items() if name != lines}
        table.add_row(*_line_head(dataset, at), *own.values(), text or "-")
    if math.prod(value.sizes[dim] for dim in outer) > MOST_ROWS:
        table.caption = f"{MOST_ROWS} of {math.prod(value.sizes[dim] for dim in outer)} lines"
    return table


def _best(dataset: xr.Dataset) -> Table:
    """The ten cases of the highest effectiveness."""
    names = [str(name) for name in dataset.coords if name != "preparation" or dataset[name].ndim]
    table = _table(*names, "effectiveness")
    if "effectiveness" in dataset:
        value = dataset["effectiveness"]
        flat = value.stack(point=value.dims, create_index=False)
        for k in np.argsort(-flat.values)[:10]:
            if np.isfinite(flat.values[k]):
                own = {name: dataset[name] for name in names}
                at = {d: int(i) for d, i in zip(value.dims, np.unravel_index(k, value.shape), strict=True)}
                cells = (shown(c.isel({d: i for d, i in at.items() if d in c.dims}).values) for c in own.values())
                table.add_row(*cells, f"{flat.values[k]:.4g}")
    return table


def _peak(peak, gammas, status) -> str:
    """A peak in words; what may hide a higher one is said."""
    notes = []
    if peak.gamma in (gammas[0], gammas[-1]):
        notes.append("the edge of what was run")
    if status > 0:
        notes.append(Status(int(status)).name.lower().replace("_", " "))
    return f"{peak.height:.4g} ± {peak.standard_error:.1g} at Γ {peak.gamma:g}" + (
        f" ({', '.join(notes)})" if notes else ""
    )


def _line_head(dataset, at):
    if "mode" in at:
        own = dataset[["natural_frequency", "mode_amplitude"]]
        own = own.isel({name: k for name, k in at.items() if name in own.dims})
        mode = int(dataset["mode"][at["mode"]])
        return f"{mode}", f"{float(own['natural_frequency']):.2f}", f"{float(own['mode_amplitude']):.4f}"
    return (f"{float(dataset['frequency'][at['frequency']]):.2f}",) if "frequency" in at else ()


def verdicts(dataset: xr.Dataset) -> list[str]:
    """How the cases ended, worst first, in sentences; and how well the ledger closed."""
    status = dataset["status"].values
    lines = [
        f"{np.sum(status == s)} of {status.size} cases: {s.meaning}" for s in reversed(Status) if np.any(status == s)
    ]
    if "message" in dataset:
        said = sorted({text for text in dataset["message"].values.ravel() if text})
        lines += [f"  {text}" for text in said[:5]] + (
            [f"  and {len(said) - 5} other messages"] if len(said) > 5 else []
        )
    if "ledger_residual" not in dataset:
        return lines
    stopped = dataset["compaction_blocks"] >= MOST_BLOCKS
    if stopped.any():
        of_drive = [dim for dim in ("frequency", "gamma") if dim in stopped.dims]
        lines.append(f"{int(stopped.any(of_drive).sum())} beds were still compacting when their preparation ended")
    residual = dataset["ledger_residual"].values
    if np.isfinite(residual).any():
        lines.append(f"energy ledger: residual at most {100 * np.nanmax(residual):.2g} % of the dissipation")
    return lines


def _table(*columns) -> Table:
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD)
    for column in columns:
        table.add_column(escape(column))
    return table
