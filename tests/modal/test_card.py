"""The damper as a part: round trips, intervals, ranges, refusals, and the same damping as by other ways."""

import re

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from card_beam import COUPLED, DIRECT, FRF, compared
from conftest import ROOT
from nastran_tables import read_bush
from warpdamp.accessor import open_results
from warpdamp.cli.app import app
from warpdamp.errors import ModalError, UsageError
from warpdamp.modal.apparent_mass import ComplexMass
from warpdamp.modal.card import at_frequencies, card, damping, is_card, read_card, write_card
from warpdamp.modal.card_nastran import write_nastran
from warpdamp.modal.frf import ModalModel, accelerance, constant_force
from warpdamp.modal.from_config import modes as structure_modes
from warpdamp.modes import Modes
from warpdamp.status import Status
from warpdamp.sweep.load import load

PARTICLES, G = 0.02, 9.81


@pytest.fixture(scope="module")
def results():
    """The committed results of the main job."""
    return xr.load_dataset(ROOT / "docs" / "beam.nc")


@pytest.fixture(scope="module")
def part(results):
    return card(results)


@pytest.fixture(scope="module")
def modes(part):
    """Those of the beam that the results are of."""
    return structure_modes(load(ROOT / "configs" / "beam.yaml"), particles=float(part["particle_mass"]))


def listed(apparent=lambda f: 0.01 + 0 * f, quadrature=lambda f: 0.008 + 0 * f, seeds=(-1, 0, 1), spread=1e-4):
    """Results at a list of frequencies, of masses that depend on frequency alone [kg], and a spread between seeds."""
    frequency, gamma = np.array([20.0, 40.0, 80.0, 160.0]), np.array([1.0, 2.0, 4.0])
    f = frequency[:, None, None] + 0 * gamma[None, :, None]
    both = [mass(f) + spread * np.array(seeds) for mass in (apparent, quadrature)]
    w, dims = 2 * np.pi * frequency[:, None], ("frequency", "gamma", "seed")
    displacement = gamma * G / w**2
    work = np.pi * (w * displacement)[..., None] ** 2 * both[1]
    return xr.Dataset(
        {
            "apparent_mass": (dims, both[0]),
            "harmonic_work": (dims, work),
            "effectiveness": (dims, np.pi / 4 * both[1] / PARTICLES),  # m'' = (4 / pi) eps m
            "displacement": (dims[:2], displacement),
            "excitation_frequency": ("frequency", frequency),
            "particle_mass": PARTICLES,
            "status": (dims, np.zeros(both[0].shape, int)),
        },
        {"frequency": frequency, "gamma": gamma, "seed": np.arange(len(seeds))},
        {"title": "a list", "source": "warpdamp 1", "seeds": np.arange(len(seeds))},
    )


def beside(frequency, shapes) -> list[Modes]:
    """Modes at frequencies [Hz] as dampers with the given shapes [kg^-0.5] see them."""
    shape = np.zeros((len(frequency), len(shapes), 3))
    shape[..., 2] = np.array(shapes, float)
    point = np.arange(3.0 * len(shapes)).reshape(-1, 3)
    first = Modes(np.arange(1, 1 + len(frequency)), np.array(frequency), point, shape, np.full(len(frequency), 0.001))
    return [first.seen_from(k, (0, 0, 1)) for k in range(len(shapes))]


