"""Content of a report: what its page shows of a results Dataset, as numbers and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..analysis.regimes import Regime, regime
from ..analysis.results import over_packings, worst_status
from ..errors import UsageError
from ..kernels.columns import EVERY_LOSS
from ..status import Status
from ..variables import VARIABLES
from .calculator import interval_of
from .figures import shown
from .offline import packed
from .tables import summary

if TYPE_CHECKING:
    import xarray as xr

    from ..modes import Modes

CHARTED = {
    "damping_ratio": (100.0, "%"),
    "effectiveness": (1.0, "-"),
    "energy_mean": (1e3, "mJ"),
    "normalised_damping": (1.0, "-"),
    "apparent_mass": (1e3, "g"),
    "quadrature_mass": (1e3, "g"),
    "floor_impulse": (1e3, "mN s"),
    "lid_impulse": (1e3, "mN s"),
    "cycle_displacement": (1e3, "mm"),
    "ledger_residual": (100.0, "%"),
    "largest_overlap": (100.0, "%"),
}
"""Variables that are drawn over the swept scalars: factor from SI, and unit."""

NAMES = {
    "damping_ratio": "damping ratio",
    "effectiveness": "effectiveness",
    "energy_mean": "energy per cycle",
    "normalised_damping": "normalised damping",
    "apparent_mass": "apparent mass",
    "quadrature_mass": "mass in quadrature",
    "floor_impulse": "impulse of the floor per cycle",
    "lid_impulse": "impulse of the lid per cycle",
    "cycle_displacement": "displacement over a cycle",
    "ledger_residual": "energy not accounted for",
    "largest_overlap": "largest overlap over the reduced radius",
    "clearance": "clearance",
    "packing_fraction": "packing fraction",
}

BED = {"clearance": (1e3, "mm"), "packing_fraction": (1.0, "-")}
"""Variables of the bed's state, before and after a case."""

MOST_POINTS = 40_000
"""Points of a study, packings not counted, that a page can hold within its size."""

MOST_SHAPE_POINTS = 2000

NEEDED = ("effectiveness", "effectiveness_standard_error", "status", "particle_mass")


def content(dataset: xr.Dataset, modes: Modes | None) -> dict:
    """What a page shows of results.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results.
    modes : Modes or None
        Of the structure with the particles.

    Raises
    ------
    UsageError
        If the Dataset is no run's results, no case is finished, or there are too many for one page.
    """
    if missing := [name for name in NEEDED if name not in dataset]:
        raise UsageError(f"these are not the results of a whole run: there is no {missing[0]}")
    if not np.isfinite(dataset["effectiveness"]).any():
        raise UsageError("no case is finished yet: there is nothing to report")
    mean, _ = over_packings(dataset, "effectiveness")
    if mean.size > MOST_POINTS:
        raise UsageError(f"a page holds {MOST_POINTS} points, and these results have {mean.size}: take a part of them")
    arrays: dict = {}
    return {
        "title": dataset.attrs.get("title") or "Granular damper",
        "dims": {str(dim): int(size) for dim, size in mean.sizes.items()},
        "coordinates": _coordinates(dataset, mean),
        "variables": _variables(dataset, mean, arrays),
        "bed": _bed(dataset, mean, arrays),
        "losses": _losses(dataset, mean, arrays),
        "regimes": _regimes(dataset, mean, arrays),
        "statuses": _statuses(dataset, mean, arrays),
        "modes": _shapes(modes),
        "calculator": _calculator(dataset, arrays),
        "packed": packed(arrays),
    }


def _coordinates(dataset: xr.Dataset, mean: xr.DataArray) -> list[dict]:
    """Coordinates of the points, each along one dimension; a dimension without one is numbered."""
    found = []
    for name, values in dataset.coords.items():
        if len(values.dims) == 1 and values.dims[0] in mean.dims:
            numeric = values.dtype.kind in "iuf"
            unit = values.attrs.get("units", "1")
            found.append(
                {
                    "name": str(name),
                    "dim": str(values.dims[0]),
                    "label": _label(str(name), values.attrs.get("long_name"), unit),
                    "numeric": numeric,
                    "values": values.values.astype(float) if numeric else [str(v) for v in values.values],
                    "names": _names(dataset, str(name), values),
                }
            )
    for dim in mean.dims:
        if not any(c["dim"] == dim for c in found):
            numbers = np.arange(mean.sizes[dim])
            one = {"name": str(dim), "dim": str(dim), "label": str(dim), "numeric": True, "values": numbers}
            found.append(one | {"names": [str(k) for k in numbers]})
    return found


