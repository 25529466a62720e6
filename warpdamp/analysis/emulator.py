"""Emulator: effectiveness between the cases of a sweep, with intervals, by a Gaussian process.

The process goes through the logarithm of the effectiveness, over the logarithms of frequency and Gamma and the swept
scalars; the noise of each case is its own: of the average over its cycles, of its bed's state (``memory_error``) and of
its step, and what neighbouring cases differ by beyond that.  What it predicts is the mean over packings; what a single
packing may differ from it by is ``effectiveness_scatter``.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from ..errors import UsageError
from ..numerics.process import Process, fit
from ..status import FIRST_UNFINISHED

LOGARITHMIC = 3.0
"""Ratio of the largest to the smallest value from which a positive scalar is taken by its logarithm."""

ALWAYS_LOGARITHMIC = ("frequency", "gamma")

UNSURE = 0.5
"""Part of its spread over the whole sweep that the emulator must know a value to, or it is not to be trusted there."""

NOISE = ("energy_dissipated_standard_error", "memory_error", "discretisation_error")
NORMAL_95 = 1.959964

REFERENCES = 256
"""Points at which the emulator's mean error is taken."""


@dataclass(frozen=True)
class Input:
    """Axis of an emulator.

    Parameters
    ----------
    name : str
    low, high : float
        Range of the cases.
    logarithmic : bool
        Whether the process takes its logarithm.
    units : str
    """

    name: str
    low: float
    high: float
    logarithmic: bool
    units: str

    def taken(self, value) -> np.ndarray:
        """Values as the process takes them."""
        return np.log(value) if self.logarithmic else np.asarray(value, float)


