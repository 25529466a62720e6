"""The search, where the answer is known: effectiveness by a formula instead of a simulation."""

import itertools
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from design_formula import STUDY, by_formula, effectiveness, simulated
from warpdamp import load
from warpdamp.config.reading import resolved_yaml
from warpdamp.design import search as searching
from warpdamp.design.cases import Order, Row
from warpdamp.design.emulation import emulate
from warpdamp.design.problem import Problem
from warpdamp.design.run import design, front
from warpdamp.design.search import Search
from warpdamp.modal.damping import damping_of_effectiveness
from warpdamp.report.design import lines, picture


@pytest.fixture
def problem(tmp_path):
    path = tmp_path / "study.yaml"
    path.write_text(STUDY)
    with by_formula():
        yield Problem(load(path))


def least_damping(config, mass):
    gammas = np.geomspace(2, 8, 60)
    return float(np.min(damping_of_effectiveness(effectiveness(config, 40.0, gammas), mass, 0.4**-0.5)))


def brute_force(problem):
    """The least mass of all designs on a fine grid that meets the target."""
    best = math.inf
    for count in range(80, 130):
        for height in np.linspace(0.025, 0.045, 40):
            made = problem.of(dict(zip([v.path for v in problem.variables], (height, count), strict=True)))
            if made and made.mass < best and least_damping(made.config, made.mass) >= 0.02:
                best = made.mass
    return best


def test_the_claim_holds_and_is_within_a_tenth_of_the_least_mass(problem, tmp_path):
    answer = design(problem.config, tmp_path / "store")
    assert answer.claimed
    assert answer.verified.probability >= 0.95
    assert least_damping(answer.design.config, answer.design.mass) >= 0.02
    best = brute_force(problem)
    assert best <= answer.design.mass * 1.001
    assert answer.design.mass <= 1.1 * best
    assert answer.bounds.least_mass < best
    said = "\n".join(lines(answer))
    assert "is met with P = " in said
    assert said.count("runner-up") == 3
    assert {tolerance.name for tolerance in answer.sensitivity.tolerances} >= {
        "contact.friction",
        "contact.restitution",
    }
    picture(answer)
    path = tmp_path / "chosen.yaml"
    path.write_text(resolved_yaml(answer.configuration()))
    again = load(path)
    assert again.damper == answer.design.config.damper
    assert again.design is None


def test_where_no_design_is_probable_the_search_goes_to_more_damping(problem, tmp_path, monkeypatch):
    """Not to the lightest: every cheap first guess may be far from the target."""
    hopeless = problem.config.design.target.model_copy(update={"damping": 0.2})
    monkeypatch.setattr(Problem, "target", property(lambda _: hopeless))
    monkeypatch.setattr(searching, "find_bounds", lambda *_: SimpleNamespace(least_mass=0.0))
    search = Search(problem, tmp_path, 1, lambda *_: None, lambda _: None)
    search.start()
    search.assess_all()
    assert all(one.probability == 0 for one in search.assessed)
    assert search.assessed[0].least == max(one.least for one in search.assessed)
    asked = []
    monkeypatch.setattr(search, "run", lambda orders: asked.extend(orders))
    search.step()
    assert min(order.design.mass for order in asked) > np.median([design.mass for design in search.sample])


def test_the_same_search_twice_runs_the_same_cases(problem, monkeypatch, tmp_path):
    asked = []

    def noted(problem, orders, *rest, **options):
        asked[-1] += [(order.design.key, order.mode, order.gamma, order.seed) for order in orders]
        return simulated(problem, orders, *rest, **options)

    monkeypatch.setattr(searching, "run_orders", noted)
    for _ in range(2):
        asked.append([])
        search = Search(problem, tmp_path, None, lambda *_: None, lambda _: None)
        search.start()
        search.step()
    assert asked[0] == asked[1]


def test_the_front_rises_with_the_mass(problem, tmp_path):
    search = Search(problem, tmp_path, None, lambda *_: None, lambda _: None)
    search.start()
    search.assess_all()
    found = front(search.assessed)
    assert len(found) >= 3
    assert all(a.design.mass < b.design.mass and a.least < b.least for a, b in itertools.pairwise(found))


def test_a_case_that_failed_is_no_data(problem):
    made = [problem.make(part) for part in np.random.default_rng(2).random((8, 2))]
    orders = [Order(one, 0, gamma, 1) for one in made if one for gamma in (2.0, 5.0)]
    rows = simulated(problem, orders, None, workers=1, report=None)
    broken = [Row(orders[0], 40.0, math.nan, math.nan, math.nan, math.nan), *rows]
    assert len(emulate(problem, broken).process.y) == len(rows)


def test_the_most_damping_is_found_within_a_limit_of_mass(tmp_path):
    path = Path(tmp_path) / "study.yaml"
    goal = "  limits: {mass: 24 g}\n  maximise: damping\n  budget: {cases: 100}"
    path.write_text(STUDY.replace("  budget: {cases: 260}", goal).replace("damping: 2 %, ", ""))
    with by_formula():
        found = design(load(path), tmp_path / "store")
    assert found.design.mass <= 0.024
    best = 0.0
    problem = Problem(load(path))
    for count in range(110, 121):
        for height in np.linspace(0.03, 0.05, 30):
            made = problem.of(dict(zip([v.path for v in problem.variables], (height, count), strict=True)))
            if made and made.mass <= 0.024:
                best = max(best, least_damping(made.config, made.mass))
    assert least_damping(found.design.config, found.design.mass) >= 0.93 * best