def _label(name: str, long_name: str | None, unit: str) -> str:
    if name == "gamma":
        return "Γ [-]"
    return f"{long_name or name} [{'-' if unit == '1' else unit}]" if long_name or unit != "1" else name


def _names(dataset: xr.Dataset, name: str, values) -> list[str]:
    """Values of a coordinate as text; a frequency of modes by the mode's number, too."""
    texts = [shown(value) for value in values.values]
    if name != "frequency" or "mode" not in dataset.dims:
        return [f"{text} Hz" for text in texts] if name == "frequency" else texts
    own = dataset["natural_frequency"]
    modes = [f"mode {int(number)}" for number in dataset["mode"].values]
    if own.ndim > 1:  # it changes with the swept scalars
        return modes
    return [f"{mode}, {float(f):.4g} Hz" for mode, f in zip(modes, own.values, strict=True)]


def _on_points(array: xr.DataArray, mean: xr.DataArray) -> xr.DataArray:
    """Array on the points' dimensions: modes stand for the frequencies that are theirs."""
    if "mode" in array.dims:
        array = array.drop_vars("mode", errors="ignore").rename(mode="frequency")
        array = array.drop_vars("frequency", errors="ignore").assign_coords(frequency=mean["frequency"])
    return array.transpose(*(dim for dim in mean.dims if dim in array.dims))


def _kept(arrays: dict, name: str, array: xr.DataArray, kind: str = "f4") -> dict:
    """Array put with those of the page; returns its name and dimensions."""
    arrays[name] = (kind, array.values)
    return {"array": name, "dims": [str(dim) for dim in array.dims]}


def _variables(dataset: xr.Dataset, mean: xr.DataArray, arrays: dict) -> dict:
    found = {}
    for name, (factor, unit) in CHARTED.items():
        if name not in dataset or not np.isfinite(dataset[name]).any():
            continue
        value, half = (_on_points(factor * array, mean) for array in interval_of(dataset, name))
        found[name] = {
            "name": NAMES[name],
            "label": f"{NAMES[name]} [{unit}]",
            "unit": unit,
            "about": VARIABLES[name][1],
            "value": _kept(arrays, name, value),
            "half": _kept(arrays, f"{name}_half", half),
        }
    return found


def _bed(dataset: xr.Dataset, mean: xr.DataArray, arrays: dict) -> list[dict]:
    found = []
    for name, (factor, unit) in BED.items():
        both = [each for each in (name, f"{name}_after") if each in dataset and np.isfinite(dataset[each]).any()]
        lines = [
            _kept(arrays, each, _on_points(factor * over_packings(dataset, each)[0], mean))
            | {"name": "after the case" if each.endswith("_after") else "before the case"}
            for each in both
        ]
        if lines:
            found.append({"label": f"{NAMES[name]} [{unit}]", "about": VARIABLES[name][1], "lines": lines})
    return found


def _losses(dataset: xr.Dataset, mean: xr.DataArray, arrays: dict) -> dict | None:
    """Energies lost by mechanism, and how well they add up to what is dissipated."""
    names = [name for name in EVERY_LOSS if f"{name}_loss" in dataset]
    parts = {name: _on_points(1e3 * over_packings(dataset, f"{name}_loss")[0], mean) for name in names}
    parts = {name: part for name, part in parts.items() if float(part.max()) > 0}
    if not parts:
        return None
    total = _on_points(1e3 * over_packings(dataset, "energy_dissipated")[0], mean)
    worst = float(np.nanmax(abs(sum(parts.values()) - total) / total.where(total > 0)))
    residual = float(np.nanmax(dataset["ledger_residual"]))
    return {
        "layers": [
            {"name": EVERY_LOSS[name].replace("particle ", "particles: ", 1).replace("wall ", "walls: ", 1)}
            | _kept(arrays, f"{name}_loss", part)
            for name, part in parts.items()
        ],
        "total": _kept(arrays, "energy_dissipated", total),
        "adds_up": worst,
        "residual": residual,
    }


