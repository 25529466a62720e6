"""Calibration of swept scalars, as restitution and friction, by measured damping: a posterior over their ranges.

The prior is even over the ranges of the sweep.  The likelihood is normal, its covariance that of the measurement, of
the emulator, and of the packing that was measured:

    zeta_measured ~ N((2 / pi) eps(theta) m phi^2 + inherent, C),   C = diag(s^2 + (scatter of packings)^2) + emulator.

It is taken at points of a low-discrepancy set, with their weights: no chain has to converge.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

from ..analysis.emulator import Emulator
from ..errors import UsageError
from ..numerics.tolerance import LOOSE_MEMORY
from .apparent_mass import require_modes
from .damping import damping_of_effectiveness
from .measured import Measured

POINTS = 2048
CHUNK = 256
REGION = 0.95


@dataclass(frozen=True)
class Posterior:
    """Posterior of scalars.

    Parameters
    ----------
    names : of the scalars
    points : (n, d) values
    weights : (n,) which add up to 1
    log_likelihood : (n,)
    predicted, spread : (p,) damping at the measured points: mean over the posterior, and its standard deviation
    before : (p,) standard deviation over the prior: what the input's uncertainty explains
    model : callable of values (d,), the logarithm of the likelihood
    """

    names: list[str]
    points: np.ndarray
    weights: np.ndarray
    log_likelihood: np.ndarray
    predicted: np.ndarray
    spread: np.ndarray
    before: np.ndarray
    model: object

    @property
    def mean(self) -> np.ndarray:
        """Mean of each scalar, (d,)."""
        return self.weights @ self.points

    @property
    def standard_deviation(self) -> np.ndarray:
        """Standard deviation of each scalar, (d,)."""
        return np.sqrt(self.weights @ (self.points - self.mean) ** 2)

    @property
    def effective_points(self) -> float:
        """Points that the weights amount to."""
        return float(1 / np.sum(self.weights**2))

    @property
    def threshold(self) -> float:
        """Logarithm of the likelihood at the edge of the 95 % region of highest density."""
        order = np.argsort(-self.log_likelihood)
        within = int(np.searchsorted(np.cumsum(self.weights[order]), REGION))
        return float(self.log_likelihood[order[min(within, len(order) - 1)]])

    def interval(self) -> np.ndarray:
        """Ends of the 95 % interval of each scalar, (d, 2)."""
        ends = []
        for column in self.points.T:
            order = np.argsort(column)
            total = np.cumsum(self.weights[order])
            ends.append(np.interp([(1 - REGION) / 2, (1 + REGION) / 2], total, column[order]))
        return np.array(ends)

    def contains(self, values) -> bool:
        """Whether values (d,) lie in the 95 % region of highest density."""
        return bool(self.model(np.asarray(values, float)) >= self.threshold)


def calibrate(
    dataset: xr.Dataset,
    measured: Measured,
    emulator: Emulator | None = None,
    *,
    known: Mapping[str, float] = MappingProxyType({}),
) -> Posterior:
    """Posterior of the scalars that results were swept over.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results with a structure, swept over scalars that change no mass.
    measured : Measured
        Damping ratios with their standard errors.
    emulator : Emulator, optional
        Of the results (default: made here).
    known : mapping, optional
        Values of swept scalars that are known, by name: the others are calibrated.

    Raises
    ------
    UsageError
        If nothing was swept, masses differ, or the measurement has no errors.
    """
    from scipy.stats import qmc

    require_modes(dataset)
    emulator = emulator or Emulator(dataset)
    swept = [axis for axis in emulator.inputs if axis.name not in ("frequency", "gamma") and axis.low < axis.high]
    scalars = [axis for axis in swept if axis.name not in known]
    if not scalars:
        raise UsageError("nothing to calibrate: the results were swept over nothing, as contact.friction: [0.2, 0.5]")
    mass = np.unique(dataset["particle_mass"].values)
    if np.ptp(mass) > 1e-9 * mass.max():
        raise UsageError("a calibration is over scalars that change no mass, as restitution and friction")
    used = np.isfinite(measured.values["damping_ratio"])
    if not used.any() or not np.isfinite(measured.errors["damping_ratio"][used]).all():
        raise UsageError("a calibration needs measured damping ratios, each with damping_ratio_standard_error")
    modes = _of_modes(dataset, measured.mode[used])
    value, error = (table["damping_ratio"][used] for table in (measured.values, measured.errors))
    per_effect = damping_of_effectiveness(1.0, float(mass[0]), modes["mode_amplitude"])
    low, high = (np.array([getattr(axis, end) for axis in scalars]) for end in ("low", "high"))
    points = low + (high - low) * qmc.Sobol(len(scalars), seed=np.random.default_rng(5)).random(POINTS)
    inputs = _inputs(emulator, scalars, dict(known), modes["natural_frequency"], measured.gamma[used])

    def predicted(thetas):
        """Damping (k, p) at the measured points, and its covariances (k, p, p), of scalars (k, d)."""
        at = np.array([inputs(theta) for theta in thetas])
        mean, covariance = emulator.process.joints(at)
        scatter = emulator.process.scatter(at.reshape(-1, at.shape[-1])).reshape(mean.shape)
        effect = per_effect * np.exp(mean)
        own = effect**2 * (scatter**2 + LOOSE_MEMORY**2)
        covariance = effect[:, :, None] * effect[:, None, :] * covariance + own[:, :, None] * np.eye(len(value))
        return effect + modes["inherent_damping"], covariance

    def likelihoods(thetas):
        """Logarithms of the likelihood (k,), and damping (k, p), of scalars (k, d)."""
        zeta, covariance = predicted(thetas)
        lower = np.linalg.cholesky(covariance + np.diag(error**2))
        white = np.linalg.solve(lower, (value - zeta)[:, :, None])[:, :, 0]
        spread = np.sum(np.log(np.diagonal(lower, axis1=1, axis2=2)), axis=1)
        return -0.5 * np.sum(white**2, axis=1) - spread, zeta

    with threadpool_limits(1):
        parts = [likelihoods(points[k : k + CHUNK]) for k in range(0, POINTS, CHUNK)]
    likelihood, every = (np.concatenate(part) for part in zip(*parts, strict=True))
    weights = np.exp(likelihood - likelihood.max())
    weights /= weights.sum()
    mean = weights @ every
    return Posterior(
        [axis.name for axis in scalars],
        points,
        weights,
        likelihood,
        mean,
        np.sqrt(weights @ (every - mean) ** 2),
        np.std(every, axis=0),
        lambda theta: float(likelihoods(theta[None])[0][0]),
    )


def _of_modes(dataset: xr.Dataset, numbers: np.ndarray) -> dict[str, np.ndarray]:
    """Frequency, amplitude and inherent damping of the mode of each measured point, (p,) each."""
    found = {}
    for name in ("natural_frequency", "mode_amplitude", "inherent_damping"):
        array = dataset[name]
        array = array.isel({dim: 0 for dim in array.dims if dim != "mode"})
        found[name] = array.sel(mode=xr.DataArray(numbers, dims="point")).values
    return found


def _inputs(emulator: Emulator, scalars, known: dict, frequency: np.ndarray, gamma: np.ndarray):
    """Function of the scalars' values (d,) that gives points (p, inputs) of the emulator's process."""

    def at(theta) -> np.ndarray:
        values = {axis.name: np.full(len(gamma), x) for axis, x in zip(scalars, theta, strict=True)}
        values |= {name: np.full(len(gamma), x) for name, x in known.items()}
        values |= {"frequency": frequency, "gamma": gamma}
        fixed = {axis.name: np.full(len(gamma), axis.low) for axis in emulator.inputs if axis.name not in values}
        return emulator.points(np.stack([(values | fixed)[name] for name in emulator.names], axis=1))

    return at