def test_a_card_reads_back_to_the_same_bits(part, tmp_path):
    write_card(part, tmp_path / "a.csv")
    first = read_card(tmp_path / "a.csv")
    write_card(first, tmp_path / "a.nc")
    second = read_card(tmp_path / "a.nc")
    write_card(second, tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    for found in (first, second):
        xr.testing.assert_identical(found.drop_attrs(), part.drop_attrs())
        assert {name: found[name].attrs["units"] for name in found} == {
            name: part[name].attrs["units"] for name in part
        }
        assert found.attrs.keys() == part.attrs.keys()


def test_a_card_says_where_it_comes_from_and_where_it_holds(results, part):
    for name in ("source", "configuration", "references", "seeds"):
        np.testing.assert_array_equal(part.attrs[name], results.attrs[name])
    assert re.search(r"\(physics \d+\)", part.attrs["source"])
    assert part.attrs["gamma_range"] == pytest.approx([0.5, 14])
    assert part.attrs["frequency_range"] == pytest.approx([0.95 * 39.500855, 1.05 * 730.598708])
    assert card(listed()).attrs["frequency_range"] == pytest.approx([20, 160])


def test_intervals_are_students(results, part):
    """t of 2 degrees of freedom at 97.5 % is 4.302653; m'' also has the interval of the energy per cycle."""
    spread = results["apparent_mass"].std("seed", ddof=1) / np.sqrt(3)
    np.testing.assert_allclose(part["apparent_mass_interval"], 4.302653 * spread, rtol=1e-6)
    relative = results["energy_mean_interval"] / results["energy_mean"]
    assert bool((part["quadrature_mass_interval"] >= relative * part["quadrature_mass"] * (1 - 1e-12)).all())
    np.testing.assert_allclose(part["effectiveness_interval"] / part["effectiveness"], relative, rtol=0.05, atol=0.5)
    without = card(listed())
    np.testing.assert_allclose(without["quadrature_mass_interval"], 4.302653 * 1e-4 / np.sqrt(3), rtol=1e-6)


def test_what_gives_no_card_is_refused():
    with pytest.raises(ModalError, match=r"one packing at Gamma 1, 20 Hz has no interval: run with two seeds"):
        card(listed(seeds=(0,)))
    with pytest.raises(ModalError, match="the results have the axes friction: choose one value"):
        card(xr.concat([listed(), listed()], "friction").assign_coords(friction=[0.1, 0.2]))
    with pytest.raises(ModalError, match="several dampers"):
        card(listed().expand_dims(damper=2))


def test_a_gamma_with_a_failed_case_is_left_out_and_said():
    failed = listed()
    failed["apparent_mass"][1, 1, 2] = np.nan
    part = card(failed)
    assert part["gamma"].values.tolist() == [1, 4]
    assert part.attrs["gamma_left_out"] == [2.0]


def test_between_frequencies_a_card_is_straight_in_their_logarithm():
    part = card(listed(lambda f: 0.01 * np.log2(f / 10), lambda f: 0.002 * np.log2(f / 10)))
    at = at_frequencies(part, [20 * np.sqrt(2), 100.0])
    expected = np.log2(np.array([2 * np.sqrt(2), 10.0]))[:, None] * np.ones(3)
    np.testing.assert_allclose(at["apparent_mass"], 0.01 * expected, rtol=1e-12)
    np.testing.assert_allclose(at["quadrature_mass"], 0.002 * expected, rtol=1e-12)
    energy = np.pi / 0.25 * 0.25 * 0.002 * expected * (2 * np.pi * at["frequency"] * at["displacement"]) ** 2
    np.testing.assert_allclose(at["energy_dissipated"], energy, rtol=1e-12)
    assert at["packings"].dtype == int
    assert (at["packings"] == 3).all()


def test_a_card_gives_the_frf_of_its_study(results, part):
    frequency = np.concatenate([np.linspace(38, 42, 50), np.linspace(700, 760, 50)])
    own = accelerance(results, [1.0, 7.3], frequency)
    by_card = accelerance(part, [1.0, 7.3], frequency, structure=ModalModel.of(results))
    for name in ("accelerance_real", "accelerance_imaginary", "resonance_frequency", "resonance_damping_ratio"):
        np.testing.assert_allclose(by_card[name], own[name], rtol=1e-9)
    forced = [
        constant_force(dataset, 0.5, (38, 41), structure=ModalModel.of(results))["response_gamma"]
        for dataset in (results, part)
    ]
    np.testing.assert_allclose(*forced, rtol=1e-6)


def test_one_row_of_the_document(part, modes):
    """Asked for: 0.5 % in frequency, 2 % in damping; a solid's clamps make 0.3 % of the one, and three modes of all 0.4 %."""
    found = compared(part, modes, 3, 5.0)
    for way in (DIRECT, COUPLED):
        assert found[way][0] == pytest.approx(found[FRF][0], rel=0.0035)
        assert found[way][1] == pytest.approx(found[FRF][1], rel=0.005)
    assert found[DIRECT] == pytest.approx(found[COUPLED], rel=2e-4)


def test_damping_by_energies_is_that_of_the_study(results, part, modes):
    expected = results["damping_ratio"]
    np.testing.assert_allclose(damping([part], [modes])["damping_ratio"], expected, rtol=1e-6)
    np.testing.assert_allclose(part.damper.damping(modes)["damping_ratio"], expected, rtol=1e-6)
    np.testing.assert_allclose(results.damper.damping(modes)["damping_ratio"], expected, rtol=1e-6)


def test_several_dampers_add_up():
    """zeta = (2 / pi) eps m phi^2 of each, and what the structure has."""
    small = card(listed(quadrature=lambda f: 0.004 + 0 * f))
    seen = beside([50.0, 100.0], [[1.0, 0.8], [0.5, -0.8]])
    seen = [seen[0].seen_from(0, (0, 0, 1)), seen[0].seen_from(1, (0, 0, 1))]
    found = damping([card(listed()), small], seen)
    first, second = (modes.amplitude[:, None] ** 2 for modes in seen)
    expected = 0.008 / 2 * first + 0.004 / 2 * second + 0.001  # m'' phi^2 / 2 = (2 / pi) eps m phi^2
    ratio = np.abs(seen[1].amplitude / seen[0].amplitude)[:, None] * found["gamma"].values
    inside = (ratio >= 1 - 1e-9) & (ratio <= 4 + 1e-9)
    assert 0 < inside.sum() < inside.size
    np.testing.assert_allclose(found["damping_ratio"], np.where(inside, expected, np.nan), rtol=1e-9)


def test_outside_its_range_a_card_is_refused(part):
    def structure(*frequency):
        count = len(frequency)
        return ModalModel(np.array(frequency), np.full(count, 0.5), np.zeros(count), float(part["particle_mass"]))

    near = structure(39.6)
    with pytest.raises(ModalError, match=r"gamma: the results reach from 0.5 to 14"):
        accelerance(part, [20.0], structure=near)
    with pytest.raises(ModalError, match=r"a mode at 12\d.* within 5 % of 39.5, 280.1, 730.6 Hz"):
        accelerance(part, structure=structure(39.6, 121.0))
    with pytest.raises(ModalError, match=r"Hz is outside the range of the card, 37.53 to 767.1 Hz"):
        accelerance(part, structure=structure(39.6, 900.0))
    with pytest.raises(ModalError, match=r"20 Hz is outside the range of the card, 37.53 to 767.1 Hz"):
        accelerance(part, structure=near, band=(20, 50))
    with pytest.raises(ModalError, match=r"1000 Hz is outside the range of the card"):
        constant_force(part, 0.01, (38, 1000), structure=near)
    with pytest.raises(ModalError, match="these results have no modes"):
        accelerance(part)
    with pytest.raises(ModalError, match="200 Hz is outside the range of the card, 20 to 160 Hz"):
        at_frequencies(card(listed()), [30, 200])
    assert accelerance(part, structure=near)["frequency"].min() >= 37.5


def test_modes_beyond_a_band_are_its_residuals(part):
    """At 0 kg^-0.5 they are none, and their own resonance is not told."""
    alone = ModalModel(np.array([39.6]), np.array([1.6]), np.zeros(1), float(part["particle_mass"]))
    more = ModalModel(np.array([39.6, 120.0]), np.array([1.6, 0.0]), np.zeros(2), float(part["particle_mass"]))
    frequency = np.linspace(38, 42, 40)
    frf = [accelerance(part, [5.0], frequency, structure=structure) for structure in (alone, more)]
    np.testing.assert_allclose(frf[1]["accelerance_imaginary"], frf[0]["accelerance_imaginary"], rtol=1e-9)
    assert np.isfinite(frf[1]["resonance_frequency"].values[:, 0]).tolist() == [True, False]


def test_nastrans_tables_are_the_complex_mass(part, tmp_path):
    """K + j w B = -w^2 (m' - m - j m''), straight between the points: w^2 within 1e-4 where m' - m is not small."""
    file = tmp_path / "damper.bdf"
    write_nastran(part, file, 5.0)
    (x, stiffness), (also, viscous) = read_bush(file)
    np.testing.assert_array_equal(x, also)
    assert np.diff(np.log(x)).max() < 0.0201
    felt = ComplexMass.of(part)
    frequency = np.geomspace(*felt.band, 3000)
    w = 2 * np.pi * frequency
    found = np.interp(frequency, x, stiffness) + 1j * w * np.interp(frequency, x, viscous)
    expected = -(w**2) * (felt(frequency, 5.0) - float(part["particle_mass"]))
    assert np.abs(found / expected - 1).max() < 5e-4
    text = file.read_text()
    assert max(map(len, text.splitlines())) <= 80
    at_mode = complex(felt(float(part["frequency"][0]), 5.0))
    for said in (
        "at Gamma 5",
        "37.526 to 767.13 Hz",
        f"39.5 Hz: m' {1e3 * at_mode.real:.4g} g, m'' {-1e3 * at_mode.imag:.4g} g",
        "CONM2,9001,GRID,,0.0239985",
    ):
        assert said in text
    with pytest.raises(ModalError, match=r"Gamma 15 is outside the range of the card, 0.5 to 14"):
        write_nastran(part, file, 15.0)


def test_what_is_no_card_is_refused_with_its_place(tmp_path):
    file = tmp_path / "damper.csv"
    write_card(card(listed()), file)
    text = file.read_text()
    rows = text.splitlines(keepends=True)
    first = next(k for k, row in enumerate(rows) if row.startswith("20.0"))

    def without(name):
        return "".join(row for row in rows if not row.startswith(f"# {name}:"))

    for changed, message in (
        ("frequency [Hz],x [kg]\n1,2\n", r"damper.csv: is no card of a damper: it has no line '# card"),
        (without("particle_mass_kg"), r"it has no line '# particle_mass_kg"),
        (text.replace("# card: 1", "# card: 7"), "is a card of version 7, read is 1"),
        (text.replace("# title: ", "# title: x"), r"damper.csv:1: title: expected a value in JSON"),
        ('# note: {"a": 1}\n' + text, r"damper.csv:1: note: expected text, a number or a list of either"),
        ("".join(rows[:-1]), "expected one row for every frequency and Gamma, 4 times 3"),
        (text + rows[-1], "expected one row for every frequency and Gamma"),
        (text.replace("apparent_mass [kg]", "apparent_mass [g]"), r"unknown column apparent_mass \[g\]"),
        (text.replace(rows[first], rows[first].replace("20.0", "nan", 1)), rf"damper.csv:{first + 1}: .*not finite"),
        (
            text.replace(rows[first], rows[first][:-2] + "0.5\n"),
            rf"damper.csv:{first + 1}: status: 0.5: expected a who",
        ),
        (text.replace('"frequencies": ', "").replace('"list"', '"all"'), 'expected "modes" or "list"'),
        (text.replace("gamma_range: [1.0, 4.0]", "gamma_range: [1.0, 9.0]"), "the rows reach from 1 to 4"),
        (text.replace("[20.0, 160.0]", "[30.0, 160.0]"), "frequency_range: expected the lowest and the highest"),
        (text.replace("particle_mass_kg: 0.02", "particle_mass_kg: -1"), "expected a mass above 0"),
    ):
        assert changed != text
        file.write_text(changed)
        with pytest.raises(ModalError, match=message) as caught:
            read_card(file)
        assert "\n" not in str(caught.value)
    with pytest.raises(ModalError, match="there is no file"):
        read_card(tmp_path / "none.csv")
    card(listed()).drop_vars("quadrature_mass").to_netcdf(tmp_path / "damaged.nc")
    with pytest.raises(ModalError, match="is a damaged card: it has no quadrature_mass"):
        read_card(tmp_path / "damaged.nc")
    (tmp_path / "text.nc").write_text("no netCDF")
    with pytest.raises(UsageError, match="is no netCDF file, or a damaged one"):
        read_card(tmp_path / "text.nc")
    with pytest.raises(ModalError, match=r"name a file that ends in \.nc or \.csv"):
        write_card(card(listed()), tmp_path / "a.txt")


def warpdamp(*arguments):
    done = CliRunner().invoke(app, list(map(str, arguments)))
    assert done.exception is None or isinstance(done.exception, SystemExit)
    return done


def test_the_commands(tmp_path):
    beam, config = ROOT / "docs" / "beam.nc", ROOT / "configs" / "beam.yaml"
    part = tmp_path / "beam.card.nc"
    done = warpdamp("card", beam, "-o", part)
    assert done.exit_code == 0, done.output
    assert is_card(open_results(part))
    unsteady = (
        f"{int((open_results(part)['status'] == Status.DRIFTING).sum())} of 63 points of the card: still drifting"
    )
    assert unsteady in done.output
    for more in ((tmp_path / "d.csv",), (tmp_path / "d.dat", "--gamma", 5)):
        assert warpdamp("card", part, "-o", *more).exit_code == 0
    done = warpdamp("frf", tmp_path / "d.csv", "--structure", config, "-o", tmp_path / "frf.nc")
    assert done.exit_code == 0, done.output
    frf = xr.load_dataset(tmp_path / "frf.nc")
    assert frf.attrs["card"] == 1
    expected = float(accelerance(open_results(beam), gamma=[5])["resonance_damping_ratio"].sel(mode=1, gamma=5))
    assert float(frf["resonance_damping_ratio"].sel(mode=1, gamma=5)) == pytest.approx(expected, rel=0.01)
    done = warpdamp("damping", part, "--structure", config, "-o", tmp_path / "damping.nc")
    assert done.exit_code == 0, done.output
    largest = float(xr.load_dataset(tmp_path / "damping.nc")["damping_ratio"].sel(mode=1).max())
    assert f"{largest:.4g} ± 0.001" in done.output
    assert unsteady in done.output
    for arguments, message in {
        ("frf", part): "is a card, a damper without a structure: name one by --structure CONFIG",
        ("frf", part, "--structure", ROOT / "configs" / "frequency_map.yaml"): "missing: a damper needs a structure",
        (
            "frf",
            part,
            "--structure",
            ROOT / "configs" / "two_dampers.yaml",
        ): "the structure carries 2, and the cards given are 1",
        ("damping", part, "--structure", ROOT / "configs" / "cantilever.yaml"): "a mode at 51.",
        ("damping", part, part, "--structure", config): "the structure carries 1, and the cards given are 2",
        ("damping", tmp_path / "frf.nc", "--structure", config): "is an FRF: warpdamp fit reads it",
        ("card", beam, "-o", tmp_path / "d.bdf"): "give it by --gamma",
        ("card", beam, "--gamma", 5, "-o", tmp_path / "d.csv"): "leave it out",
        ("card", beam, "-o", tmp_path / "d.txt"): "name a file that ends in .nc or .csv, or in .bdf or .dat",
        ("card", tmp_path / "none.nc"): "there is no file",
        ("card", ROOT / "docs" / "emulator_training.nc"): "the results have no apparent_mass and no harmonic_work",
        ("frf", beam, "--band", 5000, 6000): "5000 Hz is far above the highest mode, 730.6 Hz",
        ("frf", beam, "-o", tmp_path / "frf.txt"): "name a file that ends in .nc, .png, .pdf or .svg",
    }.items():
        done = warpdamp(*arguments)
        assert done.exit_code == 2, (arguments, done.output)
        assert message in " ".join(done.output.split())


def test_a_card_of_another_damper_is_said(part, tmp_path):
    """By the first thing that differs, and how many more; the same damper is not mentioned."""
    write_card(part, tmp_path / "one.csv")
    text = (ROOT / "configs" / "beam.yaml").read_text()
    (tmp_path / "same.yaml").write_text(text.replace("title:", "# other words\ntitle:"))
    (tmp_path / "other.yaml").write_text(
        text.replace("count: 120", "count: 60").replace("friction: 0.86", "friction: 0.5")
    )
    for name, said in (
        ("same", ""),
        ("other", "particles.count 120 where the study has 60, and 1 more; the card counts"),
    ):
        for command in ("damping", "frf"):
            arguments = [command, str(tmp_path / "one.csv"), "--structure", str(tmp_path / f"{name}.yaml")]
            arguments += ["-o", str(tmp_path / "out.nc")]
            done = CliRunner().invoke(app, arguments)
            assert done.exit_code == 0, done.output
            assert ("the card is of another damper" in done.output) == bool(said)
            assert said in " ".join(done.output.split())


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("apparent_mass", np.nan, "apparent_mass at frequency 39.5.*, gamma .* is nan, expected a finite number"),
        ("quadrature_mass_interval", -1.0, "is -1, expected at least 0"),
        ("packings", 0.5, "packings at .* expected a whole number"),
    ],
)
def test_a_netcdf_card_with_damaged_numbers_is_refused(part, tmp_path, name, value, said):
    damaged = part.copy(deep=True)
    damaged[name] = damaged[name].astype(float)
    damaged[name][{"frequency": 0, "gamma": 3}] = value
    write_card(damaged, tmp_path / "damaged.nc")
    with pytest.raises(ModalError, match=f"damaged.nc: is a damaged card: .*{said}.*: write it again"):
        read_card(tmp_path / "damaged.nc")
