"""Optima with uncertainties, against curves and lines whose answers are known; regimes; the accessor."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from warpdamp.accessor import open_results
from warpdamp.analysis import results
from warpdamp.analysis.optimum import BLOCK_FLUIDISATION, Curves, collision_optimum, optimum
from warpdamp.analysis.regimes import Regime, regime
from warpdamp.errors import UsageError
from warpdamp.numerics.regression import maxima, packings_left_out, straight_line, widened
from warpdamp.report.curves import draw
from warpdamp.report.tables import summary
from warpdamp.variables import describe

GAMMA = np.linspace(0.5, 12, 24)
CLEARANCE = 1.5e-3


def curve(gamma, low, high):
    """Two humps, of fluidisation and of collision, as damping curves have them."""
    return 0.5 * np.exp(-(((gamma - low) / 1.2) ** 2)) + 0.65 * np.exp(-(((gamma - high) / 2.2) ** 2))


def test_an_optimum_of_what_is_not_there_is_refused():
    dataset = xr.Dataset({"effectiveness": ("gamma", curve(GAMMA, 2.6, 7.5))}, {"gamma": GAMMA})
    with pytest.raises(UsageError, match="no effectiveness_standard_error"):
        optimum(dataset)
    with pytest.raises(UsageError, match="no damping and no damping_standard_error"):
        optimum(dataset, "damping")


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


def test_optima_are_expected_under_the_gravity_that_was_swept(mapped):
    """Gravity of a half halves what a block needs to lift off; without any nothing fluidises, and flights are eq. 1's."""
    fine = np.concatenate([np.linspace(0.3, 3, 19), np.linspace(3.5, 12, 12)])
    gravity = xr.DataArray([0.0, 0.5 * 9.80665], dims="gravity")
    one = mapped.isel(frequency=5, drop=False).expand_dims(gravity=gravity.values).interp(gamma=fine)
    weight, high = gravity.values[:, None] / 9.80665, float(collision_optimum(55.0, CLEARANCE, gravity=False))
    eps = curve(fine, np.where(weight > 0, 0.6, -9.0), high + weight)
    shape = one["effectiveness"].transpose("gravity", "gamma", "seed")
    noise = 0.003 * np.random.default_rng(6).standard_normal(shape.shape)
    one["effectiveness"] = shape.copy(data=eps[:, :, None] + noise)
    one["effectiveness_standard_error"] = shape.copy(data=np.full(shape.shape, 0.003))
    found = optimum(one)
    assert np.isnan(found["gamma_fluidisation"].values[0])
    assert found["gamma_fluidisation"].values[1] == pytest.approx(
        0.6, abs=0.15
    )  # a fifth of the block's place: resounds
    assert found["gamma_collision"].values == pytest.approx(high + weight[:, 0], abs=0.3)


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
    damaged = (tmp_path / "other.nc").read_bytes()
    (tmp_path / "damaged.nc").write_bytes(damaged[: len(damaged) // 2])
    for reader in (open_results, results.read):
        with pytest.raises(UsageError, match=r"damaged.nc: is no netCDF file, or a damaged one"):
            reader(tmp_path / "damaged.nc")
        with pytest.raises(UsageError, match=r"there is no file .*none.nc"):
            reader(tmp_path / "none.nc")


def packings(rng, seeds: int, spread: float):
    """Effectiveness of packings whose optima of collision differ by ``spread``, (gamma, seed), with noise of 0.02."""
    own = 7.5 + spread * rng.standard_normal(seeds)
    offset = 0.02 * rng.standard_normal(seeds)
    return curve(GAMMA[:, None], 2.6, own) + offset + 0.02 * rng.standard_normal((len(GAMMA), seeds))


def test_two_sets_of_packings_agree_within_their_errors():
    """Of twenty pairs of four packings: 47 % within one standard error of the difference, and 85 % within two.

    That is 68 and 95 % less two standard errors of twenty coins.  The errors of the fit alone, which takes points for
    independent, are too small: 30 and 58 % of forty pairs agree within them.
    """
    rng = np.random.default_rng(7)
    shares = {_of_packings: [], _pooled: []}
    for _ in range(20):
        pair = [packings(rng, 4, spread=0.4) for _ in range(2)]
        for fit, apart in shares.items():
            one, other = (
                min(fit(GAMMA, eps, np.full(eps.shape, 0.005)), key=lambda top: abs(top.gamma - 7.5)) for eps in pair
            )
            apart.append(abs(one.gamma - other.gamma) / np.hypot(one.gamma_standard_error, other.gamma_standard_error))
    assert np.mean(np.array(shares[_of_packings]) < 1) > 0.47
    assert np.mean(np.array(shares[_of_packings]) < 2) > 0.85
    assert np.mean(np.array(shares[_pooled]) < 2) < 0.8


def _of_packings(gamma, height, error):
    return [widened(top, without) for top, without in packings_left_out(gamma, height, error)]


def _pooled(gamma, height, error):
    return maxima(np.repeat(gamma[:, None], height.shape[1], axis=1), height, error)


def test_heights_are_known_no_better_than_the_points_claim(mapped):
    """The energy's mean has an error of 8 %, as a single packing: 0.04 of a height of 0.5."""
    claimed = mapped.assign(
        energy_mean=mapped["effectiveness"].mean("seed"),
        energy_mean_standard_error=0.08 * mapped["effectiveness"].mean("seed"),
    ).isel(frequency=[8])
    height, error = (optimum(claimed)[f"effectiveness_fluidisation{s}"].item() for s in ("", "_standard_error"))
    assert error == pytest.approx(0.08 * height, rel=0.05)
    assert optimum(mapped.isel(frequency=[8]))["effectiveness_fluidisation_standard_error"] < 0.3 * error


def test_a_damping_ratio_has_its_optimum_where_the_effectiveness_has(mapped):
    """zeta = inherent + (2 / pi) eps m phi^2, packing by packing: one straight line from height to height."""
    few = mapped.isel(frequency=[6, 8]).assign(
        energy_dissipated=mapped["effectiveness"],
        energy_dissipated_standard_error=mapped["effectiveness_standard_error"],
        energy_mean=mapped["effectiveness"].mean("seed"),
        energy_mean_standard_error=0.0 * mapped["effectiveness"].mean("seed"),
    )
    modes = {"frequency": "mode"}
    zeta = 0.001 + 0.02 * few["energy_mean"].rename(modes).drop_vars("mode")
    few = few.assign(
        damping_ratio=zeta.assign_coords(mode=[1, 2]),
        damping_ratio_standard_error=0.0 * zeta,
        inherent_damping=("mode", [0.001, 0.001]),
        natural_frequency=("mode", few["frequency"].values),
    )
    of_mode, of_frequency = optimum(few, "damping_ratio"), optimum(few)
    for which in ("fluidisation", "collision"):
        ratio, eps = of_mode[f"damping_ratio_{which}"].values, of_frequency[f"effectiveness_{which}"].values
        np.testing.assert_allclose(ratio, 0.001 + 0.02 * eps, rtol=1e-3)  # widths of the fit are found to that
        places = [found[f"gamma_{which}"].values for found in (of_mode, of_frequency)]
        np.testing.assert_allclose(*places, atol=0.1)  # the fine grid's step


def one_curve(height, **changes):
    """A Dataset of one curve over Gamma, at 40 Hz."""
    dims = ("frequency", "gamma")
    height = np.broadcast_to(height, GAMMA.shape)[None]
    values = {"effectiveness": height, "effectiveness_standard_error": np.full(height.shape, 0.01)}
    values |= {"clearance": np.full(height.shape, CLEARANCE), "status": np.zeros(height.shape, int)} | changes
    data = {name: (dims, np.broadcast_to(value, height.shape)) for name, value in values.items()}
    return xr.Dataset(data, {"frequency": [40.0], "gamma": GAMMA, "seed": 1})


@pytest.mark.parametrize(
    ("dataset", "fluidisation", "collision"),
    [
        (one_curve(1 / (1 + GAMMA)), "falls from Γ 0.5, the edge of what was run", "no maximum stands out"),
        (one_curve(GAMMA / 20), "no maximum stands out", "still rises at Γ 12, the edge of what was run"),
        (one_curve(np.exp(-(((GAMMA - 2.6) / 2) ** 2)), clearance=np.nan), 2.6, "no clearance between floor and lid"),
        (one_curve(np.exp(-(((GAMMA - 2.6) / 2) ** 2)), clearance=0.1), 2.6, "expected at Γ 206, not among those run"),
        (one_curve(curve(GAMMA, 2.0, 10.5), clearance=0.1), 2.0, "expected at Γ 206"),  # whatever stands out at 10.5
        (one_curve(curve(GAMMA, 2.6, 7.5)).isel(gamma=[1, 5, 9]), "fewer than four", "fewer than four amplitudes"),
    ],
)
def test_what_a_curve_does_not_have_is_said_in_words(dataset, fluidisation, collision):
    found = Curves(dataset).optima({"frequency": 0})
    for which, expected in (("fluidisation", fluidisation), ("collision", collision)):
        if isinstance(expected, str):
            assert expected in found[which]
        else:
            assert found[which].gamma == pytest.approx(expected, abs=0.2)


def test_the_table_names_optima_of_the_fit_and_says_which_point_is_the_largest(mapped):
    """One packing's outlier is the largest point, and not the optimum, which eq. 1 puts at 6.9."""
    noisy = mapped.isel(frequency=[5]).copy(deep=True)
    noisy["effectiveness"][0, 17, 0] += 0.8  # at Gamma 9
    table = summary(noisy)
    heads = [column.header for column in table.columns]
    assert heads[-3:] == ["fluidisation", "two-sided collision", "largest of the points run"]
    fluidisation, collision, largest = (next(iter(column.cells)) for column in table.columns[-3:])
    assert fluidisation.startswith("Γ 2.")
    assert largest.startswith("Γ 9: ")
    found = optimum(noisy)
    gamma, error = (found[f"gamma_collision{s}"].item() for s in ("", "_standard_error"))
    assert collision.startswith(f"Γ {gamma:.3g} ± {error:.1g}: ")
    assert abs(gamma - 6.9) < 2 * error < abs(gamma - 9)
