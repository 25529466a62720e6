"""Bad input is refused in one line that says where, what, and what to do."""

import json
import re

import pytest

from warpdamp import ConfigError, load
from warpdamp.config.quantities import COMMON, _converted, to_si
from warpdamp.config.study import Config
from warpdamp.sweep.cases import Cases
from warpdamp.sweep.reader import read_axes


def refused(tmp_path, config_path, old, new):
    text = config_path.read_text()
    assert old in text
    path = tmp_path / "study.yaml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ConfigError) as caught:
        load(path)
    return str(caught.value).replace(str(path), "FILE")


def test_the_papers_study_is_read_in_si(config_path):
    config = load(config_path)
    assert config.structure.beam.length == pytest.approx(0.58)
    assert config.materials["pmma"].youngs_modulus == pytest.approx(3.3e9)
    assert config.damper.particles.radius == pytest.approx(3.73e-3)
    assert config.excitation.gamma[0] == 0.5
    assert config.excitation.gamma[-1] == 14
    assert len(config.excitation.gamma) >= 20
    assert len(config.seeds) == 3


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("thickness: 4 mm", "thicknes: 4 mm", r"FILE:\d+:5: structure.beam.thicknes: unknown key; did you mean 'thickness'\?"),
        ("    length: 580 mm            # between the clamps\n", "", r"FILE:\d+:\d+: structure.beam.length: missing"),
        ("length: 580 mm", "length: 580 kg", r"'580 kg' has the wrong unit: expected a quantity in m"),
        ("length: 580 mm", "length: -3 mm", r"FILE:8:5: structure.beam.length: .*greater than 0, got '-3 mm'"),
        ("length: 580 mm", "length: .nan", r"structure.beam.length: .*not finite"),
        ("length: 580 mm", "length: 5 bananas", r"cannot read '5 bananas': expected a quantity in m, such as '40 mm'"),
        ("restitution: 0.52", "restitution: 1.2", r"contact.restitution: .*less than or equal to 1, got 1.2"),
        ("restitution: 0.52", "restitution: [0.2, -0.1]", r"contact.restitution.1: .*greater than or equal to 0"),
        ("poissons_ratio: 0.37", "poissons_ratio: 0.5", r"materials.pmma.poissons_ratio: .*less than 0.5, got 0.5"),
        ("poissons_ratio: 0.37", "poissons_ratio: -1", r"poissons_ratio: .*greater than -1"),
        ("radius: 3.73 mm", "radius: 25 mm", r"damper.particles.radius: .*50 mm do not fit the cavity"),
        ("count: 120", "count: 900", r"too many particles: they would fill 3.892.*take at most 171"),
        ("count: 120", "count: 12.5", r"damper.particles.count: expected a whole number"),
        ("material: steel", "material: steal", r"structure.beam.material: there is no material 'steal'; did you mean 'steel'\?"),
        ("preparation: compacted", "preparation: tapped", r"'tapped' is not one of 'loose', 'compacted' or 'carried'"),
        ("[1, 3, 5]", "[1, 1]", r"structure.modes: each mode once"),
        ("seeds: [1, 2, 3]", "seeds: []", r"seeds: .*at least 1"),
        ("frequency: modes", "frequency: 46 kg", r"excitation.frequency: '46 kg' has the wrong unit"),
        ("title: Granular damper on a clamped beam", "'[': 1", r":4:1: \[: unknown key"),
        ("fewest_cycles: 30", "fewest_cycles: 9000", r"steady_state.most_cycles: is below fewest_cycles"),
        ("title: Granular", "title: [Granular", r"FILE:\d+:\d+: not YAML"),
        ("friction: 0.86", "friction: '0,86'", r"contact.friction: cannot read '0,86': write a decimal point"),
        ("frequency: modes", "frequency: 2400 rpm", r"excitation.frequency: '2400 rpm' counts angles"),
        ("frequency: modes", "frequency: [40 Hz, 40 Hz]", r"excitation.frequency: each value once"),
        ("gravity: 9.81 m/s^2", "direction: up", r"excitation.direction: 'up' is not one of axial, lateral; or give \[x, y, z\]"),
        ("frequency: modes", "frequency: []", r"excitation.frequency: needs at least 1 value"),
        ("friction: 0.86", "friction: 0.86\n  pairs: {pmma: {restitution: 0.5, friction: 0.1}}", r"contact.pairs.pmma: expected two materials, as 'steel with pmma'"),
        ("seeds: [1, 2, 3]", "effects: {rotation: maybe}", r"effects.rotation: expected on or off, got 'maybe'"),
        ("count: 120", "count: true", r"damper.particles.count: expected a whole number"),
        ("position: 290 mm", "position: 580 mm", r"point_mass.position: is at a clamped end"),
        ("gravity: 9.81 m/s^2", "gravity: 0", r"preparation: a bed cannot be compacted without gravity"),
        ("  steel:\n", "  rubber: {density: 1 kg/m^3, youngs_modulus: 1 Pa, poissons_ratio: 0}\n  steel:\n", r"materials.rubber: is not used by anything: leave it out"),
        ("seeds: [1, 2, 3]", "seeds: [1]\nseeds: [2]", r"not YAML: found duplicate key"),
        ("seeds: [1, 2, 3]", "\tseeds: [1]", r"not YAML: .*; indent with blanks, not with tabs"),
    ],
)  # fmt: skip
def test_one_line_for_one_error(tmp_path, config_path, old, new, message):
    said = refused(tmp_path, config_path, old, new)
    assert re.search(message, said), said
    assert "\n" not in said
    assert re.match(r"FILE:\d+:\d+: ", said)


