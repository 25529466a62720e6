"""Coupled runs as a Dataset: what was recorded, and what an experimenter would read off it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..analysis.results import provenance
from ..config.reading import resolved_yaml
from ..scene.scene import STANDARD_GRAVITY
from ..variables import describe
from . import forces, noise, response
from .excitation import ends_within
from .identify import Identified, from_decay, from_response

if TYPE_CHECKING:
    import xarray as xr

    from ..config.coupled import CoupledConfig
    from ..config.study import Config
    from ..scene.host import Signal
    from .run import Run

WINDOW = 10
"""Cycles of a harmonic signal over which a mode is read."""

AVERAGES = 8
"""Pieces that the spectra of random signals are averaged over, half of each overlapping the next."""

STEADY = 0.02
"""A window is steady if its amplitude is the one before's to this part."""


def assembled(
    config: Config, runs: dict[tuple[int, int], Run], found: dict, signals: list[Signal | None]
) -> xr.Dataset:
    """Records, energies and readings of all runs, by (level, seed)."""
    import xarray as xr

    own, seeds = config.coupled, config.seeds
    shape = (len(own.levels), len(seeds))
    records = np.array([[found[i, j]["records"] for j in range(shape[1])] for i in range(shape[0])])
    several = records.shape[2] > 1
    if not several:
        records = records[:, :, 0]
    time = records[(0,) * (records.ndim - 2)][:, 0]
    series = ("level", "seed", *(("damper",) if several else ()), "time")
    data = {
        "structure_displacement": (series, records[..., 1]),
        "structure_acceleration": (series, records[..., 2]),
        "reaction": (series, records[..., 3]),
    }
    if not own.release:
        name = "base_acceleration" if own.base else "applied_force"
        data[name] = (("level", "time"), np.array([forces.applied(signal, time) for signal in signals]))
    for name in ("force_work", "structure_loss", "particle_loss", "closure", "cpu_time"):
        shown = "base_work" if own.base and name == "force_work" else name
        values = np.array([[found[i, j][name] for j in range(shape[1])] for i in range(shape[0])])
        if name == "particle_loss":
            data[shown] = (series[:-1], values if several else values[..., 0])
        else:
            data[shown] = (("level", "seed"), values)
    coords = {"level": own.levels, "seed": seeds, "time": ("time", time, {"units": "s"})}
    if several:
        coords["damper"] = ("damper", np.arange(1, 1 + records.shape[2]), {"units": "1", "long_name": "damper"})
    dataset = xr.Dataset(data, coords)
    read = _identified(own, runs, found, shape)
    dataset = describe(dataset.merge(read).merge(_root_mean_squares(own, dataset, signals)))
    dataset.attrs = {"title": f"{config.title}, coupled", **provenance(), "configuration": resolved_yaml(config)}
    dataset.attrs |= read.attrs
    return dataset


