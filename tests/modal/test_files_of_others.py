"""Studies on other people's modes and meshes: the right value, or one line that names file, place and remedy."""

import re

import numpy as np
import pytest

import nastran_files as nastran
from universal_files import mode_55, mode_2414, nodes_15, units, write
from warpdamp import ConfigError, load
from warpdamp.modal.from_config import modes
from warpdamp.study.explain import explain

POINTS = [(0, 0, 0), (0.3, 0, 0)]
ALONG_Z = {1: (0, 0, 0), 2: (0, 0, 1)}
REST = """damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 16, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 3.3 GPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.86}
excitation: {gamma: [1, 2]}
seeds: [1]
"""


@pytest.fixture
def study(tmp_path):
    """Reads a study on a structure; ``sets`` become modes.uff."""

    def reader(structure, *sets):
        if sets:
            write(tmp_path / "modes.uff", units(), *sets)
        (tmp_path / "study.yaml").write_text(f"structure:\n{structure}{REST}")
        return load(tmp_path / "study.yaml")

    return reader


def on_file(more="node: 2", particles="true"):
    return f"  mode_file: {{file: modes.uff, {more}}}\n  particles_included: {particles}\n"


COMPLEX = mode_2414(1, {1: (0, 0, 0), 2: (0, 1, 0)}, storage=5)
RIGID = (mode_55(1, ALONG_Z, frequency=0.0), mode_55(2, ALONG_Z))


def test_a_real_shape_stored_as_complex_numbers(study):
    found = modes(study(on_file("node: 2, direction: y"), nodes_15(POINTS), COMPLEX), particles=0.0)
    np.testing.assert_allclose(found.modal_mass, [2.0])


@pytest.mark.parametrize("particles", ["true", "false"])
def test_rigid_bodies_are_left_out_and_said(study, particles):
    config = study(on_file(particles=particles), nodes_15(POINTS), *RIGID)
    found = modes(config, particles=0.0)
    assert list(found.number) == [2]
    np.testing.assert_allclose((found.frequency[0], found.inherent_damping[0]), (40.0, 0.001))
    assert "left out: rigid-body motions, modes 1 (up to 0 Hz, below 0.1 Hz)" in explain(config)


@pytest.mark.parametrize(
    ("structure", "sets", "message"),
    [
        (on_file(), (nodes_15(POINTS), COMPLEX), r"2:3: structure.mode_file: no mode moves the damper where it sits, along its direction; it moves across \(0, 0, 1\) there, most of all along y: choose another place or direction"),
        (on_file() + "  modes: [1]\n", (nodes_15(POINTS), COMPLEX), r"4:3: structure.modes: mode 1 has a node where the damper sits: .*most of all along y"),
        (on_file("node: 3"), (nodes_15([*POINTS, (0.6, 0, 0)]), mode_55(1, ALONG_Z)), r"2:3: structure.mode_file: node 3 has no data in some of the modes.*: choose from 1, 2"),
        (on_file("node: 1"), (nodes_15(POINTS), mode_55(1, ALONG_Z)), r"2:3: structure.mode_file: no mode moves the damper where it sits, along its direction: choose"),
        (on_file("position: [0, 2 m, 0]"), (nodes_15(POINTS), mode_55(1, ALONG_Z)), r"2:3: structure.mode_file: \(0 x 2000 x 0\) mm is far from every point"),
        (on_file("node: 2, direction: [0, 0, 0]"), (nodes_15(POINTS), mode_55(1, ALONG_Z)), r"2:3: structure.mode_file: the direction .* has no length"),
        (on_file() + "  modes: [1]\n", (nodes_15(POINTS), *RIGID), r"4:3: structure.modes: mode 1 is a rigid-body motion"),
        (on_file(), (nodes_15(POINTS), mode_55(1, ALONG_Z), mode_55(1, ALONG_Z)), r"structure.mode_file: .*modes.uff:\d+: mode 1 is there already"),
        ("  modes_given: [{frequency: 1e-4 Hz, modal_mass: 1 kg}]\n  particles_included: true\n", (), r"2:3: structure.modes_given: there are only rigid-body motions \(below 0.1 Hz\)"),
    ],
)  # fmt: skip
def test_a_damper_that_cannot_damp_is_told_so_in_one_line(study, structure, sets, message):
    config = study(structure, *sets)
    for attempt in (lambda: modes(config, particles=0.0), lambda: explain(config)):
        with pytest.raises(ConfigError) as caught:
            attempt()
        said = str(caught.value)
        assert "\n" not in said
        assert re.search(message, said), said


def test_dampings_that_are_none(study):
    with pytest.raises(ConfigError, match=r"study.yaml:2:\d+: structure.modes_given.0.damping: .*less than 1"):
        study("  modes_given: [{frequency: 40 Hz, modal_mass: 1 kg, damping: 120 %}]\n  particles_included: true\n")


@pytest.mark.parametrize("name", ["MODES.UFF", "modes.unv", "Modes.UF"])
def test_suffixes(study, tmp_path, name):
    write(tmp_path / name, units(), nodes_15(POINTS), mode_55(1, ALONG_Z))
    found = modes(study(on_file().replace("modes.uff", name)), particles=0.0)
    np.testing.assert_allclose(found.modal_mass, [2.0])


def test_modes_of_nastran(study, tmp_path):
    """Three masses on springs, in millimetres, newtons and tonnes; the second grid point is the damper's."""
    values, vectors = nastran.exact()
    shapes = np.zeros((3, 3, 6))
    shapes[:, :, 2] = vectors.T
    text = nastran.f06(shapes, values, [1.0] * 3, echo=[*nastran.grid(), *nastran.lumped()])
    (tmp_path / "RUN.F06").write_text(text)
    found = modes(study(on_file("node: 12, units: MM-N").replace("modes.uff", "RUN.F06")), particles=0.0)
    np.testing.assert_allclose(found.frequency, np.sqrt(values) / (2 * np.pi), rtol=5e-6)
    np.testing.assert_allclose(found.modal_mass, 1e3 / vectors[1] ** 2, rtol=1e-5)
    with pytest.raises(ConfigError, match=r"structure.mode_file: .*RUN.F06 does not say its units"):
        modes(study(on_file("node: 12").replace("modes.uff", "RUN.F06")), particles=0.0)
