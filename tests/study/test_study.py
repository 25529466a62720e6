"""From YAML to a Dataset: a small damper, run to the end."""

import math
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import warpdamp
from warpdamp import ConfigError, load, peaks
from warpdamp.analysis.results import write
from warpdamp.sweep.cases import Cases
from warpdamp.variables import VARIABLES

SMALL = """
title: small
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 16, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 330 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: [0.2, 0.86]}
excitation: {gamma: [0.5, 3, 6], frequency: [40 Hz, 80 Hz]}
preparation: loose
steady_state: {fewest_cycles: 12, most_cycles: 40, standard_error: 5 %}
seeds: [1, 2]
"""


@pytest.fixture(scope="module")
def small_config(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "small.yaml"
    path.write_text(SMALL)
    return path


@pytest.fixture(scope="module")
def small(small_config):
    stages = []
    dataset = warpdamp.run(small_config, workers=2, report=lambda stage, done: stages.append((stage, done)))
    assert {stage for stage, _ in stages} == {"modes", "kernels", "beds", "cases"}
    of_cases = [done for stage, done in stages if stage == "cases"]
    assert of_cases[0] == 0  # as the first are given to a worker: what a time left, or a benchmark, counts from
    assert stages[-1] == ("cases", pytest.approx(1.0))
    return dataset


def test_the_dataset_keeps_its_contract(small):
    assert dict(small.sizes) == {"frequency": 2, "gamma": 3, "friction": 2, "seed": 2}
    assert small["effectiveness"].dims == ("frequency", "gamma", "friction", "seed")
    assert small["preparation"].item() == "loose"
    for name in (
        "effectiveness", "energy_dissipated", "energy_dissipated_standard_error", "work_input", "ledger_residual",
        "apparent_mass", "clearance", "clearance_after", "packing_fraction", "packing_fraction_after",
        "compaction_settled", "cycles", "steps", "cpu_time", "status",
    ):  # fmt: skip
        assert name in small
    for name, variable in small.variables.items():
        assert variable.attrs["units"], name
        assert variable.attrs["long_name"], name
    assert set(small.data_vars) <= set(VARIABLES)
    assert "count: 16" in small.attrs["configuration"]
    assert "warp-lang" in small.attrs["source"]
    assert small.attrs["Conventions"].startswith("CF-")


def test_packing_fractions_follow_from_clearances(small):
    """v / (1 - h / L), eq. 2 of the paper; 16 spheres in 24 x 20 mm."""
    part = 16 * 4 / 3 * np.pi * 3.73e-3**3 / (np.pi * 0.012**2 * 0.02)
    for after in ("", "_after"):
        expected = part / (1 - small[f"clearance{after}"] / 0.02)
        np.testing.assert_allclose(small[f"packing_fraction{after}"], expected, rtol=1e-12)
    assert (small["compaction_settled"] == 1).all()


def test_its_energies_belong_together(small):
    channels = sum(small[name] for name in small.data_vars if name.endswith("_loss"))
    xr.testing.assert_allclose(channels, small["energy_dissipated"], rtol=1e-9)
    assert (small["ledger_residual"] < 5e-3).all()  # at 24 steps a contact, second order
    shaken = small.sel(gamma=[3, 6])
    assert (shaken["effectiveness"] > 0.05).all()
    # at friction 0.86 a bed below Gamma 1 hardly moves; at 0.2 these small loose beds still compact, and say so
    assert (small["effectiveness"].sel(gamma=0.5, friction=0.86) < 0.05).all()
    speed = small["gamma"] * 9.81 / (2 * math.pi * small["frequency"])
    mass = 16 * 920 * 4 / 3 * math.pi * 3.73e-3**3
    ideal = 4 * speed**2 * mass
    xr.testing.assert_allclose(small["energy_dissipated"] / ideal, small["effectiveness"])


def test_cases_do_not_depend_on_how_they_are_shared_out(small, small_config):
    alone = warpdamp.run(small_config, workers=1)
    for name in set(small.data_vars) - {"cpu_time"}:
        xr.testing.assert_identical(alone[name], small[name])


def test_a_script_without_a_guard_does_not_start_itself_again(small_config, tmp_path):
    script = tmp_path / "study.py"
    script.write_text(
        f"import warpdamp\nprint(warpdamp.run({str(small_config)!r}, quick=True, workers=2).sizes['gamma'])\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "3\n"


def test_it_survives_a_file(small, tmp_path):
    write(small, tmp_path / "small.nc")
    with xr.open_dataset(tmp_path / "small.nc") as back:
        xr.testing.assert_equal(back, small)
        assert back.attrs["configuration"] == small.attrs["configuration"]
    assert [p.name for p in tmp_path.iterdir()] == ["small.nc"]


def test_carried_beds_start_from_the_amplitude_before(small_config, tmp_path):
    text = small_config.read_text().replace("preparation: loose", "preparation: carried")
    path = tmp_path / "carried.yaml"
    path.write_text(text.replace("[0.2, 0.86]", "0.86").replace("[40 Hz, 80 Hz]", "40 Hz").replace("[1, 2]", "[1]"))
    carried = warpdamp.run(path, workers=1)
    path.write_text(path.read_text().replace("carried", "loose"))
    loose = warpdamp.run(path, workers=1)
    first, rest = {"gamma": 0.5}, {"gamma": [3, 6]}
    name = "energy_dissipated"
    xr.testing.assert_equal(
        carried[name].sel(first).drop_vars("preparation"), loose[name].sel(first).drop_vars("preparation")
    )
    assert (carried[name].sel(rest).values != loose[name].sel(rest).values).all()
    assert carried["preparation"].item() == "carried"
    before, after = carried["clearance"].sel(rest).values, carried["clearance_after"].sel(gamma=[0.5, 3]).values
    np.testing.assert_array_equal(before, after)


def test_the_papers_recipe_by_name(small_config, tmp_path):
    path = tmp_path / "paper.yaml"
    path.write_text(small_config.read_text().replace("steady_state: {", "steady_state: {recipe: paper, "))
    paper = warpdamp.run(path)
    assert (paper["cycles"].sel(frequency=40) == 12).all()  # whole cycles in 0.3 s
    assert (paper["cycles"].sel(frequency=80) == 24).all()
    assert (paper["cycles_discarded"].sel(frequency=80) == 8).all()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("count: 16", "count: 30", r"small.yaml:\d+:\d+: damper.particles.count: too many particles: .*reached 0\.\d+"),
        ("seeds: [1, 2]", "seeds: [1, 2]\nnumerics: {step: 1 ms}", r"numerics.step: 0.001 s is too large for the shortest"),
        ("frequency: [40 Hz, 80 Hz]", "frequency: modes", r"'modes' needs a structure"),
    ],
)  # fmt: skip
def test_what_only_shows_when_it_is_built_is_placed_too(small_config, tmp_path, old, new, message):
    path = tmp_path / "small.yaml"
    path.write_text(small_config.read_text().replace(old, new))
    with pytest.raises(ConfigError, match=message):
        warpdamp.run(path)


