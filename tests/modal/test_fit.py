"""Modal fits on FRFs whose modes are known, and on files."""

import numpy as np
import pytest
import xarray as xr

from warpdamp.errors import ModalError
from warpdamp.modal.fit import Damping, circle_fit, dobson, half_power_band, line_fit
from warpdamp.modal.fit_together import least_squares
from warpdamp.modal.identify import fits

OWN = np.array([39.5, 280.0, 731.0])  # the paper's beam: f [Hz], zeta, modal constants phi^2
ZETA = np.array([0.03, 0.008, 0.004])
CONSTANT = np.array([1.6627, 0.7692, 0.5458]) ** 2


def accelerance(frequency, modes=slice(None), *, hysteretic=False):
    """Sum of modes; viscous unless asked."""
    w, own = 2 * np.pi * np.asarray(frequency)[:, None], 2 * np.pi * OWN[modes]
    loss = 2 * ZETA[modes] * own * (own if hysteretic else w)
    return np.sum(-(w**2) * CONSTANT[modes] / (own**2 - w**2 + 1j * loss), axis=1)


def sampled(mode, points=41, modes=slice(None), **damping):
    """The half-power band of a mode in equal steps."""
    wide = OWN[mode] * (1 + 4 * ZETA[mode] * np.linspace(-1, 1, 4001))
    f = wide[half_power_band(wide, accelerance(wide, modes, **damping), OWN[mode])]
    f = np.linspace(f[0], f[-1], points)
    return f, accelerance(f, modes, **damping)


def joined(bands):
    return np.concatenate([f for f, _ in bands]), np.concatenate([a for _, a in bands])


@pytest.mark.parametrize("fit", [line_fit, dobson, circle_fit])
@pytest.mark.parametrize("mode", range(3))
def test_a_single_hysteretic_mode_is_returned_exactly(fit, mode):
    """No neighbours, no residual: 1e-6 is what an iteration leaves."""
    found = fit(*sampled(mode, modes=[mode], hysteretic=True))
    assert found.frequency == pytest.approx(OWN[mode], rel=1e-8)
    assert found.damping_ratio == pytest.approx(ZETA[mode], rel=1e-6)
    assert found.modal_constant == pytest.approx(CONSTANT[mode], rel=1e-6)


@pytest.mark.parametrize("fit", [line_fit, dobson, circle_fit])
@pytest.mark.parametrize("mode", range(3))
def test_a_single_viscous_mode_is_returned_exactly(fit, mode):
    found = fit(*sampled(mode, modes=[mode]), Damping.VISCOUS)
    assert found.frequency == pytest.approx(OWN[mode], rel=1e-8)
    assert found.damping_ratio == pytest.approx(ZETA[mode], rel=1e-6)
    assert found.modal_constant == pytest.approx(CONSTANT[mode], rel=1e-6)
    assert found.quality == pytest.approx(1, abs=1e-10)


@pytest.mark.parametrize("damping", Damping)
@pytest.mark.parametrize("fit", [line_fit, dobson, circle_fit])
def test_a_negative_damping_is_returned_as_such(fit, damping):
    """The conjugate of an FRF runs round its circle the other way."""
    f, a = sampled(1, modes=[1], hysteretic=damping is Damping.STRUCTURAL)
    found = fit(f, np.conj(a), damping)
    assert found.frequency == pytest.approx(OWN[1], rel=1e-8)
    assert found.damping_ratio == pytest.approx(-ZETA[1], rel=1e-6)


@pytest.mark.parametrize("fit", [dobson, circle_fit])
def test_a_constant_residual_is_taken_out(fit):
    """H + B with a complex B as large as a tenth of the peak."""
    f, a = sampled(1, modes=[1], hysteretic=True)
    residual = 0.1 * (1 - 0.5j) * np.abs(a).max() / f.mean() ** 2
    found = fit(f, a + f**2 * residual)
    assert found.frequency == pytest.approx(OWN[1], rel=1e-8)
    assert found.damping_ratio == pytest.approx(ZETA[1], rel=1e-6)