def test_all_errors_are_said_at_once(tmp_path, config_path):
    text = config_path.read_text().replace("count: 120", "count: 0").replace("friction: 0.86", "friction: -1")
    path = tmp_path / "study.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load(path)
    assert len(str(caught.value).splitlines()) == 2


@pytest.mark.parametrize("content", [b"\x89PNG\r\n\x00\x1a", b"hello", b"- a\n- b\n", b""])
def test_a_file_that_is_no_configuration(tmp_path, content):
    path = tmp_path / "study.yaml"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match=r"not YAML|not a warpdamp configuration"):
        load(path)


def test_a_configuration_in_another_encoding(tmp_path, config_path):
    path = tmp_path / "study.yaml"
    path.write_text(config_path.read_text(), encoding="utf-16")
    with pytest.raises(ConfigError, match=r"no UTF-8 text \(byte 0\): save it as UTF-8"):
        load(path)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(ConfigError, match="cannot be read: No such file"):
        load(tmp_path / "nothing.yaml")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [("40 mm", "m", 0.04), ("3.3 GPa", "Pa", 3.3e9), ("2 %", "", 0.02), ("0.92 g/cm^3", "kg/m^3", 920.0),
     ("920 kg/m3", "kg/m^3", 920.0), ("3.3 N/mm2", "Pa", 3.3e6), ("920 kg m-3", "kg/m^3", 920.0), (5, "m", 5.0), ("1e-3", "m", 1e-3), ("2 us", "s", 2e-6)],
)  # fmt: skip
def test_quantities(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [("7 800 kg/m^3", "kg/m^3", 7800.0), ("7\u00a0800 kg/m^3", "kg/m^3", 7800.0), ("7\u2009800 kg/m³", "kg/m^3", 7800.0),
     ("7'800 kg/m^3", "kg/m^3", 7800.0), ("7\u2019800.5 kg/m^3", "kg/m^3", 7800.5), ("1 234 567 Pa", "Pa", 1234567.0),
     ("3 300 MPa", "Pa", 3.3e9), ("1 1/4 in", "m", 0.03175), ("1/4 in", "m", 0.00635), ("-1 1/4 in", "m", -0.03175), ("40 1/s", "Hz", 40.0),
     ("0.769 kg^-0.5", "kg^-0.5", 0.769), ("2 g-0.5", "kg^-0.5", 2 * 1000**0.5)],
)  # fmt: skip
def test_digits_apart_are_one_number(text, unit, value):
    """Thousands apart by a blank of any kind or an apostrophe, and fractions of the inch; 25.4 mm to the inch."""
    assert to_si(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [("7 80 mm", "m", "one number and its unit"), ("5 10 mm", "m", "one number and its unit"), ("1.234.567 mm", "m", "one number and its unit"),
     ("5 mm + mm", "m", "one number and its unit"), ("3*10^2 Hz", "Hz", "one number and its unit"), ("5 m^99", "m", "one number and its unit"),
     ("7'80 mm", "m", "one number and its unit"), ("1 5/4 in", "m", "no proper fraction"), ("1/0 in", "m", "no proper fraction"),
     ("46 hz", "Hz", r"did you mean Hz\?"), ("3.3 gpa", "Pa", r"did you mean GPa\?"), ("40 MM", "m", r"did you mean mm\?"),
     ("0,52", "", "write a decimal point"), (10**400, "m", "not finite"), ("9" * 5000, "m", "not finite")],
)  # fmt: skip
def test_digits_that_are_no_one_number(text, unit, message):
    with pytest.raises(ValueError, match=message):
        to_si(text, unit)


