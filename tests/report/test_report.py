"""The report's numbers and words, without a browser."""

import base64
import math
import re
import zlib

import numpy as np
import pytest
import xarray as xr

from conftest import ROOT
from warpdamp import open_results
from warpdamp.errors import UsageError
from warpdamp.modal.damping import damping_of_effectiveness
from warpdamp.modes import Modes
from warpdamp.report.calculator import Calculator, interval_of
from warpdamp.report.content import content, optima_table, question_and_answers
from warpdamp.report.report_page import write_report


@pytest.fixture(scope="module")
def dataset(results):
    return xr.load_dataset(results)


def unpacked(shown, held):
    kind, offset, length = shown["packed"]["arrays"][held["array"]]
    raw = zlib.decompress(base64.b64decode(shown["packed"]["data"]))
    shape = [shown["dims"][dim] for dim in held["dims"]]
    return np.frombuffer(raw, f"<{kind}", length, offset).reshape(shape)


def modes_at(amplitude, frequency):
    """One mode as a damper sees it."""
    shape = np.array([[[0.0, 0.0, amplitude]]])
    return Modes(np.array([1]), np.array([frequency]), np.zeros((1, 3)), shape, np.zeros(1))


def test_the_calculator_gives_the_studys_own_damping():
    """At the study's modes and Gammas it is the modal damping of the results, by another way: eqs 4 to 11 in one."""
    results = open_results(ROOT / "docs" / "beam.nc")
    calculator = Calculator.of(results)
    mass = float(results["particle_mass"])
    for k in range(results.sizes["mode"]):
        for gamma in results["gamma"].values[2::6]:
            phi, f = float(results["mode_amplitude"][k]), float(results["frequency"][k])
            zeta, half = calculator.damping(mass, phi, f, gamma)
            value, width = (a.isel(mode=k).sel(gamma=gamma) for a in interval_of(results, "damping_ratio"))
            assert zeta == pytest.approx(float(value), rel=1e-6)  # the study ran at its modes to a microhertz
            assert half == pytest.approx(float(width), rel=1e-6)


def test_the_calculator_interpolates_as_the_accessor_does():
    results = open_results(ROOT / "docs" / "beam.nc")
    f = 150.0
    expected = results.damper.damping(modes_at(0.7, f))["damping_ratio"].isel(mode=0)
    calculator, mass = Calculator.of(results), float(results["particle_mass"])
    for gamma in (2.0, 7.0, 13.0):
        assert calculator.damping(mass, 0.7, f, gamma)[0] == pytest.approx(float(expected.sel(gamma=gamma)), rel=1e-12)
    between = calculator.damping(mass, 0.7, f, 7.25)[0]  # a quarter of the way from 7 to 8
    assert between == pytest.approx(
        0.75 * float(expected.sel(gamma=7)) + 0.25 * float(expected.sel(gamma=8)), rel=1e-12
    )


@pytest.mark.parametrize(("f", "gamma"), [(30, 5), (800, 5), (100, 0.4), (100, 15), (math.nan, 5)])
def test_the_calculator_extrapolates_nothing(f, gamma):
    calculator = Calculator.of(open_results(ROOT / "docs" / "beam.nc"))
    assert np.isnan(calculator.damping(0.024, 1.0, f, gamma)).all()


def test_a_failed_corner_of_no_weight_does_no_harm():
    value = np.array([[1.0, np.nan], [0.5, 0.25]])
    calculator = Calculator(np.array([10.0, 20.0]), np.array([1.0, 2.0]), value, np.zeros((2, 2)))
    assert calculator.damping(1.0, 1.0, 10.0, 1.0)[0] == damping_of_effectiveness(1.0, 1.0, 1.0)
    assert math.isnan(calculator.damping(1.0, 1.0, 10.0, 1.5)[0])


def test_the_mechanisms_add_up(dataset):
    shown = content(dataset, None)
    layers = sum(unpacked(shown, layer) for layer in shown["losses"]["layers"])
    total = unpacked(shown, shown["losses"]["total"])
    assert layers == pytest.approx(total, rel=1e-5)  # single precision in the page
    assert shown["losses"]["adds_up"] < 1e-12
    energy = 1e3 * dataset["energy_dissipated"].mean("seed")
    assert total == pytest.approx(energy.values, rel=1e-6)


def test_arrays_are_those_of_the_results(dataset):
    shown = content(dataset, None)
    held = shown["variables"]["damping_ratio"]["value"]
    assert held["dims"] == ["frequency", "gamma"]
    assert unpacked(shown, held) == pytest.approx(100 * dataset["damping_ratio"].values, rel=1e-6)
    names = next(c for c in shown["coordinates"] if c["name"] == "frequency")["names"]
    assert [name.partition(",")[0] for name in names] == ["mode 1", "mode 3"]


def test_the_answer_names_the_largest_damping_of_every_mode(dataset):
    _, answers = question_and_answers(dataset)
    assert len(answers) == 2
    for k, answer in enumerate(answers):
        own = dataset["damping_ratio"].isel(mode=k)
        assert f"{100 * float(own.max()):.3g} %" in answer
        assert f"at Γ {float(own.idxmax('gamma')):g}" in answer
        assert answer.startswith(f"Mode {int(own['mode'])} (")


def test_the_table_is_that_of_the_terminal(dataset):
    table = optima_table(dataset)
    assert table["heads"][:3] == ["mode", "f [Hz]", "phi [kg^-½]"]
    assert [row[0] for row in table["rows"]] == ["1", "3"]


def test_a_page_has_no_outside_address_and_says_what_is_missing(dataset, tmp_path):
    write_report(dataset, tmp_path / "r.html", modes="No modes today.", film="No film today.")
    text = (tmp_path / "r.html").read_text()
    assert not re.search(r"""(src|href)=["'](?!#|data:)""", text)
    assert "//" not in re.sub(r"/\*.*?\*/|(?<=\s)//.*", "", text.partition('<script type="application/json"')[0])
    assert "No modes today." in text
    assert "No film today." in text
    assert "&lt;b&gt;" in text
    assert "<b>" not in text
    assert "youngs_modulus: 33000000.0" in text


def test_results_without_a_finished_case(dataset, tmp_path):
    failed = dataset.assign(effectiveness=dataset["effectiveness"] * np.nan)
    with pytest.raises(UsageError, match="no case is finished"):
        write_report(failed, tmp_path / "r.html")
    assert list(tmp_path.iterdir()) == []


def test_a_part_of_a_run(dataset, tmp_path):
    with pytest.raises(UsageError, match="not the results of a whole run: there is no status"):
        write_report(dataset.drop_vars("status"), tmp_path / "r.html")


def test_too_many_points(dataset, monkeypatch, tmp_path):
    monkeypatch.setattr("warpdamp.report.content.MOST_POINTS", 7)
    with pytest.raises(UsageError, match="a page holds 7 points, and these results have 8"):
        write_report(dataset, tmp_path / "r.html")


def test_packings_that_move_in_different_ways_are_said_to(dataset):
    mixed = dataset.copy(deep=True)
    mixed["effectiveness"][0, 0, 0] = 0.001  # solid, beside one that is not
    shown = content(mixed, None)
    names, regimes = shown["regimes"]["names"], unpacked(shown, shown["regimes"])
    assert names[regimes[0, 0]] == "packings differ"
