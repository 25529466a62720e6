"""The cases of a study as one Dataset on (frequency, gamma, swept scalars, seed), and the modal damping they give."""

from __future__ import annotations

import io
import math
from typing import TYPE_CHECKING

import numpy as np

from .config import Config
from .modal.damping import damping_ratio, normalised_damping
from .results import INTEGERS, describe, provenance
from .scene import STANDARD_GRAVITY
from .sweep import Axis, Point, as_list, axes, particle_mass

if TYPE_CHECKING:
    import xarray as xr

MODAL = {
    "natural_frequency": "frequency",
    "mode_amplitude": "amplitude",
    "modal_mass": "modal_mass",
    "inherent_damping": "inherent_damping",
}
"""Variables of the results, and what of ``Modes`` they hold."""


def assemble(config: Config, every: list[Point], values: dict) -> xr.Dataset:
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
    energy = to_mode(dataset["energy_dissipated"])
    modal["damping_ratio"] = per_joule * energy.mean("seed", skipna=False) + modal["inherent_damping"]
    modal["damping_ratio_standard_error"] = per_joule * _combined_error(
        energy, to_mode(dataset["energy_dissipated_standard_error"])
    )
    return modal.drop_vars("frequency", errors="ignore")


def _combined_error(mean: xr.DataArray, error: xr.DataArray) -> xr.DataArray:
    """Standard error of the mean over seeds: by the spread of the seeds, and never below their own errors' share."""
    n = mean.sizes["seed"]
    within = np.sqrt((error**2).sum("seed", skipna=False)) / n
    if n == 1:
        return within
    return np.maximum(within, mean.std("seed", ddof=1, skipna=False) / math.sqrt(n))


def resolved_yaml(config: Config) -> str:
    """The configuration with every default filled in, in SI, as YAML."""
    from ruamel.yaml import YAML

    text = io.StringIO()
    yaml = YAML()
    yaml.dump(config.model_dump(mode="json"), text)
    return text.getvalue()
