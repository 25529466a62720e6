"""A configuration with its tolerance applied, its files read in, or shortened for a first look."""

from __future__ import annotations

import numpy as np

from ..config.study import Config
from ..config.sweep import as_list
from ..numerics.tolerance import settings_for
from .axes import dotted
from .reader import Reader


def with_tolerance(config: Config) -> Config:
    """Configuration with the step, the length and the packings that its tolerance chooses.

    Raises
    ------
    ConfigError
        If it also asks for a step or an error of its own.
    """
    if config.accuracy is None:
        return config
    chosen = settings_for(config.accuracy.tolerance)
    for section, key in (("numerics", "steps_per_contact"), ("steady_state", "standard_error")):
        given = getattr(config, section)
        if key in given.model_fields_set and getattr(given, key) != getattr(chosen, key):
            raise config.error(f"{section}.{key}", "is chosen by accuracy.tolerance: leave one of the two out")
    if config.numerics.step != "auto" or config.steady_state.recipe != "detect":
        raise config.error("accuracy", "chooses the step and the length of a run: leave numerics.step and recipe out")
    steady = config.steady_state.model_copy(update={"standard_error": chosen.standard_error})
    numerics = config.numerics.model_copy(update={"steps_per_contact": chosen.steps_per_contact})
    given = "seeds" in config.model_fields_set or (config.sweep and config.sweep.varies("seed", "seeds"))
    seeds = config.seeds if given else list(range(1, config.accuracy.most_packings + 1))
    changed = config.model_copy(update={"steady_state": steady, "numerics": numerics, "seeds": seeds})
    changed._source = config._source
    return changed


def self_contained(config: Config) -> Config:
    """Configuration that does not depend on its folder: its table read in, absolute paths of its other files.

    Raises
    ------
    ConfigError
        If the table cannot be read.
    """
    change: dict = {}
    if config.structure:
        change["structure"] = config.structure.found_from(config.folder.resolve())
    if config.sweep and config.sweep.csv:
        table = Reader(config).table(config.sweep.csv)
        group = {dotted(path): list(values) for path, values in table.columns().items()}
        change["sweep"] = config.sweep.model_copy(update={"csv": None, "zip": [*config.sweep.zip, group]})
    whole = config.model_copy(update=change)
    whole._source = config._source
    return whole


def shortened(config: Config) -> Config:
    """Configuration for a first look in a minute: five amplitudes, one seed, loose bed, 12 cycles, no ``sweep``.

    Its figures are a first look only: loose beds drift, and ``status`` says so.
    """
    gammas = as_list(config.excitation.gamma)
    few = sorted({round(k) for k in np.linspace(0, len(gammas) - 1, QUICK["amplitudes"])})
    change = {
        "title": f"{config.title} (quick look)",
        "excitation": config.excitation.model_copy(update={"gamma": [gammas[k] for k in few]}),
        "seeds": config.seeds[:1],
        "sweep": None,
        "accuracy": None,
        "preparation": "loose",
        "steady_state": config.steady_state.model_copy(
            update={name: QUICK[name] for name in ("fewest_cycles", "most_cycles")}
        ),
    }
    short = config.model_copy(update=change)
    short._source = config._source
    return short


QUICK = {"amplitudes": 5, "fewest_cycles": 12, "most_cycles": 12}
