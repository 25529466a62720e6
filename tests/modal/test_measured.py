"""Measurement beside prediction: reading, residuals, calibration."""

import numpy as np
import pytest
import xarray as xr

from warpdamp import open_results
from warpdamp.errors import ModalError, UsageError
from warpdamp.modal.calibrate import calibrate
from warpdamp.modal.measured import Measured, compare, read_measured
from warpdamp.report.compare import calibration_lines, comparison_lines, overlay, posterior_overlay

BEAM = "docs/beam.nc"


def table(tmp_path, text):
    path = tmp_path / "measured.csv"
    path.write_text(text)
    return path


def test_columns_are_read_by_their_names_and_units(tmp_path):
    text = "mode,gamma,damping_ratio [%],damping_ratio_standard_error [%],frequency [Hz]\n1,2,1.5,0.1,39.6\n3,4,0.2,0.02,280\n"
    found = read_measured(table(tmp_path, text), np.array([1, 3, 5]))
    assert found.mode.tolist() == [1, 3]
    np.testing.assert_allclose(found.values["damping_ratio"], [0.015, 0.002])
    np.testing.assert_allclose(found.errors["damping_ratio"], [0.001, 0.0002])
    np.testing.assert_allclose(found.values["frequency"], [39.6, 280])
    assert np.isnan(found.errors["frequency"]).all()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("gamma,zeta\n1,2\n", "measured.csv:1: unknown column zeta; known: mode, gamma, damping_ratio"),
        ("gamma,damping_ratio [kg]\n1,2\n", "measured.csv:1: column damping_ratio [kg]: unknown unit"),
        ("gamma,gamma\n1,2\n", "measured.csv:1: column gamma is there twice"),
        ("gamma,mode\n1,1\n", "measured.csv:1: expected columns gamma and damping_ratio or frequency"),
        ("gamma,damping_ratio\n1,0.02\n", "measured.csv:1: the results have modes 1, 3, 5: add a column mode"),
        ("mode,gamma,damping_ratio\n1,1,0.02\n2,1,0.02\n", "measured.csv:3: mode: the results have none 2"),
        ("mode,gamma,damping_ratio\n1,0,0.02\n", "measured.csv:2: gamma: 0: expected above 0"),
        ("mode,gamma,damping_ratio\n1,1,-0.02\n", "measured.csv:2: damping_ratio: -0.02: expected above 0"),
    ],
)
def test_what_cannot_be_is_refused_with_its_line(tmp_path, text, expected):
    with pytest.raises(ModalError) as error:
        read_measured(table(tmp_path, text), np.array([1, 3, 5]))
    assert expected in str(error.value)


def test_a_measurement_that_is_the_prediction_has_no_residual():
    dataset = open_results(BEAM)
    curve = dataset["damping_ratio"].sel(mode=1)
    gamma = dataset["gamma"].values[2:12]
    value = curve.sel(gamma=gamma).values
    nothing = np.full(len(gamma), np.nan)
    same = Measured(
        np.full(10, 1),
        gamma,
        {"damping_ratio": value, "frequency": nothing},
        {"damping_ratio": 0.05 * value, "frequency": nothing},
    )
    found = compare(dataset, same)
    np.testing.assert_allclose(found["damping_ratio_residual"], 0, atol=1e-9)
    assert "frequency" not in found
    shifted = Measured(same.mode, gamma, same.values | {"damping_ratio": 1.2 * value}, same.errors)
    z = compare(dataset, shifted)["damping_ratio_residual"].values
    joint = np.hypot(0.05 * value, dataset["damping_ratio_standard_error"].sel(mode=1, gamma=gamma).values)
    np.testing.assert_allclose(z, 0.2 * value / joint)
    assert "+20 % from the prediction" in "\n".join(comparison_lines(compare(dataset, shifted)))
    overlay(dataset, found)


def test_beyond_the_gammas_that_were_run_nothing_is_compared():
    dataset = open_results(BEAM)
    far = Measured(
        np.array([1]),
        np.array([99.0]),
        {"damping_ratio": np.array([0.01]), "frequency": np.array([np.nan])},
        {"damping_ratio": np.array([0.001]), "frequency": np.array([np.nan])},
    )
    found = compare(dataset, far)
    assert np.isnan(found["damping_ratio_residual"]).all()
    assert "no measured point lies within" in "\n".join(comparison_lines(found))


GAMMAS = np.array([1.5, 2, 3, 4, 6, 8, 10])
MASS, PHI = 0.024, 1.6


