"""Several dampers on one structure: places, masses, and energies that add up."""

import numpy as np
import pytest
import xarray as xr
from ruamel.yaml import YAML

from conftest import ROOT
from two_dampers import GIVEN
from warpdamp import Config, ConfigError, accelerance, carry_out, load, run
from warpdamp.accessor import Damper
from warpdamp.analysis.optimum import optimum
from warpdamp.errors import ModalError
from warpdamp.formats.mode_csv import read_csv
from warpdamp.modal.from_config import modes, seen_by_all
from warpdamp.report.tables import summary
from warpdamp.study.explain import explain
from warpdamp.study.several import modes_of_all, studies
from warpdamp.sweep.dampers import every_damper

PHI = 0.5**-0.5
BEAM = """
structure:
  beam: {length: 580 mm, width: 20 mm, thickness: 4 mm, material: steel}
  point_mass: {mass: 200 g, position: 290 mm}
  modes: [1, 3]
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 8, radius: 3.73 mm, material: pmma}
dampers:
  - enclosure: {diameter: 24 mm, height: 20 mm, material: steel}
    particles: {count: 4, radius: 2 mm, material: steel}
    point_mass: {mass: 50 g, position: 145 mm}
materials:
  steel: {density: 7800 kg/m^3, youngs_modulus: 210 GPa, poissons_ratio: 0.3}
  pmma: {density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: 2}
preparation: loose
"""


def test_two_equal_dampers_at_one_place_are_twice_one(write):
    """To rounding: the same beds at the same Gamma.  On the node of mode 2 the second adds nothing."""
    two = run(load(write(GIVEN.replace("PHI", repr(PHI)))), executor="in-process")
    single = GIVEN[: GIVEN.index("dampers:")] + GIVEN[GIVEN.index("materials:") :]
    one = run(load(write(single)), executor="in-process")
    added = (two["damping_ratio"] - two["inherent_damping"]).transpose("mode", "gamma").values
    by_one = (one["damping_ratio"] - one["inherent_damping"]).transpose("mode", "gamma").values
    np.testing.assert_allclose(added, by_one * [[2], [1]], rtol=1e-12)
    assert (two["damper_share"].sel(damper=2, mode=2) == 0).all()
    assert (two["energy_mean"].sel(damper=2).isel(frequency=1) == 0).all()
    columns = {column.header: list(column.cells) for column in summary(two).columns}
    assert columns["two-sided collision"] == ["none: several dampers, each with its own"] * 2
    assert all(text.startswith("Γ ") for text in columns["largest of the points run"])


def test_a_damper_is_shaken_as_hard_as_its_place_moves(write):
    """At half the shape: half of Gamma, and its energy over the strain energy of the same motion of the mode."""
    config = load(write(GIVEN.replace("PHI", repr(-PHI / 2))))
    own, seen = studies(config)
    assert own[1].sweep.zip[0]["excitation.gamma"] == [1.0, 2.0]
    assert own[1].sweep.zip[0]["excitation.frequency"] == [40.0, 40.0]
    assert [modes.amplitude[0] for modes in seen] == pytest.approx([PHI, PHI / 2])
    found = run(config, executor="in-process")
    single = GIVEN[: GIVEN.index("dampers:")] + GIVEN[GIVEN.index("materials:") :]
    alone = run(load(write(single.replace("[2, 4]", "[1, 2]"))), executor="in-process")
    energy = found["energy_mean"].sel(damper=2).isel(frequency=0)
    np.testing.assert_allclose(energy, alone["energy_mean"].isel(frequency=0), rtol=1e-12)
    strain = 0.5 * (np.array([2, 4]) * 9.81 / (80 * np.pi) / PHI) ** 2
    share = found["damper_share"].sel(damper=2, mode=1)
    np.testing.assert_allclose(share, energy.values / (4 * np.pi * strain), rtol=1e-12)


def test_masses_and_places_on_a_beam(write):
    """Each damper's empty mass and particles sit where it does, as masses beside the first one would."""
    config = load(write(BEAM))
    alone = every_damper(config)
    first, second = modes_of_all(config, alone)
    steel = 4 * 7800 * 4 / 3 * np.pi * 0.002**3
    text = BEAM[: BEAM.index("dampers:")] + BEAM[BEAM.index("materials:") :]
    other = f"other_masses: [{{mass: {0.05 + steel} kg, position: 145 mm}}]"
    text = text.replace("  modes: [1, 3]", f"  {other}\n  modes: [1, 3]")
    beside = modes(load(write(text)), particles=8 * 920 * 4 / 3 * np.pi * 0.00373**3)
    np.testing.assert_allclose(first.frequency, beside.frequency, rtol=1e-9)
    np.testing.assert_allclose(second.amplitude, beside.at((0.145, 0, 0)).amplitude, rtol=1e-9)
    assert list(alone[1].materials) == ["steel"]


def test_places_on_a_plate_are_those_of_their_footprints(write):
    """Dampers in mirrored places see the same shapes, whichever is the first."""
    plate = BEAM.replace("beam: {length: 580 mm, width: 20 mm, ", "plate: {length: 300 mm, width: 200 mm, ")
    plate = plate.replace("200 g, position: 290 mm", "50 g, position: [100 mm, 100 mm], footprint: 30 mm")
    plate = plate.replace("50 g, position: 145 mm", "50 g, position: [200 mm, 100 mm], footprint: 30 mm")
    config = load(write(plate.replace("modes: [1, 3]", "modes: [1]")))
    first, second = seen_by_all(config, modes(config, particles=0.0))
    assert second.amplitude == pytest.approx(first.amplitude, rel=1e-3)  # meshes are graded from one side


