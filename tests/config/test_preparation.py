"""How beds are prepared, as a configuration says it: read in SI, and refused at its place."""

import re

import pytest

from warpdamp import Config, ConfigError, load
from warpdamp.config.build import bed
from warpdamp.config.preparation import carried_path, preparation_word
from warpdamp.sweep.cases import Cases
from warpdamp.sweep.plan import make_plan
from warpdamp.sweep.resolve import shortened

BASE = """
damper:
  enclosure: {diameter: 20 mm, height: 25 mm, material: pmma}
  particles: {count: 14, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.86}
excitation: {frequency: 40 Hz, gamma: [3, 6]}
"""


@pytest.fixture
def study(tmp_path):
    def read(preparation, text=BASE):
        path = tmp_path / "study.yaml"
        path.write_text(f"{text}preparation: {preparation}\n")
        return load(path)

    return read


@pytest.mark.parametrize(
    ("preparation", "request_has", "path", "word"),
    [
        ("loose", {"preparation": "loose"}, (), "loose"),
        ("carried", {"preparation": "loose"}, ("up",), "carried"),
        ("{carried: {path: [down, up]}}", {"preparation": "loose"}, ("down", "up"), "carried"),
        ("{clearance: 1.8 mm}", {"preparation": "compacted", "clearance": 1.8e-3}, (), "given clearance"),
        (
            "{packing_fraction: 54 %}",
            {"preparation": "compacted", "packing_fraction": 0.54},
            (),
            "given packing fraction",
        ),
    ],
)
def test_a_preparation_becomes_a_request_or_a_path(study, preparation, request_has, path, word):
    config = study(preparation)
    assert bed(config) == pytest.approx(request_has)
    assert carried_path(config.preparation) == path
    assert preparation_word(config.preparation) == word
    assert shortened(config).preparation == "loose"


ONE = "beds are carried from one amplitude to the next, and excitation.gamma has one, 3: give several"
NO_LID = ("height: 25 mm", "height: 25 mm, lid: false")
NO_FLOOR = ("height: 25 mm", "height: 25 mm, floor: false")


@pytest.mark.parametrize(
    ("preparation", "change", "message"),
    [
        ("{carried: {path: []}}", (), r"FILE:9:25: preparation.carried.path: needs at least 1 value"),
        ("{carried: {path: [up, left]}}", (), r"FILE:9:36: preparation.carried.path.1: 'left' is not one of 'up' or 'down'"),
        ("{carried: true}", (), r"FILE:9:15: preparation.carried: expected keys below it"),
        ("carried", ("[3, 6]", "3"), f"FILE:9:1: preparation: {ONE}"),
        ("{carried: {path: [up, down]}}", ("[3, 6]", "3"), f"FILE:9:1: preparation: {ONE}"),
        ("loose\nsweep: {product: {preparation: [loose, carried]}}", ("[3, 6]", "3"), f"FILE:9:1: preparation: {ONE}"),
        ("{clearance: 1 mm, packing_fraction: 0.5}", (), r"FILE:9:1: preparation: give one of clearance: 1.8 mm"),
        ("{clearance: 0}", (), r"FILE:9:15: preparation.clearance: input should be greater than 0"),
        ("{clearence: 1 mm}", (), r"FILE:9:15: preparation.clearence: unknown key; did you mean 'clearance'\?"),
        ("{packing_fraction: 54}", (), r"FILE:9:15: preparation.packing_fraction: input should be less than 1, got 54"),
        ("{clearance: 1 mm}", NO_LID, r"FILE:9:15: preparation.clearance: is defined .*damper.enclosure has no lid; set prep"),
        ("{packing_fraction: 0.5}", NO_FLOOR, r"FILE:3:47: damper.enclosure.floor: gravity draws the particles out"),
        ("{clearance: 1 mm}", ("gamma:", "gravity: 0, gamma:"), r"FILE:9:15: preparation.clearance: .* without gravity"),
        ("compacted\nsweep: {product: {preparation.clearance: [1 mm]}}", (), r"FILE:10:19: .*not a scalar of this conf"),
        ("{carried: {path: [up]}}\nsweep: {product: {path: [up]}}", (), r"FILE:10:19: .*not a scalar of this configuration"),
    ],
)  # fmt: skip
def test_what_contradicts_itself_is_refused_in_one_line(study, tmp_path, preparation, change, message):
    with pytest.raises(ConfigError) as refused:
        study(preparation, BASE.replace(*change) if change else BASE)
    said = str(refused.value).replace(str(tmp_path / "study.yaml"), "FILE")
    assert re.match(message, said), said
    assert "\n" not in said


