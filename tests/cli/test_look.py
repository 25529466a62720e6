"""``warpdamp film`` and ``warpdamp report`` as a user meets them; what goes wrong is one line and leaves nothing."""

import importlib.util
import os
import sys

import pytest
from typer.testing import CliRunner

from warpdamp import run
from warpdamp.analysis.results import write
from warpdamp.cli.app import app
from warpdamp.errors import MissingLibrary
from warpdamp.status import Status

STUDY = """
title: Four balls
damper:
  enclosure: {diameter: 20 mm, height: 20 mm, material: pmma}
  particles: {count: 4, radius: 3 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {frequency: 60 Hz, gamma: [3, 6]}
preparation: loose
steady_state: {fewest_cycles: 8, most_cycles: 8}
"""


@pytest.fixture
def warpdamp(folder, monkeypatch):
    """Runs a command in the folder of the study."""
    monkeypatch.chdir(folder)
    return lambda *arguments: CliRunner().invoke(app, list(map(str, arguments)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with a study and its results; the case of Gamma 3 had failed."""
    folder = tmp_path_factory.mktemp("look")
    (folder / "study.yaml").write_text(STUDY)
    dataset = run(folder / "study.yaml", executor="in-process")
    dataset["status"].loc[{"gamma": 3}] = int(Status.ESCAPED)
    write(dataset, folder / "study.nc")
    return folder


def refused(done, folder, *words):
    """Whether a command failed with one line that says why, and left nothing behind."""
    there = {path.name for path in folder.rglob("*")}
    assert done.exit_code == 2
    lines = [line for line in done.stderr.strip().splitlines() if not line.startswith("frames ")]
    assert len(lines) == 1, done.stderr
    for word in words:
        assert word in lines[0]
    assert {name for name in there if "film" in name or "writing" in name or name.endswith(".html")} == set()


def test_a_film_of_results(warpdamp, tmp_path):
    done = warpdamp("film", "study.nc", "--gamma", 6, "-o", tmp_path / "new" / "a.html", "--frames", 4)
    assert done.exit_code == 0, done.stderr
    assert "its energies the same in every bit" in done.stdout
    assert (tmp_path / "new" / "a.html").stat().st_size < 6e6


def test_a_report(warpdamp, tmp_path):
    done = warpdamp("report", "study.nc", "-o", tmp_path / "r.html")
    assert done.exit_code == 0, done.stderr
    text = (tmp_path / "r.html").read_text()
    assert "Four balls" in text
    assert 'data-film="film"' in text
    assert "a particle left the cavity" in text  # the case that had failed


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("film", "study.nc", "--gamma", "4"), ["no case with gamma 4: there is 3, 6"]),
        (("film", "study.nc", "--mode", "1"), ["no mode to choose by"]),
        (("film", "study.nc", "--gamma", "3"), ["had failed", "a particle left the cavity"]),
        (("film", "study.nc", "-o", "film.avi"), ["ends in .html, .gif, .mp4, .xyz, .vtkhdf"]),
        (("film", "nothing.nc"), ["there is no file nothing.nc"]),
        (("film", "study.yaml"), ["2 such cases: choose by gamma as well: 3, 6"]),
        (("film", "study.nc", "-o", "study.yaml/film.html"), ["study.yaml"]),
        (("report", "study.nc", "-o", "study.yaml/r.html"), ["study.yaml"]),
        (("report", "study.nc", "-o", "r.pdf"), ["r.pdf: name a file that ends in .html"]),
        (("report", "nothing.nc"), ["there is no file nothing.nc"]),
        (("report", "study.yaml"), ["study.yaml: is no netCDF file"]),
    ],
)
def test_what_goes_wrong_is_one_line_and_leaves_nothing(warpdamp, folder, arguments, words):
    refused(warpdamp(*arguments), folder, *words)


@pytest.mark.parametrize(
    ("library", "arguments", "extra"),
    [
        ("jinja2", ("report", "study.nc", "-o", "r.html"), "report"),
        ("jinja2", ("film", "study.nc", "--gamma", "6", "-o", "film.html"), "film"),
        ("imageio_ffmpeg", ("film", "study.nc", "--gamma", "6", "-o", "film.mp4"), "film"),
        ("h5py", ("film", "study.nc", "--gamma", "6", "-o", "film.vtkhdf"), "film"),
    ],
)
def test_a_missing_extra_is_named_with_its_pip_line_before_anything_runs(
    warpdamp, folder, monkeypatch, library, arguments, extra
):
    find = importlib.util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda name, *rest: None if name == library else find(name, *rest))
    refused(warpdamp(*arguments), folder, library, f"pip install 'warpdamp[{extra}]'")


def test_a_missing_cluster_library_is_named_with_its_pip_line(folder, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingLibrary, match=r"Dask is not installed: pip install 'warpdamp\[cluster\]'"):
        run(folder / "study.yaml", executor="dask", store=tmp_path)


def test_a_folder_that_cannot_be_written(warpdamp, folder, monkeypatch):
    """As for a user without permission: root may write anywhere."""
    monkeypatch.setattr("os.access", lambda path, mode, **_: mode != os.W_OK)
    refused(warpdamp("film", "study.nc", "--gamma", "6", "-o", "film.gif"), folder, "cannot be written")


def test_several_files_of_one_run_of_the_most_effective_case(warpdamp, tmp_path):
    files = [tmp_path / f"a.{suffix}" for suffix in ("gif", "xyz")]
    options = [part for file in files for part in ("-o", file)]
    done = warpdamp("film", "study.nc", *options, "--frames", 3, "--colour", "spin", "--forces")
    assert done.exit_code == 0, done.stderr
    assert all(file.stat().st_size for file in files)
    assert "Γ 6" in done.stdout  # that of Gamma 3 had failed