class Emulator:
    """Effectiveness between the cases of a sweep; see ``dataset.damper.emulator()``.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results.

    Raises
    ------
    UsageError
        If the results are of several dampers, a swept scalar is no number, or there are too few cases.
    """

    def __init__(self, dataset: xr.Dataset):
        if "damper" in dataset.dims:
            raise UsageError("results of several dampers: an emulator is of one, as `warpdamp collect` gives each")
        names = _input_names(dataset)
        value = dataset["effectiveness"]
        relative = sum((dataset[name] / dataset["energy_dissipated"]) ** 2 for name in NOISE if name in dataset)
        columns = [_input_values(dataset, name) for name in names]
        value, relative, status, seed, *columns = xr.broadcast(
            value, relative, dataset["status"], dataset.get("seed", xr.DataArray(0)), *columns
        )
        table = np.stack([column.values.ravel().astype(float) for column in columns], axis=1)
        value, relative, status, seed = (a.values.ravel() for a in (value, relative, status, seed))
        known = np.isfinite(value) & (value > 0) & np.isfinite(relative) & np.isfinite(table).all(axis=1)
        known &= (status >= 0) & (status < FIRST_UNFINISHED)
        table = table[known]
        if not len(table):
            raise UsageError("an emulator needs finished cases, and there is none")
        self.inputs = [
            Input(name, float(column.min()), float(column.max()), _logarithmic(name, column), _units(dataset, name))
            for name, column in zip(names, table.T, strict=True)
        ]
        """Axes, in order."""
        rest = [k for k, name in enumerate(names) if name not in ALWAYS_LOGARITHMIC]
        beds = np.column_stack([table[:, rest], seed[known].astype(float)])
        self._beds = np.unique(beds, axis=0, return_inverse=True)[1].ravel()
        points = np.stack([axis.taken(c) for axis, c in zip(self.inputs, table.T, strict=True)], axis=1)
        try:
            self.process: Process = fit(points, np.log(value[known]), np.sqrt(relative[known]), self._beds)
        except ValueError as error:
            raise UsageError(f"an emulator cannot be made: {error}") from None

    def __repr__(self) -> str:
        axes = ", ".join(f"{axis.name} {axis.low:.4g} to {axis.high:.4g}" for axis in self.inputs)
        return f"Emulator of {len(self.process.y)} cases over {axes}"

    @property
    def names(self) -> list[str]:
        """Names of the inputs."""
        return [axis.name for axis in self.inputs]

    def predict(self, **at) -> xr.Dataset:
        """Effectiveness at any inputs, mean over packings, with its 95 % interval.

        Parameters
        ----------
        **at : float, array or xarray.DataArray
            Value of each input by name (SI); one that had a single value in the sweep may be left out.  DataArrays are
            broadcast by their dimensions; an array of a name becomes a dimension of that name.

        Returns
        -------
        xarray.Dataset
            ``effectiveness``, ``effectiveness_standard_error``, ``effectiveness_low`` and ``effectiveness_high`` (95 %
            interval), ``effectiveness_scatter`` (standard deviation of single packings about it, beyond the errors of
            their averages), and ``trusted``: 0 outside the range of the cases, or where the cases say little.

        Raises
        ------
        UsageError
            If an input is missing, or is none of this emulator.
        """
        columns = xr.broadcast(*self._given(at))
        template = columns[0]
        raw = np.stack([column.values.ravel().astype(float) for column in columns], axis=1)
        log_mean, spread = self.process.predict(self.points(raw))
        scatter = self.process.scatter(self.points(raw))
        trusted = self._inside(raw) & (spread <= UNSURE * self.process.size)

        def shaped(values):
            return xr.DataArray(values.reshape(template.shape), template.coords, template.dims)

        value = np.exp(log_mean)
        return _described(
            xr.Dataset(
                {
                    "effectiveness": shaped(value),
                    "effectiveness_standard_error": shaped(value * spread),
                    "effectiveness_low": shaped(value * np.exp(-NORMAL_95 * spread)),
                    "effectiveness_high": shaped(value * np.exp(NORMAL_95 * spread)),
                    "effectiveness_scatter": shaped(value * scatter),
                    "trusted": shaped(trusted.astype(np.int64)),
                }
            )
        )

    def points(self, raw: np.ndarray) -> np.ndarray:
        """Points (m, d) of the process at values (m, d) of the inputs, in their order."""
        if any(np.any(c <= 0) for axis, c in zip(self.inputs, raw.T, strict=True) if axis.logarithmic):
            raise UsageError("an input that is taken by its logarithm must be positive")
        return np.stack([axis.taken(c) for axis, c in zip(self.inputs, raw.T, strict=True)], axis=1)

    def cross_validation(self) -> xr.Dataset:
        """Every case as predicted from the others, whole beds left out together.

        Returns
        -------
        xarray.Dataset
            ``observed``, ``predicted`` and ``deviation`` (of the logarithms, over the standard deviation of both) of
            every case; attributes ``coverage``, the part within its 95 % interval, and ``rms``, relative.
        """
        mean, spread = self.process.left_out(self._beds)
        deviation = (self.process.y - mean) / spread
        coverage = float(np.mean(np.abs(deviation) <= NORMAL_95))
        rms = float(np.sqrt(np.mean((self.process.y - mean) ** 2)))
        return xr.Dataset(
            {
                "observed": ("case", np.exp(self.process.y)),
                "predicted": ("case", np.exp(mean)),
                "deviation": ("case", deviation),
            },
            attrs={"coverage": coverage, "rms": rms},
        )

    def mean_error(self, rows: np.ndarray | None = None) -> float:
        """Relative standard error of the emulator, mean over its range; with some of its cases only, by their rows."""
        process = self.process if rows is None else self.process.of(rows)
        return float(np.mean(process.predict(self._references())[1]))

    def cases_to_halve(self) -> int:
        """Number of further cases that would halve the emulator's mean error.

        By the power law that its error follows from a quarter over a half to all of its cases, widths unchanged; those
        are added as these were spread, beds included.

        Raises
        ------
        UsageError
            If the error does not fall with the cases: there are too few to say.
        """
        rng, n = np.random.default_rng(0), len(self.process.y)
        order = rng.permutation(n)
        sizes = [max(4, n // 4), max(4, n // 2), n]
        errors = [self.mean_error(np.sort(order[:size])) for size in sizes]
        slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
        if slope > -0.02:
            raise UsageError(f"{n} cases are too few to say how many halve the error")
        return int(np.ceil(n * (2 ** (-1 / slope) - 1)))

    def _references(self) -> np.ndarray:
        from scipy.stats import qmc

        unit = qmc.Sobol(len(self.inputs), seed=np.random.default_rng(0)).random(REFERENCES)
        low, high = (self.points(np.array([[getattr(a, end) for a in self.inputs]]))[0] for end in ("low", "high"))
        return low + (high - low) * unit

    def _given(self, at: dict[str, object]) -> list[xr.DataArray]:
        unknown = [name for name in at if name not in self.names]
        if unknown:
            raise UsageError(f"{unknown[0]}: is not an input of this emulator: choose from {', '.join(self.names)}")
        missing = [axis.name for axis in self.inputs if axis.name not in at and axis.low < axis.high]
        if missing:
            raise UsageError(f"{missing[0]}: say at which value, as predict({missing[0]}=...)")
        found = []
        for axis in self.inputs:
            value = at.get(axis.name, axis.low)
            if not isinstance(value, xr.DataArray):
                dims: tuple[Hashable, ...] = (axis.name,) if np.ndim(value) else ()
                value = xr.DataArray(np.asarray(value, float), {d: value for d in dims}, dims)
            found.append(value)
        return found

    def _inside(self, raw: np.ndarray) -> np.ndarray:
        slack = 1e-9
        low, high = (np.array([getattr(axis, end) for axis in self.inputs]) for end in ("low", "high"))
        room = slack * np.maximum(np.abs(low), np.abs(high))
        return np.all((raw >= low - room) & (raw <= high + room), axis=1)


def _input_names(dataset: xr.Dataset) -> list[str]:
    """Names of the inputs: frequency, Gamma, and every scalar that the sweep varied."""
    names = ["frequency", "gamma"]
    for name, coordinate in dataset.coords.items():
        if name in (*names, "seed", "case", "mode", "leg", "leg_direction") or not coordinate.dims:
            continue
        if coordinate.dims == ("mode",):
            continue
        if coordinate.dtype.kind not in "fiu":
            raise UsageError(f"{name}: an emulator takes numbers only: choose one value, as dataset.sel({name}=...)")
        names.append(str(name))
    return names


def _input_values(dataset: xr.Dataset, name: str) -> xr.DataArray:
    values = dataset["excitation_frequency"] if name == "frequency" else dataset[name]
    return values.drop_vars([c for c in values.coords if c not in values.dims])


def _logarithmic(name: str, values: np.ndarray) -> bool:
    return name in ALWAYS_LOGARITHMIC or bool(values.min() > 0 and values.max() >= LOGARITHMIC * values.min())


def _units(dataset: xr.Dataset, name: str) -> str:
    return "Hz" if name == "frequency" else dataset[name].attrs.get("units", "1")


def _described(dataset: xr.Dataset) -> xr.Dataset:
    names = {
        "effectiveness": "dissipation effectiveness, mean over packings, emulated",
        "effectiveness_standard_error": "standard error of the emulated effectiveness",
        "effectiveness_low": "lower end of the 95 % interval",
        "effectiveness_high": "upper end of the 95 % interval",
        "effectiveness_scatter": "standard deviation of single packings",
        "trusted": "whether the cases say enough there",
    }
    for name, long_name in names.items():
        dataset[name].attrs.update(units="1", long_name=long_name)
    return dataset
