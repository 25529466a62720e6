"""Numbers that a file cannot mean are refused with what may be meant; with their units extremes are taken."""

import re

import pytest

from warpdamp import ConfigError, load
from warpdamp.config.plausible import LIMITS, refusal
from warpdamp.config.reading import IN_SI, resolved_yaml
from warpdamp.config.study import Config

STUDY = """
structure:
  beam: {length: 580 mm, width: 20 mm, thickness: 4 mm, material: steel}
  point_mass: {mass: 200 g, position: 290 mm}
  modes: [1]
  inherent_damping: 1 %
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 8, radius: 3.73 mm, material: pmma}
materials:
  steel: {density: 7800 kg/m^3, youngs_modulus: 210 GPa, poissons_ratio: 0.3}
  pmma: {density: 920 kg/m^3, youngs_modulus: 3.3 GPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.86, rolling_friction: 1 %}
excitation: {gamma: [1, 2], gravity: 9.81}
steady_state: {standard_error: 2 %}
"""

REFUSED = [
    ("friction: 0.86", "friction: 86", r"13:30: contact.friction: 86 is no coefficient of friction \(at most 5\): did you mean 0.86, which is 86 %\?"),
    ("friction: 0.86", "friction: 8600 %", "did you mean 0.86, which is 86 %"),
    ("friction: 0.86", "friction: [0.5, 50]", "13:46: contact.friction.1: 50 is no coefficient"),
    ("friction: 0.86", "friction: {from: 10, to: 0.86, n: 3}", "contact.friction.from: 10 is no coefficient"),
    ("rolling_friction: 1 %", "rolling_friction: 2", "2 is no coefficient of rolling friction .*did you mean 0.02"),
    ("restitution: 0.52", "restitution: 52", r"less than or equal to 1, got 52; did you mean 0.52, which is 52 %\?"),
    ("ratio: 0.37", "ratio: 37", r"less than 0.5, got 37; did you mean 0.37, which is 37 %\?"),
    ("density: 920 kg/m^3", "density: 0.92", "0.92 without a unit is 0.92 kg/m.3: write its unit, as '0.92 g/cm.3'"),
    ("density: 7800 kg/m^3", "density: 7.8e-9", "as '7.8e-09 t/mm.3'"),
    ("density: 7800 kg/m^3", "density: 7.8e-6", "as '7.8e-06 kg/mm.3'"),
    ("density: 7800 kg/m^3", "density: 7800 g/cm^3", r"'7800 g/cm.3' is 7.8e\+06 kg/m.3, which nothing has"),
    ("modulus: 210 GPa", "modulus: 210", "210 without a unit is 210 Pa: write its unit, as '210 GPa', or '210 Pa' if that is meant"),
    ("modulus: 210 GPa", "modulus: '210000'", "as '210000 MPa'"),
    ("modulus: 210 GPa", "modulus: 210e9 GPa", "which nothing has: check the unit"),
    ("length: 580 mm", "length: 580", "write its unit, as '580 mm', or '580 m' if that is meant"),
    ("width: 20 mm", "width: 20", "as '20 mm'"),
    ("thickness: 4 mm", "thickness: 4", "as '4 mm'"),
    ("diameter: 24 mm", "diameter: 24", "as '24 mm'"),
    ("mass: 200 g", "mass: 200", "200 without a unit is 200 kg: write its unit, as '200 g'"),
    ("contact:", "design: {target: {damping: 2 %, gamma: [2, 8]}, variables: {particles.count: [8, 9]}, limits: {mass: 40}}\ncontact:", "design.limits.mass: 40 without a unit is 40 kg: write its unit, as '40 g'"),
    ("gravity: 9.81", "gravity: 1", "as '1 standard_gravity', or '1 m/s.2' if that is meant"),
    ("gravity: 9.81", "gravity: 9810", "as '9810 mm/s.2'"),
    ("gravity: 9.81", "gravity: 1 g", "has the wrong unit: .*g is gram: write standard_gravity"),
    ("radius: 3.73 mm", "radius: 1/8\"", "has the wrong unit: .*write in for inches"),
    ("inherent_damping: 1 %", "inherent_damping: 0.5", "0.5 is 50 %: write '0.5 %' if that is meant, or '50 %'"),
    ("inherent_damping: 1 %", "inherent_damping: 5", r"did you mean 0.05, which is 5 %\?"),
    ("standard_error: 2 %", "standard_error: 2", r"2 is no relative standard error .*did you mean 0.02, which is 2 %\?"),
    ("radius: 3.73 mm", "radius: {lognormal: {median: 2 mm, deviation: 5}}", r"deviation: 5 is no .*mean 0.05, which is 5 %\?"),
    ("contact:", "sweep: {product: {contact.friction: [0.1, 10]}}\ncontact:", "sweep.product.contact.friction.1: 10 is no"),
    ("contact:", "accuracy: {tolerance: 0.5}\ncontact:", "accuracy.tolerance: 0.5 is 50 %: write '0.5 %'"),
    ("contact:", "accuracy: {tolerance: 2}\ncontact:", r"got 2; did you mean 0.02, which is 2 %\?"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), REFUSED)
