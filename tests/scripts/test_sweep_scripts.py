"""What is shipped for sweeps, shortened: configurations, scripts, and the commands."""

import re
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import warpdamp
from conftest import ROOT
from warpdamp.status import Status
from warpdamp.study.explain import explain

MAP = (ROOT / "configs" / "frequency_map.yaml").read_text()
THIN_MAP = (
    MAP.replace("diameter: 40 mm, height: 40 mm", "diameter: 24 mm, height: 20 mm")
    .replace("count: 120", "count: 8")
    .replace("youngs_modulus: 3.3 GPa", "youngs_modulus: 33 MPa")
    .replace("log: [30 Hz, 680 Hz], n: 27", "log: [30 Hz, 80 Hz], n: 6")
    .replace("from: 0.5, to: 12, n: 24", "from: 1, to: 10, n: 8")
    .replace("preparation: compacted", "preparation: loose")
    .replace("most_cycles: 400", "fewest_cycles: 12, most_cycles: 12")
)


def python(*arguments, cwd):
    done = subprocess.run(
        [sys.executable, *map(str, arguments)], capture_output=True, text=True, cwd=cwd, timeout=200, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_frequency_map_is_what_was_asked_for():
    config = warpdamp.load(ROOT / "configs" / "frequency_map.yaml")
    np.testing.assert_allclose(config.excitation.frequency, np.geomspace(30, 680, 27))
    assert len(config.excitation.gamma) == 24
    assert config.preparation == "compacted"


def test_the_frequency_map_of_a_small_damper(tmp_path):
    """Run in two parts, looked at in between, collected, fitted, drawn."""
    config = tmp_path / "map.yaml"
    config.write_text(THIN_MAP)
    python("-m", "warpdamp", "run", config, "-o", tmp_path, "--part", "1/2", "--workers", "1", cwd=tmp_path)
    told = python("-m", "warpdamp", "status", tmp_path / "map", cwd=tmp_path)
    assert "of 48 cases done" in told
    assert "no run in progress; the last run done; run again to continue" in told
    python("-m", "warpdamp", "collect", tmp_path, cwd=tmp_path)
    with xr.open_dataset(tmp_path / "map.nc") as part:
        assert 0 < int((part["status"] == Status.NOT_RUN).sum()) < 48
        assert "not_run" in part["status"].attrs["flag_meanings"].split()
    script = ROOT / "scripts" / "documents" / "frequency_map.py"
    said = python(
        script,
        "--config",
        config,
        "--store",
        tmp_path / "map",
        "--docs",
        tmp_path / "docs",
        "--workers",
        "2",
        cwd=tmp_path,
    )
    assert "Clearance measured (loose bed)" in said
    text = (tmp_path / "docs" / "frequency_map.md").read_text()
    assert "48 cases, 48 of them finished" in text
    assert "The paper's line: 3 - 0.0037 f" in text or "needs three points" in text
    for name in ("frequency_map", "frequency_map_regimes"):
        assert (tmp_path / "docs" / f"{name}.png").read_bytes()[:4] == b"\x89PNG"
    python("-m", "warpdamp", "plot", tmp_path / "docs" / "frequency_map.nc", "-o", tmp_path / "a.png", cwd=tmp_path)


def test_the_design_study_shortened(tmp_path):
    text = (ROOT / "configs" / "design_study.yaml").read_text()
    config = tmp_path / "design.yaml"
    config.write_text(
        text.replace("n: 16\n", "n: 3\n").replace("to: 8, n: 8", "to: 8, n: 3").replace("[1, 2]", "[1]")
        .replace("most_cycles: 120", "fewest_cycles: 12, most_cycles: 12")
    )  # fmt: skip
    dataset = warpdamp.run(config, executor="in-process")
    assert dict(dataset.sizes) == {"frequency": 2, "gamma": 3, "case": 3, "seed": 1}
    for name, units in (("friction", "1"), ("youngs_modulus", "Pa"), ("height", "m")):
        assert dataset[name].dims == ("case",)
        assert dataset[name].attrs["units"] == units
    left_out = dataset["status"] == Status.EXCLUDED
    assert left_out.sum() == 3  # 40 Hz, Gamma 8
    assert left_out.sel(frequency=40, gamma=8).all()
    assert (dataset["effectiveness"].notnull() == ~left_out).all()
    optima = dataset.damper.optimum()
    assert optima["gamma_collision"].dims == ("frequency", "case")
    said = explain(warpdamp.load(ROOT / "configs" / "design_study.yaml"), workers=2)
    assert "416 cases, Gamma 1 to 8; 32 loose beds" in said
    assert "2 frequency x 8 gamma x 16 case x 2 seed, without 96 excluded" in said


def test_everything_sampled_has_one_dimension(tmp_path):
    config = tmp_path / "sampled.yaml"
    config.write_text(
        THIN_MAP.replace("{log: [30 Hz, 80 Hz], n: 6}", "40 Hz").replace("{from: 1, to: 10, n: 8}", "3")
        + "sweep: {sample: {n: 4, over: {gamma: [2, 6], frequency: [40 Hz, 80 Hz], friction: [0.1, 0.9], seed: [1, 1000]}}}\n"
    )
    dataset = warpdamp.run(config, executor="in-process")
    assert dict(dataset.sizes) == {"case": 4}
    speed = dataset["gamma"] * 9.81 / (2 * np.pi * dataset["frequency"])
    np.testing.assert_allclose(
        dataset["effectiveness"], dataset["energy_dissipated"] / (4 * speed**2 * dataset["particle_mass"]), rtol=1e-12
    )
    assert len(set(dataset["seed"].values.tolist())) == 4


def test_modal_damping_of_swept_and_sampled_dampers(tmp_path, config_path):
    """The identity zeta = (2 / pi) eps m phi^2 with the modes of each structure and mass of particles."""
    text = config_path.read_text()
    for old, new in (
        ("diameter: 40 mm", "diameter: 24 mm"), ("height: 40 mm", "height: 20 mm"), ("count: 120", "count: 8"),
        ("3.3 GPa", "33 MPa"), ("compacted ", "loose "), ("[1, 3, 5]", "[1]"), ("seeds: [1, 2, 3]", "seeds: [1]"),
        ("fewest_cycles: 30", "fewest_cycles: 12"), ("most_cycles: 1000", "most_cycles: 12"),
    ):  # fmt: skip
        assert old in text
        text = text.replace(old, new)
    text = re.sub(r"gamma: \[.*\]", "gamma: 3", text)
    (tmp_path / "product.yaml").write_text(
        text + "\nsweep: {product: {structure.point_mass.mass: [0.2, 0.3], particles.count: [6, 8], gamma: [2, 3]}}\n"
    )
    swept = warpdamp.run(tmp_path / "product.yaml", executor="in-process")
    assert swept["damping_ratio"].dims == ("mode", "gamma", "mass", "count")
    assert (swept["natural_frequency"].sel(mass=0.3) < swept["natural_frequency"].sel(mass=0.2)).all()
    (tmp_path / "sampled.yaml").write_text(text + "\nsweep: {sample: {n: 2, over: {gamma: [2, 5], seed: [1, 50]}}}\n")
    sampled = warpdamp.run(tmp_path / "sampled.yaml", executor="in-process")
    assert sampled["damping_ratio"].dims == ("mode", "case")
    for dataset in (swept, sampled):
        eps = dataset["effectiveness"].rename(frequency="mode").drop_vars("mode", errors="ignore")
        eps = eps.mean("seed") if "seed" in eps.dims else eps
        expected = 2 / np.pi * eps * dataset["particle_mass"] * dataset["mode_amplitude"] ** 2
        # modes' frequencies are rounded to a microhertz for the drive
        expected = expected.transpose(*dataset["damping_ratio"].dims)
        np.testing.assert_allclose(dataset["damping_ratio"], expected, rtol=1e-6)


@pytest.mark.parametrize("text", ["0/3", "4/3", "3", "a/b"])
def test_parts_that_are_none(text, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "warpdamp", "run", ROOT / "configs" / "beam.yaml", "-o", tmp_path, "--part", text],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "is not a part" in done.stderr
