"""The schema says of every key what it does, its range and its unit: editors and the reference show nothing else."""

import json
from functools import reduce

import pytest

from warpdamp.config.damper import SWITCHES
from warpdamp.config.schema import json_schema
from warpdamp.scene.effects import FORCIBLE

SCHEMA = json_schema()
MODELS = {"Config": SCHEMA, **SCHEMA["$defs"]}


@pytest.mark.parametrize("name", MODELS)
def test_every_key_says_what_it_does(name):
    model = MODELS[name]
    assert model["description"], f"{name} has no docstring"
    silent = [key for key, prop in model["properties"].items() if not prop.get("description", "").endswith(".")]
    assert not silent, f"{name}: a sentence is missing behind these fields"


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("EnclosureConfig.height", {"unit": "m", "exclusiveMinimum": 0}),
        ("MaterialConfig.poissons_ratio.anyOf.0", {"unit": "", "exclusiveMinimum": -1, "exclusiveMaximum": 0.5}),
        ("SurfaceConfig.restitution.anyOf.0", {"minimum": 0, "maximum": 1}),
        ("SteadyConfig.most_cycles", {"minimum": 8, "default": 1000}),
    ],
)
def test_ranges_and_units_of_quantities(path, expected):
    model, *keys = path.split(".")
    found = reduce(lambda node, key: node[int(key) if key.isdigit() else key], keys, MODELS[model]["properties"])
    assert {name: found.get(name) for name in expected} == expected
    assert not {"gt", "ge", "lt", "le"} & set(json.loads(json.dumps(found)))


def test_every_switch_of_an_effect_is_explained():
    assert set(SWITCHES) == set(FORCIBLE) - {"channels"}


def test_what_a_file_may_leave_out_or_say_in_a_word_is_in_the_schema():
    """Editors would mark as wrong what the reader takes: names of the library, presets, spectra of standards."""
    asked = {name: set(MODELS[name].get("required", ())) for name in ("Config", "MaterialConfig", "ContactConfig")}
    assert asked == {"Config": {"damper", "excitation"}, "MaterialConfig": set(), "ContactConfig": set()}
    assert set(MODELS["SurfaceConfig"]["required"]) == {"restitution", "friction"}
    assert {"enum": ["fast", "balanced", "reference"]} in MODELS["Config"]["properties"]["accuracy"]["anyOf"]
    spectrum = MODELS["BaseRandomConfig"]["properties"]["spectrum"]["anyOf"]
    assert any("NAVMAT P-9492" in kind.get("enum", ()) for kind in spectrum)
