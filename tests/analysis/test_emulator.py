"""Emulators of results: between the cases, where not to trust them, and how many more are needed."""

import numpy as np
import pytest
import xarray as xr

from warpdamp import open_results
from warpdamp.analysis.emulator import Emulator
from warpdamp.errors import UsageError


def truth(frequency, gamma, friction):
    return 0.5 * np.exp(-0.5 * np.log(gamma / 4) ** 2) * (frequency / 50) ** -0.3 * (1 + 0.3 * friction)


def results(n=120, noise=0.04, seed=0, **more):
    """Results of a sweep along ``case``, effectiveness by a formula."""
    rng = np.random.default_rng(seed)
    frequency, gamma, friction = 30 * 4 ** rng.random(n), 10 ** rng.random(n), rng.uniform(0.1, 0.9, n)
    value = truth(frequency, gamma, friction) * np.exp(noise * rng.standard_normal(n))
    energy = 1e-3 * value
    return xr.Dataset(
        {
            "effectiveness": ("case", value),
            "energy_dissipated": ("case", energy),
            "energy_dissipated_standard_error": ("case", 0.5 * noise * energy),
            "memory_error": ("case", np.sqrt(0.75) * noise * energy),
            "discretisation_error": ("case", 0 * energy),
            "status": ("case", np.zeros(n, int)),
            "excitation_frequency": ("case", frequency),
        },
        {
            "case": np.arange(n),
            "gamma": ("case", gamma),
            "friction": ("case", friction, {"units": "1"}),
            **more,
        },
    )


@pytest.fixture(scope="module")
def emulator():
    return Emulator(results())


def test_it_predicts_between_the_cases_within_its_intervals(emulator):
    """400 points never seen: 95 % of the true values within the intervals, to four binomial standard errors."""
    rng = np.random.default_rng(7)
    at = {
        "frequency": 30 * 4 ** rng.random(400),
        "gamma": 10 ** rng.random(400),
        "friction": rng.uniform(0.1, 0.9, 400),
    }
    found = emulator.predict(**{name: xr.DataArray(value, dims="point") for name, value in at.items()})
    expected = truth(**at)
    inside = (found["effectiveness_low"] <= expected) & (expected <= found["effectiveness_high"])
    assert float(inside.mean()) > 0.95 - 4 * np.sqrt(0.95 * 0.05 / 400)
    assert float(np.median(np.abs(found["effectiveness"] / expected - 1))) < 0.02
    assert emulator.names == ["frequency", "gamma", "friction"]


def test_it_says_where_not_to_trust_it(emulator):
    found = emulator.predict(frequency=50.0, gamma=[0.1, 3.0, 30.0], friction=0.5)
    assert found["trusted"].values.tolist() == [0, 1, 0]
    assert found["effectiveness"].dims == ("gamma",)


def test_leaving_out_agrees_with_the_noise_that_was_put_in(emulator):
    checked = emulator.cross_validation()
    assert checked.attrs["rms"] == pytest.approx(0.04, rel=0.5)
    assert 0.9 <= checked.attrs["coverage"] <= 1.0


def test_more_cases_halve_the_error():
    """Noise alone: the error falls about as the root of the number of cases, so that three times as many are added."""
    more = Emulator(results(200)).cases_to_halve()
    assert 200 < more < 1600


def test_cases_that_failed_do_not_count():
    dataset = results(60)
    dataset["status"][:10] = 20
    dataset["effectiveness"][10:15] = np.nan
    assert len(Emulator(dataset).process.y) == 45


@pytest.mark.parametrize(
    ("at", "expected"),
    [
        ({"gamma": 2.0, "friction": 0.5}, "frequency: say at which value"),
        ({"frequency": 40.0, "gamma": 2.0, "friction": 0.5, "height": 1.0}, "height: is not an input of this emulator"),
        ({"frequency": -1.0, "gamma": 2.0, "friction": 0.5}, "must be positive"),
    ],
)
def test_what_cannot_be_predicted_is_refused(emulator, at, expected):
    with pytest.raises(UsageError, match=expected):
        emulator.predict(**at)


def test_words_are_refused():
    with pytest.raises(UsageError, match="preparation: an emulator takes numbers only"):
        Emulator(results(60, preparation=("case", ["loose"] * 60)))


def test_committed_results_have_one():
    """The paper's beam: three modes, 21 amplitudes, three packings; the curve of mode 1 from its other cases."""
    emulator = open_results("docs/beam.nc").damper.emulator()
    assert emulator.names == ["frequency", "gamma"]
    assert emulator.cross_validation().attrs["coverage"] > 0.8
