"""The steady-state estimator on series whose truth is known."""

import numpy as np
import pytest

from warpdamp.numerics.steady import autocorrelation_time, standard_error, steady


def autoregression(rng, n, phi, mean=100.0):
    noise = rng.normal(size=n + 200)
    x = np.zeros(n + 200)
    for i in range(1, n + 200):
        x[i] = phi * x[i - 1] + noise[i]
    return x[200:] + mean


@pytest.mark.parametrize("phi", [-0.5, 0.0, 0.5, 0.8])
def test_autocorrelation_time_of_an_autoregression(phi):
    """(1 + phi) / (1 - phi); 15 % at 4,000 values."""
    rng = np.random.default_rng(1)
    found = np.mean([autocorrelation_time(autoregression(rng, 4000, phi)) for _ in range(10)])
    assert found == pytest.approx((1 + phi) / (1 - phi), rel=0.15)


@pytest.mark.parametrize(("phi", "n", "least"), [(0.0, 30, 0.88), (0.5, 60, 0.86), (0.8, 400, 0.90)])
def test_the_interval_of_two_standard_errors_covers_the_mean(phi, n, least):
    """95 % is nominal; short correlated series fall short by what is known of them (see the module)."""
    rng = np.random.default_rng(2)
    covered = []
    for _ in range(400):
        found = steady(autoregression(rng, n, phi), fewest=20)
        covered.append(abs(found.mean - 100) < 1.96 * found.standard_error)
    assert least <= np.mean(covered) <= 0.99


def test_the_standard_error_falls_with_the_root_of_the_length():
    rng = np.random.default_rng(3)
    lengths = np.array([50, 200, 800, 3200])
    errors = [np.mean([standard_error(autoregression(rng, n, 0.3)) for _ in range(20)]) for n in lengths]
    assert np.polyfit(np.log(lengths), np.log(errors), 1)[0] == pytest.approx(-0.5, abs=0.05)


def test_a_transient_is_cut_off():
    rng = np.random.default_rng(4)
    x = rng.normal(10, 0.5, 120)
    x[:30] -= np.linspace(8, 0, 30)
    found = steady(x, fewest=20)
    assert 20 <= found.discarded <= 60
    assert not found.drifting
    assert found.mean == pytest.approx(10, abs=4 * found.standard_error)


def test_a_drift_is_called_a_drift():
    rng = np.random.default_rng(5)
    x = rng.normal(10, 0.2, 80) + np.linspace(0, 4, 80)
    assert steady(x, fewest=20).drifting
    assert not steady(x, fewest=20, floor=10.0).drifting  # too small to matter


def test_stationary_series_are_rarely_called_drifting():
    rng = np.random.default_rng(6)
    called = [steady(autoregression(rng, 60, 0.5), fewest=20).drifting for _ in range(300)]
    assert np.mean(called) < 0.03


def test_a_constant_series_has_no_error():
    found = steady(np.full(40, 3.0), fewest=20)
    assert (found.mean, found.standard_error, found.drifting) == (3.0, 0.0, False)
