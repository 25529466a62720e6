"""Part of a study that is done, as learnt from the cases that have finished."""

from types import SimpleNamespace

import numpy as np
import pytest

from warpdamp.execution.batching import pilots
from warpdamp.execution.estimate import Estimate


@pytest.fixture
def plan():
    """Two frequencies, ten amplitudes of slowly rising cost, three packings."""
    frequency, cost, _ = np.meshgrid([40.0, 700.0], np.geomspace(1e5, 2e5, 10), range(3), indexing="ij")
    cost = np.where(frequency > 100, 0.1, 1.0) * cost
    return SimpleNamespace(
        keys=np.arange(60), frequency=frequency.ravel(), cost=cost.ravel(), cases=SimpleNamespace(shape=(2, 10, 3))
    )


def seconds(plan, numbers):
    """What cases take: at 700 Hz thirty times as much for their least cost."""
    return 1e-5 * plan.cost[numbers] * np.where(plan.frequency[numbers] > 100, 30.0, 1.0)


def test_one_packing_of_each_point_tells_what_the_others_take(plan):
    numbers = np.arange(60)
    first = pilots(plan, numbers)
    np.testing.assert_array_equal(first, numbers[::3])
    estimate = Estimate(plan, numbers)
    estimate.finished(first, seconds(plan, first))
    assert estimate.share == pytest.approx(1 / 3, rel=1e-6)  # all packings of a point take the same here


def test_cases_cost_what_those_like_them_took(plan):
    """At the least until some have finished; then thirty times as much at 700 Hz, where cases are cheapest at first."""
    numbers = np.arange(60)
    estimate = Estimate(plan, numbers)
    np.testing.assert_array_equal(estimate.costs, plan.cost)
    first = pilots(plan, numbers)
    estimate.finished(first, seconds(plan, first))
    np.testing.assert_allclose(estimate.costs, 1e5 * seconds(plan, numbers), rtol=1e-6)
    assert estimate.costs.argmax() >= 30 > plan.cost.argmax()


def test_cases_at_the_same_frequency_are_nearer_than_those_of_the_same_cost(plan):
    numbers = np.arange(60)
    estimate = Estimate(plan, numbers)
    known = np.array([0, 57])  # one of each frequency
    estimate.finished(known, seconds(plan, known))
    true = seconds(plan, known).sum() / seconds(plan, numbers).sum()
    assert estimate.share == pytest.approx(true, rel=0.2)


def test_cases_that_cost_nearly_the_same_at_the_least_are_told_apart(plan):
    """What cases take falls by half from one amplitude to the next, while their least cost rises by 4 %."""
    plan.cost = 1.04 ** np.round(np.log(plan.cost / plan.cost.min()) / np.log(2) * 9)
    numbers, first = np.arange(60), np.arange(0, 60, 3)
    takes = 2.0 ** -(numbers // 3 % 10)
    estimate = Estimate(plan, numbers)
    estimate.finished(first, takes[first])
    others = numbers[(numbers // 3 % 2 == 1) & (numbers % 3 > 0)]
    estimate.finished(others, takes[others])
    done = np.union1d(first, others)
    assert estimate.share == pytest.approx(
        takes[done].sum() / takes.sum(), rel=0.01
    )  # neighbours have a thousandth of the weight


def test_cases_that_could_not_be_run_say_nothing_of_the_others(plan):
    estimate = Estimate(plan, np.arange(60))
    assert estimate.share == 0
    estimate.finished(np.arange(30), np.zeros(30))
    assert estimate.share == 0
    estimate.finished(np.arange(30, 60), seconds(plan, np.arange(30, 60)))
    assert estimate.share == 1


def test_no_packing_runs_before_others_that_there_are_not(plan):
    assert len(pilots(plan, np.arange(0, 60, 3))) == 0