@pytest.mark.parametrize(
    ("old", "new", "place", "message"),
    [
        ("restitution: 0.52\n", "restitution: 0,52\n", "contact.restitution", "cannot read '0,52': write a decimal point"),
        ("\ncontact:", "\ncontact: {restitution: 0,52, friction: 0.86}\nold:", "contact.restitution", "'0' and then '52'.*decimal point"),
        ("\ncontact:", "\ncontact: {restitution: 0,52, friction: 0,52}\nold:", "", 'duplicate key "52".*decimal point'),
        ("  particles:", "  particles: {count: 120, radius: 3,73 mm, material: pmma}\n  old:", "damper.particles.radius", "'3' and then '73 mm'.*decimal point"),
        ("  frequency: modes", "  frequency: [40,5 Hz, 60,7 Hz]", "", r"\[40,5 Hz, 60,7 Hz\] has decimal commas.*decimal points"),
    ],
)  # fmt: skip
def test_a_decimal_comma_is_said_with_its_remedy(tmp_path, config_path, old, new, place, message):
    """YAML splits a number at its comma within braces and brackets: 0,52 becomes the keys 0 and 52."""
    text = config_path.read_text()
    assert old in text
    path = tmp_path / "study.yaml"
    path.write_text(text.replace(old, new))
    with pytest.raises(ConfigError) as caught:
        load(path)
    (said,) = [line for line in str(caught.value).splitlines() if "decimal point" in line]
    assert re.search(rf"study.yaml:\d+:\d+: {place}.*{message}", said), said


@pytest.mark.parametrize("value", [True, None, [1], {"a": 1}, "inf m", "import os", "mm", ""])
def test_what_is_no_quantity(value):
    with pytest.raises(ValueError, match="expected a quantity in m"):
        to_si(value, "m")


def test_any_scalar_may_be_an_axis(tmp_path, config_path):
    text = config_path.read_text()
    text = text.replace("friction: 0.86", "friction: [0.1, 0.3]").replace(
        "youngs_modulus: 3.3 GPa", "youngs_modulus: [33 MPa, 3.3 GPa]"
    )
    path = tmp_path / "study.yaml"
    path.write_text(text)
    config = load(path)
    assert [(axis.name, axis.values) for axis in read_axes(config)[1]] == [
        ("youngs_modulus", (33e6, 3.3e9)),
        ("friction", (0.1, 0.3)),
    ]
    every = {point.index: point.config for point in Cases(config).points()}
    assert set(every) == {(0, 0), (0, 1), (1, 0), (1, 1)}
    assert every[1, 0].contact.friction == 0.1
    assert every[1, 0].materials["pmma"].youngs_modulus == 3.3e9


def test_equal_names_are_told_apart(tmp_path, config_path):
    text = config_path.read_text().replace(
        "friction: 0.86", "friction: [0.1, 0.3]\n  walls: {restitution: 0.5, friction: [0, 1]}"
    )
    path = tmp_path / "study.yaml"
    path.write_text(text)
    assert [axis.name for axis in read_axes(load(path))[1]] == ["friction", "walls_friction"]


def test_the_schema_serves_editors():
    schema = Config.model_json_schema()
    json.dumps(schema)
    assert set(schema["properties"]) >= {"structure", "damper", "materials", "contact", "excitation", "seeds"}
    assert schema["additionalProperties"] is False


@pytest.mark.parametrize(("unit", "given"), [(unit, name) for unit, names in COMMON.items() for name in names])
def test_common_units_are_those_of_pint_to_the_bit(unit, given):
    for number in (3.73, 40.0, 1 / 3, 6.02e23, 9.1e-31):
        assert to_si(f"{number!r} {given}", unit) == _converted(number, given, unit)
