"""The mass a structure feels, and its frequency response, against closed forms; the paper's beam from docs/beam.nc."""

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from conftest import ROOT
from warpdamp.errors import ModalError
from warpdamp.modal import appendix_a as two_mass
from warpdamp.modal.apparent_mass import ComplexMass, complex_mass, corrected, loaded_modes
from warpdamp.modal.beam import Beam, PointMass, beam_modes
from warpdamp.modal.frf import ModalModel, accelerance, chosen, complex_accelerance, constant_force
from warpdamp.modal.section import Rectangle
from warpdamp.scene.scene import Material
from warpdamp.variables import VARIABLES

G = 9.81
PARTICLES = 0.0239985
FREQUENCY = np.array([39.5, 280.0, 730.0])
AMPLITUDE = np.array([1.66, 0.77, 0.55])


@pytest.fixture(scope="module")
def beam():
    """The committed results of the main job."""
    return xr.load_dataset(ROOT / "docs" / "beam.nc")


def study(apparent, quadrature, gamma=(0.5, 1.0, 2.0, 4.0, 8.0), modes=slice(None), inherent=0.0):
    """Results of a damper whose complex mass is ``apparent`` - j ``quadrature``, functions of Gamma (same at all f)."""
    gamma, frequency, phi = np.array(gamma), FREQUENCY[modes], AMPLITUDE[modes]
    w = 2 * np.pi * frequency[:, None, None]
    x = gamma[None, :, None] * G / w**2 * np.ones((1, 1, 2))
    mass, loss = (np.broadcast_to(f(gamma)[None, :, None], x.shape) for f in (apparent, quadrature))
    work = np.pi * w**2 * x**2 * loss
    dims = ("frequency", "gamma", "seed")
    zeta = loss[..., 0] * phi[:, None] ** 2 / 2 + inherent
    return xr.Dataset(
        {
            "apparent_mass": (dims, mass),
            "harmonic_work": (dims, work),
            "energy_dissipated": (dims, work),
            "effectiveness": (dims, work / (4 * (w * x) ** 2 * PARTICLES)),
            "particle_mass": ((), PARTICLES),
            "displacement": (("frequency", "gamma"), x[..., 0]),
            "excitation_frequency": ("frequency", frequency),
            "natural_frequency": ("mode", frequency),
            "mode_amplitude": ("mode", phi),
            "inherent_damping": ("mode", np.full(len(phi), inherent)),
            "damping_ratio": (("mode", "gamma"), zeta),
            "damping_ratio_standard_error": (("mode", "gamma"), 0 * zeta),
        },
        {"frequency": frequency, "gamma": gamma, "seed": [1, 2], "mode": np.arange(1, len(frequency) + 1)},
    )


def constant(value):
    return lambda gamma: np.full(gamma.shape, value)


def test_the_mass_of_the_particles_is_in_the_results(beam):
    assert float(beam["particle_mass"]) == pytest.approx(PARTICLES, rel=1e-5)


def test_complex_mass_is_the_appendix_one(beam):
    """m'' = (4 / pi) eps m (appendix A): 1 % is what dissipation and harmonic agree to where a case is steady."""
    steady = (beam["status"] == 0).all("seed") & (beam["gamma"] > 1)  # at rest there is next to nothing to compare
    expected = 4 / np.pi * beam["effectiveness"].mean("seed") * PARTICLES
    ratio = (complex_mass(beam)["quadrature_mass"] / expected).where(steady)
    assert int(ratio.count()) > 40
    assert float(np.abs(ratio - 1).max()) < 0.01


def test_with_the_particles_as_a_rigid_mass_nothing_is_corrected():
    found = corrected(study(constant(PARTICLES), constant(0.01), inherent=0.002))
    np.testing.assert_allclose(found["corrected_natural_frequency"], np.tile(FREQUENCY, (5, 1)).T, rtol=1e-12)
    xr.testing.assert_allclose(found["corrected_damping_ratio"], found["damping_ratio"].rename(None), rtol=1e-12)
    xr.testing.assert_allclose(found["corrected_strain_energy"], found["strain_energy"], rtol=1e-12)


