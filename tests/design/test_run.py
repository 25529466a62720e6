"""A small design by simulation, whole, stopped and continued; and the commands."""

import importlib.util
import sys
from functools import partial

import pytest
from typer.testing import CliRunner

from conftest import ROOT
from warpdamp import open_results
from warpdamp.cli.app import app
from warpdamp.design import cases, tolerances, verify
from warpdamp.errors import MissingLibrary
from warpdamp.study.run import run

SMALL = """\
structure:
  modes_given: [{frequency: 120 Hz, modal_mass: 0.3 kg}]
  particles_included: true
damper:
  enclosure: {diameter: 20 mm, height: 16 mm, material: soft}
  particles: {count: 4, radius: 3.73 mm, material: soft}
materials: {soft: {density: 920 kg/m^3, youngs_modulus: 3.3 MPa, poissons_ratio: 0.37}}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: [2, 4]}
preparation: loose
steady_state: {standard_error: 10 %, fewest_cycles: 8, most_cycles: 8}
design:
  target: {damping: 0.05 %, gamma: [2, 4]}
  variables:
    enclosure.height: {from: 14 mm, to: 20 mm}
    particles.count: {from: 2, to: 6}
  budget: {cases: 40}
"""


@pytest.fixture
def in_process(monkeypatch):
    monkeypatch.setattr(cases, "run", partial(run, executor="in-process"))
    monkeypatch.setattr(verify, "PACKINGS", 3)
    monkeypatch.setattr(tolerances, "SAMPLES", 4)


def command(*arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


def shards(folder):
    return {path.name for path in folder.rglob("shards/*.nc")}


class Stopped(Exception):
    """What stands for Ctrl-C."""


def test_a_search_that_was_stopped_goes_on_from_its_store(in_process, monkeypatch, tmp_path):
    """Stopped after the first cases: these are kept, and not run again."""
    study = tmp_path / "small.yaml"
    study.write_text(SMALL)

    def stop(*_):
        raise Stopped

    with monkeypatch.context() as patch:
        patch.setattr("warpdamp.design.search.Search.assess_all", stop)
        assert isinstance(command("design", study, "-o", tmp_path / "parts").exception, Stopped)
    first = shards(tmp_path / "parts")
    assert first
    monkeypatch.setattr("warpdamp.design.search.SAMPLE", 64)  # start takes the first of them, which stay
    done = command("design", study, "-o", tmp_path / "parts")
    assert done.exit_code == 0, done.output
    assert first < shards(tmp_path / "parts")
    assert "fresh packings" in done.output
    text = (tmp_path / "parts" / "small-design.yaml").read_text()
    assert text.startswith("# ")
    assert (tmp_path / "parts" / "small-design.png").read_bytes()[:4] == b"\x89PNG"
    assert command("report", tmp_path / "parts" / "small-design.nc").exit_code == 0
    assert "Which damper damps" in (tmp_path / "parts" / "small-design.html").read_text()
    assert command("modes", tmp_path / "parts" / "small-design.yaml").exit_code == 0


def test_what_is_impossible_is_one_line_and_no_simulation(tmp_path):
    study = tmp_path / "small.yaml"
    study.write_text(SMALL.replace("damping: 0.05 %", "damping: 3 %"))
    done = command("design", study, "-o", tmp_path)
    assert done.exit_code == 2
    assert "small.yaml:14:3: design.variables: the target is impossible: 3 % takes at least 14.14 g" in done.output
    assert not shards(tmp_path)


def test_without_its_extra_a_design_says_so_before_anything_runs(monkeypatch, tmp_path):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *rest: None if name == "sklearn" else find(name, *rest)
    )
    done = command("design", ROOT / "configs" / "design.yaml", "-o", tmp_path)
    assert done.exit_code == 2
    assert done.stderr == "warpdamp: designs need sklearn: pip install 'warpdamp[design]'\n"
    assert not shards(tmp_path)


def test_without_its_extra_an_emulator_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "sklearn.gaussian_process", None)
    with pytest.raises(MissingLibrary, match="emulators need scikit-learn: pip install 'warpdamp\\[design\\]'"):
        open_results(ROOT / "docs" / "beam.nc").damper.emulator()


def test_a_study_without_design_says_so():
    done = command("design", ROOT / "configs" / "beam.yaml")
    assert done.exit_code == 2
    assert "design: missing: say what is wanted, under design" in done.output


def test_materials_are_listed():
    assert "soda_lime_glass" in command("materials").output
    assert "doi:10.1063/1.868282" in command("materials", "soda_lime_glass").output
    assert "did you mean 'lead'?" in command("materials", "led").output


def test_a_measurement_is_compared(tmp_path):
    table = tmp_path / "measured.csv"
    table.write_text("mode,gamma,damping_ratio [%],damping_ratio_standard_error [%]\n1,4,2.5,0.1\n1,6,3,0.1\n")
    done = command("compare", ROOT / "docs" / "beam.nc", table)
    assert done.exit_code == 0, done.output
    assert "residuals over joint errors" in done.output
    assert (tmp_path / "measured.png").exists()
