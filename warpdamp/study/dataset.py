"""Dataset of a study's cases, and the modal damping they give."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..analysis.results import provenance
from ..config.preparation import carried_path, preparation_word, state_asked
from ..config.reading import resolved_yaml
from ..execution.adaptive import needed_cases
from ..modal.apparent_mass import per_mode
from ..modal.damping import damping_ratio, normalised_damping
from ..numerics.tolerance import PARTS, allowed, combined
from ..scene.scene import STANDARD_GRAVITY
from ..status import Status
from ..sweep.axes import CASE, FREQUENCY, GAMMA, LEG, OWN, SEED, attributes
from ..sweep.plan import Fate
from ..variables import INTEGERS, NOT_RUN, describe

if TYPE_CHECKING:
    import xarray as xr

    from ..config.study import Config
    from ..execution.store import Finished
    from ..sweep.cases import Cases
    from ..sweep.plan import Plan

MODAL = {
    "natural_frequency": "frequency",
    "mode_amplitude": "amplitude",
    "modal_mass": "modal_mass",
    "inherent_damping": "inherent_damping",
}
"""Variables of the results, and the attributes of ``Modes`` that they hold."""


def assemble(plan: Plan, finished: Finished) -> xr.Dataset:
    """Dataset of finished cases; those that are missing are NaN, as ``status`` says.

    Scalars that change together share the dimension ``case`` and are its coordinates; every other swept scalar has a
    dimension of its own, beside frequency, gamma and seed.
    """
    import xarray as xr

    cases, config = plan.cases, plan.cases.config
    table = _table(plan, finished)
    dims = [name for name in cases.dims if name not in {OWN[path] for path in cases.carried}]
    shape = [n for name, n in zip(cases.dims, cases.shape, strict=True) if name in dims]
    data = {name: (dims, values.reshape(shape)) for name, values in table.items()}
    dataset = _with_seeds_that_ran(xr.Dataset(data, _coordinates(cases)), config)
    dataset["particle_mass"] = _of_points(cases, plan.particle_mass)
    dataset["excitation_frequency"] = _of_points(cases, plan.frequency, "frequency")

    speed = dataset["gamma"] * STANDARD_GRAVITY / (2 * np.pi * dataset["excitation_frequency"])
    dataset["displacement"] = speed / (2 * np.pi * dataset["excitation_frequency"])
    if "energy_dissipated" in dataset:
        dataset = dataset.merge(answers(dataset, config.accuracy.tolerance if config.accuracy else None))
        largest = dataset["maximum_energy"]
        dataset["effectiveness"] = dataset["energy_dissipated"] / largest
        dataset["effectiveness_standard_error"] = dataset["energy_dissipated_standard_error"] / largest
        if config.structure and config.structure.point_mass:
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
    dataset.attrs |= plan.attributes
    return dataset


def _table(plan: Plan, finished: Finished) -> dict[str, np.ndarray]:
    """Values of every case, by name, in the order of the plan."""
    rows, present = finished.rows(plan.keys), np.zeros(len(plan.keys), bool)
    present[needed_cases(plan, finished)] = True
    present &= rows >= 0
    table = {}
    for name, values in finished.values.items():
        whole = name in INTEGERS
        table[name] = np.full(len(plan.keys), -1 if whole else np.nan, np.int64 if whole else float)
        table[name][present] = values[rows[present]]
    status = table.setdefault("status", np.full(len(plan.keys), int(Status.NOT_RUN)))
    status[~present] = Status.NOT_RUN
    status[plan.fate == Fate.EXCLUDED] = Status.EXCLUDED
    status[plan.fate == Fate.REFUSED] = Status.REFUSED
    messages = np.full(len(plan.keys), "", object)
    messages[present] = finished.messages[rows[present]]
    by_point = messages.reshape(plan.cases.shape)
    for index, why in plan.refused.items():
        by_point[(slice(None), slice(None), *index)] = why
    return table | {"message": messages}


def _coordinates(cases: Cases) -> dict:
    """Coordinates of every dimension, and of what changes along ``case``."""
    config, names = cases.config, cases.names()
    coords: dict = {}
    excitation = {FREQUENCY: _frequencies(cases), GAMMA: cases.gammas, SEED: cases.seeds}
    for path, values in excitation.items():
        if path not in cases.carried:
            coords[OWN[path]] = (OWN[path], np.array(values), attributes(path))
    for axis in cases.axes:
        for path, values in axis.columns().items():
            coords[names[path]] = (axis.name, np.array(values), attributes(path))
        if axis.name == CASE:
            coords[CASE] = (CASE, np.arange(len(axis)), {"units": "1", "long_name": "number of the case"})
        if axis.name == LEG:
            path = list(carried_path(config.preparation))
            about = {"units": "1", "long_name": "leg of the path of amplitudes"}
            coords[LEG] = (LEG, np.arange(1, len(path) + 1), about)
            coords["leg_direction"] = (LEG, path, {"long_name": "direction in which the leg meets the amplitudes"})
    return preparation_coordinates(config) | coords


def preparation_coordinates(config: Config) -> dict:
    """Coordinates that say how the beds of a study were prepared, and the state that they were to have."""
    coords = {"preparation": ((), preparation_word(config.preparation), attributes(("preparation",)))}
    for name, value in state_asked(config.preparation).items():
        path = ("preparation", name)
        about = attributes(path)
        coords["_".join(path)] = ((), value, about | {"long_name": f"{about['long_name']} asked for"})
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
    """Modal damping of every mode: mean over packings, plus what the bare structure has."""
    import xarray as xr

    dims = ("mode", *(axis.name for axis in cases.axes))
    shape = (cases.shape[0], *cases.shape[2:-1])
    table = {name: np.full(shape, np.nan) for name in MODAL}
    for point in cases.points():
        if point.refused:
            continue
        modes = point.modes
        for name, attribute in MODAL.items():
            table[name][(slice(None), *point.index)] = getattr(modes, attribute)
    family = "bending mode" if cases.config.structure.beam else "mode"
    coords = {"mode": ("mode", modes.number, {"units": "1", "long_name": family})}
    modal = xr.Dataset({name: (dims, values) for name, values in table.items()}, coords)

    of_modes = per_mode(modal, dataset[["displacement", "energy_mean", "energy_mean_standard_error"]])
    per_joule = damping_ratio(1.0, of_modes["displacement"], modal["mode_amplitude"], modal["natural_frequency"])
    modal["damping_ratio"] = per_joule * of_modes["energy_mean"] + modal["inherent_damping"]
    modal["damping_ratio_standard_error"] = per_joule * of_modes["energy_mean_standard_error"]
    return modal.drop_vars("frequency", errors="ignore")


def _with_seeds_that_ran(dataset: xr.Dataset, config: Config) -> xr.Dataset:
    """Dataset without the packings that the tolerance required at no point."""
    ran = dataset["status"] != NOT_RUN
    if config.accuracy is None or "seed" not in dataset.dims or not ran.any():
        return dataset
    return dataset.isel(seed=ran.any([dim for dim in ran.dims if dim != "seed"]).values)


def answers(dataset: xr.Dataset, tolerance: float | None) -> xr.Dataset:
    """Mean over the packings of every point, its uncertainty, and whether that is within the tolerance."""
    import xarray as xr

    def over_packings(name):
        array = dataset[name]
        return array.transpose(..., "seed").values if "seed" in array.dims else array.values[..., None]

    status = over_packings("status")
    ran = ~np.isin(status, (Status.NOT_RUN, Status.EXCLUDED, Status.REFUSED))
    answer = combined(*(over_packings(name) for name in PARTS), ran)
    variables = {
        "energy_mean": answer.mean,
        "energy_mean_standard_error": answer.total_error,
        "energy_mean_interval": answer.interval,
        "packings": answer.packings.astype(np.int64),
    }
    if tolerance is not None:
        largest = np.max(np.where(ran, over_packings("maximum_energy"), 0.0), axis=-1)
        limit = allowed(tolerance, answer.mean, largest)
        within = (answer.total_error <= limit).astype(np.int64)
        variables["within_tolerance"] = np.where(answer.packings > 0, within, NOT_RUN)
    dims = [dim for dim in dataset["status"].dims if dim != "seed"]
    return xr.Dataset({name: (dims, values) for name, values in variables.items()})