def test_one_mode_alone_follows_the_closed_form():
    """w^2 (1 + phi^2 (m' - m)) = w_r^2; strain energy by (w_r / w)^4 and damping by (w / w_r)^2, phi changing with w."""
    found = corrected(study(lambda g: 0.03 / g, constant(0.01), modes=[0])).isel(mode=0)
    added = 1 + AMPLITUDE[0] ** 2 * (0.03 / found["gamma"] - PARTICLES)
    np.testing.assert_allclose(found["corrected_natural_frequency"], 39.5 / np.sqrt(added), rtol=1e-12)
    np.testing.assert_allclose(found["corrected_damping_ratio"], found["damping_ratio"] / added, rtol=1e-12)
    ratio = found["corrected_strain_energy"] / found["strain_energy"]
    np.testing.assert_allclose(ratio, added**2, rtol=1e-12)
    np.testing.assert_allclose(found["empty_natural_frequency"], 39.5 / np.sqrt(1 - AMPLITUDE[0] ** 2 * PARTICLES))


def test_taking_the_particles_off_gives_the_empty_beam():
    """Three modes of the beam with particles give those without, as finite elements do: 0.01 % in f, 0.3 % in phi.

    What is left are the modes above the fifth.
    """
    paper = Beam(0.58, Rectangle(0.02, 0.004), Material(7800, 210e9, 0.3))
    empty, full = (beam_modes(paper, PointMass(0.2 + m, 0.29), highest=5).pick([1, 3, 5]) for m in (0.0, PARTICLES))
    frequency, amplitude = loaded_modes(full.frequency, full.amplitude, np.full(3, -PARTICLES))
    np.testing.assert_allclose(frequency, empty.frequency, rtol=1e-4)
    np.testing.assert_allclose(amplitude, empty.amplitude, rtol=3e-3)
    assert np.all(np.abs(full.amplitude[1:] / empty.amplitude[1:] - 1) > 0.05)  # shapes do change
    with pytest.raises(ModalError, match="more mass is taken away"):
        loaded_modes(full.frequency, full.amplitude, np.full(3, -1.0))


def test_every_variable_has_units_and_a_name(beam):
    for dataset in (corrected(beam), accelerance(beam, [1, 5]), constant_force(beam, 0.1, (35, 45))):
        for name, variable in dataset.data_vars.items():
            assert (variable.attrs["units"], variable.attrs["long_name"]) == VARIABLES[name]


def test_between_amplitudes_and_frequencies():
    mass = ComplexMass(np.array([10.0, 1000.0]), np.array([1.0, 2.0, 4.0]), np.array([[3, 2, 1], [6, 4, 2]]) * (1 - 1j))
    assert mass(10, 2) == 2 - 2j
    assert mass(100, 2) == pytest.approx(3 - 3j)  # half way in the logarithm
    assert mass([5, 2000], 4).tolist() == [1 - 1j, 2 - 2j]  # beyond: the nearest
    assert 2 < mass(11, 2).real < 2.011  # flat round a mode: 2 (3 t^2 - 2 t^3), t = log(1.1) / log(100)
    assert mass(10, 0.1) == 3 - 3j  # below the lowest Gamma
    assert 2 < mass(10, 1.5).real < 3
    np.testing.assert_array_equal(mass.within([0.5, 1, 4, 5]), [False, True, True, False])
    with pytest.raises(ModalError, match="Gamma 5 is above 4, the highest in the results"):
        mass(10, 5)
    listed = ComplexMass(mass.frequency, mass.gamma, mass.mass, of_modes=False)
    assert listed(10**1.5, 2) == pytest.approx(2.5 - 2.5j)  # straight


