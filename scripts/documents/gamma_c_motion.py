"""Mean cycle of beds round the optimum of two-sided collision: recording, and what it says; see ``gamma_c.py``."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import xarray as xr

from warpdamp import Batch, Case, Drive, prepare
from warpdamp.config.study import Config
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene.paper import COUNT, RADIUS, damper
from warpdamp.scene.scene import STANDARD_GRAVITY
from warpdamp.sweep.cases import Cases

SEEDS, FREQUENCIES, RATIOS = (1, 2, 3, 4), (28.0, 40.0, 52.0, 64.0), (0.8, 0.95, 1.1, 1.25, 1.4)
CYCLES, RECORDED, SAMPLES, STEPS = 36, 20, 48, 12
"""Cycles, those at the end that are recorded, and records of a cycle; steps a contact."""

TOTALS = "floor_impulse", "lid_impulse", "work_input"
"""Running totals that are recorded."""

PHASE = np.arange(SAMPLES) / SAMPLES
"""Of the records, in cycles: the enclosure moves up fastest at 0 and down fastest at 0.5."""

COLUMNS = (
    *("f [Hz]", "Gamma", "over the block's", "travel [mm]", "thickness [mm]", "speed", "floor", "lid"),
    *("middle", "length", "side"),
)


def record(frequency: float, config: Config, block: float) -> xr.Dataset:
    """Mean cycle of some packings of a job, seen from the enclosure: (frequency, ratio, seed, sample).

    Parameters
    ----------
    frequency : [Hz]
    config : whose packings are taken
    block : Gamma of collision of a plastic block, which ``RATIOS`` multiply
    """
    beds = {spec.bed.seed: spec.bed for spec in Cases(config).specs()}
    packings = {seed: prepare(beds[seed]) for seed in SEEDS}
    cases, steps = [], []
    for ratio, seed in itertools.product(RATIOS, SEEDS):
        scene, state = beds[seed].scene.driven(Drive(frequency, ratio * block * STANDARD_GRAVITY)), packings[seed].state
        steps.append(steps_per_cycle(scene, state, steps_per_contact=STEPS))
        cases.append(Case(scene, state, 1 / (frequency * steps[-1])))
    records = list(_records(Batch(cases, max_rows=CYCLES + 1), np.array(steps)))
    shape = len(RATIOS), len(SEEDS), SAMPLES
    columns = {}
    for name in records[0][0]:
        cycles = [_mean_cycle(name, [row[k][name] for row in records]) for k in range(len(cases))]
        columns[name] = (("ratio", "seed", "sample"), np.reshape(cycles, shape))
    rest = {
        "clearance": [packings[seed].clearance for seed in SEEDS],
        "thickness_at_rest": [_thickness(packings[seed].state) for seed in SEEDS],
    }
    columns |= {name: ("seed", values) for name, values in rest.items()} | {
        "gamma": ("ratio", block * np.array(RATIOS))
    }
    coordinates = {"ratio": list(RATIOS), "seed": list(SEEDS), "sample": PHASE}
    return xr.Dataset(columns, coordinates).expand_dims(frequency=[frequency])


def _records(batch: Batch, steps: np.ndarray) -> Iterator[list[dict[str, float]]]:
    """What is recorded of every case, at every sample of the last cycles."""
    for sample in range((CYCLES - RECORDED) * SAMPLES, CYCLES * SAMPLES + 1):
        batch.advance(np.rint(sample * steps / SAMPLES).astype(int))
        yield [_at(state, ledger) for state, ledger in batch.read()]


def _at(state, ledger) -> dict[str, float]:
    """Height and speed of the centre of mass, how thick the bed is, and running totals."""
    height, speed = (float(vector[:, 2].mean()) for vector in (state.position, state.velocity))
    totals = {name: float(ledger[name][-1]) for name in TOTALS}
    return {"height": height, "speed": speed, "thickness": _thickness(state), **totals}


def _mean_cycle(name: str, values: list[float]) -> np.ndarray:
    """Mean over the recorded cycles, (SAMPLES,): of a value at each sample, or of a total's increase to the next."""
    series = np.diff(values) if name in TOTALS else np.array(values[:-1])
    return series.reshape(-1, SAMPLES).mean(axis=0)