@pytest.mark.parametrize("damping", Damping)
def test_least_squares_returns_its_own_modes_exactly(damping):
    bands = [sampled(mode, hysteretic=damping is Damping.STRUCTURAL) for mode in range(3)]
    found = least_squares(*joined(bands), [line_fit(*band) for band in bands], damping)
    np.testing.assert_allclose([fit.frequency for fit in found], OWN, rtol=1e-9)
    np.testing.assert_allclose([fit.damping_ratio for fit in found], ZETA, rtol=1e-7)
    np.testing.assert_allclose([fit.modal_constant for fit in found], CONSTANT, rtol=1e-7)


@pytest.mark.parametrize("hysteretic", [False, True])
def test_dobson_circle_and_least_squares_are_within_one_per_cent(hysteretic):
    """The figure asked for, on three modes, whatever the damping; scripts/documents/modal_fits.py prints the errors."""
    bands = [sampled(mode, hysteretic=hysteretic) for mode in range(3)]
    rows = [[fit(*band) for band in bands] for fit in (dobson, circle_fit)]
    rows.append(least_squares(*joined(bands), rows[0]))
    for row in rows:
        np.testing.assert_allclose([fit.damping_ratio for fit in row], ZETA, rtol=0.01)
        np.testing.assert_allclose([fit.frequency for fit in row], OWN, rtol=0.001)


def test_the_line_fit_is_biased_by_the_square_of_what_the_neighbours_leave():
    """With a real B the bias of zeta goes with (B / peak)^2: halving B quarters it.  10 %: the next order."""
    _, a = sampled(2, modes=[2], hysteretic=True)
    wide = np.linspace(0.97, 1.03, 40_001) * OWN[2]
    bias = []
    for part in (0.1, 0.05, 0.025):
        residual = -part * np.abs(a).max() / OWN[2] ** 2
        disturbed = accelerance(wide, [2], hysteretic=True) - wide**2 * residual
        band = half_power_band(wide, disturbed, OWN[2])
        bias.append(line_fit(wide[band], disturbed[band]).damping_ratio / ZETA[2] - 1)
    assert bias[0] > 0.03
    assert bias[0] / bias[1] == pytest.approx(4, rel=0.1)
    assert bias[1] / bias[2] == pytest.approx(4, rel=0.1)


def test_errors_of_the_least_squares_fit_are_its_spread():
    """1 % noise, 60 draws: the spread of a spread is 1 / sqrt(2 * 59) = 9 %, so 30 % is three of those."""
    random = np.random.default_rng(3)
    bands = [sampled(mode) for mode in range(3)]
    f, a = joined(bands)
    start = [dobson(*band) for band in bands]
    draws = []
    for _ in range(60):
        noise = random.normal(size=(2, len(a))) / np.sqrt(2)
        draws.append(least_squares(f, a * (1 + 0.01 * (noise[0] + 1j * noise[1])), start))
    for mode in range(3):
        for name in ("frequency", "damping_ratio"):
            spread = np.std([getattr(draw[mode], name) for draw in draws], ddof=1)
            stated = np.mean([getattr(draw[mode], f"{name}_error") for draw in draws])
            assert stated == pytest.approx(spread, rel=0.3)


