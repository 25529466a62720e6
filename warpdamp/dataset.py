"""The cases of a study as one Dataset on (frequency, gamma, swept scalars, seed), and the modal damping they give."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from .config import Config
from .modal.damping import damping_ratio, normalised_damping
from .results import INTEGERS, NOT_RUN, describe, provenance
from .scene import STANDARD_GRAVITY
from .sweep import Axis, Point, as_list, axes, particle_mass
from .tolerance import SMALLEST_EFFECTIVENESS, combined

if TYPE_CHECKING:
    import xarray as xr

    from .shaking import Spec

MODAL = {
    "natural_frequency": "frequency",
    "mode_amplitude": "amplitude",
    "modal_mass": "modal_mass",
    "inherent_damping": "inherent_damping",
}
"""Variables of the results, and what of ``Modes`` they hold."""


def assemble(config: Config, every: list[Point], specs: Iterable[Spec], values: dict) -> xr.Dataset:
    """Assemble the cases, in whatever order they came, on (frequency, gamma, swept scalars, seed)."""
    import xarray as xr

    swept = axes(config)
    gammas = np.array(as_list(config.excitation.gamma))
    frequencies = np.array(every[0].frequencies)
    dims = ("frequency", "gamma", *(axis.name for axis in swept), "seed")
    shape = (len(frequencies), len(gammas), *(len(axis.values) for axis in swept), len(config.seeds))

    names = {name: None for value in values.values() for name in value}
    arrays = {name: np.full(shape, -1 if name in INTEGERS else np.nan) for name in names}
    for index, value in values.items():
        for name, number in value.items():
            arrays[name][index] = number
    data = {name: (dims, a.astype(np.int64) if name in INTEGERS else a) for name, a in arrays.items()}
    coords = {
        "frequency": ("frequency", frequencies, {"units": "Hz", "long_name": "excitation frequency"}),
        "gamma": ("gamma", gammas, {"units": "1", "long_name": "acceleration amplitude over g"}),
        **{axis.name: (axis.name, np.array(axis.values), axis.attributes) for axis in swept},
        "seed": ("seed", np.array(config.seeds), {"units": "1", "long_name": "seed of the packing"}),
        "preparation": ((), config.preparation, {"units": "1", "long_name": "how the bed was prepared"}),
    }
    if swept and len({tuple(p.frequencies) for p in every}) > 1:
        coords["frequency"][2]["comment"] = "of the first combination; see excitation_frequency for each"
    dataset = xr.Dataset(data, coords)
    ran = (dataset["status"] != NOT_RUN).any([dim for dim in dims if dim != "seed"])
    dataset = dataset.isel(seed=ran.values)
    dataset = dataset.merge(answers(dataset, config.accuracy.tolerance if config.accuracy else None))

    point_dims = ("frequency", *(axis.name for axis in swept))
    own = np.empty(tuple(len(dataset[d]) for d in point_dims))
    particles = np.empty(own.shape[1:])
    for point in every:
        own[(slice(None), *point.index)] = point.frequencies
        particles[point.index] = particle_mass(point.config)
    dataset["excitation_frequency"] = (point_dims, own)
    speed = dataset["gamma"] * STANDARD_GRAVITY / (2 * np.pi * dataset["excitation_frequency"])
    dataset["displacement"] = speed / (2 * np.pi * dataset["excitation_frequency"])
    dataset["effectiveness"] = dataset["energy_dissipated"] / dataset["maximum_energy"]
    dataset["effectiveness_standard_error"] = dataset["energy_dissipated_standard_error"] / dataset["maximum_energy"]
    if config.structure and config.structure.point_mass:
        total = config.structure.point_mass.mass + xr.DataArray(particles, dims=point_dims[1:])
        dataset["normalised_damping"] = normalised_damping(dataset["energy_dissipated"], speed, total)
    dataset = dataset.drop_vars("maximum_energy")
    if config.excitation.frequency == "modes":
        dataset = dataset.merge(_modal(config, every, dataset, swept))
    dataset = describe(dataset.transpose("mode", *dims, missing_dims="ignore"))
    dataset.attrs = {"title": config.title, **provenance(), "configuration": resolved_yaml(config)}
    dataset.attrs["seeds"] = np.array(config.seeds)
    dataset.attrs["effects"] = "; ".join(sorted({str(spec.effects) for spec in specs}))
    dataset.attrs["effects_forced_off"] = ", ".join(sorted({name for spec in specs for name in spec.forced_off}))
    return dataset


def _modal(config: Config, every: list[Point], dataset: xr.Dataset, swept: list[Axis]) -> xr.Dataset:
    """Modal damping of every mode: mean over seeds, plus what the bare structure has."""
    import xarray as xr

    dims = ("mode", *(axis.name for axis in swept))
    first = every[0].modes
    shape = (len(first.number), *(len(axis.values) for axis in swept))
    table = {name: np.empty(shape) for name in MODAL}
    for point in every:
        at = (slice(None), *point.index)
        for name, attribute in MODAL.items():
            table[name][at] = getattr(point.modes, attribute)
    coords = {
        "mode": ("mode", first.number, {"units": "1", "long_name": "bending mode" if config.structure.beam else "mode"})
    }
    modal = xr.Dataset({name: (dims, values) for name, values in table.items()}, coords)

    def to_mode(array):
        return array.rename(frequency="mode").assign_coords(mode=modal["mode"])

    per_joule = damping_ratio(
        1.0, to_mode(dataset["displacement"]), modal["mode_amplitude"], modal["natural_frequency"]
    )
    modal["damping_ratio"] = per_joule * to_mode(dataset["energy_mean"]) + modal["inherent_damping"]
    modal["damping_ratio_standard_error"] = per_joule * to_mode(dataset["energy_mean_standard_error"])
    return modal.drop_vars("frequency", errors="ignore")


def answers(dataset: xr.Dataset, tolerance: float | None) -> xr.Dataset:
    """Mean over the packings of every point, what it is worth, and whether that is what was asked for."""
    import xarray as xr

    values = {name: dataset[name].transpose(..., "seed") for name in ("energy_dissipated", *_PARTS)}
    status = dataset["status"].transpose(..., "seed").values
    dims = values["energy_dissipated"].dims[:-1]
    names = ("energy_mean", "energy_mean_standard_error", "energy_mean_interval", "packings", "within_tolerance")
    out = {name: np.full(status.shape[:-1], -1 if name in INTEGERS else np.nan) for name in names}
    for at in np.ndindex(status.shape[:-1]):
        ran = status[at] != NOT_RUN
        mean, error, degrees, step = (array.values[at][ran] for array in values.values())
        answer = combined(mean, error, degrees)
        left = float(np.mean(step))
        total = math.hypot(answer.standard_error, left)
        out["energy_mean"][at] = answer.mean
        out["energy_mean_standard_error"][at] = total
        out["energy_mean_interval"][at] = math.hypot(answer.interval, 2 * left)
        out["packings"][at] = answer.packings
        smallest = SMALLEST_EFFECTIVENESS * float(dataset["maximum_energy"].transpose(..., "seed").values[at][ran][0])
        if tolerance is not None:
            out["within_tolerance"][at] = total <= max(tolerance * answer.mean, smallest)
    if tolerance is None:
        del out["within_tolerance"]
    return xr.Dataset(
        {name: (dims, array.astype(np.int64) if name in INTEGERS else array) for name, array in out.items()}
    )


_PARTS = ("energy_dissipated_standard_error", "degrees_of_freedom", "discretisation_error")


def resolved_yaml(config: Config) -> str:
    """The configuration with every default filled in, in SI, as YAML."""
    from ruamel.yaml import YAML

    text = io.StringIO()
    yaml = YAML()
    yaml.dump(config.model_dump(mode="json"), text)
    return text.getvalue()
