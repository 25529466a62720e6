"""Packings called for by a tolerance: the rule, and that it does not matter when and where the cases ran."""

import numpy as np
import pytest
import xarray as xr

import warpdamp
from warpdamp import ConfigError, carry_out, collect, load
from warpdamp.numerics.tolerance import packings_needed
from warpdamp.variables import NOT_RUN

STUDY = """
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 8, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: [2, 3, 4, 5, 6, 7], frequency: 60 Hz}
preparation: loose
steady_state: {most_cycles: 30}
accuracy: {tolerance: 5 %, most_packings: 6}
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("rounds") / "study.yaml"
    path.write_text(STUDY)
    return path


@pytest.fixture(scope="module")
def undisturbed(study):
    return warpdamp.run(study, executor="in-process")


@pytest.mark.parametrize(
    ("energies", "step", "packings"),
    [
        ([1.0, 1.0, 1.0, 9.0, 9.0, 9.0], 0.0, 3),  # three agree: what comes after is not looked at
        ([1.0, 1.5, 0.5, np.nan, np.nan, np.nan], 0.0, 4),  # they do not: one more, and then it is seen
        ([1.0, 1.5, 0.5, 1.5, 0.5, 1.5], 0.0, 6),  # all there are
        ([1.0, np.nan, 0.5, 1.5, 0.5, 1.5], 0.0, 3),  # more of what failed does not help
        ([1.07, 0.93, 1.0, 1.0, 1.0, 1.0], 0.0, 3),
        ([1.07, 0.93, 1.0, 1.0, 1.0, 1.0], 0.04, 4),  # the step has taken its part of the tolerance
        ([1.07, 0.93, 1.0, 1.0, 1.0, 1.0], 0.06, 3),  # more packings do not mend a step
        ([1.0, 2.0], 0.0, 2),
    ],
)
def test_the_rule(energies, step, packings):
    def every(value):
        return np.full(len(energies), value)

    found = packings_needed(np.array(energies), every(0.01), every(20.0), every(0.0), every(step), every(4.0), 0.05)
    assert found == packings


def test_what_their_own_errors_take_is_called_for_at_once():
    """Errors of 8 % and 6 % each and a step's 3 %: (64 + 36) / (25 - 9) = 6.25 packings, if they all agree."""
    energies = np.array([1.0, 1.0, 1.0, *[np.nan] * 7])

    def every(value):
        return np.full(10, value)

    given = every(0.06), every(20.0), every(0.08), every(0.03), every(4.0), 0.05
    assert packings_needed(energies, *given) == 7
    energies[:7] = 1.0
    assert packings_needed(energies, *given) == 7  # and it is enough
    energies[5:7] = 1.4, 0.6
    assert packings_needed(energies, *given) == 8


def test_points_get_what_they_need(undisturbed):
    packings = undisturbed["packings"].values.ravel()
    assert packings.min() == 3
    assert packings.max() > 3
    assert undisturbed.sizes["seed"] == packings.max()  # seeds that nobody ran are not there
    assert ((undisturbed["status"] != NOT_RUN).sum("seed") == undisturbed["packings"]).all()
    ran = undisturbed["energy_dissipated"]
    xr.testing.assert_allclose(undisturbed["energy_mean"], ran.mean("seed").rename("energy_mean"))


def test_an_interrupted_study_ends_with_the_same_packings(study, undisturbed, tmp_path, monkeypatch, same):
    monkeypatch.setattr(warpdamp.execution.batching, "BATCH_COST", 1.0)
    warpdamp.run(study, store=tmp_path, executor="in-process")
    kept = sorted((tmp_path / "shards").glob("*.nc"))
    for shard in kept[::2]:
        shard.unlink()
    assert (collect(tmp_path)["packings"] < undisturbed["packings"]).any()
    same(warpdamp.run(study, store=tmp_path, executor="in-process"), undisturbed)
    same(collect(tmp_path), undisturbed)


def test_parts_end_with_the_same_packings(study, undisturbed, tmp_path, same):
    for k in (1, 2, 3):
        carry_out(study, tmp_path, part=(k, 3), executor="in-process")
    same(collect(tmp_path), undisturbed)


def test_what_the_tolerance_chooses_is_not_swept(tmp_path):
    path = tmp_path / "study.yaml"
    for key in ("numerics.steps_per_contact: [20, 30]", "accuracy.tolerance: [0.05, 0.1]"):
        path.write_text(STUDY + f"sweep:\n  product:\n    {key}\n")
        with pytest.raises(ConfigError, match="is chosen by accuracy"):
            load(path)


def test_seeds_of_a_sweep_are_the_packings(tmp_path):
    path = tmp_path / "study.yaml"
    path.write_text(STUDY.replace("[2, 3, 4, 5, 6, 7]", "4") + "sweep:\n  product:\n    seed: [11, 12, 13]\n")
    assert list(warpdamp.run(path, executor="in-process")["seed"]) == [11, 12, 13]
