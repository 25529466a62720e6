"""The cases of a study as one Dataset, and the modal damping they give."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .axes import CASE, FREQUENCY, GAMMA, OWN, SEED, attributes
from .config import resolved_yaml
from .modal.damping import damping_ratio, normalised_damping
from .plan import EXCLUDED, REFUSED, RUN
from .results import INTEGERS, describe, provenance
from .scene import STANDARD_GRAVITY
from .steady import Status

if TYPE_CHECKING:
    import xarray as xr

    from .cases import Cases
    from .plan import Plan
    from .store import Finished


def assemble(plan: Plan, finished: Finished) -> xr.Dataset:
    """Put finished cases where they belong; those that are missing are NaN, and ``status`` says so.

    Scalars that change together share the dimension ``case`` and are its coordinates; every other swept scalar has a
    dimension of its own, beside frequency, gamma and seed.
    """
    import xarray as xr

    cases, config = plan.cases, plan.cases.config
    table = _table(plan, finished)
    dims = [name for name in cases.dims if name not in {OWN[path] for path in cases.carried}]
    shape = [n for name, n in zip(cases.dims, cases.shape, strict=True) if name in dims]
    data = {name: (dims, values.reshape(shape)) for name, values in table.items()}
    dataset = xr.Dataset(data, _coordinates(cases))
    dataset["particle_mass"] = _of_points(cases, plan.particle_mass)
    dataset["excitation_frequency"] = _of_points(cases, plan.frequency, "frequency")

    speed = dataset["gamma"] * STANDARD_GRAVITY / (2 * np.pi * dataset["excitation_frequency"])
    dataset["displacement"] = speed / (2 * np.pi * dataset["excitation_frequency"])
    if "energy_dissipated" in dataset:
        largest = dataset["maximum_energy"]
        dataset["effectiveness"] = dataset["energy_dissipated"] / largest
        dataset["effectiveness_standard_error"] = dataset["energy_dissipated_standard_error"] / largest
        if config.structure:
            empty = _scalar(cases, ("structure", "point_mass", "mass"), config.structure.point_mass.mass)
            total = dataset["particle_mass"] + empty
            dataset["normalised_damping"] = normalised_damping(dataset["energy_dissipated"], speed, total)
        dataset = dataset.drop_vars("maximum_energy")
        if cases.modal:
            dataset = dataset.merge(_modal(cases, dataset))
    dataset = describe(dataset.transpose("mode", *dims, missing_dims="ignore"))
    dataset.attrs = {"title": config.title, **provenance(), "configuration": resolved_yaml(config)}
    if SEED not in cases.carried:
        dataset.attrs["seeds"] = np.array(config.seeds)
    dataset.attrs |= plan.said
    return dataset


def _table(plan: Plan, finished: Finished) -> dict[str, np.ndarray]:
    """Values of every case, by name, in the order of the plan."""
    at = np.searchsorted(finished.keys, plan.keys)
    at[at == len(finished)] = 0
    found = (finished.keys[at] == plan.keys) & (plan.fate == RUN) if len(finished) else np.zeros(len(at), bool)
    table = {}
    for name, values in finished.values.items():
        whole = name in INTEGERS
        table[name] = np.full(len(plan.keys), -1 if whole else np.nan, np.int64 if whole else float)
        table[name][found] = values[at[found]]
    status = table.setdefault("status", np.full(len(plan.keys), int(Status.NOT_RUN)))
    status[~found] = Status.NOT_RUN
    status[plan.fate == EXCLUDED] = Status.EXCLUDED
    status[plan.fate == REFUSED] = Status.REFUSED
    messages = np.full(len(plan.keys), "", object)
    messages[found] = finished.messages[at[found]]
    by_point = messages.reshape(plan.cases.shape)
    for index, why in plan.refused.items():
        by_point[(slice(None), slice(None), *index)] = why
    return table | ({"message": messages} if (messages != "").any() else {})


def _coordinates(cases: Cases) -> dict:
    """Of every dimension, and of what changes along ``case``."""
    config, names = cases.config, cases.names()
    coords: dict = {}
    own = {FREQUENCY: _frequencies(cases), GAMMA: cases.gammas, SEED: cases.seeds}
    for path, values in own.items():
        if path not in cases.carried:
            coords[OWN[path]] = (OWN[path], np.array(values), attributes(path))
    for axis in cases.axes:
        for path, values in axis.columns().items():
            coords[names[path]] = (axis.name, np.array(values), attributes(path))
        if axis.name == CASE:
            coords[CASE] = (CASE, np.arange(len(axis)), {"units": "1", "long_name": "number of the case"})
    if "preparation" not in coords:
        coords["preparation"] = ((), config.preparation, attributes(("preparation",)))
    return coords


def _frequencies(cases: Cases) -> list[float]:
    first = next((point for point in cases.points() if not point.refused), None)
    return list(first.frequencies) if first else [np.nan] * cases.shape[0]


def _of_points(cases: Cases, values: np.ndarray, *leading: str) -> tuple:
    """Values that do not depend on gamma and seed, on (frequency, if asked for, and) the swept scalars."""
    whole = values.reshape(cases.shape)[..., 0][:, 0]
    dims = ("frequency", *(axis.name for axis in cases.axes))
    if not leading or FREQUENCY in cases.carried:
        return dims[1:], whole[0]
    return dims, whole


def _scalar(cases: Cases, path, otherwise) -> xr.DataArray:
    """A scalar of the configuration, on the dimension along which it is swept, if it is."""
    import xarray as xr

    for axis in cases.axes:
        if path in axis.paths:
            return xr.DataArray(np.array(axis.columns()[path], float), dims=axis.name)
    return xr.DataArray(otherwise)


def _modal(cases: Cases, dataset: xr.Dataset) -> xr.Dataset:
    """Modal damping of every mode: mean over seeds, plus what the bare structure has."""
    import xarray as xr

    config = cases.config
    dims = ("mode", *(axis.name for axis in cases.axes))
    shape = (len(config.structure.modes), *cases.shape[2:-1])
    table = {name: np.full(shape, np.nan) for name in ("natural_frequency", "mode_amplitude", "modal_mass")}
    for point in cases.points():
        if point.refused:
            continue
        at = (slice(None), *point.index)
        table["natural_frequency"][at] = point.modes.frequency
        table["mode_amplitude"][at] = point.modes.amplitude
        table["modal_mass"][at] = point.modes.modal_mass
    coords = {"mode": ("mode", config.structure.modes, {"units": "1", "long_name": "bending mode"})}
    modal = xr.Dataset({name: (dims, values) for name, values in table.items()}, coords)

    def to_mode(array):
        return array.rename(frequency="mode").assign_coords(mode=modal["mode"])

    per_joule = damping_ratio(
        1.0, to_mode(dataset["displacement"]), modal["mode_amplitude"], modal["natural_frequency"]
    )
    inherent = xr.DataArray(config.structure.inherent(), dims="mode", coords={"mode": modal["mode"]})
    energy, error = (to_mode(dataset[f"energy_dissipated{what}"]) for what in ("", "_standard_error"))
    if "seed" in energy.dims:  # otherwise each case has its own
        energy, error = energy.mean("seed", skipna=False), _combined_error(energy, error)
    modal["damping_ratio"] = per_joule * energy + inherent
    modal["damping_ratio_standard_error"] = per_joule * error
    return modal.drop_vars("frequency", errors="ignore")


def _combined_error(mean: xr.DataArray, error: xr.DataArray) -> xr.DataArray:
    """Standard error of the mean over seeds: by the spread of the seeds, and never below their own errors' share."""
    n = mean.sizes["seed"]
    within = np.sqrt((error**2).sum("seed", skipna=False)) / n
    if n == 1:
        return within
    return np.maximum(within, mean.std("seed", ddof=1, skipna=False) / math.sqrt(n))
