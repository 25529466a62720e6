"""Materials from the library: what a name stands for, and what is refused."""

import pytest

from warpdamp import ConfigError, load
from warpdamp.config.build import scene
from warpdamp.config.reading import resolved_yaml
from warpdamp.report.materials import material_lines
from warpdamp.scene.materials import ELASTIC, LIBRARY, SOURCES

STUDY = """\
damper:
  enclosure: {{diameter: 24 mm, height: 20 mm, material: {wall}}}
  particles: {{count: 16, radius: 3.73 mm, material: {grain}}}
{materials}
contact: {contact}
excitation: {{frequency: 46 Hz, gamma: 4}}
"""


def study(tmp_path, wall="steel_structural", grain="soda_lime_glass", materials="", contact="{}"):
    path = tmp_path / "study.yaml"
    path.write_text(STUDY.format(wall=wall, grain=grain, materials=materials, contact=contact))
    return load(path)


def refusal(tmp_path, **parts):
    with pytest.raises(ConfigError) as error:
        study(tmp_path, **parts)
    (line,) = str(error.value).splitlines()
    return line


@pytest.mark.parametrize("name", LIBRARY)
def test_every_value_has_a_source_and_lies_in_its_range(name):
    values = LIBRARY[name].values()
    assert values
    for value in values.values():
        assert value.sources
        assert set(value.sources) <= set(SOURCES)
        assert 0 < value.low <= value.value <= value.high
    if "poissons_ratio" in values:
        assert values["poissons_ratio"].high < 0.5


def test_the_library_is_as_large_as_was_asked_for_and_no_source_is_idle():
    assert sum(set(ELASTIC) <= set(material.values()) for material in LIBRARY.values()) >= 20
    values = [value for material in LIBRARY.values() for value in material.values().values()]
    values += [value for m in LIBRARY.values() for one in m.beside for value in (one.restitution, one.friction)]
    assert {word for value in values for word in value.sources} == set(SOURCES)


def test_what_was_measured_on_another_material_is_shown_and_not_taken(tmp_path):
    (line,) = [line for line in material_lines("alumina") if "soda-lime glass" in line]
    assert "restitution 0.98 at 3.85 m/s, friction 0.092: Kharaz" in line
    assert "contact: the library has no restitution and no friction of alumina" in refusal(tmp_path, grain="alumina")


@pytest.mark.parametrize("name", LIBRARY)
def test_density_and_modulus_agree_with_the_speed_of_sound(name):
    """sqrt(E / density) of solids lies between 40 m/s (rubber) and 12 km/s: a slip of a unit would not."""
    values = LIBRARY[name].values()
    if {"density", "youngs_modulus"} <= set(values):
        assert 40 < (values["youngs_modulus"].value / values["density"].value) ** 0.5 < 12e3


def test_names_are_written_out_with_their_sources(tmp_path):
    config = study(tmp_path)
    made = scene(config)
    glass = LIBRARY["soda_lime_glass"]
    assert made.particle.density == glass.density.value == 2500
    assert made.wall.youngs_modulus == 210e9
    assert made.particle_contact.restitution == glass.restitution.value
    text = " ".join(resolved_yaml(config).split())
    assert "EN 572-1" in text
    assert "doi:10.1063/1.868282" in text


def test_what_was_written_out_can_be_read_again(tmp_path):
    config = study(tmp_path)
    (tmp_path / "again.yaml").write_text(resolved_yaml(config))
    assert scene(load(tmp_path / "again.yaml")) == scene(config)


def test_a_value_of_ones_own_goes_before_the_librarys(tmp_path):
    own = "materials: {balls: {library: soda_lime_glass, density: 2600 kg/m^3}}"
    config = study(tmp_path, grain="balls", materials=own, contact="{friction: 0.4}")
    assert config.materials["balls"].density == 2600
    assert config.materials["balls"].youngs_modulus == 70e9
    assert (config.contact.friction, config.contact.restitution) == (0.4, 0.97)
    assert "density" not in config.materials["balls"].source


def test_a_name_of_ones_own_hides_the_librarys(tmp_path):
    own = "materials: {lead: {density: 1 kg/m^3, youngs_modulus: 2 Pa, poissons_ratio: 0.1}}"
    config = study(tmp_path, grain="lead", materials=own, contact="{restitution: 0.5, friction: 0.5}")
    assert config.materials["lead"].density == 1


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ({"grain": "stel_ball_bearing", "contact": "{restitution: 0.5, friction: 0.5}"}, "3:43: damper.particles.material: there is no material 'stel_ball_bearing'; did you mean 'steel_ball_bearing'?"),
        ({"grain": "unobtainium", "contact": "{restitution: 0.5, friction: 0.5}"}, "3:43: damper.particles.material: there is no material 'unobtainium': define it under materials; `warpdamp materials` lists"),
        ({"grain": "polypropylene"}, "3:43: damper.particles.material: the library has no poissons_ratio of polypropylene"),
        ({"grain": "lead"}, "5:1: contact: the library has no restitution and no friction of lead with a source: give restitution, friction"),
        ({"grain": "b", "materials": "materials: {b: {library: led}}"}, "4:17: materials.b.library: there is no 'led'; did you mean 'lead'?"),
        ({"wall": "brass", "materials": "materials: {lead: {library: lead}}"}, "materials.lead: is not used by anything"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_one_line_with_its_place(tmp_path, parts, expected):
    assert expected in refusal(tmp_path, **parts)


def test_gaps_are_said(tmp_path):
    lines = "\n".join(material_lines("lead"))
    assert "restitution: no value with a source" in lines
    assert "ISBN" in lines