MIXED = max(Regime) + 1
"""Stands for packings of a point that move in different ways."""


def _regimes(dataset: xr.Dataset, mean: xr.DataArray, arrays: dict) -> dict | None:
    try:
        each = regime(dataset)
    except ValueError:  # no indicators were recorded
        return None
    if "seed" in each.dims:
        same = each.max("seed") == each.min("seed")
        each = each.max("seed").where(same, MIXED)
    names = [r.name.lower().replace("_", " ") for r in Regime] + ["packings differ"]
    return {"names": names, **_kept(arrays, "regime", _on_points(each, mean), "u1")}


def _statuses(dataset: xr.Dataset, mean: xr.DataArray, arrays: dict) -> dict:
    status = worst_status(dataset)
    if "damper" in mean.dims:
        status = dataset["status"]
    names = {int(s): s.name.lower().replace("_", " ") for s in Status}
    return {"names": names, **_kept(arrays, "status", _on_points(status, mean), "i1")}


def _shapes(modes: Modes | None) -> list[dict]:
    """Mode shapes: curves along a line of points, or points seen along the direction in which they extend least."""
    if modes is None or len(modes.point) == 1:
        return []
    order = np.argsort(-np.ptp(modes.point, axis=0))
    extent = np.ptp(modes.point, axis=0)[order]
    line = extent[1] < 1e-6 * extent[0]
    across, up = (order[0], None) if line else sorted(order[:2])
    rows = np.unique(np.linspace(0, len(modes.point) - 1, MOST_SHAPE_POINTS).astype(int))
    rows = rows[np.argsort(modes.point[rows, across], kind="stable")]
    shapes = modes.shape @ np.asarray(modes.direction)
    return [
        {
            "name": f"mode {modes.number[k]}, {modes.frequency[k]:.4g} Hz",
            "across": f"{'xyz'[across]} [mm]",
            "up": None if line else f"{'xyz'[up]} [mm]",
            "x": 1e3 * modes.point[rows, across],
            "y": None if line else 1e3 * modes.point[rows, up],
            "shape": shapes[k, rows],
            "damper": [
                float(1e3 * modes.point[modes.damper, across]),
                None if line else float(1e3 * modes.point[modes.damper, up]),
                float(modes.amplitude[k]),
            ],
        }
        for k in range(len(modes.number))
    ]


def _calculator(dataset: xr.Dataset, arrays: dict) -> dict:
    """Numbers of the calculator, or why there is none; at a swept scalar's value for each of its combinations."""
    mean, _ = over_packings(dataset, "effectiveness")
    if not {"frequency", "gamma"} <= set(mean.dims):
        return {"why_not": "frequency and Γ are no grid in these results"}
    if "damper" in mean.dims:
        return {"why_not": "these are results of several dampers"}
    other = [dim for dim in mean.dims if dim not in ("frequency", "gamma")]
    value, half = interval_of(dataset, "effectiveness")
    value, half = (a.sortby(["frequency", "gamma"]).transpose(*other, "frequency", "gamma") for a in (value, half))
    mass = dataset["particle_mass"].transpose(*(d for d in other if d in dataset["particle_mass"].dims))
    return {
        "frequency": value["frequency"].values,
        "gamma": value["gamma"].values,
        "dims": [str(dim) for dim in value.dims],
        "value": _kept(arrays, "calculator", value, "f8"),
        "half": _kept(arrays, "calculator_half", half, "f8"),
        "mass": _kept(arrays, "particle_mass", mass, "f8"),
        "modes": _presets(dataset),
        "gamma_start": float(dataset["gamma"][int(mean.max([d for d in mean.dims if d != "gamma"]).argmax("gamma"))]),
    }


def _presets(dataset: xr.Dataset) -> list[dict]:
    """Modes of the study, whose numbers the calculator can take over; of a sweep those of its first values."""
    if "mode_amplitude" not in dataset:
        return []
    first = {dim: 0 for dim in dataset["mode_amplitude"].dims if dim != "mode"}
    own = dataset[["mode_amplitude", "natural_frequency"]].isel(first)
    run_at = dataset["frequency"].values if "frequency" in dataset.dims else own["natural_frequency"].values
    return [
        {
            "name": f"mode {int(own['mode'][k])}",
            "amplitude": abs(float(own["mode_amplitude"][k])),
            "frequency": float(f),
        }
        for k, f in enumerate(run_at)
    ]