def test_places_on_modes_from_a_file(tmp_path):
    """By node and by position: the same place, and the mass of both fillings there and at the first damper."""
    yaml = YAML(typ="safe")
    study = yaml.load(ROOT / "configs" / "mode_file.yaml")
    study["structure"]["mode_file"]["file"] = str(ROOT / "configs" / study["structure"]["mode_file"]["file"])
    every = read_csv(study["structure"]["mode_file"]["file"]).at((0.29, 0, 0), (0, 0, 1))
    row = len(every.point) // 4
    study["dampers"] = [study["damper"] | {"position": [float(x) for x in every.point[row]]}]
    both = Config.model_validate(study)
    first, second = seen_by_all(both, modes(both, particles=0.02, further=[0.01]))
    exact = every.with_mass(0.02).seen_from(row, (0, 0, 1)).with_mass(0.01)
    np.testing.assert_allclose(second.frequency, exact.pick([1, 3]).frequency, rtol=1e-12)
    np.testing.assert_allclose(second.amplitude, exact.pick([1, 3]).amplitude, rtol=1e-9)
    np.testing.assert_allclose(
        first.amplitude, exact.seen_from(every.damper, (0, 0, 1)).pick([1, 3]).amplitude, rtol=1e-9
    )
    assert second.damper == row
    study["dampers"] = [study["damper"] | {"node": 9999}]
    wrong = Config.model_validate(study)
    with pytest.raises(ConfigError, match="there is no node 9999"):
        seen_by_all(wrong, modes(Config.model_validate(study | {"dampers": []}), particles=0.0))


def test_participation_on_modes_from_a_file():
    study = YAML(typ="safe").load(ROOT / "configs" / "mode_file.yaml")
    source = study["structure"]["mode_file"]
    source["file"] = str(ROOT / "configs" / source["file"])
    count = len(read_csv(source["file"]).number)
    source["participation"] = [0.1 * k for k in range(count)]
    found = modes(Config.model_validate(study), particles=0.0)
    along = found.participation @ np.asarray(found.direction)
    np.testing.assert_allclose(along, 0.1 * (found.number - 1), atol=1e-12)
    source["participation"] = [0.1]
    with pytest.raises(ConfigError, match=f"participation: 1 values for {count} modes"):
        modes(Config.model_validate(study), particles=0.0)


def test_it_is_explained(write):
    text = explain(load(write(GIVEN.replace("PHI", repr(PHI / 2)))))
    assert "Damper 1: mass-normalised shape 1.414 in mode 1, 1.118 in mode 2" in text
    assert "Damper 2: mass-normalised shape 0.7071 in mode 1, 0 in mode 2" in text
    assert "at 40 Hz, Gamma 1" in text


def test_what_is_for_one_damper_says_so(write):
    """FRFs and parts of a run are refused by name."""
    config = load(write(GIVEN.replace("PHI", "1")))
    with pytest.raises(ConfigError, match="dampers: several dampers are run as a whole: leave --part out"):
        carry_out(config, "nowhere", part=(1, 2))
    several = xr.Dataset(coords={"damper": [1, 2]})
    with pytest.raises(ModalError, match="several dampers, which have no one mass"):
        accelerance(several)
    with pytest.raises(ValueError, match="several dampers: an optimum is of one"):
        optimum(several)
    with pytest.raises(ValueError, match="several dampers: the damping is in `damping_ratio`"):
        Damper(several).damping(None)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("    amplitude: [PHI kg^-0.5, 0]\n", "", "dampers.0: say where the damper sits, by one of point_mass, node"),
        ("amplitude: [PHI kg^-0.5, 0]", "node: 3", r"dampers.0.node: on structure.modes_given give amplitude instead"),
        ("amplitude: [PHI kg^-0.5, 0]", "amplitude: [1]", "dampers.0.amplitude: 1 values for 2 modes"),
        ("[PHI kg^-0.5, 0]", "[0, 0]", "dampers.0.amplitude: is on a node of every mode"),
        ("gamma: [2, 4]", "gamma: 2, frequency: 40 Hz", "shaken at the structure's modes: leave it out"),
        ("friction: 0.5", "friction: [0.4, 0.5]", "takes one value where there are several dampers"),
        ("preparation: loose", "preparation: carried", "'carried' is for one damper"),
        ("preparation: loose", "preparation: loose\nsweep: {product: {friction: [0.1, 0.2]}}", "sweep: is for one damper"),
        ("count: 8, radius: 3.73 mm, material: pmma}\n    amp", "count: 90, radius: 3.73 mm, material: pmma}\n    amp",
         "dampers.0.particles.count: too many particles"),
        ("material: pmma}\n    amp", "material: wood}\n    amp", "dampers.0.particles.material: there is no material"),
    ],
)  # fmt: skip
def test_what_is_refused(write, old, new, message):
    assert old in GIVEN
    with pytest.raises(ConfigError, match=message):
        run(load(write(GIVEN.replace(old, new).replace("PHI", "1"))), executor="in-process")