def _root_mean_squares(own: CoupledConfig, dataset: xr.Dataset, signals: list[Signal]) -> xr.Dataset:
    """Root mean squares of noise and of its answer: applied, tabulated, and of the acceleration in the second half."""
    import xarray as xr

    random = own.signals.random
    if not random:
        return xr.Dataset()
    name, unit = ("base_grms", STANDARD_GRAVITY) if own.base else ("force_rms", 1.0)
    late = dataset["structure_acceleration"].isel(time=slice(dataset.sizes["time"] // 2, None))
    given = noise.rms(random.spectrum) if random.spectrum else random.rms
    return xr.Dataset(
        {
            name: ("level", [forces.root_mean_square(signal.samples) / unit for signal in signals]),
            f"{name}_asked": ("level", given * np.array(own.levels) / unit),
            "response_grms": np.sqrt((late**2).mean("time")) / STANDARD_GRAVITY,
        }
    )


def _identified(own: CoupledConfig, runs, found, shape) -> xr.Dataset:
    """Dataset of what an experimenter would identify from the records at the first damper."""
    import xarray as xr

    host = runs[0, 0].host
    if own.release or own.signals.harmonic:
        if len(host.frequency) > 1:
            return xr.Dataset()
        read = {
            index: from_decay(one["records"][0])
            if own.release
            else from_response(one["records"][0], runs[index].host, WINDOW)
            for index, one in found.items()
        }
        return _windows(read, shape)
    step = runs[0, 0].dt * host.record
    curves, moving = [], 0.0
    for i in range(shape[0]):
        signal = runs[i, 0].host.excitation
        records = [found[i, j]["records"][0] for j in range(shape[1])]
        if own.signals.recorded and ends_within(signal, own.duration):
            moving = max(moving, *(response.still_moving(one[:, 1]) for one in records))
            frequency, curve = response.whole(signal, [one[:, 1] for one in records], step)
        else:
            pairs = [(forces.applied(signal, one[:, 0]), one[:, 1]) for one in records]
            frequency, curve = response.averaged(pairs, step, 1 if own.signals.swept else AVERAGES)
        curves.append(curve)
    if moving > response.AT_REST:
        return xr.Dataset(attrs={"left_out": _left_out(own, moving)})
    return _curve(own, frequency, np.array(curves) + (1.0 if own.base else 0.0))


def _left_out(own: CoupledConfig, moving: float) -> str:
    return (
        f"no {_name(own)}: in the last {100 * response.TAPER:g} % of the run the structure still moves by "
        f"{100 * moving:.2g} % of its largest displacement, and {100 * response.AT_REST:g} % are allowed: take a "
        "longer coupled.duration"
    )


def _name(own: CoupledConfig) -> str:
    return "transmissibility" if own.base else "accelerance"


def _curve(own: CoupledConfig, frequency: np.ndarray, curves: np.ndarray) -> xr.Dataset:
    """Accelerance or transmissibility where the excitation has power, on (level, frequency)."""
    import xarray as xr

    low, high = _band(own)
    kept = (frequency > 0) & (frequency >= low) & (frequency <= high) & np.isfinite(curves).all(axis=0)
    curves = curves[:, kept]
    dims = ("level", "frequency")
    curve = xr.Dataset(
        {f"{_name(own)}_real": (dims, curves.real), f"{_name(own)}_imaginary": (dims, curves.imag)},
        {"frequency": ("frequency", frequency[kept], {"units": "Hz"})},
    )
    return curve.squeeze("level", drop=True) if len(curves) == 1 else curve  # one curve is what `fit` reads


def _band(own: CoupledConfig) -> tuple[float, float]:
    """Frequencies between which a signal was asked to have power [Hz]."""
    random = own.signals.random
    if random and random.spectrum:
        return random.spectrum[0][0], random.spectrum[-1][0]
    band = own.signals.swept or random
    return (min(band.from_, band.to), max(band.from_, band.to)) if band else (0.0, np.inf)


def _windows(read: dict[tuple[int, int], list[Identified]], shape) -> xr.Dataset:
    import xarray as xr

    longest = max(len(one) for one in read.values())
    values = np.full((3, *shape, longest), np.nan)
    for (i, j), one in read.items():
        for k, window in enumerate(one):
            values[:, i, j, k] = window.gamma, window.frequency, window.damping
    with np.errstate(invalid="ignore"):
        steady = abs(values[0, ..., 1:] / values[0, ..., :-1] - 1) <= STEADY
    steady = np.concatenate([np.zeros((*shape, 1), bool), steady], axis=-1)
    dims = ("level", "seed", "window")
    names = ("window_gamma", "window_frequency", "window_damping_ratio")
    return xr.Dataset(
        {name: (dims, own) for name, own in zip(names, values, strict=True)}
        | {"window_steady": (dims, steady.astype(np.int8))},
        {"window": np.arange(1, longest + 1)},
    )