def optima_table(dataset: xr.Dataset) -> dict:
    """The table that a run ends with: title, heads, rows of text, remark."""
    from rich.text import Text

    table = summary(dataset)
    heads = [Text.from_markup(str(column.header)).plain for column in table.columns]
    rows = list(zip(*(map(str, column.cells) for column in table.columns), strict=True))
    title = str(table.title or "the ten most effective cases")
    return {"title": title, "heads": heads, "rows": rows, "remark": str(table.caption or "")}


def question_and_answers(dataset: xr.Dataset) -> tuple[str, list[str]]:
    """What the study asks, and its answer in a sentence for each mode or frequency."""
    modal = "damping_ratio" in dataset
    name, dim = ("damping_ratio", "mode") if modal else ("effectiveness", "frequency")
    value, half = interval_of(dataset, name)
    question = (
        "How much damping does this damper give each mode, and at which amplitude the most?"
        if modal
        else "Where does this damper take the most energy out, as a part of what an ideal impact damper would?"
    )
    separate = dim in value.dims and value.sizes[dim] <= MOST_ANSWERS
    answers = []
    for k in range(value.sizes[dim]) if separate else [None]:
        own = {} if k is None else {dim: k}
        part, width = value.isel(own), half.isel(own)
        if not np.isfinite(part).any():
            answers.append(f"{_place(dataset, value, own, modal)}: no case is finished.")
            continue
        place = {str(d): int(i) for d, i in part.fillna(-np.inf).argmax([*part.dims]).items()} if part.ndim else {}
        best, interval = float(part.isel(place)), float(width.isel(place))
        factor, unit = (100.0, " %") if modal else (1.0, "")
        said = f"{factor * best:.3g}{unit}" + (f" ± {factor * interval:.2g}{unit}" if np.isfinite(interval) else "")
        where = _place(dataset, value, {d: i for d, i in (own | place).items() if d != "gamma"}, modal)
        at = f" at Γ {float(value['gamma'][place['gamma']]):g}" if "gamma" in place else ""
        edge = place.get("gamma") in (0, value.sizes.get("gamma", 0) - 1) and value.sizes.get("gamma", 0) > 1
        answers.append(f"{where}: {said}{at}{', the edge of what was run' if edge else ''}.")
    return question, answers


MOST_ANSWERS = 8


def _place(dataset: xr.Dataset, value: xr.DataArray, index: dict[str, int], modal: bool) -> str:
    """Where a point is, in words."""
    words = []
    for dim, k in index.items():
        if dim == "mode":
            natural = dataset["natural_frequency"]
            natural = float(natural.isel({d: index.get(str(d), 0) for d in natural.dims}))
            words.append(f"Mode {int(value['mode'][k])} ({natural:.4g} Hz)")
        elif dim == "frequency":
            words.append(f"{float(value['frequency'][k]):.4g} Hz")
        elif dim == "case":
            names = [n for n, c in value.coords.items() if c.dims == ("case",) and n != "case"]
            words += [f"{n} {shown(value[n].values[k])}" for n in names]
        else:
            words.append(f"{dim} {shown(value[dim].values[k]) if dim in value.coords else k}")
    return ", ".join(words) or f"Largest {'damping ratio' if modal else 'effectiveness'}"


def cost(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """What the study took, as named values."""
    found = [("cases run", f"{int((dataset['status'] >= 0).sum())} of {dataset['status'].size}")]
    if "cpu_time" in dataset and np.isfinite(dataset["cpu_time"]).any():
        spent = dataset["cpu_time"]
        found += [
            ("processor time of the cases", f"{float(spent.sum()):.4g} s, without that of their beds"),
            ("of a case, median and largest", f"{float(spent.median()):.3g} s, {float(spent.max()):.3g} s"),
        ]
    if "steps" in dataset:
        steps = dataset["steps"].where(dataset["steps"] > 0)
        found.append(("steps of a case, median and largest", f"{float(steps.median()):.4g}, {float(steps.max()):.4g}"))
    return found