def _thickness(state) -> float:
    """Distance of the upper and the lower quarter's mean heights, over their share of a uniform bed's [m]."""
    heights = np.sort(state.position[:, 2])
    quarter = len(heights) // 4
    return float(heights[-quarter:].mean() - heights[:quarter].mean()) / 0.75 + 2 * RADIUS


def measures(cycle: xr.Dataset, frequency: float, gamma: float) -> dict[str, float]:
    """What the mean cycle of one packing says.

    Returns
    -------
    dict
        ``travel`` of the centre of mass [m]; ``thinnest`` and ``thickest``, the bed's thickness less that at rest [m];
        ``speed``, half of the range of its velocity in the laboratory over the largest of the enclosure, V; middles of
        the pushes of ``floor`` and ``lid`` [cycles]; their impulses' mean over 2 m V (``momentum``); the cosine of the
        pushes' phases (``middle``) and what is lost by their ``length``, both weighted with their impulses; and the
        share of the work by the ``side``, which floor and lid did not do.
    """
    largest = gamma * STANDARD_GRAVITY / (2 * np.pi * frequency)
    mass = COUNT * float(damper(gamma=0).mass(RADIUS))
    wave = np.cos(2 * np.pi * PHASE)
    inside = cycle["thickness"].values - float(cycle["thickness_at_rest"])
    pushes = np.stack([cycle["floor_impulse"].values, cycle["lid_impulse"].values])
    waves = pushes @ np.exp(2j * np.pi * (PHASE + 0.5 / SAMPLES))
    impulse = pushes.sum(axis=1)
    in_phase = np.array([waves[0].real, -waves[1].real])  # the lid is to push while the enclosure moves down
    return {
        "travel": float(np.ptp(cycle["height"].values)),
        "thinnest": float(inside.min()),
        "thickest": float(inside.max()),
        "speed": float(np.ptp(cycle["speed"].values + largest * wave)) / (2 * largest),
        "floor": float(np.angle(waves[0]) / (2 * np.pi)),
        "lid": float(np.angle(waves[1]) / (2 * np.pi)) % 1,
        "momentum": float(impulse.sum()) / (4 * mass * largest),
        "middle": float(in_phase.sum() / np.abs(waves).sum()),
        "length": float(np.abs(waves).sum() / impulse.sum()),
        "side": 1 - float(in_phase.sum()) * largest / float(cycle["work_input"].sum()),
    }


def means(motions: xr.Dataset) -> xr.Dataset:
    """``measures`` in the mean over packings: (frequency, ratio)."""
    rows = {}
    for name in measures(motions.isel(frequency=0, ratio=0, seed=0), 1.0, 1.0):
        rows[name] = (("frequency", "ratio"), np.zeros((motions.sizes["frequency"], motions.sizes["ratio"])))
    result = xr.Dataset(rows, {name: motions[name].values for name in ("frequency", "ratio")})
    for f, r in itertools.product(motions["frequency"].values, motions["ratio"].values):
        at = motions.sel(frequency=f, ratio=r)
        own = [measures(at.sel(seed=s), float(f), float(at["gamma"])) for s in at["seed"].values]
        for name in rows:
            result[name].loc[{"frequency": f, "ratio": r}] = float(np.mean([one[name] for one in own]))
    return result


def rows(motions: xr.Dataset):
    """A line of the table for each frequency and amplitude."""
    mean = means(motions)
    for f, r in itertools.product(mean["frequency"].values, mean["ratio"].values):
        at = {name: float(value) for name, value in mean.sel(frequency=f, ratio=r).data_vars.items()}
        yield (
            *(f"{f:g}", f"{float(motions['gamma'].sel(frequency=f, ratio=r)):.2f}", f"{r:g}"),
            *(f"{1e3 * at['travel']:.2f}", f"{1e3 * at['thinnest']:+.2f} / {1e3 * at['thickest']:+.2f}"),
            *(f"{at[name]:.2f}" for name in ("speed", "floor", "lid", "middle", "length", "side")),
        )
