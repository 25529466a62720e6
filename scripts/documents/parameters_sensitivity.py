"""What matters together: an emulator of the sampled dampers, its errors, and total-effect indices with intervals."""

from __future__ import annotations

import numpy as np
import xarray as xr
from parameters_data import DATA
from shared import table

INPUTS = {
    "density": "density", "youngs_modulus": "elastic modulus", "restitution": "restitution", "friction": "friction",
    "rolling_friction": "rolling friction", "gravity": "gravity", "frequency": "frequency", "gamma": "Γ",
    "clearance": "clearance of the bed",
}  # fmt: skip
LOGARITHMIC = ("density", "youngs_modulus")
FOLDS, POINTS, SEED = 10, 2048, 0
STUDIES = {"fluidisation": "280 Hz, Γ 1 to 3", "collision": "39.5 Hz, Γ 4 to 9"}
IMPORTANT = 0.05
"""Total effect above which an engineer has to know a parameter well."""


def inputs_and_answer(runs: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Inputs, each scaled to 0 to 1, and the logarithm of the effectiveness, of the cases that moved."""
    columns = [np.asarray(runs[name].values, float) for name in INPUTS]
    x = np.stack([np.log(c) if n in LOGARITHMIC else c for n, c in zip(INPUTS, columns, strict=True)], axis=1)
    eps = runs["effectiveness"].values
    known = np.isfinite(x).all(axis=1) & np.isfinite(eps) & (eps > 0)
    x, y = x[known], np.log(eps[known])
    return (x - x.min(axis=0)) / np.ptp(x, axis=0), y


def emulator(x, y, kernel=None):
    """Gaussian process with a width for each input and noise of its own; its widths are found unless they are given."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    optimizer = None if kernel is not None else "fmin_l_bfgs_b"
    widths = RBF(np.ones(x.shape[1]), (0.1, 100))
    kernel = kernel or ConstantKernel(1.0, (1e-2, 1e3)) * widths + WhiteKernel(0.05, (1e-4, 1.0))
    return GaussianProcessRegressor(kernel, optimizer=optimizer, normalize_y=True).fit(x, y)


def cross_validated(x, y, kernel) -> tuple[float, float, float, list]:
    """Error of left-out tenths, what part of the variance they explain, coverage, and the emulators."""
    order = np.random.default_rng(SEED).permutation(len(y))
    folds, errors, inside, made = np.array_split(order, FOLDS), [], [], []
    for fold in folds:
        rest = np.setdiff1d(order, fold)
        own = emulator(x[rest], y[rest], kernel)
        mean, spread = own.predict(x[fold], return_std=True)
        errors.append(y[fold] - mean)
        inside.append(np.abs(y[fold] - mean) < 1.96 * spread)
        made.append(own)
    error = np.concatenate(errors)
    explained = 1 - float(np.mean(error**2) / np.var(y))
    return float(np.sqrt(np.mean(error**2))), explained, float(np.mean(np.concatenate(inside))), made


def total_effects(predict, dimensions: int) -> np.ndarray:
    """Total-effect indices of independent inputs, by Jansen's estimator (1999, doi:10.1016/S0010-4655(98)00154-4)."""
    from scipy.stats import qmc

    both = qmc.Sobol(2 * dimensions, seed=SEED).random(POINTS)
    a, b = both[:, :dimensions], both[:, dimensions:]
    at_a = predict(a)
    variance = np.var(np.concatenate([at_a, predict(b)]))
    index = np.empty(dimensions)
    for k in range(dimensions):
        other = a.copy()
        other[:, k] = b[:, k]
        index[k] = np.mean((at_a - predict(other)) ** 2) / (2 * variance)
    return index


def of_study(name: str) -> list[str]:
    """Blocks of the document on one optimum."""
    path = DATA / f"sensitivity_{name}.nc"
    if not path.exists():
        command = f"python scripts/documents/parameters.py simulate sensitivity_{name}"
        return [f"Round the optimum of {name}: not run: `{command}`."]
    x, y = inputs_and_answer(xr.load_dataset(path))
    whole = emulator(x, y)
    error, explained, coverage, parts = cross_validated(x, y, whole.kernel_)
    index = total_effects(whole.predict, x.shape[1])
    left_out = np.array([total_effects(part.predict, x.shape[1]) for part in parts])
    spread = np.sqrt((FOLDS - 1) / FOLDS * np.sum((left_out - left_out.mean(axis=0)) ** 2, axis=0))
    rows = []
    low, high = np.full(x.shape[1], 0.5), np.full(x.shape[1], 0.5)
    for k in np.argsort(-index):
        one, other = low.copy(), high.copy()
        one[k], other[k] = 0.0, 1.0
        change = float(np.exp(np.diff(whole.predict(np.stack([one, other])))[0]) - 1)
        word = "must be known well" if index[k] - 2.26 * spread[k] > IMPORTANT else ""
        word = "hardly matters" if index[k] + 2.26 * spread[k] < IMPORTANT else word
        name_of = list(INPUTS.values())[k]
        rows.append([name_of, f"{index[k]:.3f} ± {2.26 * spread[k]:.3f}", f"{100 * change:+.0f} %", word])
    noise = float(np.exp(whole.kernel_.theta[-1])) * float(np.var(y))
    return [
        f"**Round the optimum of {name}** ({STUDIES[name]}): {len(y)} dampers.  Error of left-out tenths "
        f"{100 * error:.1f} %, {100 * explained:.0f} % of the variance explained, {100 * coverage:.0f} % of them in "
        f"their 95 % intervals; what one packing's run scatters by: {100 * np.sqrt(noise):.1f} %.  Total effects with "
        "95 % intervals (tenths left out in turn), and the change of the effectiveness from the lowest to the highest "
        "value, all others in the middle:",
        table(["parameter", "total effect", "lowest to highest", ""], rows),
    ]


def sensitivity_page() -> list[str]:
    """The section of the document on what matters together."""
    return [
        "## What matters together",
        "Dampers sampled (Sobol) over eight parameters, one packing of four each; the clearance is the bed's.  Their "
        "runs are short (table of costs): what they scatter by is part of the emulator, as its noise.  "
        "Ranges are in `configs/studies/sensitivity_*.yaml`: a parameter that is known better matters less than here.",
        *of_study("fluidisation"),
        *of_study("collision"),
    ]
