"""What parameters.py draws on: results of each study on plain dimensions, and the factors of the paper's Table 1."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import xarray as xr
from scipy.stats import t
from shared import DOCS

import warpdamp.accessor  # noqa: F401  gives datasets their ``damper``
from warpdamp.analysis.effects import RESPONSES, effect_of

DATA = DOCS / "parameters"
SLOW, FAST, FASTEST = 39.5, 280.0, 730.0
"""Frequencies [Hz] of modes 1, 3 and 5 of the beam: the optimum of collision stands alone at the first, that of
fluidisation at the second."""

NOT_RUN = -1

BESIDE = ("case", "fewest_cycles", "most_cycles", "steps_per_contact")
"""Coordinates that change with the frequency and are not of interest."""

DEAR = {"modulus": ("modulus_stiff", "youngs_modulus"), "restitution": ("restitution_low", "restitution")}
"""Studies, and the levels of theirs that take several times the steps and are files of their own."""


@dataclass(frozen=True)
class Factor:
    """One row of the paper's table: the study, its coordinate, and the paper's words for each response.

    ``expected`` has the verdicts that the paper's words stand for; empty where it says that it does not know.
    """

    title: str
    study: str
    key: str
    unit: str
    words: tuple[str, str, str, str]
    expected: tuple[tuple[str, ...], ...]
    shown: float = 1.0


SAME, UP, DOWN, OPEN, NEEDS = ("not affected",), ("higher",), ("lower",), (), ("does not exist",)
FACTORS = (
    Factor(
        "Frequency", "frequency", "frequency", "Hz",
        ("uncertain, falls slightly", "uncertain, rises at low frequency", "proportional to f^2", "not affected"),
        (OPEN, OPEN, UP, SAME),
    ),
    Factor(
        "Gravity", "gravity", "gravity", "m/s^2",
        ("needs gravity", "needs gravity", "not affected", "not affected"), (NEEDS, NEEDS, SAME, SAME),
    ),
    Factor("Orientation to gravity", "orientation", "angle", "degrees", ("not affected",) * 4, (SAME,) * 4),
    Factor(
        "Clearance", "clearance", "free_height", "mm",
        ("not affected", "not affected", "proportional to it", "not affected"), (SAME, SAME, UP, SAME), 1e3,
    ),
    Factor(
        "Bed depth", "bed_depth", "count", "particles",
        ("higher", "not affected", "only by the clearance", "not affected"), (UP, SAME, SAME, SAME),
    ),
    Factor(
        "Shear resistance (rolling friction)", "shear_resistance", "rolling_friction", "",
        ("not mentioned", "not mentioned", "higher", "not affected"), (OPEN, OPEN, UP, SAME),
    ),
    Factor(
        "Density", "density", "density", "kg/m^3",
        ("slightly lower", "not affected", "not affected", "not affected"), (DOWN, SAME, SAME, SAME),
    ),
    Factor(
        "Size", "size", "radius", "mm",
        ("not affected", "not affected", "only by the clearance", "not affected"), (SAME,) * 4, 1e3,
    ),
    Factor(
        "Elastic modulus", "modulus", "youngs_modulus", "MPa",
        ("uncertain", "slightly lower", "uncertain, tends to rise", "uncertain"), (OPEN, DOWN, OPEN, OPEN), 1e-6,
    ),
    Factor(
        "Restitution", "restitution", "restitution", "",
        ("not affected", "slightly higher", "uncertain, not affected", "slightly higher"), (SAME, UP, OPEN, UP),
    ),
    Factor("Friction", "friction", "friction", "", ("inconsistent results",) * 4, (OPEN,) * 4),
    Factor(
        "Sphericity (over \\|ln aspect\\|)", "sphericity", "elongation", "",
        ("uncertain, none", "uncertain, none", "higher", "not affected"), (OPEN, OPEN, UP, SAME),
    ),
)  # fmt: skip
"""Rows of Table 1; what says "higher" of sphericity rises as particles are less like spheres."""

FEWEST_PACKINGS = 3
"""Packings from which on effects are had."""


@cache
def results(study: str) -> xr.Dataset | None:
    """Results of a study on (gamma, frequency, factor, seed); None if it was not run."""
    if study in OWN:
        return OWN[study]()
    path = DATA / f"{study}.nc"
    if not path.exists():
        return None
    dataset = on_frequencies(xr.load_dataset(path))
    dear, dim = DEAR.get(study, ("", ""))
    if (DATA / f"{dear}.nc").exists():
        parts = [dataset, on_frequencies(xr.load_dataset(DATA / f"{dear}.nc"))]
        dataset = xr.concat(parts, dim, join="outer", coords="minimal", compat="override", combine_attrs="override")
        dataset["status"] = dataset["status"].fillna(NOT_RUN)
        dataset = dataset.sortby(dim)
    if study == "clearance":
        heights = dataset["clearance"].mean([dim for dim in dataset["clearance"].dims if dim != "height"])
        dataset = dataset.assign_coords(free_height=("height", heights.values, {"units": "m"}))
    return dataset


def _orientation() -> xr.Dataset | None:
    parts = [results(study) for study in ("gravity", "orientation_45", "orientation_90")]
    if any(part is None for part in parts):
        return None
    upright = parts[0].sel(gravity=9.81, drop=True)
    together = xr.concat(
        [upright, *parts[1:]], "angle", join="outer", combine_attrs="override", coords="minimal", compat="override"
    )
    return together.assign_coords(angle=("angle", [0.0, 45.0, 90.0], {"units": "degrees"}))


def _shapes() -> xr.Dataset | None:
    """Spheroids of docs/sphericity.nc over |ln aspect|, their modes named by the frequencies of the studies here."""
    path = DOCS / "sphericity.nc"
    if not path.exists():
        return None
    runs = xr.load_dataset(path)
    runs = runs.sel(seed=runs["effectiveness"].notnull().any(["mode", "gamma"]).all("aspect"))
    if runs.sizes["seed"] < FEWEST_PACKINGS:
        return None
    runs = runs.sel(mode=[1, 3, 5]).assign_coords(mode=[SLOW, FAST, FASTEST]).rename(mode="frequency")
    elongation = ("aspect", np.abs(np.log(runs["aspect"].values)), {"units": "1"})
    runs["status"] = runs["status"].fillna(NOT_RUN)
    return runs.assign_coords(elongation=elongation)


OWN = {"orientation": _orientation, "sphericity": _shapes}
"""Studies whose results are put together from other files."""


def on_frequencies(dataset: xr.Dataset) -> xr.Dataset:
    """Results whose frequencies change together with other scalars, on dimensions of their own."""
    if "case" not in dataset.dims:
        return dataset
    about = {name: dict(dataset[name].attrs) for name in dataset.coords}
    dataset = dataset.drop_vars(BESIDE, errors="ignore")
    others = [str(n) for n, c in dataset.coords.items() if c.dims == ("case",) and n != "frequency"]
    if not others:
        return dataset.swap_dims(case="frequency")
    first, rest = others[0], others[1:]
    along = {n: dict(zip(dataset[first].values, dataset[n].values, strict=True)) for n in rest}
    dataset = dataset.drop_vars(rest).set_index(case=["frequency", first]).unstack("case")
    for name, values in along.items():
        dataset[name] = (first, [values[v] for v in dataset[first].values])
    dataset = dataset.set_coords(list(along))
    for name in (first, *rest, "frequency"):
        dataset[name].attrs = about[name]
    return dataset


@cache
def effects(study: str, key: str) -> xr.Dataset | None:
    """Effects of a factor on (response, frequency); None if it was not run."""
    dataset = results(study)
    return None if dataset is None else effect_of(dataset, key)


def cells(factor: Factor) -> list[xr.Dataset | None]:
    """The four cells of a factor: fluidisation at the higher frequency, collision at the lower one."""
    if factor.study == "frequency":
        fluidised, collided = effects("frequency", "frequency"), collision_over_frequency()
        return [None if d is None else d.sel(response=r) for r, d in _pairs(fluidised, collided)]
    found = effects(factor.study, factor.key)
    if found is None:
        return [None] * len(RESPONSES)
    return [found.sel(response=r, frequency=FAST if "fluid" in r else SLOW) for r in RESPONSES]


def _pairs(fluidised, collided):
    return [(r, fluidised if "fluid" in r else collided) for r in RESPONSES]


@cache
def collision_over_frequency() -> xr.Dataset | None:
    """Effect of the frequency on the optimum of collision, from docs/gamma_c.nc."""
    path = DOCS / "gamma_c.nc"
    if not path.exists():
        return None
    runs = xr.load_dataset(path)
    parts = [
        runs.isel(frequency=k).drop_vars("gamma").assign_coords(ratio=runs["gamma"].isel(frequency=k).values)
        .rename(ratio="gamma")
        for k in range(runs.sizes["frequency"])
    ]  # fmt: skip
    together = xr.concat(parts, "frequency", join="outer", coords="minimal", compat="override")
    together["status"] = together["status"].fillna(NOT_RUN)
    return effect_of(together, "frequency")


def nearest(dataset: xr.Dataset, frequency: float, gamma: float) -> xr.Dataset:
    """Results at a frequency and the Gamma that is nearest among those run at all levels."""
    at = dataset.sel(frequency=frequency)
    run = at["effectiveness"].notnull().any("seed")
    whole = run.all([dim for dim in run.dims if dim != "gamma"])
    gammas = at["gamma"].values[whole.values]
    return at.sel(gamma=float(gammas[np.argmin(np.abs(np.log(gammas / gamma)))]))


def shares(at: xr.Dataset) -> dict[str, xr.DataArray]:
    """Parts of the loss by mechanism, mean over packings: dashpots, friction, rolling, and all of it at walls."""
    whole = sum(_loss(at, channels).mean("seed") for channels in KINDS.values())
    own = {kind: _loss(at, channels).mean("seed") / whole for kind, channels in KINDS.items()}
    every = [channel for channels in KINDS.values() for channel in channels]
    return own | {"walls": _loss(at, every, ("wall",)).mean("seed") / whole}


KINDS = {
    "dashpots": ("normal_dashpot", "tangential_dashpot"),
    "friction": ("slip", "history"),
    "rolling": ("rolling",),
}
"""Mechanisms, and the channels of the ledger that they are."""


def _loss(at: xr.Dataset, channels, places=("particle", "wall")) -> xr.DataArray:
    names = [f"{place}_{channel}_loss" for place in places for channel in channels]
    return sum(at[name] for name in names if name in at)


def losses(at: xr.Dataset, kind: str) -> xr.DataArray:
    """Loss by one mechanism in parts of the ideal damper, packing by packing."""
    whole = sum(_loss(at, channels) for channels in KINDS.values())
    return _loss(at, KINDS[kind]) / whole * at["effectiveness"]


def change_of(logs) -> tuple[float, float, float]:
    """Relative change of which ``logs`` are the logarithms by packing: its mean and the ends of its 95 % interval."""
    mean, width = _mean_and_width(logs)
    return tuple(float(np.expm1(mean + end)) for end in (0.0, -width, width))


def difference_of(values) -> tuple[float, float, float]:
    """Mean of differences by packing, and the ends of its 95 % interval."""
    mean, width = _mean_and_width(values)
    return mean, mean - width, mean + width


def _mean_and_width(values) -> tuple[float, float]:
    values = np.asarray(values, float)
    values = values[np.isfinite(values)]
    n = len(values)
    return float(values.mean()), float(t.ppf(0.975, n - 1) * values.std(ddof=1) / np.sqrt(n))
