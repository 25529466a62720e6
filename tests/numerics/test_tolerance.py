"""Accuracy by tolerance: what is chosen before a run, how packings combine, and what a study then claims."""

import math

import numpy as np
import pytest
from scipy.stats import t as student_t

import warpdamp
from warpdamp import ConfigError, load
from warpdamp.config.study import PRESETS
from warpdamp.numerics.steady import degrees_of_freedom, standard_error
from warpdamp.numerics.tolerance import combined, settings_for, single_interval, step_error, student
from warpdamp.status import Status
from warpdamp.sweep.resolve import with_tolerance
from warpdamp.variables import NOT_RUN

SMALL = """
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 16, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 330 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: [1, 4], frequency: 60 Hz}
preparation: loose
"""


def correlated(rng, n, phi):
    """A stationary first-order autoregression of variance 1."""
    x = np.empty(n)
    x[0] = rng.normal()
    for k in range(1, n):
        x[k] = phi * x[k - 1] + math.sqrt(1 - phi**2) * rng.normal()
    return x


@pytest.mark.parametrize("tolerance", [0.2, *(preset["tolerance"] for preset in PRESETS.values()), 0.005])
def test_the_step_is_never_the_largest_part(tolerance):
    chosen = settings_for(tolerance)
    assert step_error(chosen.steps_per_contact) <= tolerance / 3 * (1 + 1e-12)
    assert math.hypot(step_error(chosen.steps_per_contact), chosen.standard_error) <= tolerance * (1 + 1e-12)
    assert 10 <= chosen.steps_per_contact <= 120


def test_packings_combine_by_the_larger_of_their_spread_and_their_own_errors():
    alike = combined([1.0, 1.0, 1.0, 1.0], [0.1] * 4, [20] * 4)
    assert alike.mean == 1.0
    assert alike.standard_error == pytest.approx(0.05)
    assert alike.interval == pytest.approx(0.05 * student_t.ppf(0.975, 80))  # Welch, Satterthwaite: four times 20
    remembering = combined([1.0, 1.0, 1.0, 1.0], [0.1] * 4, [20] * 4, [0.2] * 4)
    own = math.hypot(0.1, 0.2)
    assert remembering.standard_error == pytest.approx(own / 2)
    assert remembering.interval == pytest.approx(own / 2 * student_t.ppf(0.975, 80 * (own / 0.1) ** 4), rel=1e-5)
    spread = combined([0.8, 1.0, 1.2], [1e-6] * 3, [20] * 3)
    assert spread.standard_error == pytest.approx(0.2 / math.sqrt(3))
    assert spread.interval == pytest.approx(spread.standard_error * student_t.ppf(0.975, 2))
    stepped = combined([1.0, 1.0], [0.1] * 2, [20] * 2, steps=[0.03, 0.05])
    assert stepped.step_error == pytest.approx(0.04)  # packings share it
    assert stepped.total_error == pytest.approx(math.hypot(0.1 / math.sqrt(2), 0.04))
    one = single_interval(0.1, 9.0, 0.2)
    assert one == pytest.approx(math.hypot(0.1 * student_t.ppf(0.975, 9), 1.95996 * 0.2), rel=1e-4)


def test_intervals_of_correlated_cycles_cover_the_mean():
    """600 series of 60 cycles with correlations 0 to 0.7: 95 % intervals hold zero in 93 to 99 % of them.

    The chance of a sample of 600 at 95 % is 0.9 %.
    """
    rng = np.random.default_rng(5)
    hits = []
    for phi in (0.0, 0.4, 0.7):
        for _ in range(200):
            x = correlated(rng, 60, phi)
            hits.append(abs(x.mean()) <= standard_error(x) * student(degrees_of_freedom(x)))
    assert 0.93 <= np.mean(hits) <= 0.99


def test_the_standard_error_falls_as_one_over_root_of_cycles():
    rng = np.random.default_rng(6)
    lengths = np.array([50, 100, 200, 400, 800])
    errors = [np.mean([standard_error(correlated(rng, n, 0.3)) for _ in range(60)]) for n in lengths]
    slope = np.polyfit(np.log(lengths), np.log(errors), 1)[0]
    assert slope == pytest.approx(-0.5, abs=0.05)


def test_presets_and_conflicts(write):
    assert load(write(SMALL + "accuracy: balanced\n")).accuracy.tolerance == 0.02
    for text, message in (
        ("accuracy: best\n", r":10:1: accuracy: 'best' is not one of fast, balanced, reference"),
        ("accuracy: {tolerance: 0}\n", r"accuracy.tolerance: .*greater than 0"),
        ("accuracy: {tolerance: 2 mm}\n", r"accuracy.tolerance: '2 mm' has the wrong unit"),
    ):
        with pytest.raises(ConfigError, match=message):
            load(write(SMALL + text))
    for text, message in (
        ("numerics: {steps_per_contact: 33}\n", r"numerics.steps_per_contact: is chosen by accuracy.tolerance"),
        ("steady_state: {standard_error: 1 %}\n", r":10:16: steady_state.standard_error: is chosen by"),
        ("numerics: {step: 1 us}\n", "leave numerics.step"),
    ):
        with pytest.raises(ConfigError, match=message):
            with_tolerance(load(write(SMALL + text + "accuracy: fast\n")))


def test_a_tolerance_is_kept_or_said_not_to_be(write):
    dataset = warpdamp.run(write(SMALL + "accuracy: {tolerance: 6 %, most_packings: 5}\n"), workers=1)
    assert 3 <= dataset.sizes["seed"] <= 5
    ran = dataset["status"] != NOT_RUN
    assert (ran.sum("seed") == dataset["packings"]).all()
    assert (dataset["packings"] >= 3).all()
    total = dataset["energy_mean_standard_error"]
    within = total <= np.maximum(0.06 * dataset["energy_mean"], 0)
    kept = dataset["within_tolerance"] == 1
    assert (kept | ~within).all()
    assert (kept | (dataset["packings"] == 5)).all()  # what misses it has had all its packings
    assert kept.any()
    assert (dataset["discretisation_error"].mean("seed") <= total).all()
    tight = warpdamp.run(
        write(SMALL + "accuracy: {tolerance: 0.1 %, most_packings: 3}\nsteady_state: {most_cycles: 40}\n")
    )
    assert (tight["within_tolerance"] == 0).any()
    assert tight["status"].isel(gamma=1).isin((Status.IMPRECISE, Status.DRIFTING)).all()  # and says so
