"""The command line as a user meets it."""

import json
import os
import subprocess
import sys

import pytest
import xarray as xr

from conftest import ROOT


def warpdamp(*arguments, cwd=None):
    return subprocess.run(
        [sys.executable, "-m", "warpdamp", *map(str, arguments)], capture_output=True, text=True, cwd=cwd, timeout=280
    )


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """The paper's study, shortened, into a folder that does not exist yet."""
    output = tmp_path_factory.mktemp("cli") / "new" / "folder"
    return output, warpdamp("run", ROOT / "configs" / "beam.yaml", "-o", output, "--quick")


def test_the_papers_study_runs_shortened(quick):
    output, done = quick
    assert done.returncode == 0, done.stderr
    assert sorted(p.name for p in output.iterdir()) == ["beam-quick", "beam-quick.nc", "beam-quick.png"]
    with xr.open_dataset(output / "beam-quick.nc") as dataset:
        assert dict(dataset.sizes) == {"frequency": 3, "gamma": 5, "seed": 1, "mode": 3}
        assert dataset["natural_frequency"].values == pytest.approx([39.50, 280.1, 730.6], rel=1e-3)
        assert (dataset["ledger_residual"] < 5e-3).all()
        # the identity zeta = (2 / pi) eps m phi^2
        phi, mass = dataset["mode_amplitude"], 0.0239985
        eps = dataset["effectiveness"].mean("seed").rename(frequency="mode").assign_coords(mode=dataset["mode"])
        expected = 2 / 3.141592653589793 * eps * mass * phi**2
        xr.testing.assert_allclose(dataset["damping_ratio"], expected.transpose("mode", "gamma"), rtol=1e-5)
        assert dataset["preparation"].item() == "loose"
        assert "normalised_damping" in dataset
        assert (dataset["message"] == "").all()  # there in every file


def test_it_says_what_came_out(quick):
    _, done = quick
    for word in ("mode", "phi", "optima of the damping ratio", "39.50", "energy ledger: residual at most"):
        assert word in done.stdout
    assert "cases 100 %" in done.stderr
    assert "CUDA" not in done.stderr


def test_results_can_be_drawn_again(quick, tmp_path):
    output, _ = quick
    done = warpdamp("plot", output / "beam-quick.nc", "-o", tmp_path / "again.png")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "again.png").read_bytes()[:4] == b"\x89PNG"


def test_modes(config_path):
    done = warpdamp("modes", config_path)
    assert done.returncode == 0
    assert "39.50" in done.stdout
    assert "40.8" in done.stdout


def test_modes_can_be_drawn_and_written(tmp_path):
    config = ROOT / "configs" / "cantilever.yaml"
    for name, head in (("modes.png", b"\x89PNG"), ("modes.csv", b"mode,frequency_Hz"), ("new/modes.uff", b"    -1")):
        done = warpdamp("modes", config, "-o", tmp_path / name)
        assert done.returncode == 0, done.stderr
        assert "54.73" in done.stdout
        assert (tmp_path / name).read_bytes().startswith(head)
    done = warpdamp("modes", config, "-o", tmp_path / "modes.txt")
    assert done.returncode == 2
    assert "name a file that ends in .csv, .uff, .unv, .uf, .png, .pdf or .svg" in done.stderr


def test_known_modes_are_shown_as_the_particles_make_them():
    done = warpdamp("modes", ROOT / "configs" / "modes_given.yaml")
    assert done.stdout.count("of particles") == 1
    assert "39.40" in done.stdout


def test_explain_reads_the_design_too(tmp_path):
    """What is wrong with a design is said before anything is simulated."""
    done = warpdamp("explain", ROOT / "configs" / "design.yaml")
    assert "chooses damper.enclosure.height, damper.particles.count; the search ends after 120 cases" in done.stdout
    text = (ROOT / "configs" / "design.yaml").read_text()
    for wrong, message in (
        (text.replace("particles.count:", "particles.colour:"), "design.variables.particles.colour: is not a scalar"),
        (text.replace("{from: 24, to: 80}", "{from: 80, to: 24}"), "the range from 80 to 24 is empty"),
    ):
        (tmp_path / "wrong.yaml").write_text(wrong)
        done = warpdamp("explain", tmp_path / "wrong.yaml")
        assert done.returncode == 2
        assert message in done.stderr
        assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("arguments", [("explain",), ("modes",), ("--help",)])
def test_a_reader_that_leaves_early_is_no_error(config_path, arguments):
    """As behind `| head`: the pipe is closed before anything is written."""
    command = [sys.executable, "-m", "warpdamp", *arguments, *([config_path] if arguments[0][0] != "-" else [])]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        process.stdout.close()
        assert process.stderr.read() == ""


def test_schema():
    done = warpdamp("schema")
    assert json.loads(done.stdout)["title"] == "Config"


def test_bad_input_is_one_line_a_non_zero_exit_and_leaves_results_alone(tmp_path, config_path):
    path = tmp_path / "beam.yaml"
    path.write_text(config_path.read_text().replace("friction: 0.86", "frction: 0.86"))
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "beam.nc").write_text("precious")
    done = warpdamp("run", path, "-o", tmp_path / "out")
    assert done.returncode == 2
    assert done.stderr.strip().splitlines() == [f"{path}:41:3: contact.frction: unknown key; did you mean 'friction'?"]
    assert (tmp_path / "out" / "beam.nc").read_text() == "precious"


def test_an_output_that_cannot_be_written(tmp_path, config_path):
    (tmp_path / "file").write_text("")
    done = warpdamp("run", config_path, "-o", tmp_path / "file" / "out", "--quick")
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1
    assert "out" in done.stderr


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission(tmp_path, config_path):
    tmp_path.chmod(0o500)
    done = warpdamp("run", config_path, "-o", tmp_path, "--quick")
    assert done.returncode == 2
    assert "cannot be written" in done.stderr


def test_a_results_file_that_is_not_there(tmp_path):
    done = warpdamp("plot", tmp_path / "nothing.nc")
    assert done.returncode == 2
    assert "nothing.nc" in done.stderr
    assert "Traceback" not in done.stderr
