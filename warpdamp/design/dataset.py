"""Answer to a design problem as a Dataset: the damper chosen, its curve, the front, runners-up and tolerances."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..analysis.results import provenance
from ..config.reading import resolved_yaml
from ..report.design import left_out
from ..sweep.axes import attributes, coordinate_names
from .assess import Assessment
from .problem import goal_words
from .run import Answer

CHOSEN, FRONT, RUNNER_UP = "chosen", "front", "runner-up"
"""What a design of an answer is."""

ABOUT = {
    "gamma": ("1", "acceleration amplitude over g at the damper"),
    "natural_frequency": ("Hz", "natural frequency with the particles of the damper chosen"),
    "mode_amplitude": ("kg-0.5", "mass-normalised mode shape at the damper"),
    "damping_ratio": ("1", "damping ratio of each fresh packing of the damper chosen, inherent damping included"),
    "damping_ratio_mean": ("1", "mean over the fresh packings"),
    "damping_ratio_interval": ("1", "half-width of the 95 % interval of the mean"),
    "role": ("", "what the design is: chosen, of the front, or a runner-up"),
    "particle_mass": ("kg", "mass of all particles"),
    "least_damping": ("1", "least damping ratio over the range, by the emulator"),
    "least_damping_low": ("1", "lower end of its 95 % interval"),
    "least_damping_high": ("1", "upper end of its 95 % interval"),
    "force": ("N", "amplitude of the particles' force on the structure at the upper end of the range"),
    "probability": ("1", "that the target is met; of the damper chosen by fresh packings, of others by the emulator"),
    "target_probability": ("1", "that the damper chosen meets the target, by fresh packings"),
    "target_probability_low": ("1", "the least of it without any one of the packings"),
    "target_probability_high": ("1", "the largest of it without any one of the packings"),
    "target_damping": ("1", "damping ratio that was wanted"),
    "least_mass": ("kg", "mass of particles that any damper needs (eqs 5-11)"),
    "confidence": ("1", "probability that was wanted"),
    "claimed": ("1", "whether the target is met with it (1) or not (0)"),
    "cases": ("1", "cases simulated, or read from the store"),
    "attempts": ("1", "designs that were simulated again with fresh packings"),
    "tolerance_value": ("1", "of the damper chosen, in the unit of the scalar"),
    "tolerance_low": ("1", "lower end of the range that was tried"),
    "tolerance_high": ("1", "upper end of the range that was tried"),
    "kept_low": ("1", "lower end of the part of it over which the claim keeps its confidence"),
    "kept_high": ("1", "upper end of the part of it over which the claim keeps its confidence"),
    "tolerance_unit": ("", "unit of the scalar"),
    "tolerance_probability": ("1", "that the target is met with every scalar anywhere in its range"),
}
"""Variables of an answer: unit and meaning."""


def to_dataset(answer: Answer) -> xr.Dataset:
    """Answer to a design problem as a Dataset, which ``warpdamp report`` makes a page of.

    Parameters
    ----------
    answer : Answer

    Returns
    -------
    xarray.Dataset
        On the dimensions ``mode`` and ``point`` (Gammas of a mode), ``packing``, ``design`` (the damper chosen first,
        then the front and the runners-up) and ``tolerance``; the configuration of the damper is an attribute.
    """
    parts = _curve(answer) | _designs(answer) | _totals(answer) | _tolerances(answer)
    described = {
        name: (dims, values, _about(name) if name in ABOUT else own) for name, (dims, values, own) in parts.items()
    }
    numbers = answer.problem.modes(answer.design).number
    dataset = xr.Dataset(described, {"mode": ("mode", numbers, {"units": "1", "long_name": "mode number"})})
    return dataset.assign_attrs(_attributes(answer))


def _about(name: str) -> dict:
    unit, meaning = ABOUT[name]
    return ({"units": unit} if unit else {}) | {"long_name": meaning}


def _curve(answer: Answer) -> dict:
    verified = answer.verified
    drives, modes = verified.drives, len(np.unique(verified.drives.mode))
    shape = modes, len(drives.gamma) // modes
    flat = {"gamma": drives.gamma, "damping_ratio_mean": verified.mean, "damping_ratio_interval": verified.interval}
    found = {name: (("mode", "point"), values.reshape(shape), {}) for name, values in flat.items()}
    packings = verified.damping.reshape(-1, *shape)
    own = {"natural_frequency": drives.frequency, "mode_amplitude": drives.amplitude}
    found |= {name: ("mode", values.reshape(shape)[:, 0], {}) for name, values in own.items()}
    return found | {"damping_ratio": (("packing", "mode", "point"), packings, {})}


def _designs(answer: Answer) -> dict:
    """Columns of the designs, one for each variable of the problem among them."""
    chosen, rest = answer.verified, [*answer.front, *answer.runners_up]
    every: list[Assessment] = [chosen.least, *rest]
    probability = [chosen.probability, *(one.probability for one in rest)]
    role = [CHOSEN, *[FRONT] * len(answer.front), *[RUNNER_UP] * len(answer.runners_up)]
    columns = {
        "role": role,
        "particle_mass": [one.design.mass for one in every],
        "least_damping": [one.least for one in every],
        "least_damping_low": [one.interval[0] for one in every],
        "least_damping_high": [one.interval[1] for one in every],
        "force": [one.force for one in every],
        "probability": probability,
    }
    found = {name: ("design", values, {}) for name, values in columns.items()}
    for path, name in coordinate_names(variable.path for variable in answer.problem.variables).items():
        found[name] = ("design", [one.design.values[path] for one in every], attributes(path))
    return found


def _totals(answer: Answer) -> dict:
    verified, wanted = answer.verified, answer.problem.target.damping
    low, high = verified.probability_interval
    values = {
        "least_mass": answer.bounds.least_mass,
        "confidence": answer.problem.design.confidence,
        "claimed": int(answer.claimed),
        "cases": answer.cases,
        "attempts": answer.attempts,
    }
    if wanted is not None:
        values |= {"target_damping": wanted, "target_probability": verified.probability}
        values |= {"target_probability_low": low, "target_probability_high": high}
    if answer.sensitivity is not None:
        values["tolerance_probability"] = answer.sensitivity.probability
    return {name: ((), value, {}) for name, value in values.items()}


def _tolerances(answer: Answer) -> dict:
    if answer.sensitivity is None:
        return {}
    every = answer.sensitivity.tolerances
    columns = {
        "tolerance": [one.name for one in every],
        "tolerance_unit": [attributes(tuple(one.name.split(".")))["units"] for one in every],
        "tolerance_value": [one.value for one in every],
        "tolerance_low": [one.range[0] for one in every],
        "tolerance_high": [one.range[1] for one in every],
        "kept_low": [one.kept[0] for one in every],
        "kept_high": [one.kept[1] for one in every],
    }
    return {name: ("tolerance", values, {"long_name": "scalar that is varied"}) for name, values in columns.items()}


def _attributes(answer: Answer) -> dict:
    about = provenance()
    about["history"] = about["history"].replace("warpdamp run", "warpdamp design")
    problem = answer.problem
    return about | {
        "title": problem.config.title,
        "goal": goal_words(problem.design),
        "target_over": problem.target.over,
        "target_range": list(getattr(problem.target, problem.target.over)),
        "motion": answer.bounds.motion,
        "why": answer.bounds.why,
        "left_out": "; ".join(left_out(answer.sensitivity)) if answer.sensitivity else "",
        "configuration": resolved_yaml(answer.configuration()),
        "problem": resolved_yaml(problem.config),
    }
