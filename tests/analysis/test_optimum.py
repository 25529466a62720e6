"""Optima with uncertainties, against curves and lines whose answers are known; regimes; the accessor."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from warpdamp.accessor import open_results
from warpdamp.analysis.optimum import BLOCK_FLUIDISATION, collision_optimum, optimum
from warpdamp.analysis.regimes import Regime, regime
from warpdamp.errors import UsageError
from warpdamp.numerics.regression import maxima, straight_line
from warpdamp.report.curves import draw
from warpdamp.variables import describe

GAMMA = np.linspace(0.5, 12, 24)
CLEARANCE = 1.5e-3


def curve(gamma, low, high):
    """Two humps, of fluidisation and of collision, as damping curves have them."""
    return 0.5 * np.exp(-(((gamma - low) / 1.2) ** 2)) + 0.65 * np.exp(-(((gamma - high) / 2.2) ** 2))


def test_maxima_lie_where_they_are_within_their_errors():
    """Of forty noisy curves: pulls with the mean and spread that standard errors promise (0 +- 1, by a half each)."""
    noise, fine = 0.01, np.linspace(0.5, 12, 20_001)
    values = curve(fine, 2.6, 7.5)
    true = [fine[fine < 4.2][np.argmax(values[fine < 4.2])], fine[np.argmax(values * (fine > 4.2))]]
    rng = np.random.default_rng(5)
    pulls = []
    for _ in range(40):
        noisy = curve(GAMMA, 2.6, 7.5) + noise * rng.standard_normal(len(GAMMA))
        tops = maxima(GAMMA, noisy, np.full(len(GAMMA), noise))
        for wanted in true:
            top = min(tops, key=lambda t: abs(t.gamma - wanted))
            pulls.append((top.gamma - wanted) / top.gamma_standard_error)
    assert abs(np.mean(pulls)) < 0.5
    assert 0.5 < np.std(pulls) < 1.5


def test_seeds_that_scatter_more_than_their_errors_widen_the_answer():
    rng = np.random.default_rng(1)
    gamma = np.repeat(GAMMA[:, None], 3, axis=1)
    scattered = curve(gamma, 2.6, 7.5) + 0.05 * rng.standard_normal(gamma.shape)
    near = [maxima(gamma, values, np.full(gamma.shape, 1e-3)) for values in (curve(gamma, 2.6, 7.5), scattered)]
    exact, rough = (min(tops, key=lambda t: abs(t.gamma - 7.5)).gamma_standard_error for tops in near)
    assert rough > 3 * exact


@pytest.mark.parametrize("height", [np.full(24, np.nan), GAMMA, np.full(24, 0.3)])
def test_curves_without_a_maximum_have_none(height):
    assert maxima(GAMMA, height, np.full(24, 0.01)) == []


def test_a_line_and_its_errors():
    """Slope and intercept of 400 noisy lines scatter as their errors say (to 10 %: four standard errors of a spread)."""
    rng = np.random.default_rng(2)
    x, error = np.linspace(900, 4900, 9), np.linspace(0.05, 0.2, 9)
    lines = [straight_line(x, 1.1 + 0.0028 * x + error * rng.standard_normal(9), error) for _ in range(400)]
    plain = [line for line in lines if line.scatter <= 1]  # others widen their errors
    assert np.mean([line.slope for line in lines]) == pytest.approx(0.0028, rel=0.01)
    assert np.std([line.slope for line in lines]) == pytest.approx(plain[0].slope_standard_error, rel=0.14)
    assert np.std([line.intercept for line in lines]) == pytest.approx(plain[0].intercept_standard_error, rel=0.14)
    with pytest.raises(ValueError, match="needs three points, got 2"):
        straight_line([1, 2, np.nan], [1, 2, 3], [1, 1, 1])


@pytest.fixture
def mapped():
    """A made-up map whose optima follow eq. 1 and a plastic block."""
    frequency = np.arange(30.0, 71.0, 5.0)
    rng = np.random.default_rng(3)
    shape = (len(frequency), len(GAMMA), 2)
    high = collision_optimum(frequency, CLEARANCE)[:, None, None]
    eps = curve(GAMMA[:, None], 2.4, high) + 0.01 * rng.standard_normal(shape)
    dims = ("frequency", "gamma", "seed")
    displacement = GAMMA * 9.81 / (2 * np.pi * frequency[:, None]) ** 2
    dataset = xr.Dataset(
        {
            "effectiveness": (dims, eps),
            "effectiveness_standard_error": (dims, np.full(shape, 0.01)),
            "clearance": (dims, np.full(shape, CLEARANCE)),
            "status": (dims, np.zeros(shape, int)),
            "displacement": (dims[:2], displacement),
            "excitation_frequency": (dims[:1], frequency),
            "particle_mass": 0.024,
        },
        {"frequency": frequency, "gamma": GAMMA, "seed": [1, 2], "preparation": "compacted"},
        {"title": "made up"},
    )
    return describe(dataset)


def test_optima_are_called_by_their_names(mapped):
    found = optimum(mapped)
    line = straight_line(found["frequency"] ** 2, found["gamma_collision"], found["gamma_collision_standard_error"])
    slope = 4 * np.pi * CLEARANCE / 9.81
    assert abs(line.slope - slope) < 3 * line.slope_standard_error + 0.02 * slope  # the humps overlap at 30 Hz
    apart = found["frequency"] >= 45
    low = found["gamma_fluidisation"].where(apart, drop=True)
    assert np.allclose(low, 2.4, atol=0.4)
    assert abs(float(low.mean()) - BLOCK_FLUIDISATION) < 0.5


def test_the_picture_follows_the_dimensions(mapped, tmp_path):
    assert len(draw(mapped).axes) == 2  # a map and its colours
    assert len(draw(mapped.isel(frequency=[0, 5])).axes) == 2  # two panels of curves
    several = xr.concat([mapped, mapped], xr.DataArray([0.1, 0.3], dims="friction", name="friction"))
    assert len(draw(several).axes) == 3
    cases = mapped.stack(case=("frequency", "gamma"), create_index=False).assign_coords(
        case=np.arange(mapped.sizes["frequency"] * mapped.sizes["gamma"])
    )
    assert len(draw(cases).axes) == 3  # against frequency and Gamma, and colours
    with pytest.raises(ValueError, match="no case is finished yet"):
        draw(mapped.where(False))


def test_regimes(mapped):
    """Each label by what it is told from; a case that did not finish has none."""
    with pytest.raises(ValueError, match="no floor_impulse: run with effects"):
        regime(mapped)
    one = xr.ones_like(mapped["effectiveness"])
    still = mapped.assign(
        floor_impulse=one,
        lid_impulse=0.02 * one,
        apparent_mass=0.9 * mapped["particle_mass"] * one,
        cycle_displacement=0.5 * mapped["displacement"] * one,
        effectiveness=0.4 * one,
    )
    assert (regime(still) == Regime.FLUIDISED).all()
    assert (regime(still.assign(effectiveness=0.01 * one)) == Regime.SOLID).all()
    assert (regime(still.assign(lid_impulse=0.2 * one)) == Regime.TWO_SIDED_COLLISION).all()
    upside_down = still.assign(floor_impulse=0.02 * one, lid_impulse=one)  # the bed rests on the lid
    assert (regime(upside_down) == Regime.FLUIDISED).all()
    assert (regime(still.assign(lid_impulse=np.nan * one)) == Regime.UNKNOWN).all()
    light = still.assign(apparent_mass=0.1 * mapped["particle_mass"] * one)
    assert (regime(light) == Regime.FLUIDISED).all()  # it floats, and returns
    assert (regime(light.assign(cycle_displacement=2 * mapped["displacement"] * one)) == Regime.CONVECTING).all()
    assert (regime(still.assign(effectiveness=np.nan * one)) == Regime.UNKNOWN).all()


def test_damping_of_any_structure(mapped):
    """The identity zeta = (2 / pi) eps m phi^2, at frequencies run and half-way between them."""
    modes = SimpleNamespace(number=[1, 2], frequency=np.array([40.0, 42.5]), amplitude=np.array([1.7, 0.8]))
    zeta = mapped.damper.damping(modes)
    eps = mapped["effectiveness"].mean("seed")
    for k, own in enumerate((eps.sel(frequency=40), eps.sel(frequency=[40, 45]).mean("frequency"))):
        expected = 2 / np.pi * own * 0.024 * modes.amplitude[k] ** 2
        np.testing.assert_allclose(zeta["damping_ratio"].isel(mode=k), expected, rtol=1e-12)
    with pytest.raises(ValueError, match=r"90\.0 Hz lies outside the frequencies run, 30 to 70 Hz"):
        mapped.damper.damping(SimpleNamespace(number=[1], frequency=[90.0], amplitude=[1.0]))


def test_files_that_are_no_results(tmp_path):
    xr.Dataset({"a": 1}).to_netcdf(tmp_path / "other.nc")
    with pytest.raises(UsageError, match="is not a results file of warpdamp"):
        open_results(tmp_path / "other.nc")
