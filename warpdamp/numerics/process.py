"""Gaussian process through noisy points in several dimensions, each point with a standard error of its own.

    y(x) = f(x) + scatter(x) + error,   f ~ GP(mean, s^2 Matern_5/2(|(x - x') / widths|)),

widths and size s those of the largest marginal likelihood (Rasmussen & Williams 2006, chapter 5, ISBN 0-262-18253-X;
leaving points out: section 5.4.2).  The scatter is what neighbouring points miss their predictions by, each left out
with its group, beyond what f and the errors explain: beds differ more where they begin to lift than elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..errors import MissingLibrary

JITTER = 1e-10
FITTED = 256
"""Points that the widths are fitted to, drawn at random where there are more: the time grows with their cube."""
NEIGHBOURS = 25
"""Points whose misses make the scatter at a place."""
ROUNDS = 2
"""Times that widths and scatter are fitted in turn."""
LEAST_SCATTER = 0.02
"""Scatter, over the standard deviation of f, that is assumed at the least."""
NARROWEST, WIDEST = 0.1, 30.0
"""Bounds of the widths, in standard deviations of the points along each axis."""


@dataclass(frozen=True)
class Process:
    """Gaussian process with its hyperparameters.

    Parameters
    ----------
    x : (n, d) array
        Points.
    y, error : (n,) arrays
        Values there and their standard errors.
    widths : (d,) array
        Distances over which f changes, along each axis.
    size : float
        Standard deviation of f.
    mean : float
        Of f far from all points.
    misses : (n,) array
        Squares of what each point misses its prediction by, less what f and its error explain.
    """

    x: np.ndarray
    y: np.ndarray
    error: np.ndarray
    widths: np.ndarray
    size: float
    mean: float
    misses: np.ndarray

    def kernel(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Covariance of f between points (n, d) and (m, d), (n, m)."""
        from scipy.spatial.distance import cdist

        r = np.sqrt(5.0) * cdist(a / self.widths, b / self.widths)
        return self.size**2 * (1 + r + r**2 / 3) * np.exp(-r)

    @cached_property
    def _factor(self):
        from scipy.linalg import cho_factor

        noise = self.error**2 + self.scatter(self.x) ** 2 + JITTER * self.size**2
        return cho_factor(self.kernel(self.x, self.x) + np.diag(noise), lower=True)

    @cached_property
    def _weights(self) -> np.ndarray:
        from scipy.linalg import cho_solve

        return cho_solve(self._factor, self.y - self.mean)

    @cached_property
    def _tree(self):
        from scipy.spatial import cKDTree

        return cKDTree(self.x / self.widths)

    def scatter(self, x: np.ndarray) -> np.ndarray:
        """Standard deviation by which points at (m, d) differ beyond their errors, (m,)."""
        near = self._tree.query(x / self.widths, k=min(NEIGHBOURS, len(self.y)))[1]
        near = near.reshape(len(x), -1)
        return np.sqrt(np.maximum(self.misses[near].mean(axis=1), (LEAST_SCATTER * self.size) ** 2))

    def predict(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of f at points (m, d), each (m,): of f itself, without scatter."""
        from scipy.linalg import solve_triangular

        across = self.kernel(x, self.x)
        half = solve_triangular(self._factor[0], across.T, lower=True)
        variance = self.size**2 - np.sum(half**2, axis=0)
        return self.mean + across @ self._weights, np.sqrt(np.maximum(variance, 0.0))

    def joint(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean (m,) and covariance (m, m) of f at points (m, d)."""
        mean, covariance = self.joints(x[None])
        return mean[0], covariance[0]

    def joints(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Means (k, m) and covariances (k, m, m) of f at sets of points (k, m, d), each set for itself."""
        from scipy.linalg import solve_triangular

        sets, size, axes = x.shape
        across = self.kernel(x.reshape(-1, axes), self.x)
        half = solve_triangular(self._factor[0], across.T, lower=True).reshape(-1, sets, size)
        own = np.array([self.kernel(one, one) for one in x])
        mean = self.mean + (across @ self._weights).reshape(sets, size)
        return mean, own - np.einsum("nki,nkj->kij", half, half, optimize=True)

    def left_out(self, groups: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of each y as predicted without its group, each (n,); noise included.

        Parameters
        ----------
        groups : (n,) array
            Points that share a number are left out together; hyperparameters stay those of all points.
        """
        from scipy.linalg import cho_solve

        inverse = cho_solve(self._factor, np.eye(len(self.y)))
        mean, spread = np.empty(len(self.y)), np.empty(len(self.y))
        for group in np.unique(groups):
            rows = np.flatnonzero(groups == group)
            covariance = np.linalg.inv(inverse[np.ix_(rows, rows)])
            mean[rows] = self.y[rows] - covariance @ self._weights[rows]
            spread[rows] = np.sqrt(np.diag(covariance))
        return mean, spread

    def of(self, rows: np.ndarray) -> Process:
        """Process through some of the points, its hyperparameters unchanged."""
        own = {name: getattr(self, name)[rows] for name in ("x", "y", "error", "misses")}
        return replace(self, **own)


def fit(x, y, error, groups) -> Process:
    """Process through points, its hyperparameters those of the largest marginal likelihood.

    Parameters
    ----------
    x : (n, d) array
    y, error : (n,) arrays
    groups : (n,) array of integers
        Points that share one, as those of one bed, do not err independently.

    Raises
    ------
    ValueError
        If there are fewer points than four, or than two more than dimensions.
    MissingLibrary
        If scikit-learn is not installed.
    """
    from threadpoolctl import threadpool_limits

    x, y, error = np.asarray(x, float), np.asarray(y, float), np.asarray(error, float)
    if len(y) < max(4, x.shape[1] + 2):
        raise ValueError(f"{len(y)} points are too few for a Gaussian process in {x.shape[1]} dimensions")
    rows = np.sort(np.random.default_rng(0).permutation(len(y))[:FITTED])
    scale = np.std(x, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    groups, mean = np.asarray(groups), float(np.mean(y))
    process = Process(x, y, error, scale, max(float(np.std(y)), JITTER), mean, np.zeros(len(y)))
    with threadpool_limits(1):  # matrices are small: more threads take longer, by far so on a busy machine
        for _ in range(1 + ROUNDS):
            noise = np.hypot(error, process.scatter(x))
            widths, size = _likeliest(x[rows], y[rows] - mean, noise[rows], scale, process.size)
            process = replace(process, widths=widths, size=size)
            predicted, spread = process.left_out(groups)
            of_f = np.maximum(spread**2 - np.hypot(error, process.scatter(x)) ** 2, 0.0)
            process = replace(process, misses=(y - predicted) ** 2 - of_f - error**2)
    return process


def _likeliest(x, y, noise, scale, spread: float) -> tuple[np.ndarray, float]:
    """Widths (d,) and size of the largest marginal likelihood."""
    import warnings

    try:
        from sklearn.exceptions import ConvergenceWarning
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel
    except ImportError:
        line = "emulators need scikit-learn: pip install 'warpdamp[design]'"
        raise MissingLibrary(line, name="sklearn") from None

    matern = Matern(np.ones(x.shape[1]), (NARROWEST, WIDEST), nu=2.5)
    kernel = ConstantKernel(1.0, (0.05, 50.0)) * matern + WhiteKernel(1e-3, (1e-8, 0.5))
    found = GaussianProcessRegressor(kernel, alpha=(noise / spread) ** 2 + JITTER, random_state=0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # a width at its bound: the axis has no effect
        found.fit(x / scale, y / spread)
    product = found.kernel_.k1
    return np.atleast_1d(product.k2.length_scale) * scale, spread * float(np.sqrt(product.k1.constant_value))