def test_a_single_mode_with_a_complex_mass_is_the_textbooks():
    """A = w^2 phi^2 / (w^2 (1 + phi^2 (m' - j m'' - m)) - w_r^2 (1 + 2 j zeta)), 1e-12."""
    found = accelerance(study(constant(0.01), constant(0.005), modes=[0], inherent=0.003), [1.0, 3.0])
    w, own, phi = 2 * np.pi * found["frequency"].values, 2 * np.pi * 39.5, AMPLITUDE[0]
    loaded = 1 + phi**2 * (0.01 - 0.005j - PARTICLES)
    expected = w**2 * phi**2 / (w**2 * loaded - own**2 * (1 + 0.006j))
    for curve in complex_accelerance(found).values:
        np.testing.assert_allclose(curve, expected, rtol=1e-9)
    square = own**2 * (1 + 0.006j) / loaded
    assert found["resonance_frequency"].values == pytest.approx(np.sqrt(square.real) / (2 * np.pi), rel=1e-12)
    assert found["resonance_damping_ratio"].values == pytest.approx(square.imag / square.real / 2, rel=1e-9)


def test_the_peaks_are_the_resonances_and_the_grid_resolves_them(beam):
    """Half a step along the modal circle is 0.06 zeta f: the largest point is within 0.1 zeta f of the frequency."""
    found = accelerance(beam, [0.5, 3, 14])
    size = np.abs(complex_accelerance(found))
    for gamma in found["gamma"].values:
        own = found.sel(gamma=gamma, mode=1)
        f, zeta = float(own["resonance_frequency"]), float(own["resonance_damping_ratio"])
        near = size.sel(gamma=gamma, frequency=slice(f * 0.9, f * 1.1))
        assert float(near["frequency"][int(np.argmax(near.values))]) == pytest.approx(f, rel=0.1 * zeta)
        half = near["frequency"].values[near.values > float(near.max()) / np.sqrt(2)]
        assert len(half) > 10
        assert half[-1] - half[0] == pytest.approx(2 * zeta * f, rel=0.15)  # to the spacing of the points


def test_a_damper_that_does_not_depend_on_gamma_responds_linearly():
    dataset = study(constant(0.01), constant(0.005))
    found = constant_force(dataset, 0.05, (35, 45))
    assert set(np.unique(found["branch"])) == {1}
    assert found["stable"].all()
    f = found["excitation_frequency"].values
    order = np.argsort(f)
    linear = complex_accelerance(accelerance(dataset, [1.0], f[order])).values[0]
    np.testing.assert_allclose(complex_accelerance(found).values[order], linear, rtol=1e-6)  # 1e-7 ends the corrector


def test_at_constant_force_every_point_is_a_point_of_the_controlled_family(beam):
    """Gamma g = F |A(f, Gamma)| on every branch: 1e-8 is the continuation's tolerance."""
    found = constant_force(beam, [0.05, 0.5], (36, 43))
    for k in range(0, found.sizes["point"], 97):
        point = found.isel(point=k)
        if not bool(point["within_range"]):
            continue
        same = accelerance(beam, [float(point["response_gamma"])], [float(point["excitation_frequency"])])
        assert complex(complex_accelerance(same).item()) == pytest.approx(
            complex(complex_accelerance(point).item()), rel=1e-8
        )
        assert abs(complex_accelerance(point).item()) * float(point["force"]) == pytest.approx(
            float(point["response_gamma"]) * G, rel=1e-8
        )


def test_a_mass_that_is_shaken_off_bends_the_peak_over():
    """m' falling fast with Gamma at little damping: three states at one frequency, the middle one unstable."""
    dataset = study(lambda g: PARTICLES / (1 + g**2), constant(0.0005), gamma=np.linspace(0.2, 8, 40), modes=[0])
    found = constant_force(dataset, 0.02, (39, 42))
    branch = found.isel(point=found["branch"].values == 1)
    step = np.diff(branch["excitation_frequency"])
    assert np.sum(step[1:] * step[:-1] < 0) == 2
    assert 0 < int((~branch["stable"].astype(bool)).sum()) < branch.sizes["point"] / 2
    forward = step > 0  # between the folds the curve runs back, and only there it is unstable
    unstable = ~branch["stable"].values.astype(bool)
    assert np.mean(unstable[:-1] == (forward != forward[0])) > 0.98


