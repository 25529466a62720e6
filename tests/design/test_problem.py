"""Design problems: what is read, what is impossible, and the bounds that say so."""

import math
from pathlib import Path

import numpy as np
import pytest

from design_studies import study
from warpdamp import ConfigError, load
from warpdamp.design.bounds import collision_clearance, find_bounds, largest_damping, least_mass
from warpdamp.design.problem import Problem
from warpdamp.scene.scene import STANDARD_GRAVITY

CONFIGS = Path(__file__).parents[2] / "configs"


def sampled(problem, n=64):
    rng = np.random.default_rng(1)
    found = (problem.make(rng.random(len(problem.variables))) for _ in range(n))
    return [design for design in found if design is not None]


def bounds_of(tmp_path, **changes):
    problem = Problem(study(tmp_path, **changes))
    return find_bounds(problem, sampled(problem))


def refusal(tmp_path, **changes):
    with pytest.raises(ConfigError) as error:
        bounds_of(tmp_path, **changes)
    (line,) = str(error.value).splitlines()
    return line


def test_values_become_designs(tmp_path):
    problem = Problem(study(tmp_path))
    height, count = problem.variables
    assert isinstance(count.at(0.999), int)
    assert (count.at(0.0), count.at(0.9999)) == (20, 120)
    design = problem.make([0.5, 0.5])
    assert design.config.damper.enclosure.height == height.at(0.5) == pytest.approx(math.sqrt(0.03 * 0.05))
    assert design.config.damper.particles.count == count.at(0.5)
    assert design.config.design is None
    one = 4 / 3 * math.pi * 3.73e-3**3 * 920
    assert design.mass == pytest.approx(count.at(0.5) * one)


@pytest.mark.parametrize("part", [0.0, 0.13, 0.5, 0.77])
def test_the_part_of_a_value_leads_back_to_it(tmp_path, part):
    for variable in Problem(study(tmp_path)).variables:
        value = variable.at(part)
        assert variable.at(variable.part(value)) == pytest.approx(value)


def test_a_choice_of_material_changes_the_contact_with_it(tmp_path):
    choices = "{particles.material: [pmma_terzioglu, soda_lime_glass]}"
    problem = Problem(study(tmp_path, variables=choices))
    contacts = [problem.make([part]).config.contact for part in (0.1, 0.9)]
    assert [contact.restitution for contact in contacts] == [0.52, 0.97]
    assert set(problem.make([0.9]).config.materials) == {"pmma_terzioglu", "soda_lime_glass"}


def test_least_mass_where_the_particles_are_part_of_the_modes(tmp_path):
    """zeta = (2 / pi) m / M with M fixed."""
    problem = Problem(study(tmp_path))
    assert least_mass(problem, problem.make([0.5, 0.5])) == pytest.approx(math.pi / 2 * 0.01 * 0.4, rel=1e-5)


def test_least_mass_where_they_are_added(tmp_path):
    """One mode: M = 0.4 kg + m, so that m = (pi / 2) zeta M0 / (1 - (pi / 2) zeta); two modes: checked by what it gives."""
    problem = Problem(study(tmp_path, included="false"))
    design = problem.make([0.5, 0.5])
    mass = least_mass(problem, design)
    from dataclasses import replace

    modes = problem.modes(replace(design, mass=mass))
    assert float(np.min(largest_damping(mass, modes.amplitude, 0.0))) == pytest.approx(0.01, rel=1e-4)
    assert mass == pytest.approx(math.pi / 2 * 0.01 * 0.4 / (1 - math.pi / 2 * 0.01), rel=0.03)


def test_clearance_of_the_collision_optimum_is_that_of_equation_1():
    """u_c = w^2 h / pi."""
    h = collision_clearance(6.0, 46.0)
    assert (2 * math.pi * 46.0) ** 2 * h / math.pi == pytest.approx(6.0 * STANDARD_GRAVITY)


def test_motion_follows_from_the_clearance(tmp_path):
    low = Problem(study(tmp_path))
    assert find_bounds(low, sampled(low)).motion == "collision"
    high = Problem(study(tmp_path, target="{damping: 1 %, modes: [3], gamma: [2, 6]}"))
    bounds = find_bounds(high, sampled(high))
    assert bounds.motion == "fluidisation"
    assert "less than there is" in bounds.why


