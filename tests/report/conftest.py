"""A small study with its results, and a film of one of its cases."""

from dataclasses import replace

import numpy as np
import pytest

from design_formula import STUDY as DESIGN
from design_formula import by_formula
from warpdamp import load, run
from warpdamp.analysis.results import write
from warpdamp.design.dataset import to_dataset
from warpdamp.design.run import design
from warpdamp.report.film import Film
from warpdamp.study.again import again
from warpdamp.sweep.choice import Choice

STUDY = """
title: Twelve balls <b>& a beam</b>
structure:
  beam: {length: 580 mm, width: 20 mm, thickness: 4 mm, material: steel, supports: [clamped, clamped]}
  point_mass: {mass: 200 g, position: 290 mm}
  modes: [1, 3]
damper:
  enclosure: {diameter: 20 mm, height: 20 mm, material: pmma}
  particles: {count: 12, radius: 3 mm, material: pmma}
materials:
  steel: {density: 7800 kg/m^3, youngs_modulus: 210 GPa, poissons_ratio: 0.3}
  pmma: {density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: [2, 4, 6, 8]}
preparation: loose
steady_state: {fewest_cycles: 8, most_cycles: 8}
seeds: [1, 2]
"""


@pytest.fixture(scope="session")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "small.yaml"
    path.write_text(STUDY)
    return path


@pytest.fixture(scope="session")
def results(study):
    """Results of the small study, in a file."""
    path = study.with_suffix(".nc")
    write(run(study, executor="in-process"), path)
    return path


@pytest.fixture(scope="session")
def answer(tmp_path_factory):
    """Answer to a design problem, as a Dataset."""
    path = tmp_path_factory.mktemp("design") / "problem.yaml"
    path.write_text(DESIGN)
    with by_formula():
        return to_dataset(design(load(path), path.with_suffix("")))


@pytest.fixture(scope="session")
def taken(results):
    """A case of it, run again."""
    return again(results, Choice(gamma=6, mode=1), frames=10, shown=2)


@pytest.fixture(scope="session")
def film(taken):
    return Film(
        taken.trajectory, taken.title, taken.label, taken.remark, taken.source, int(taken.values["cycles_discarded"])
    )


@pytest.fixture(scope="session")
def beside(film, results):
    """The film with that of a second damper beside it: the same case by another packing, a quarter of a cycle apart."""
    other = again(results, Choice(gamma=6, mode=1, seed=2), frames=10, shown=2).trajectory
    frames = [replace(frame, cycle=frame.cycle - 0.25) for frame in other.frames]
    second = replace(film, trajectory=replace(other, frames=frames), label="damper 2: mode 1")
    return replace(film, beside=(second,))


@pytest.fixture(scope="session")
def spheroids(film):
    """The same film with particles that are twice as long as wide, their axes turning from z to x."""
    frames = []
    for k, frame in enumerate(film.frames):
        angle = 0.5 * np.pi * k / (len(film.frames) - 1)
        axis = np.tile([np.sin(angle), 0, np.cos(angle)], (film.particles, 1))
        state = replace(frame.state, axis=axis, aspect=np.full(film.particles, 2.0))
        frames.append(replace(frame, state=state))
    return replace(film, trajectory=replace(film.trajectory, frames=frames))