def effectiveness(gamma, restitution, friction):
    """Restitution changes the height, friction the place of the optimum: the two are told apart."""
    return 0.4 * (1 + 0.8 * restitution) * np.exp(-0.6 * np.log(gamma / (3 + 4 * friction)) ** 2)


def swept(n=160, noise=0.04):
    """Results of a sweep of restitution and friction, (frequency, gamma, case)."""
    rng = np.random.default_rng(1)
    restitution, friction = rng.uniform(0.2, 0.9, n), rng.uniform(0.1, 0.9, n)
    value = effectiveness(GAMMAS[:, None], restitution, friction) * np.exp(
        noise * rng.standard_normal((len(GAMMAS), n))
    )
    dims, energy = ("frequency", "gamma", "case"), 1e-3 * value[None]
    return xr.Dataset(
        {
            "effectiveness": (dims, value[None]),
            "energy_dissipated": (dims, energy),
            "energy_dissipated_standard_error": (dims, 0.5 * noise * energy),
            "memory_error": (dims, np.sqrt(0.75) * noise * energy),
            "status": (dims, np.zeros(energy.shape, int)),
            "excitation_frequency": (("frequency", "case"), np.full((1, n), 40.0)),
            "particle_mass": ("case", np.full(n, MASS)),
            "damping_ratio": (("mode", "gamma", "case"), 0.01 * value[None]),
            "natural_frequency": (("mode", "case"), np.full((1, n), 40.0)),
            "mode_amplitude": (("mode", "case"), np.full((1, n), PHI)),
            "inherent_damping": (("mode", "case"), np.full((1, n), 1e-3)),
            "modal_mass": (("mode", "case"), np.full((1, n), PHI**-2)),
        },
        {
            "frequency": [40.0], "gamma": GAMMAS, "case": np.arange(n), "mode": [1],
            "restitution": ("case", restitution, {"units": "1"}), "friction": ("case", friction, {"units": "1"}),
        },
    )  # fmt: skip


@pytest.fixture(scope="module")
def sweep():
    from warpdamp.analysis.emulator import Emulator

    dataset = swept(60)
    return dataset, Emulator(dataset)


def draw(seed, relative=0.05):
    """A curve measured with 5 % of noise on one packing, and what made it."""
    rng = np.random.default_rng(seed)
    truth = rng.uniform(0.3, 0.8), rng.uniform(0.2, 0.8)
    zeta = 2 / np.pi * effectiveness(GAMMAS, *truth) * MASS * PHI**2 + 1e-3
    value = zeta * np.exp(relative * rng.standard_normal(len(GAMMAS)))
    nothing = np.full(len(GAMMAS), np.nan)
    return truth, Measured(
        np.ones(len(GAMMAS), int),
        GAMMAS,
        {"damping_ratio": value, "frequency": nothing},
        {"damping_ratio": relative * zeta, "frequency": nothing},
    )


def test_the_posterior_holds_what_made_the_curve(sweep):
    """At 95 %, ten draws hold nine or more with 91 %: these are fixed, and hold."""
    dataset, emulator = sweep
    held = 0
    for seed in range(10):
        truth, measured = draw(seed)
        posterior = calibrate(dataset, measured, emulator)
        at = dict(zip(("restitution", "friction"), truth, strict=True))
        held += posterior.contains([at[name] for name in posterior.names])
    assert held >= 9


def test_the_posterior_is_narrower_than_the_prior_and_said(sweep):
    dataset, emulator = sweep
    _, measured = draw(3)
    posterior = calibrate(dataset, measured, emulator)
    prior = np.std(posterior.points, axis=0)
    assert (posterior.standard_deviation < 0.7 * prior).all()
    said = "\n".join(calibration_lines(posterior, measured))
    assert "friction: " in said
    assert "residuals after calibration" in said
    posterior_overlay(posterior, measured)


def test_a_calibration_needs_errors_and_a_sweep(sweep):
    dataset, emulator = sweep
    _, measured = draw(0)
    bare = Measured(
        measured.mode, measured.gamma, measured.values, {name: np.full(len(GAMMAS), np.nan) for name in measured.errors}
    )
    with pytest.raises(UsageError, match="each with damping_ratio_standard_error"):
        calibrate(dataset, bare, emulator)
    with pytest.raises(UsageError, match="nothing to calibrate"):
        calibrate(open_results(BEAM), measured)
    with pytest.raises(UsageError, match="choose by --at, or calibrate"):
        compare(dataset, measured)
