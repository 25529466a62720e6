"""Shapes of particles in the configuration: read, swept, and refused in one line before anything runs."""

import re

import pytest

from conftest import ROOT
from warpdamp import ConfigError, load
from warpdamp.config.build import grains, particle_mass
from warpdamp.config.study import Config
from warpdamp.sweep.cases import Cases

PARTICLES = "{count: 120, radius: 3.73 mm, material: pmma}"


@pytest.fixture
def study(tmp_path):
    text = (ROOT / "configs" / "frequency_map.yaml").read_text()

    def write(particles=PARTICLES, more=""):
        path = tmp_path / "study.yaml"
        path.write_text(text.replace(PARTICLES, particles, 1) + more)
        return path

    return write


def shaped(aspect):
    return PARTICLES.replace("}", f", shape: {{aspect: {aspect}}}}}")


def test_spheres_need_no_shape(study):
    config = load(study())
    assert config.damper.particles.shape.aspect == 1
    assert grains(config).aspect == ()
    assert grains(load(study(shaped(1)))) == grains(config)


def test_spheroids_keep_their_mass(study):
    config = load(study(shaped(2.0)))
    assert grains(config).aspect == (2.0,) * 120
    assert particle_mass(config) == particle_mass(load(study()))


def test_each_component_of_a_mixture_has_its_shape(study):
    parts = [shaped(0.5), PARTICLES, shaped(2.0).replace("3.73 mm", "{uniform: [2 mm, 3 mm]}")]
    config = load(study(f"[{', '.join(part.replace('120', '4') for part in parts)}]"))
    assert grains(config).aspect == (0.5,) * 4 + (1.0,) * 4 + (2.0,) * 4


@pytest.mark.parametrize("key", ["aspect", "shape.aspect", "damper.particles.shape.aspect"])
def test_the_aspect_is_swept_by_its_path(study, key):
    cases = Cases(load(study(more=f"sweep: {{product: {{{key}: [0.5, 1, 2]}}}}\n")))
    assert cases.names() == {("damper", "particles", "shape", "aspect"): "aspect"}
    assert [grains(point.config).aspect[:1] for point in cases.points()] == [(0.5,), (), (2.0,)]


def test_an_aspect_that_the_cavity_does_not_allow_is_one_combination_that_cannot_be(study):
    cases = Cases(load(study(more="sweep: {product: {aspect: [1, 3], diameter: [40 mm, 60 mm]}}\n")))
    refused = [point.refused for point in cases.points()]
    assert [bool(text) for text in refused] == [False, False, True, False]
    assert "both ends at once" in refused[2]


@pytest.mark.parametrize(
    ("particles", "more", "message"),
    [
        (shaped(0), "", r"FILE:7:68: damper.particles.shape.aspect: .*greater than 0, got 0"),
        (shaped(-2), "", r"shape.aspect: .*greater than 0, got -2"),
        (shaped(".nan"), "", r"shape.aspect: .*not finite"),
        (shaped(".inf"), "", r"shape.aspect: .*not finite"),
        (shaped("long"), "", r"shape.aspect: cannot read 'long'"),
        (shaped("[1, 2]"), "", r"shape.aspect: expected a plain number"),
        (shaped(3), "", r"7:68: .*aspect 3 might touch the side at both ends at once: its largest radius of curvature, "
         r"23\.3 mm, is not below the cavity's radius, 20 mm; take an aspect above 0\.284 and below 2\.739"),
        (shaped(0.25), "", r"aspect 0\.25 might touch the side at both ends at once"),
        (shaped(1e300), "", r"both ends at once"),
        (f"[{shaped(2)}, {shaped(20)}]", "", r"damper.particles.1.shape.aspect: .*aspect 20"),
        (shaped(2).replace("aspect", "aspct"), "", r"shape.aspct: unknown key; did you mean 'aspect'\?"),
        (shaped(2).replace("{aspect: 2}", "2"), "", r"particles.shape: expected keys below it, got 2"),
        (shaped(2).replace("120", "250"), "", r"count: too many particles: .*not even sizes and shapes fill"),
        (shaped(2), "effects: {rotation: off}\n", r"FILE:22:11: effects.rotation: spheroids turn"),
        (PARTICLES, "sweep: {product: {aspect: [1, 0]}}\n", r"sweep.product.aspect.1: .*greater than 0"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_in_one_line(study, particles, more, message):
    path = study(particles, more)
    with pytest.raises(ConfigError) as caught:
        Cases(load(path))
    said = str(caught.value).replace(str(path), "FILE")
    assert re.search(message, said), said
    assert "\n" not in said


def test_a_spheroid_longer_than_the_cavity_is_high_is_refused(study):
    path = study(shaped(2.5))
    path.write_text(path.read_text().replace("height: 40 mm", "height: 13 mm").replace("120", "10"))
    with pytest.raises(ConfigError, match=r"shape.aspect: particles 13\.7 mm across do not fit the cavity"):
        load(path)


def test_editors_know_the_shape():
    schema = Config.model_json_schema()
    assert schema["$defs"]["ShapeConfig"]["properties"].keys() == {"aspect"}
    assert "shape" in schema["$defs"]["ParticlesConfig"]["properties"]
