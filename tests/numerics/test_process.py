"""Gaussian processes in several dimensions: against closed forms, an independent code, and coverage."""

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern

from warpdamp.numerics.process import Process, fit


def made(n=40, noise=0.05, seed=0):
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1, 1, (n, 2))
    return x, np.sin(3 * x[:, 0]) + 0.5 * x[:, 1], noise * rng.standard_normal(n), rng


def quiet(x, y, error) -> Process:
    """Process of given hyperparameters, its scatter at the floor."""
    return Process(x, y, error, np.array([0.5, 1.5]), 1.2, 0.1, np.zeros(len(y)))


def test_prediction_is_that_of_an_independent_code():
    x, y, noise, rng = made()
    error = np.full(len(y), 0.1)
    process = quiet(x, y + noise, error)
    kernel = ConstantKernel(1.2**2, "fixed") * Matern([0.5, 1.5], "fixed", nu=2.5)
    alpha = error**2 + process.scatter(x) ** 2
    other = GaussianProcessRegressor(kernel, alpha=alpha, optimizer=None).fit(x, y + noise - 0.1)
    at = rng.uniform(-1, 1, (7, 2))
    mean, spread = process.predict(at)
    expected, deviation = other.predict(at, return_std=True)
    np.testing.assert_allclose(mean, expected + 0.1, atol=1e-7)
    np.testing.assert_allclose(spread, deviation, atol=1e-7)
    joint, covariance = process.joint(at)
    np.testing.assert_allclose(joint, mean, atol=1e-10)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), spread, atol=1e-7)


def test_sets_of_points_are_predicted_as_one_by_one():
    x, y, noise, rng = made()
    process = quiet(x, y + noise, np.full(len(y), 0.1))
    sets = rng.uniform(-1, 1, (3, 5, 2))
    means, covariances = process.joints(sets)
    for k in range(3):
        mean, covariance = process.joint(sets[k])
        np.testing.assert_allclose(means[k], mean, atol=1e-12)
        np.testing.assert_allclose(covariances[k], covariance, atol=1e-12)


def test_leaving_out_in_closed_form_is_leaving_out():
    """A group left out by the inverse, and by a process that never saw it."""
    x, y, noise, _ = made(20)
    process = quiet(x, y + noise, np.full(len(y), 0.1))
    groups = np.repeat(np.arange(5), 4)
    mean, spread = process.left_out(groups)
    for group in range(5):
        rows = groups == group
        without = process.of(np.flatnonzero(~rows))
        expected, deviation = without.predict(x[rows])
        np.testing.assert_allclose(mean[rows], expected, atol=1e-8)
        noise_of = np.hypot(process.error[rows], process.scatter(x[rows]))
        np.testing.assert_allclose(spread[rows], np.hypot(deviation, noise_of), atol=1e-6)


def test_intervals_cover_what_they_say_where_the_scatter_varies():
    """Points scatter by 2 % on one side and 20 % on the other, which their errors do not say: 95 % of 2,000 others lie
    within the intervals to 3 %, of the noisy side to 4.5 % (25 neighbours know a variance to 28 %).
    """
    rng = np.random.default_rng(4)

    def scatter(x):
        return np.where(x[:, 0] > 0, 0.2, 0.02)

    x, at = rng.uniform(-1, 1, (300, 2)), rng.uniform(-1, 1, (2000, 2))
    y = np.sin(3 * x[:, 0]) + 0.5 * x[:, 1] + scatter(x) * rng.standard_normal(300)
    process = fit(x, y, np.full(300, 0.01), np.arange(300))
    mean, spread = process.predict(at)
    others = np.sin(3 * at[:, 0]) + 0.5 * at[:, 1] + scatter(at) * rng.standard_normal(2000)
    inside = np.abs(others - mean) <= 1.96 * np.sqrt(spread**2 + process.scatter(at) ** 2 + 0.01**2)
    assert abs(inside.mean() - 0.95) < 0.03
    assert abs(inside[at[:, 0] > 0.1].mean() - 0.95) < 0.045
    assert inside[at[:, 0] < -0.1].mean() > 0.93  # the smallest scatter that is assumed is that of this side


def test_an_axis_without_effect_is_wide():
    rng = np.random.default_rng(5)
    x = rng.uniform(-1, 1, (80, 2))
    process = fit(x, np.sin(4 * x[:, 0]), np.full(80, 0.01), np.arange(80))
    assert process.widths[1] > 8 * process.widths[0]


def test_too_few_points_are_refused():
    with pytest.raises(ValueError, match="3 points are too few for a Gaussian process in 2 dimensions"):
        fit(np.zeros((3, 2)), np.zeros(3), np.ones(3), np.arange(3))
