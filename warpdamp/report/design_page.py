"""Report of a design as one page that opens offline."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .offline import as_json, page, write_page
from .report_page import MOST_BYTES, versions_of

if TYPE_CHECKING:
    import xarray as xr

SCRIPTS = ("chart.js", "design.js")

READABLE = {"m": (1e3, "mm"), "kg": (1e3, "g"), "1": (1.0, "")}
"""Factor and unit as shown, by the unit of a Dataset."""

OVER = {"gamma": ("Γ", ""), "force": ("a force at the damper of", " N"), "base": ("a base's acceleration of", " m/s²")}
"""Range of a target in words, and its unit."""

ROLES = {"front": "front (emulator)", "chosen": "the damper chosen", "runner-up": "runners-up (emulator)"}
"""Roles of designs, in the order in which they are drawn, and their names in the legend."""


def write_design_report(dataset: xr.Dataset, path: Path) -> None:
    """Write the report of a design as one HTML file, which loads nothing from anywhere.

    Parameters
    ----------
    dataset : xarray.Dataset
        Answer that ``warpdamp design`` wrote.
    path : Path

    Raises
    ------
    UsageError
        If the page would be larger than ``MOST_BYTES``.
    MissingLibrary
        If Jinja2 is not installed.
    """
    text = page(
        "design.html",
        SCRIPTS,
        "report",
        title=str(dataset.attrs["title"]),
        question=_question(dataset),
        answers=_answers(dataset),
        cost=_cost(dataset),
        damper=_damper(dataset),
        motion=f"Motion: {dataset.attrs['motion']}: {dataset.attrs['why']}.",
        packings=dataset.sizes["packing"],
        bound=_bound(dataset),
        yaml=dataset.attrs["configuration"],
        problem=dataset.attrs["problem"],
        versions=versions_of(dataset),
        effects="",
        data=as_json(_content(dataset)),
        **_curve_table(dataset),
        **_tolerance_table(dataset),
        **_design_table(dataset),
    )
    write_page(text, path, MOST_BYTES)


def _cost(dataset: xr.Dataset) -> str:
    cases, again = int(dataset["cases"]), int(dataset["attempts"])
    return f"{cases} cases; {again} design{'s' * (again > 1)} simulated again with fresh packings"


def _chosen(dataset: xr.Dataset) -> list[str]:
    """Names of the scalars that the design chose."""
    return [str(name) for name, column in dataset.data_vars.items() if "configuration_key" in column.attrs]


def _quantity(value, unit: str) -> str:
    """A value with its unit, in the one in which people write it."""
    if isinstance(value, str):
        return value
    factor, shown = READABLE.get(unit, (1.0, unit))
    return f"{factor * float(value):.4g} {shown}".rstrip()


def _percent(value) -> str:
    return f"{100 * float(value):.3g} %"


def _with_interval(dataset: xr.Dataset, k: int) -> str:
    """Least damping of a design, with its 95 % interval."""
    low, high = (100 * float(dataset[f"least_damping_{end}"][k]) for end in ("low", "high"))
    return f"{_percent(dataset['least_damping'][k])} ({low:.3g} to {high:.3g} %)"


def _probability(dataset: xr.Dataset) -> str:
    low, high = (float(dataset[f"target_probability_{end}"]) for end in ("low", "high"))
    without = f"{low:.3f} to {high:.3f} without any one of the {dataset.sizes['packing']} packings"
    return f"P = {float(dataset['target_probability']):.3f} ({without})"


def _range(dataset: xr.Dataset) -> str:
    words, unit = OVER[dataset.attrs["target_over"]]
    low, high = (f"{value:g}" for value in dataset.attrs["target_range"])
    numbers = [str(number) for number in dataset["mode"].values]
    modes = f"mode {numbers[0]}" if len(numbers) == 1 else f"modes {', '.join(numbers)}"
    return f"{modes} over {words} {low} to {high}{unit}"


def _question(dataset: xr.Dataset) -> str:
    if "target_damping" not in dataset:
        return f"Which damper has {dataset.attrs['goal']} in {_range(dataset)}?"
    wanted = f"damps {_range(dataset)} by at least {_percent(dataset['target_damping'])}"
    return f"Which damper {wanted}, with {dataset.attrs['goal']}?"


def _answers(dataset: xr.Dataset) -> list[str]:
    values = ", ".join(f"{name} {value}" for name, value in _values(dataset, 0))
    mass = _quantity(dataset["particle_mass"][0], "kg")
    found = [f"{values}; particles of {mass}.", f"Least damping over the range: {_with_interval(dataset, 0)}."]
    if "target_damping" in dataset and int(dataset["claimed"]):
        return [f"The target is met with {_probability(dataset)}.", *found]
    if "target_damping" in dataset:
        asked = f"{float(dataset['confidence']):g} was asked for"
        return [f"No claim: the best damper found meets the target with {_probability(dataset)}, and {asked}.", *found]
    return found


def _values(dataset: xr.Dataset, k: int) -> list[tuple[str, str]]:
    """Names and values of the scalars of a design."""
    columns = [dataset[name] for name in _chosen(dataset)]
    return [
        (column.attrs["long_name"], _quantity(column.values[k].item(), column.attrs["units"])) for column in columns
    ]


def _damper(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """The damper chosen, as named values."""
    rows = [*_values(dataset, 0), ("mass of the particles", _quantity(dataset["particle_mass"][0], "kg"))]
    rows.append(("least damping over the range (95 % interval)", _with_interval(dataset, 0)))
    rows.append(("force of the particles on the structure, at most", f"{float(dataset['force'][0]):.3g} N"))
    if "target_probability" in dataset:
        rows.append(("probability that the target is met", _probability(dataset)))
    return rows


def _bound(dataset: xr.Dataset) -> str:
    least = float(dataset["least_mass"])
    return f"No damper with less than {1e3 * least:.4g} g of particles does it (eqs 5-11)." if least else ""


def _curve_table(dataset: xr.Dataset) -> dict:
    """Damping of the damper chosen: Gammas of the modes may differ."""
    heads = ["Γ", *(f"mode {number}" for number in dataset["mode"].values)]
    shared = bool((dataset["gamma"] == dataset["gamma"][0]).all())
    rows = []
    for k in range(dataset.sizes["point"]):
        cells = []
        for mode in range(dataset.sizes["mode"]):
            mean, half, gamma = (
                float(dataset[name][mode, k]) for name in ("damping_ratio_mean", "damping_ratio_interval", "gamma")
            )
            at = "" if shared else f" at Γ {gamma:.3g}"
            cells.append(f"{100 * mean:.3g} ± {100 * half:.2g} %{at}")
        rows.append([f"{float(dataset['gamma'][0, k]):.3g}" if shared else f"{k + 1}", *cells])
    return {"curve_heads": heads if shared else ["point", *heads[1:]], "curve_rows": rows}


def _tolerance_table(dataset: xr.Dataset) -> dict:
    nothing = {"tolerances": [], "tolerance_heads": [], "tolerance_line": "", "left_out": ""}
    if "tolerance" not in dataset.dims:
        return nothing
    rows = []
    for k, name in enumerate(dataset["tolerance"].values):
        unit = str(dataset["tolerance_unit"].values[k])
        value, low, high, first, last = (
            _quantity(dataset[column][k], unit)
            for column in ("tolerance_value", "tolerance_low", "tolerance_high", "kept_low", "kept_high")
        )
        rows.append([name, value, f"{low} to {high}", f"{first} to {last}"])
    line = "With all of these anywhere in their ranges the target is met with P = "
    return {
        "tolerances": rows,
        "tolerance_heads": ["scalar", "value", "range tried", "the claim holds"],
        "tolerance_line": f"{line}{float(dataset['tolerance_probability']):.3f}.",
        "left_out": dataset.attrs.get("left_out", ""),
    }


def _design_table(dataset: xr.Dataset) -> dict:
    names = [dataset[name].attrs["long_name"] for name in _chosen(dataset)]
    probable = "target_damping" in dataset
    heads = ["design", *names, "particles", "least damping (95 % interval)", *["P"] * probable]
    rows = []
    for k, role in enumerate(dataset["role"].values):
        own = [value for _, value in _values(dataset, k)]
        mass, chance = _quantity(dataset["particle_mass"][k], "kg"), f"{float(dataset['probability'][k]):.3f}"
        rows.append([role, *own, mass, _with_interval(dataset, k), *[chance] * probable])
    return {"design_heads": heads, "designs": rows}


def _content(dataset: xr.Dataset) -> dict:
    """What the page draws; see ``page/design.js``."""
    percent = 100 * dataset[["damping_ratio", "damping_ratio_mean", "damping_ratio_interval"]]
    curves = [
        {
            "name": f"mode {number}, {float(dataset['natural_frequency'][k]):.4g} Hz",
            "gamma": dataset["gamma"].values[k],
            "mean": percent["damping_ratio_mean"].values[k],
            "half": percent["damping_ratio_interval"].values[k],
            "packings": percent["damping_ratio"].values[:, k],
        }
        for k, number in enumerate(dataset["mode"].values)
    ]
    role = dataset["role"].values
    groups = [{"name": name, "points": _points(dataset, np.flatnonzero(role == key))} for key, name in ROLES.items()]
    return {
        "curves": curves,
        "wanted": 100 * float(dataset["target_damping"]) if "target_damping" in dataset else None,
        "bound": 1e3 * float(dataset["least_mass"]) or None,
        "designs": [group for group in groups if group["points"]],
    }


def _points(dataset: xr.Dataset, rows: np.ndarray) -> list[dict]:
    """Designs as points of the chart of damping against mass."""
    return [
        {
            "x": 1e3 * float(dataset["particle_mass"][k]),
            "y": 100 * float(dataset["least_damping"][k]),
            "ends": [100 * float(dataset[f"least_damping_{end}"][k]) for end in ("low", "high")],
            "note": ", ".join(f"{name} {value}" for name, value in _values(dataset, k)),
        }
        for k in rows
    ]