@pytest.mark.parametrize(("fit", "damping"), [(line_fit, Damping.VISCOUS), (dobson, "structural"), (circle_fit, "structural")])  # fmt: skip
def test_errors_of_the_fits_of_one_mode_are_their_spread(fit, damping):
    """A jackknife of 10 groups scatters by 1 / sqrt(2 * 9) = 24 % a draw; 40 draws and their spread: 30 % as above."""
    random = np.random.default_rng(4)
    f, a = sampled(1, 31, modes=[1], hysteretic=damping is Damping.STRUCTURAL)
    draws = []
    for _ in range(40):
        noise = random.normal(size=(2, len(a))) / np.sqrt(2)
        draws.append(fit(f, a * (1 + 0.01 * (noise[0] + 1j * noise[1])), damping))
    for name in ("frequency", "damping_ratio"):
        spread = np.std([getattr(draw, name) for draw in draws], ddof=1)
        stated = np.mean([getattr(draw, f"{name}_error") for draw in draws])
        assert stated == pytest.approx(spread, rel=0.3)
    lost = 1e-4 * np.mean(np.abs(a) ** 2) / np.var(a)  # less the share of the unknowns, 6 of 62
    assert np.mean([1 - draw.quality for draw in draws]) == pytest.approx(lost, rel=0.2)


def test_the_half_power_band_is_twice_zeta_wide():
    """2 zeta f to first order; zeta^2 and the step of the samples bound the rest."""
    f = np.linspace(700, 760, 60_001)
    band = half_power_band(f, accelerance(f, [2]), 731)
    assert f[band.stop - 1] - f[band.start] == pytest.approx(2 * ZETA[2] * OWN[2], rel=0.01)


def test_what_cannot_be_fitted_is_refused():
    f = np.linspace(20, 900, 2000)
    with pytest.raises(ModalError, match=r"no peak near 100 Hz.*39\.\d+, 280\.\d+, 73\d"):
        half_power_band(f, accelerance(f), 100)
    with pytest.raises(ModalError, match=r"no peak near 281 Hz.*none"):
        half_power_band(f[f < 280], accelerance(f[f < 280], [1]), 281)
    with pytest.raises(ModalError, match=r"only \d points in the half-power band near 39.5 Hz: measure with steps"):
        half_power_band(f[::2], accelerance(f[::2]), 39.5)
    band = sampled(1, 6)
    start = [line_fit(*band)] * 3
    with pytest.raises(ModalError, match="6 points cannot tell"):
        least_squares(*band, start)


def frf_dataset(frequency, curves, gamma):
    dims = ("gamma", "frequency")
    return xr.Dataset(
        {"accelerance_real": (dims, curves.real), "accelerance_imaginary": (dims, curves.imag)},
        {"gamma": gamma, "frequency": frequency},
    )


STEP = np.arange(20, 100, 0.05)


def one(curve, frequency=STEP):
    return xr.Dataset(
        {"accelerance_real": ("frequency", curve.real), "accelerance_imaginary": ("frequency", curve.imag)},
        {"frequency": frequency},
    )


def smooth_noise(seed, lines=60):
    """Complex noise whose peaks are as wide as those of modes: its spectrum is smooth over so many lines."""
    random = np.random.default_rng(seed)
    white = random.normal(size=len(STEP)) + 1j * random.normal(size=len(STEP))
    return np.convolve(white, np.hanning(lines), "same")


def test_a_negative_damping_is_said_and_left_out():
    with pytest.raises(ModalError, match=r"line fit from 38\.\d* to 40\.\d* Hz: its damping ratio is negative, -3"):
        fits(one(np.conj(accelerance(STEP, [0], hysteretic=True))))


@pytest.mark.parametrize("seed", range(2))
def test_no_fit_lies_outside_its_band_or_has_no_sense(seed):
    """Noise as smooth as modes: whatever is kept lies in its band, is damped, and explains it."""
    try:
        found = fits(one(smooth_noise(seed)))
    except ModalError:
        return
    kept = found["fitted_frequency"].notnull()
    for end, sign in (("band_start", 1), ("band_end", -1)):
        assert (sign * (found["fitted_frequency"] - found[end]) >= 0).where(kept, True).all()
    assert (found["fitted_damping_ratio"] > 0).where(kept, True).all()
    assert (found["fitted_quality"] >= 0.5).where(kept, True).all()
    assert found.attrs["refused"]


