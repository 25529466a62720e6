"""Films of several dampers: each its own case, in one moment of the drive."""

import numpy as np
import pytest

from two_dampers import GIVEN
from warpdamp import run
from warpdamp.analysis.results import write as write_results
from warpdamp.errors import UsageError
from warpdamp.study.again_beside import again_all
from warpdamp.sweep.choice import Choice

STUDY = GIVEN.replace("PHI", "-1.4142135623730951")


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Two equal dampers; the second moves against the first, and sits on the node of the second mode."""
    path = tmp_path_factory.mktemp("beside") / "two.yaml"
    path.write_text(STUDY)
    return path


def test_a_damper_that_moves_against_the_first_is_seen_to(study):
    """Equal but for the sign of the mode shape: the same case, half a cycle apart."""
    first, second = again_all(study, Choice(gamma=4, mode=1), frames=6, shown=1)
    assert second.label.startswith("damper 2: mode 1, 40 Hz, Γ 4")
    moved = first.trajectory.displacement
    assert np.abs(moved).max() > 0
    np.testing.assert_allclose(second.trajectory.displacement, -moved, atol=1e-9 * np.abs(moved).max())
    assert np.array_equal(first.trajectory.ledger.rows, second.trajectory.ledger.rows)
    assert [frame.cycle for frame in second.trajectory.frames] != [frame.cycle for frame in first.trajectory.frames]


def test_a_damper_on_a_node_is_left_out(study):
    (only,) = again_all(study, Choice(gamma=2, mode=2), frames=2, shown=1)
    assert only.label.startswith("damper 1: mode 2, 90 Hz, Γ 2")


def test_of_results_the_most_damping_is_filmed(study, tmp_path):
    dataset = run(study, executor="in-process")
    write_results(dataset, tmp_path / "two.nc")
    best = dataset["damping_ratio"].argmax(["mode", "gamma"])
    taken = again_all(tmp_path / "two.nc", Choice(), frames=2, shown=1)
    gamma = float(dataset["gamma"][int(best["gamma"])])
    assert f"mode {int(dataset['mode'][int(best['mode'])])}, " in taken[0].label
    assert taken[0].label.endswith(f"Γ {gamma:g}")
    assert "by itself" in taken[0].remark
    effectiveness = float(dataset["effectiveness"].sel(damper=1).isel(frequency=int(best["mode"])).sel(gamma=gamma))
    own = taken[0].trajectory.effectiveness[int(taken[0].values["cycles_discarded"]) :]
    assert np.mean(own) == pytest.approx(effectiveness, rel=1e-9)  # the mean over one packing


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        (Choice(mode=1), "2 such cases: choose by gamma as well"),
        (Choice(gamma=2), "2 such cases: choose by mode as well"),
        (Choice(gamma=3, mode=1), "no case with gamma 3: there is 2, 4"),
        (Choice(gamma=2, mode=1, at={"friction": "1"}), "no friction to choose by: the cases differ in mode, gamma"),
        (Choice(gamma=2, mode=1, seed=9), "no case with seed 9"),
    ],
)
def test_a_case_that_is_not_there(study, choice, words):
    with pytest.raises(UsageError, match=words):
        again_all(study, choice)


def test_a_case_that_takes_too_long(study):
    with pytest.raises(UsageError, match=r"particle-steps: warpdamp film .* films it"):
        again_all(study, Choice(gamma=2, mode=1), most=10)
