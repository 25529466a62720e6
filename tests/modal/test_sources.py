"""From the configuration's structure to modes: every source, its errors, and the examples in configs/."""

import re

import numpy as np
import pytest
from ruamel.yaml import YAML

import warpdamp
from conftest import ROOT
from warpdamp import ConfigError, load
from warpdamp.formats.mode_csv import read_csv
from warpdamp.modal.from_config import modes

PARTICLES = 0.0239985
REST = """
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 16, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 330 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.86}
excitation: {gamma: [3]}
preparation: loose
"""
STEEL = "  steel: {density: 7800 kg/m^3, youngs_modulus: 210 GPa, poissons_ratio: 0.3}\n"


@pytest.fixture
def written(tmp_path):
    """Writes a study with the given structure, and reads it."""

    def write(structure):
        text = f"structure:\n{structure}{REST}"
        if "steel" in structure:
            text = text.replace("materials:\n", f"materials:\n{STEEL}")
        path = tmp_path / "study.yaml"
        path.write_text(text)
        return load(path)

    return write


BEAM = "  beam: {length: 580 mm, width: 20 mm, thickness: 4 mm, material: steel}\n"
MASS = "  point_mass: {mass: 200 g, position: 290 mm}\n"
PLATE = "  plate: {length: 400 mm, width: 300 mm, thickness: 3 mm, material: steel}\n"
GIVEN = "  modes_given:\n    - {frequency: 40.88 Hz, amplitude: 1.7207 kg^-0.5}\n"


def test_numbers_are_taken_as_they_are_when_they_include_the_particles(written):
    config = written(
        "  modes_given:\n"
        "    - {frequency: 39.4 Hz, modal_mass: 0.25 kg, damping: 0.1 %}\n"
        "    - {frequency: 279 Hz, amplitude: 0.769 kg^-0.5, number: 3}\n"
        "  particles_included: true\n"
    )
    found = modes(config, particles=PARTICLES)
    assert list(found.number) == [1, 3]
    np.testing.assert_allclose(found.frequency, [39.4, 279])
    np.testing.assert_allclose(found.amplitude, [2.0, 0.769])
    np.testing.assert_allclose(found.inherent_damping, [0.001, 0])


def test_particles_are_added_to_modes_with_the_empty_damper(written):
    """The first mode of the paper's beam alone: f / sqrt(1 + m phi^2), which the finite elements meet to 0.05 %."""
    found = modes(written(GIVEN + "  particles_included: false\n"), particles=PARTICLES)
    factor = np.sqrt(1 + PARTICLES * 1.7207**2)
    assert found.frequency[0] == pytest.approx(40.88 / factor, rel=1e-9)
    assert found.amplitude[0] == pytest.approx(1.7207 / factor, rel=1e-9)
    exact = modes(load(ROOT / "configs" / "beam.yaml"), particles=PARTICLES)
    assert found.frequency[0] == pytest.approx(exact.frequency[0], rel=5e-4)
    assert found.amplitude[0] == pytest.approx(exact.amplitude[0], rel=1e-3)


def test_a_table_of_eight_modes_carries_particles_like_the_beam_itself():
    """configs/mode_file.yaml holds the beam of configs/beam.yaml with the empty damper; 0.1 % for what modes 9 on add."""
    config = load(ROOT / "configs" / "mode_file.yaml")
    found = modes(config, particles=PARTICLES)
    exact = modes(load(ROOT / "configs" / "beam.yaml"), particles=PARTICLES).pick([1, 3])
    np.testing.assert_allclose(found.frequency, exact.frequency, rtol=1e-3)
    np.testing.assert_allclose(found.amplitude, exact.amplitude, rtol=1e-3)
    assert (read_csv(ROOT / "configs" / "beam_modes.csv").inherent_damping == 0.001).all()


def test_without_a_choice_every_mode_that_moves_the_damper_is_taken():
    config = load(ROOT / "configs" / "mode_file.yaml")
    structure = config.structure.model_copy(update={"modes": None, "inherent_damping": 0.02})
    found = modes(config.model_copy(update={"structure": structure}), particles=0.0)
    assert list(found.number) == [1, 3, 5, 7]
    assert (found.inherent_damping == 0.02).all()