def test_a_mode_that_does_not_exist_is_refused(config_path, tmp_path):
    path = tmp_path / "beam.yaml"
    path.write_text(config_path.read_text().replace("[1, 3, 5]", "[2]"))
    with pytest.raises(ConfigError, match=r"beam.yaml:\d+:\d+: structure.modes: mode 2 has a node"):
        warpdamp.run(path)


def test_failed_cases_are_values(small_config, monkeypatch):
    """A case that blows up is NaN with a status; the others are as they were."""
    from warpdamp.damper import shake as shaking
    from warpdamp.status import Status

    class Sabotaged(shaking.Batch):
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            particles = self._particles.numpy().copy()
            particles["half_velocity"][-1] = np.nan
            self._particles.assign(particles)

    config = load(small_config)
    cases = Cases(config)
    specs = [cases.spec(cases.shape[2] * cases.shape[3] * 2 + k)[0] for k in range(2)]
    monkeypatch.setattr(shaking, "Batch", Sabotaged)
    (_, good), (_, bad) = shaking.shake([[specs[0]], [specs[1]]], shaking.Criteria(0.05, 12, 40))
    assert bad["status"] == Status.NOT_FINITE
    assert "energy_dissipated" not in bad
    assert good["energy_dissipated"] > 0


def test_a_study_of_which_nothing_is_left_is_an_error(small_config, monkeypatch):
    from warpdamp import SimulationError
    from warpdamp.damper import shake as shaking
    from warpdamp.status import Status

    def escaped(chains, criteria):
        return [(spec.index, {"status": int(Status.ESCAPED)}) for chain in chains for spec in chain]

    monkeypatch.setattr(shaking, "shake", escaped)
    with pytest.raises(SimulationError, match="all 24 cases failed: a particle left the cavity"):
        warpdamp.run(small_config, executor="in-process")


def test_peaks_stand_out_of_the_noise():
    gamma = np.array([1, 2, 3, 4, 5, 6, 7.0])
    two = peaks(gamma, [0, 0.5, 0.56, 0.5, 0.6, 0.67, 0.5], np.full(7, 0.01))
    assert [p.gamma for p in two] == [3, 6]
    shoulder = peaks(gamma, [0, 0.5, 0.56, 0.555, 0.6, 0.67, 0.5], np.full(7, 0.01))
    assert [p.gamma for p in shoulder] == [6]
    falling = peaks(gamma, [0.9, 0.5, 0.4, 0.3, 0.2, 0.1, np.nan], np.full(7, 0.01))
    assert [p.gamma for p in falling] == [1]
    assert peaks(gamma, np.full(7, np.nan), np.full(7, 0.1)) == []