def test_what_no_one_means_is_refused_in_one_line(write, old, new, message):
    assert old in STUDY
    file = write(STUDY.replace(old, new, 1))
    with pytest.raises(ConfigError, match=message) as caught:
        load(file)
    for line in str(caught.value).splitlines():
        assert re.match(re.escape(str(file)) + r":\d+:\d+: ", line)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("friction: 0.86", "friction: [0, 1.2, 4.5]"),  # studies, rubber, clean metal
        ("friction: 0.86", "friction: 86 %"),
        ("density: 920 kg/m^3", "density: 15 kg/m^3"),  # foam
        ("density: 920 kg/m^3", "density: {log: [15 kg/m^3, 20 kg/m^3], n: 3}"),
        ("density: 7800 kg/m^3", "density: 22600"),  # osmium
        ("modulus: 3.3 GPa", "modulus: 20 kPa"),  # a gel
        ("modulus: 210 GPa", "modulus: 1.2e12"),  # diamond
        ("length: 580 mm", "length: 120 m"),
        ("mass: 200 g", "mass: 200 kg"),
        ("mass: 200 g", "mass: 0"),
        ("gravity: 9.81", "gravity: [0.27 m/s^2, 1 standard_gravity]"),
        ("gravity: 9.81", "gravity: 1.62"),  # the Moon's
        ("inherent_damping: 1 %", "inherent_damping: 50 %"),
    ],
)
def test_extremes_that_exist_are_taken(write, old, new):
    assert old in STUDY
    load(write(STUDY.replace(old, new, 1)))


def test_what_was_read_with_its_unit_is_read_again_without_it(write):
    """As configurations in results, and those of sweeps, are."""
    config = load(write(STUDY.replace("density: 920 kg/m^3", "density: 15 kg/m^3")))
    with pytest.raises(ConfigError, match="15 without a unit"):  # a person's file is asked
        load(write(resolved_yaml(config)))
    assert load(write(IN_SI + resolved_yaml(config))).materials["pmma"].density == 15  # a program's says what it is
    assert Config.model_validate(config.model_dump()).materials["pmma"].density == 15


def test_a_table_of_a_sweep_is_looked_at_too(write, tmp_path):
    (tmp_path / "cases.csv").write_text("contact.friction,materials.pmma.density\n0.5,920 kg/m^3\n0.6,0.92\n")
    with pytest.raises(ConfigError, match=r"cases.csv:3: materials.pmma.density: 0.92 without a unit"):
        load(write(STUDY + "sweep: {csv: cases.csv}\n"))
    (tmp_path / "cases.csv").write_text("contact.restitution\n52\n")
    with pytest.raises(ConfigError, match=r"contact.restitution = 52\); did you mean 0.52, which is 52 %\?"):
        load(write(STUDY + "sweep: {csv: cases.csv}\n"))
    (tmp_path / "cases.csv").write_text("contact.friction,materials.pmma.density [g/cm^3]\n0.5,0.92\n")
    load(write(STUDY + "sweep: {csv: cases.csv}\n"))


def test_every_limit_is_of_a_scalar_that_exists():
    """Each name stands in the schema, so that a renamed key does not lose its limits."""
    known = str(Config.model_json_schema())
    for name in LIMITS:
        *_, last = (part for part in name.split(".") if not part.isdecimal())
        assert f"'{last}'" in known
    assert refusal("damper.particles.radius", "3 mm") == ""