def test_the_schema_has_words_and_states():
    nodes = {
        node.get("$ref", "words"): node for node in Config.model_json_schema()["properties"]["preparation"]["anyOf"]
    }
    assert nodes["words"]["enum"] == ["loose", "compacted", "carried"]
    assert "#/$defs/PreparationConfig" in nodes


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (
            "clearance: 18 mm",
            "18 mm: the particles of damper fill 0.387 of it, and packed as densely as .* leave 11.9 mm",
        ),
        ("packing_fraction: 0.3", "0.3: the particles of damper fill 0.387 of it at least, and 0.74 is the densest"),
        ("packing_fraction: 0.8", "0.8: the particles of damper fill 0.387"),
        ("clearance: [2 mm, 20 mm]", "preparation.clearance: 20 mm"),
    ],
)
def test_what_no_bed_can_have_is_refused_before_one_is_made(study, asked, said):
    with pytest.raises(ConfigError, match=said):
        study(f"{{{asked}}}")


MADE = "{made_with: {contact: {friction: 0.86}, excitation: {gravity: 9.81 m/s^2}}}"


def test_beds_are_made_with_other_values_than_they_are_shaken_with(study):
    """Two frictions and no gravity from one bed: cases have their own scene, beds the one they are made with."""
    config = study(MADE, BASE.replace("0.86", "[0.1, 0.5]").replace("gamma:", "gravity: 0, gamma:"))
    specs = list(Cases(config).specs())
    assert {spec.scene.particle_contact.friction for spec in specs} == {0.1, 0.5}
    assert {spec.scene.gravity for spec in specs} == {(0, 0, 0)}
    assert len({spec.bed.key() for spec in specs}) == 1
    assert specs[0].bed.scene.particle_contact.friction == 0.86
    assert specs[0].bed.scene.gravity == (0, 0, -9.81)
    assert specs[0].bed.key() == next(Cases(study("compacted")).specs()).bed.key()
    assert preparation_word(config.preparation) == "compacted"
    assert len(set(make_plan(Cases(config)).keys)) == 4
    same = make_plan(Cases(study(MADE))), make_plan(Cases(study("compacted")))  # what beds are made with anyhow
    assert set(same[0].keys) == set(same[1].keys)


@pytest.mark.parametrize(
    ("preparation", "message"),
    [
        ("{made_with: {}}", r"FILE:9:1: preparation: give one of"),
        ("{made_with: {damper: {count: 3}}}", r"FILE:9:[0-9]+: preparation.made_with.damper: is not one of materials, contact, ex"),
        ("{made_with: {excitation: {gamma: 3}}}", r"FILE:9:[0-9]+: preparation.made_with.excitation.gamma: is not one of gravity"),
        ("{made_with: {contact: {friktion: 1}}}", r"FILE:9:[0-9]+: preparation.made_with.contact.friktion: extra inputs"),
        ("{made_with: {contact: {friction: [0.1, 1]}}}", r"FILE:9:[0-9]+: preparation.made_with.contact.friction: needs one value"),
        ("{made_with: {contact: {friction: -1}}}", r"FILE:9:[0-9]+: preparation.made_with.contact.friction: input should be"),
        ("{carried: {path: [up]}, made_with: {contact: {friction: 1}}}", r"FILE:9:[0-9]+: preparation.made_with: is for compacted"),
        (f"{MADE}\nsweep: {{product: {{made_with.contact.friction: [0, 1]}}}}", r"FILE:10:19: .*not a scalar of this conf"),
    ],
)  # fmt: skip
def test_what_beds_cannot_be_made_with_is_refused_at_its_place(study, tmp_path, preparation, message):
    with pytest.raises(ConfigError) as refused:
        Cases(study(preparation))
    said = str(refused.value).replace(str(tmp_path / "study.yaml"), "FILE")
    assert re.match(message, said), said