def test_what_cannot_be_had_is_refused(beam):
    with pytest.raises(ModalError, match="a force of -1 N: expected an amplitude above 0 N"):
        constant_force(beam, -1.0)
    with pytest.raises(ModalError, match=r"drives the damper above Gamma 14.*take a force between 0 and 1\.59"):
        constant_force(beam, 5.0, (30, 50))
    with pytest.raises(ModalError, match=r"reach from 0.5 to 14"):
        accelerance(beam, [0.1])
    with pytest.raises(ModalError, match="have no modes"):
        ModalModel.of(beam.drop_vars("natural_frequency"))
    with pytest.raises(ModalError, match="results at two Gammas or more"):
        ComplexMass.of(beam.isel(gamma=[3]))
    swept = xr.concat([beam, beam], xr.Variable("friction", [0.2, 0.8]))
    with pytest.raises(ModalError, match=r"have the axes friction: choose one value of each, as friction=0.2"):
        accelerance(swept)
    xr.testing.assert_identical(chosen(swept, ["friction=0.8"]).drop_vars("friction"), beam)
    for choice, message in {"friction=0.5": "choose from 0.2, 0.8", "size=1": "no swept scalar 'size'"}.items():
        with pytest.raises(ModalError, match=message):
            chosen(swept, [choice])


def test_bands_and_frequencies_that_are_none(beam):
    for band in ((50, 40), (0, 40), (-1, 40), (40, np.nan), (40, np.inf)):
        with pytest.raises(ModalError, match="band: expected two frequencies above 0 Hz, the lower one first"):
            accelerance(beam, band=band)
    for frequency in ([0.0, 40], [-40.0], [np.nan]):
        with pytest.raises(ModalError, match="frequency: expected finite frequencies above 0 Hz"):
            accelerance(beam, frequency=frequency)
    with pytest.raises(ModalError, match="give an amplitude"):
        constant_force(beam, [])


def test_axes_of_names_are_chosen_by_name(beam):
    swept = xr.concat([beam, beam], xr.Variable("preparation_", ["loose", "compacted"]))
    xr.testing.assert_identical(chosen(swept, ["preparation_=loose"]).drop_vars("preparation_"), beam)
    with pytest.raises(ModalError, match="choose from loose, compacted"):
        chosen(swept, ["preparation_=carried"])


def test_a_sweep_is_corrected_along_its_axes(beam):
    swept = xr.concat([beam, beam], xr.Variable("friction", [0.2, 0.8]))
    swept["excitation_frequency"] = beam["excitation_frequency"].expand_dims(friction=swept["friction"])
    found = corrected(swept)["corrected_natural_frequency"]
    assert found.dims == ("mode", "gamma", "friction")
    np.testing.assert_allclose(found.isel(friction=1), corrected(beam)["corrected_natural_frequency"])


def test_modes_may_come_in_any_order(beam):
    """A configuration may list modes as [5, 1, 3]: the same numbers, in that order."""
    order = [2, 0, 1]
    mixed = beam.isel(mode=order, frequency=order)
    xr.testing.assert_allclose(corrected(mixed), corrected(beam).isel(mode=order), rtol=1e-12)
    mixed, plain = accelerance(mixed, [3.0]), accelerance(beam, [3.0])
    xr.testing.assert_allclose(mixed, plain.isel(mode=order), rtol=1e-9)


def test_one_seed_and_a_failed_case_are_no_hindrance(beam):
    one = beam.isel(seed=[0])
    one["apparent_mass"] = one["apparent_mass"].where((one["gamma"] != 3) | (one["frequency"] > 100))
    found = corrected(one)
    assert np.isnan(found["corrected_natural_frequency"].sel(gamma=3)).values.tolist() == [True, False, False]
    assert found["corrected_natural_frequency_standard_error"].isnull().all()
    assert 3 not in ComplexMass.of(one).gamma
    assert np.isfinite(complex_accelerance(accelerance(one, [3.0]))).all()


