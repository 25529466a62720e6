"""Modal fits on FRFs whose modes are known, and on files."""

import numpy as np
import pytest
import xarray as xr

from warpdamp.errors import ModalError
from warpdamp.modal.fit import circle_fit, dobson, half_power_band, line_fit
from warpdamp.modal.fit_together import least_squares
from warpdamp.modal.frf_file import read_frf
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


@pytest.mark.parametrize("fit", [dobson, circle_fit])
def test_a_constant_residual_is_taken_out(fit):
    """H + B with a complex B as large as a tenth of the peak."""
    f, a = sampled(1, modes=[1], hysteretic=True)
    residual = 0.1 * (1 - 0.5j) * np.abs(a).max() / f.mean() ** 2
    found = fit(f, a + f**2 * residual)
    assert found.frequency == pytest.approx(OWN[1], rel=1e-8)
    assert found.damping_ratio == pytest.approx(ZETA[1], rel=1e-6)


def test_least_squares_returns_hysteretic_modes_exactly():
    bands = [sampled(mode, hysteretic=True) for mode in range(3)]
    found = least_squares(*joined(bands), [line_fit(*band) for band in bands])
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


def test_csv_with_and_without_names(tmp_path):
    f = np.linspace(250, 310, 500)
    a = accelerance(f)
    rows = "\n".join(f"{x},{y.real},{y.imag}" for x, y in zip(f, a, strict=True))
    for name, text in {"bare.csv": rows, "named.csv": f"f [Hz],real,imaginary\n# shaker\n\n{rows}"}.items():
        (tmp_path / name).write_text(text)
        found = fits(read_frf(tmp_path / name))
        assert found["fitted_damping_ratio"].sel(fit="dobson").item() == pytest.approx(ZETA[1], rel=0.01)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("frf.csv", "1,2,3\n4,5", r"frf.csv:2: expected frequency, real, imaginary, got '4,5'"),
        ("frf.csv", "f,re,im\n", "holds no data"),
        ("frf.csv", "1,2,3\n1,2,3", "each given once"),
        ("frf.txt", "1,2,3", r"ends in .nc, .csv, .uff or .unv"),
        ("frf.nc", "nothing", "is no netCDF file"),
        ("frf.uff", "nothing", "holds 0 FRFs"),
    ],
)
def test_files_that_hold_no_frf(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(OSError, match=message):
        read_frf(path)
    with pytest.raises(FileNotFoundError):
        read_frf(tmp_path / "missing.csv")


@pytest.mark.parametrize(("kind", "power"), [(8, 2), (11, 1), (12, 0)])
def test_universal_files(tmp_path, kind, power):
    """Receptance, mobility and accelerance come out as accelerance; 1e-5: what the file's digits keep."""
    pyuff = pytest.importorskip("pyuff")
    f = np.linspace(250, 310, 200)
    a = accelerance(f)
    data = a / (2j * np.pi * f) ** power
    point = {"rsp_node": 1, "rsp_dir": 3, "ref_node": 1, "ref_dir": 3}
    dataset = pyuff.prepare_58(
        func_type=4, x=f, data=data, ordinate_spec_data_type=kind, orddenom_spec_data_type=13, **point
    )
    path = tmp_path / "frf.uff"
    pyuff.UFF(str(path)).write_sets(dataset, "overwrite")
    read = read_frf(path)
    np.testing.assert_allclose(read["accelerance_real"] + 1j * read["accelerance_imaginary"], a, rtol=1e-5)
