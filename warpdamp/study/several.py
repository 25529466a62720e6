"""Studies of several dampers on one structure: a study of each alone, and what they add up to.

At Gamma of the first damper, damper j is shaken with Gamma |phi_j / phi_1| in each mode.  The energies of all add up
over the one strain energy of the mode:

    zeta(Gamma) = sum_j E_j(Gamma |phi_j / phi_1|) / (4 pi E_strain) + inherent damping.

It holds as far as the structure's response is one real mode.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.results import over_packings, provenance, worst_status
from ..config.build import particle_mass
from ..config.reading import resolved_yaml
from ..config.study import Config
from ..config.sweep import SweepConfig, as_list
from ..modal.damping import damping_ratio
from ..modal.from_config import modes as modes_of
from ..modal.from_config import seen_by_all
from ..scene.scene import STANDARD_GRAVITY
from ..status import Status
from ..sweep.dampers import every_damper
from ..variables import describe
from .dataset import preparation_coordinates

if TYPE_CHECKING:
    import xarray as xr

    from ..modes import Modes


def modes_of_all(config: Config, alone: Sequence[Config]) -> list[Modes]:
    """Modes of the structure with the particles of all dampers, as each damper sees them."""
    return modes_with(config, list(map(particle_mass, alone)))


def modes_with(config: Config, masses: Sequence[float]) -> list[Modes]:
    """Modes of the structure with particles of given masses [kg] in its dampers, as each damper sees them.

    Raises
    ------
    ConfigError
        If there is not one mass for each damper, or the modes cannot be had.
    """
    first, *further = masses
    if len(further) != len(config.dampers):
        there = f"the structure carries {1 + len(config.dampers)}, and the cards given are {len(masses)}"
        raise config.error("dampers", f"{there}: warpdamp damping takes one for each, in their order")
    return seen_by_all(config, modes_of(config, particles=first, further=further))


def studies(config: Config) -> tuple[list[Config], list[Modes]]:
    """The study of each damper: every mode and Gamma, as the damper's own place moves; and the modes as each sees them.

    On its node in a mode a damper is not shaken, and no case is made.
    """
    alone = every_damper(config)
    seen = modes_of_all(config, alone)
    found = []
    for own, modes in zip(alone, seen, strict=True):
        if modes.on_node.all():  # not of the first: such modes are not picked
            k = len(found) - 1
            raise config.error(
                f"dampers.{k}.{config.dampers[k].place}", "is on a node of every mode, where it damps none"
            )
        frequency, gamma = zip(*((f, g) for _, _, f, g in cases_of(config, modes, seen[0])), strict=True)
        excitation = own.excitation.model_copy(update={"frequency": frequency[0], "gamma": gamma[0]})
        together = {"excitation.frequency": list(frequency), "excitation.gamma": list(gamma)}
        study = own.model_copy(
            update={
                "title": f"{config.title}, damper {len(found) + 1}",
                "excitation": excitation,
                "sweep": SweepConfig(zip=[together]),
            }
        )
        study._source = None  # its keys are not where those of the file are
        found.append(study)
    return found, seen


def cases_of(config: Config, modes: Modes, reference: Modes):
    """Row of the mode, row of Gamma, frequency [Hz] and own Gamma of every case of a damper."""
    ratio = np.abs(modes.amplitude / reference.amplitude)
    for i in np.flatnonzero(~modes.on_node):
        for k, gamma in enumerate(as_list(config.excitation.gamma)):
            # to a microhertz: an eigensolver's last bits depend on the machine, and beds are chaotic
            yield int(i), k, round(float(modes.frequency[i]), 6), float(f"{gamma * ratio[i]:.9g}")


def combined(config: Config, datasets: Sequence[xr.Dataset], seen: Sequence[Modes]) -> xr.Dataset:
    """Energies of all dampers at Gamma of the first, and the damping that they add up to.

    Returns
    -------
    xarray.Dataset
        Of each damper on (damper, frequency, gamma), of the structure on (mode, gamma).  Standard errors of the dampers
        are added up, not squared: equal dampers share their beds.
    """
    import xarray as xr

    gammas, reference = as_list(config.excitation.gamma), seen[0]
    each = [
        _on_the_grid(config, dataset, modes, reference) for dataset, modes in zip(datasets, seen, strict=True)
    ]  # fmt: skip
    frequency = np.round(reference.frequency, 6)
    coords = {"frequency": ("frequency", frequency, {"units": "Hz"}), "gamma": gammas}
    dataset = xr.concat(each, "damper").assign_coords(damper=np.arange(1, len(seen) + 1), **coords)
    dataset["particle_mass"] = ("damper", [float(own["particle_mass"].max()) for own in datasets])
    dataset = dataset.assign_coords(preparation_coordinates(config))
    displacement = np.array(gammas) * STANDARD_GRAVITY / (2 * np.pi * frequency[:, None]) ** 2
    amplitude, natural = reference.amplitude[:, None], reference.frequency[:, None]
    per_joule = xr.DataArray(damping_ratio(1.0, displacement, amplitude, natural), dims=("mode", "gamma"))
    share, error = (
        (per_joule * dataset[name].drop_vars("frequency").rename(frequency="mode")).transpose("damper", ...)
        for name in ("energy_mean", "energy_mean_standard_error")
    )
    inherent = xr.DataArray(reference.inherent_damping, dims="mode")
    dataset = dataset.assign(
        damper_share=share,
        damping_ratio=share.sum("damper", skipna=False) + inherent,
        damping_ratio_standard_error=error.sum("damper", skipna=False),
        natural_frequency=("mode", reference.frequency),
        inherent_damping=inherent,
        mode_amplitude=("mode", reference.amplitude),
        damper_amplitude=(("damper", "mode"), [modes.amplitude for modes in seen]),
    ).assign_coords(mode=("mode", reference.number, {"units": "1", "long_name": "mode"}))
    dataset = describe(dataset)
    dataset.attrs = {"title": config.title, **provenance(), "configuration": resolved_yaml(config)}
    return dataset


def _on_the_grid(config: Config, dataset: xr.Dataset, modes: Modes, reference: Modes) -> xr.Dataset:
    """Results of one damper's study, on (frequency, gamma); on its node a damper takes nothing."""
    import xarray as xr

    shape = (len(modes.frequency), len(as_list(config.excitation.gamma)))
    rows = [(i, k) for i, k, _, _ in cases_of(config, modes, reference)]
    effectiveness, error = over_packings(dataset, "effectiveness")
    values = {
        "energy_mean": dataset["energy_mean"],
        "energy_mean_standard_error": dataset["energy_mean_standard_error"],
        "effectiveness": effectiveness,
        "effectiveness_standard_error": error,
        "damper_gamma": dataset["gamma"],
        "packings": dataset["packings"],
        "status": worst_status(dataset),
    }
    if "within_tolerance" in dataset:
        values["within_tolerance"] = dataset["within_tolerance"]
    found = {}
    for name, value in values.items():
        on_node = {"status": int(Status.STEADY), "within_tolerance": 1}.get(name, 0)
        found[name] = np.full(shape, on_node, value.dtype)
        found[name][tuple(zip(*rows, strict=True))] = np.atleast_1d(value.values)
    return xr.Dataset({name: (("frequency", "gamma"), value) for name, value in found.items()})