def test_white_noise_is_refused():
    random = np.random.default_rng(5)
    white = random.normal(size=len(STEP)) + 1j * random.normal(size=len(STEP))
    with pytest.raises(ModalError, match=r"\d+ peaks that stand out by 6 dB, as noise has"):
        fits(one(white))
    with pytest.raises(ModalError, match="near 40 Hz"):
        fits(one(white), 40)


def test_fits_say_what_they_are_worth():
    """Lines and band as the samples have them; least squares has the model, so its quality is one."""
    found = fits(one(accelerance(STEP, [0])), damping="viscous")
    band = half_power_band(STEP, accelerance(STEP, [0]), 39.5)
    assert found["band_lines"].item() == band.stop - band.start
    assert (found["band_start"].item(), found["band_end"].item()) == (STEP[band.start], STEP[band.stop - 1])
    assert found.attrs["damping"] == "viscous"
    np.testing.assert_allclose(found["fitted_damping_ratio"], ZETA[0], rtol=1e-6)
    assert np.isfinite(found["fitted_damping_ratio_standard_error"]).all()
    assert found["fitted_quality"].values == pytest.approx(1)


def test_lines_without_a_value_are_left_out_and_order_does_not_count():
    curve = accelerance(STEP, [0])
    curve[:200] = np.nan
    found = fits(one(curve[::-1], STEP[::-1]), damping="viscous")
    np.testing.assert_allclose(found["fitted_frequency"], OWN[0], rtol=1e-8)


@pytest.mark.parametrize(
    ("near", "message"),
    [
        (0, "near: expected frequencies above 0 Hz, got 0"),
        (np.nan, "near: .* got nan"),
        ([], "near: .* got none"),
        (-40, "near: .* got -40"),
        (300, "no peak near 300 Hz"),
    ],
)
def test_where_no_mode_can_be(near, message):
    with pytest.raises(ModalError, match=message):
        fits(one(accelerance(STEP, [0])), near)


def test_a_peak_is_fitted_once():
    found = fits(one(accelerance(STEP, [0])), [39, 40, 39])
    assert found["fitted_frequency"].sel(fit="circle").notnull().values.tolist() == [True, False]
    assert found.attrs["refused"] == ["near 40 Hz the peak is that at 39.55 Hz, which is fitted already: give it once"]


def test_no_resonance_and_no_values():
    for curve in (np.ones(len(STEP)), STEP * 1j, np.zeros(len(STEP))):
        with pytest.raises(ModalError, match="no peak that stands out by 6 dB"):
            fits(one(curve + 0j))
    with pytest.raises(ModalError, match="no line with a value"):
        fits(one(np.full(len(STEP), np.nan + 0j)))
    with pytest.raises(ModalError, match="damping 'coulomb': is none of structural, viscous"):
        fits(one(STEP + 0j), damping="coulomb")


def test_a_family_is_fitted_curve_by_curve():
    """A mode that one of the curves lacks is left out there, and the reason kept."""
    f = np.arange(20, 900, 0.05)
    curves = np.stack([accelerance(f), accelerance(f, hysteretic=True), accelerance(f, [1, 2])])
    found = fits(frf_dataset(f, curves, [1.0, 2.0, 3.0]), near=OWN)
    assert dict(found.sizes) == {"fit": 4, "mode": 3, "gamma": 3}
    best = found["fitted_damping_ratio"].sel(fit="least squares")
    np.testing.assert_allclose(best.sel(gamma=[1.0, 2.0]), np.stack([ZETA] * 2, axis=1), rtol=0.01)
    assert np.isnan(best.sel(gamma=3.0)).values.tolist() == [True, False, False]
    (message,) = found.attrs["refused"]
    assert message.startswith("Gamma 3, no peak near 39")
    peaks = fits(frf_dataset(f, curves[:2], [1.0, 2.0]))  # found by itself
    np.testing.assert_allclose(peaks["fitted_frequency"].sel(fit="circle", gamma=1.0), OWN, rtol=2e-3)