def test_the_papers_appendix():
    """0.200 is the real modes' at r_k 1.41, 0.154 the rigid limit, 0.2037 = (2 / pi) 0.32 leaves the mass out."""
    assert two_mass.real_mode(0.32, 1.41)[1] == pytest.approx(0.200, abs=5e-4)
    assert two_mass.rigid_damping(0.32) == pytest.approx(0.154, abs=5e-4)
    assert 2 / np.pi * 0.32 == pytest.approx(0.2037, abs=5e-5)
    square = two_mass.complex_mode(0.32, 1e7)
    assert two_mass.energy_damping(square) == pytest.approx(two_mass.rigid_damping(0.32), rel=1e-6)
    assert two_mass.real_mode(0.32, 1e7)[1] == pytest.approx(two_mass.rigid_damping(0.32), rel=1e-6)
    assert two_mass.pole_damping(square) == pytest.approx(np.sin(np.arctan(square.imag / square.real) / 2))


def test_real_modes_err_by_the_square_of_the_damping():
    """Halving eps quarters the error in the loss factor; 5 %: the next order."""
    error = []
    for eps in (0.2, 0.1, 0.05):
        exact = two_mass.energy_damping(two_mass.complex_mode(0.32, 1.41, eps))
        error.append(two_mass.real_mode(0.32, 1.41, eps)[1] / exact - 1)
    assert error[0] / error[1] == pytest.approx(4, rel=0.05)
    assert error[1] / error[2] == pytest.approx(4, rel=0.05)


def warpdamp(*arguments):
    command = [sys.executable, "-m", "warpdamp", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=280)


def test_the_command_line(tmp_path):
    beam = ROOT / "docs" / "beam.nc"
    done = warpdamp("frf", beam, "-o", tmp_path / "frf.nc")
    assert done.returncode == 0, done.stderr
    done = warpdamp("fit", tmp_path / "frf.nc", "-o", tmp_path / "fit.png")
    assert done.returncode == 0, done.stderr
    for word in ("dobson", "least squares", "39.49", "733."):
        assert word in done.stdout
    done = warpdamp("frf", beam, "--constant-force", "0.2 N", "--band", 38, 41, "-o", tmp_path / "force.png")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "force.png").read_bytes()[:4] == b"\x89PNG"
    for arguments, message in {
        ("frf", beam, "--constant-force", "5 N", "--band", "30", "50"): "take a force between",
        ("frf", beam, "--constant-force", "5 m"): "has the wrong unit",
        ("frf", beam, "--at", "friction=1"): "no swept scalar 'friction'",
        ("frf", tmp_path / "frf.nc"): "is an FRF: warpdamp fit reads it",
        ("fit", tmp_path / "none.csv"): "no such file",
    }.items():
        done = warpdamp(*arguments)
        assert done.returncode == 2
        assert message in " ".join(done.stderr.split())
        assert "Traceback" not in done.stderr


def test_at_the_natural_frequency_of_a_mode_without_damping():
    """The receptance is infinite there, the dynamic mass that of the other end of the chain: minus the particles."""
    model = ModalModel(np.array([40.0, 90.0]), np.array([1.7, 0.8]), np.zeros(2), 0.02)
    assert model.dynamic_mass(np.array([40.0, 90.0])) == pytest.approx([-0.02, -0.02])
    near = model.dynamic_mass(40.0 * (1 + 1e-9))
    assert model.dynamic_mass(40.0) == pytest.approx(near, abs=1e-8)


def test_a_band_of_one_text_and_branches_are_refused_with_their_remedy(tmp_path):
    from typer.testing import CliRunner

    from warpdamp.cli.app import app

    beam = str(ROOT / "docs" / "beam.nc")
    done = CliRunner().invoke(app, ["frf", beam, "--band", "40,50", "-o", str(tmp_path / "x.png")])
    assert done.exit_code == 2
    assert "'40,50' is no frequency: give two numbers in Hz" in done.output
    branches = str(tmp_path / "branches.nc")
    made = CliRunner().invoke(app, ["frf", beam, "--constant-force", "50 mN", "--band", "38", "41", "-o", branches])
    assert made.exit_code == 0, made.output
    done = CliRunner().invoke(app, ["fit", branches])
    assert done.exit_code == 2
    assert "holds branches at constant force" in done.output