def test_a_beam_of_any_kind(written):
    """Bending across the width is stiffer by its ratio to the thickness, 5; 3 % for shear."""
    across = BEAM.replace("material", "supports: [pinned, free], bends: width, material")
    along = BEAM.replace("material", "supports: [pinned, free], material")
    light = MASS.replace("200 g", "0 g") + "  modes: [1]\n"
    ratio = modes(written(across + light), particles=0).frequency / modes(written(along + light), particles=0).frequency
    assert ratio[0] == pytest.approx(5, rel=0.03)


@pytest.mark.parametrize(
    ("name", "number"), [("cantilever", 2), ("plate", 1), ("mesh", 1), ("mode_file", 3), ("modes_given", 3)]
)
def test_every_example_runs(name, number, tmp_path):
    """Shortened and softened; the chain's identity holds for its last mode: zeta = (2 / pi) eps m phi^2 + inherent."""
    path = ROOT / "configs" / f"{name}.yaml"
    study = YAML().load(path.read_text())
    study["materials"]["pmma"]["youngs_modulus"] = "33 MPa"
    for key in ("mesh", "mode_file"):
        if key in study["structure"]:
            study["structure"][key]["file"] = str(ROOT / "configs" / study["structure"][key]["file"])
    YAML().dump(study, tmp_path / path.name)
    dataset = warpdamp.run(tmp_path / path.name, quick=True, workers=2)

    mode = dataset.sel(mode=number)
    eps = dataset["effectiveness"].mean("seed").isel(frequency=list(dataset["mode"].values).index(number))
    mass = 16 * 920 * 4 / 3 * np.pi * 3.73e-3**3
    expected = 2 / np.pi * eps * mass * mode["mode_amplitude"] ** 2 + mode["inherent_damping"]
    np.testing.assert_allclose(mode["damping_ratio"], expected, rtol=1e-5)
    assert (mode["damping_ratio"] > 0).all()
    assert ("normalised_damping" in dataset) == (name in ("cantilever", "plate", "mesh"))


@pytest.mark.parametrize(
    ("structure", "message"),
    [
        (BEAM + PLATE + MASS, r"FILE:1:1: structure: give one of beam, plate, mesh, mode_file, modes_given; got beam and plate"),
        (MASS, r"FILE:1:1: structure: give one of .*; got none of them"),
        (BEAM + "  modes: [1]\n", r"structure: point_mass is missing: .* as \{mass: 200 g, position: 290 mm\}"),
        (BEAM + MASS, r"structure: modes is missing: .* as \[1, 3\]"),
        (BEAM.replace("thickness: 4 mm, ", "") + MASS, r"structure.beam: a section is width and thickness, or .*; got width"),
        (BEAM.replace("width: 20 mm", "diameter: 9 mm") + MASS, r"a section is .*; got diameter and thickness"),
        (BEAM.replace("width: 20 mm, thickness: 4", "diameter: 20 mm, wall: 10") + MASS, r"FILE:2:\d+: structure.beam.wall: leaves no hole"),
        (BEAM + MASS.replace("290 mm", "[290 mm, 1 mm]") + "  modes: [1]\n", r"point_mass.position: on a beam it is written as 290 mm"),
        (BEAM + MASS + "  other_masses:\n    - {mass: 1 g, position: 600 mm}\n  modes: [1]\n", r"FILE:5:19: structure.other_masses.0.position: lies beyond the end of the beam"),
        (BEAM + MASS.replace("}", ", footprint: 1 mm}") + "  modes: [1]\n", r"point_mass.footprint: a mass on a beam is fixed to the whole section"),
        (PLATE + "  point_mass: {mass: 1 g, position: [400 mm, 0.1]}\n  modes: [1]\n", r"structure.point_mass: footprint is missing: .*as 40 mm"),
        (PLATE + "  point_mass: {mass: 1 g, position: [400 mm, 0.1], footprint: 9 mm}\n  modes: [1]\n", r"point_mass.position: is at a clamped end"),
        (PLATE + "  point_mass: {mass: 1 g, position: 0.1, footprint: 9 mm}\n  modes: [1]\n", r"point_mass.position: on a plate it is written as \[100 mm, 50 mm\]"),
        (BEAM + MASS + "  modes: [1]\n  particles_included: true\n", r"structure.particles_included: is for known modes"),
        (GIVEN, r"structure: particles_included is missing: say true if"),
        (GIVEN + MASS + "  particles_included: true\n", r"structure.point_mass: is for computed modes"),
        (GIVEN.replace(", amplitude: 1.7207 kg^-0.5", "") + "  particles_included: true\n", r"FILE:3:7: structure.modes_given.0: no modal mass: .*give modal_mass .* or amplitude"),
        (GIVEN.replace("}", ", modal_mass: 1 kg}") + "  particles_included: true\n", r"FILE:3:29: structure.modes_given.0.amplitude: is 1 / sqrt\(modal_mass\): give one"),
        (GIVEN.replace("amplitude", "amplitud") + "  particles_included: true\n", r"modes_given.0.amplitud: unknown key; did you mean 'amplitude'\?"),
        (GIVEN.replace("kg^-0.5", "mm") + "  particles_included: true\n", r"'1.7207 mm' has the wrong unit: expected a quantity in kg\^-0.5"),
        (GIVEN.replace("}", ", damping: 1 %}") + "  particles_included: true\n  inherent_damping: 1 %\n", r"structure.inherent_damping: is given for each mode already"),
        (GIVEN.replace("}", ", number: 2}") + GIVEN.splitlines()[1].replace("}", ", number: 2}") + "\n  particles_included: true\n", r"structure.modes_given: each number once"),
        ("  mode_file: {file: modes.csv, direction: up, node: 1}\n  particles_included: true\n", r"mode_file.direction: 'up' is not one of 'x', 'y' or 'z'"),
        ("  mode_file: {file: modes.csv}\n  particles_included: true\n", r"structure.mode_file: give the damper's node, or its position"),
    ],
)  # fmt: skip
def test_structures_that_contradict_themselves(written, tmp_path, structure, message):
    with pytest.raises(ConfigError) as caught:
        written(structure)
    said = str(caught.value).replace(str(tmp_path / "study.yaml"), "FILE")
    assert re.search(message, said), said
    assert "\n" not in said
    assert re.match(r"FILE:\d+:\d+: ", said)


