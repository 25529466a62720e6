"""Designs judged by draws of their effectiveness: ranges of Gamma and of force, against closed forms."""

import math

import numpy as np
import pytest

from design_studies import study
from warpdamp.design.assess import drawn, drives_of, judged
from warpdamp.design.problem import Problem
from warpdamp.scene.scene import STANDARD_GRAVITY

MASSES = (1e-3, 0.1)


def of_target(tmp_path, target, **changes):
    problem = Problem(study(tmp_path, target=target, **changes))
    design = problem.make([0.5, 0.5])
    return problem, design, drives_of(problem, design, MASSES)


def test_a_constant_effectiveness_has_the_damping_of_the_identity(tmp_path):
    """zeta = (2 / pi) eps m phi^2, here phi^2 = 1 / 0.4 kg."""
    problem, design, drives = of_target(tmp_path, "{damping: 1 %, modes: [1], gamma: [2, 6]}")
    assert drives.gamma[[0, -1]] == pytest.approx([2, 6])
    found = judged(problem, design, drives, np.full((10, len(drives.gamma)), 0.5))
    assert found.least == pytest.approx(2 / math.pi * 0.5 * design.mass / 0.4)
    assert found.probability == float(found.least >= 0.01)


def test_the_probability_is_that_of_the_least_of_the_range(tmp_path):
    problem, design, drives = of_target(tmp_path, "{damping: 1 %, modes: [1], gamma: [2, 6]}")
    needed = 0.01 * 0.4 * math.pi / 2 / design.mass
    draws = np.full((4, len(drives.gamma)), 1.1 * needed)
    draws[0, 3] = 0.9 * needed  # one draw of four dips below, at one Gamma
    found = judged(problem, design, drives, draws)
    assert found.probability == 0.75
    assert found.decisive[3] == 0.25


def test_only_gammas_that_the_forces_reach_count(tmp_path):
    """a = phi^2 F / (2 zeta): with twice the damping wanted, half of the Gammas above are not answered to."""
    problem, design, drives = of_target(tmp_path, "{damping: 1 %, modes: [1], force: [0.1 N, 0.2 N]}")
    effectiveness = 0.02 * 0.4 * math.pi / 2 / design.mass
    damping = drives.damping(np.full(len(drives.gamma), effectiveness), design.mass)
    assert damping == pytest.approx(0.02)
    answered = np.array([0.1, 0.2]) / 0.4 / (2 * 0.02) / STANDARD_GRAVITY
    expected = (drives.gamma >= answered[0] * (1 - 1e-9)) & (drives.gamma <= answered[1] * (1 + 1e-9))
    assert drives.counts(damping).tolist() == expected.tolist()
    weak = np.where(expected, 1.0, 0.1) * effectiveness  # weak only where no force of the range leads to
    weak[drives.gamma > answered[1]] = 2 * effectiveness
    assert judged(problem, design, drives, weak[None]).probability == 1.0


def test_draws_have_the_mean_and_covariance_asked_for():
    mean, covariance = np.log([[0.2, 0.4]]), np.array([[[0.04, 0.03], [0.03, 0.09]]])
    logs = np.log(drawn(mean, covariance, 20_000, 0))[0]
    np.testing.assert_allclose(logs.mean(axis=0), mean[0], atol=4 * 0.3 / math.sqrt(20_000))
    np.testing.assert_allclose(np.cov(logs.T), covariance[0], atol=4 * 0.09 * math.sqrt(2 / 20_000))


def test_the_least_response_weighs_modes_by_their_shapes(tmp_path):
    target = "{gamma: [2, 6]}"
    problem, design, drives = of_target(
        tmp_path,
        target,
        variables="{particles.count: {from: 20, to: 120}, particles.radius: [3 mm, 3.73 mm]}",
        limits="{mass: 40 g}\n  minimise: response",
    )
    found = judged(problem, design, drives, np.full((2, len(drives.gamma)), 0.5))
    assert problem.design.goal == "response"
    assert found.merit == pytest.approx(2 / math.pi * 0.5 * design.mass)  # zeta / phi^2, the same in both modes
    assert found.probability == 1.0