def test_force_and_base_become_gamma(tmp_path):
    """At resonance a = phi^2 F / (2 zeta): the upper end is that of the damping wanted."""
    problem = Problem(study(tmp_path, target="{damping: 1 %, modes: [1], force: [0.1 N, 0.2 N]}"))
    bounds = find_bounds(problem, sampled(problem))
    assert bounds.gamma[0, 1] == pytest.approx(0.2 / 0.4 / (2 * 0.01) / STANDARD_GRAVITY)
    assert bounds.gamma[0, 0] <= 0.1 / 0.4 / (2 * 0.01) / STANDARD_GRAVITY


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"limits": "{mass: 2 g}"}, "study.yaml:12:12: design.limits.mass: the target is impossible: 1 % takes at least 6.283 g of particles, whatever the damper (eqs 5-11), and 2 g are allowed"),
        ({"target": "{damping: 40 %, modes: [1], gamma: [2, 6]}"}, "study.yaml:11:3: design.variables: the target is impossible: 40 % takes at least 251.3 g"),
        ({"target": "{damping: 70 %, modes: [1], gamma: [2, 6]}", "included": "false"}, "study.yaml:10:12: design.target.damping: no mass of particles gives 70 % here"),
        ({"limits": "{force: 0.1 N}"}, "study.yaml:12:12: design.limits.force: the target is impossible: 1 % at Γ 6 takes a force of 0.471 N"),
        ({"limits": "{height: 20 mm}"}, "study.yaml:12:12: design.limits.height: 0.02 m, and the cavity is never less than 0.03 m"),
        ({"target": "{damping: 1 %, gamma: [6, 2]}"}, "study.yaml:10:26: design.target.gamma: the range from 6 to 2 is empty"),
        ({"target": "{damping: 1 %, gamma: [2, 6], force: [1 N, 2 N]}"}, "study.yaml:10:3: design.target: give one of gamma, force, base, as gamma: [2, 8]; got gamma and force"),
        ({"target": "{gamma: [2, 6]}"}, "design: target.damping is missing: the least mass is sought for a damping ratio"),
        ({"target": "{damping: 1 %, modes: [2], gamma: [2, 6]}"}, "there is no mode 2"),
        ({"target": "{damping: 1 %, modes: [1], base: [1 m/s^2, 2 m/s^2]}"}, "study.yaml:10:38: design.target.base: the modes say nothing of their participation"),
        ({"variables": "{enclosure.height: {from: 50 mm, to: 30 mm}}"}, "study.yaml:11:15: design.variables.enclosure.height: the range from 0.05 to 0.03 is empty"),
        ({"variables": "{enclosure.hight: {from: 30 mm, to: 50 mm}}"}, "study.yaml:11:15: design.variables.enclosure.hight: is not a scalar of this configuration; did you mean 'damper.enclosure.height'?"),
        ({"variables": "{excitation.gravity: {from: 9, to: 10}}"}, "study.yaml:11:15: design.variables.excitation.gravity: excitation.gravity is no part of a damper"),
        ({"variables": "{particles.material: [pmma_terzioglu, unobtainium]}"}, "study.yaml:11:15: design.variables.particles.material: there is no material 'unobtainium'"),
        ({"variables": "{particles.material: [pmma_terzioglu, lead]}"}, "study.yaml:11:15: design.variables.particles.material: with lead: contact: the library has no restitution"),
        ({"variables": "{particles.count: {from: 600, to: 900}}"}, "study.yaml:11:3: design.variables: no combination of them can be"),
        ({"variables": "{particles.count: {from: 20, to: 30, step: 50}}"}, "design.variables.particles.count: a step of 50 is not positive, or longer than the range"),
        ({"contact": "{restitution: [0.5, 0.6], friction: 0.5}"}, "contact.restitution: takes one value in a design: make it one of design.variables"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_in_one_line_with_its_place(tmp_path, changes, expected):
    assert expected in refusal(tmp_path, **changes)


def test_a_target_on_a_node_is_refused(tmp_path):
    text = (CONFIGS / "design.yaml").read_text()
    path = tmp_path / "node.yaml"
    path.write_text(text.replace("modes: [1]\n", "modes: [1, 2]\n").replace("modes: [1],", "modes: [2],"))
    problem = Problem(load(path))
    with pytest.raises(ConfigError, match=r"node\.yaml:\d+:\d+: design\.target\.modes: mode 2 has a node where the"):
        find_bounds(problem, sampled(problem, 8))