@pytest.mark.parametrize(
    ("structure", "message"),
    [
        ("  mode_file: {file: modes.csv, node: 7}\n  particles_included: true\n", r"FILE:2:3: structure.mode_file: there is no node 7"),
        ("  mode_file: {file: other.csv, node: 7}\n  particles_included: true\n", r"structure.mode_file: there is no file .*other.csv"),
        ("  mode_file: {file: modes.txt, node: 7}\n  particles_included: true\n", r"modes.txt: modes are read from .csv, .uff, .unv, .uf, .f06, .pch or .rst"),
        ("  mode_file: {file: bare.csv, node: 1}\n  particles_included: true\n", r"structure.mode_file: .*bare.csv has no modal mass: add a column"),
        ("  mode_file: {file: modes.csv, node: 1}\n  particles_included: true\n  modes: [4]\n", r"FILE:4:3: structure.modes: there is no mode 4: choose from 1"),
        ("  mode_file: {file: modes.csv, node: 1}\n  particles_included: true\n  inherent_damping: [1 %, 2 %]\n", r"structure.inherent_damping: 2 values for 1 modes"),
        ("  mesh: {file: no.msh, material: steel}\n  point_mass: {mass: 0, position: [0, 0, 0], footprint: 1}\n  modes: [1]\n", r"structure.mesh: there is no file .*no.msh"),
        (BEAM.replace("width: 20 mm, thickness: 4 mm", "section: {file: no.msh}") + MASS + "  modes: [1]\n", r"structure.beam: there is no file"),
    ],
)  # fmt: skip
def test_what_only_shows_when_it_is_read_is_placed_too(written, tmp_path, structure, message):
    head = "mode,frequency_Hz,modal_mass_kg,x_m,y_m,z_m,u_z\n"
    (tmp_path / "modes.csv").write_text(f"{head}1,40,0.3,0,0,0,1\n")
    (tmp_path / "bare.csv").write_text("mode,frequency_Hz,x_m,y_m,z_m,u_z\n1,40,0,0,0,1\n")
    config = written(structure)
    with pytest.raises(ConfigError) as caught:
        modes(config, particles=0.001)
    said = str(caught.value).replace(str(tmp_path / "study.yaml"), "FILE")
    assert re.search(message, said), said
    assert re.match(r"FILE:\d+:\d+: ", said)


def test_a_missing_library_is_named_with_its_remedy(written, monkeypatch):
    import importlib.util

    mass = "  point_mass: {mass: 0, position: [0, 0, 0], footprint: 1}\n  modes: [1]\n"
    config = written("  mesh: {file: bracket.msh, material: steel}\n" + mass)
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "meshio" else found(name))
    with pytest.raises(ConfigError, match=r"mesh files need meshio: pip install 'warpdamp\[modes\]'"):
        modes(config, particles=0.0)
