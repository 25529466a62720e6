"""Effects in the configuration, and the plan told before a run."""

import re

import numpy as np
import pytest

import warpdamp
from conftest import ROOT
from warpdamp import Batch, Case, ConfigError, Effects, State, load
from warpdamp.config.build import grains, scene
from warpdamp.engine.memory import particle_bytes
from warpdamp.study.explain import effects_of, explain
from warpdamp.study.speeds import remember, without
from warpdamp.sweep.cases import Cases

MIXED = """
damper:
  enclosure: {diameter: 30 mm, height: 40 mm, material: pmma, lid: false}
  particles:
    - {count: 9, radius: {normal: {mean: 2.4 mm, deviation: 0.2 mm}}, material: pmma}
    - {count: 3, radius: 2 mm, material: steel}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 3.3 GPa, poissons_ratio: 0.37}
  steel: {density: 7800 kg/m^3, youngs_modulus: 33 GPa, poissons_ratio: 0.3}
contact:
  restitution: 0.52
  friction: 0.3
  pairs:
    steel with steel: {restitution: 0.6, friction: 0.2}
    steel with walls: {restitution: 0.55, friction: 0.25, rolling_friction: 0.01}
excitation: {gamma: [0.5, 1], frequency: 30 Hz, direction: lateral}
preparation: loose
steady_state: {fewest_cycles: 12, most_cycles: 12}
"""


def shown(config):
    spec, _ = Cases(config).spec(0)
    return {row.name: row for row in effects_of(config, spec)}


def test_a_mixture_is_read(write):
    config = load(write(MIXED))
    own, s = grains(config), scene(config)
    assert own.species == (0,) * 9 + (1,) * 3
    assert np.mean(own.radius[:9]) == pytest.approx(2.4e-3)
    assert np.ptp(own.radius[:9]) > 0.4e-3  # the middles of nine equal parts reach to 1.59 deviations either way
    assert own.radius[9:] == (2e-3,) * 3
    assert s.pair_surface(1, 1).restitution == 0.6
    assert s.pair_surface(0, 1) == s.pair_surface(1, 0) == s.pair_surface(0, 0)
    assert s.wall_surface(0).friction == 0.3
    assert s.wall_surface(1).rolling_friction == 0.01
    assert not s.enclosure.lid
    spec, _ = Cases(config).spec(0)
    assert spec.scene.drive.direction == (1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("radius", "expected"),
    [
        ("{uniform: [1 mm, 3 mm]}", [1.25e-3, 1.75e-3, 2.25e-3, 2.75e-3]),
        ("{lognormal: {median: 2 mm, deviation: 0.1}}", 2e-3 * np.exp(0.1 * np.array([-1.150349, -0.318639, 0.318639, 1.150349]))),
        ("{each: [1 mm, 2 mm, 1 mm, 2 mm]}", [1e-3, 2e-3, 1e-3, 2e-3]),
    ],
)  # fmt: skip
def test_sizes(write, radius, expected):
    text = re.sub(r"  particles:\n.*\n.*\n", f"  particles: {{count: 4, radius: {radius}, material: pmma}}\n", MIXED)
    text = re.sub(r"  steel: .*\n|  pairs:\n(    .*\n)*", "", text)
    assert grains(load(write(text))).radius == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("lid: false", "floor: false", r":3:\d+: damper.enclosure.floor: gravity draws the particles out"),
        (
            "normal: {mean: 2.4 mm, deviation: 0.2 mm}",
            "normal: {mean: 1 mm, deviation: 0.5 mm}",
            r"more than a quarter",
        ),
        ("{normal: {mean: 2.4 mm, deviation: 0.2 mm}}", "{each: [1 mm]}", r"1 radii for 9 particles"),
        ("{normal: {mean: 2.4 mm, deviation: 0.2 mm}}", "{uniform: [3 mm, 2 mm]}", r"the smallest and the largest"),
        ("steel with walls", "stele with walls", r":15:5: contact.pairs.*there are no particles of 'stele'"),
        ("steel with walls", "steel-walls", r"contact.pairs"),
        ("direction: lateral", "direction: [0, 0, 0]", r"excitation.direction: .*cannot be \[0, 0, 0\]"),
        ("direction: lateral", "direction: up", r"excitation.direction"),
        ("material: steel}", "material: stel}", r"damper.particles.1.material: there is no material 'stel'"),
    ],
)
def test_what_cannot_be_is_refused(write, old, new, message):
    assert old in MIXED
    with pytest.raises(ConfigError, match=message):
        load(write(MIXED.replace(old, new, 1)))


def test_explain_names_the_line_that_calls_for_an_effect(write, monkeypatch, tmp_path):
    monkeypatch.setenv("WARPDAMP_CACHE", str(tmp_path / "no speed yet"))
    path = write(MIXED)
    lines = path.read_text().splitlines()
    rows = shown(load(path))
    assert [name for name, row in rows.items() if not row.on] == ["lid", "spheroids"]
    for name, key in (("friction", "friction: 0.3"), ("dashpots", "restitution: 0.52"), ("lid", "lid: false")):
        line = int(re.search(r"line (\d+)", rows[name].why)[1])
        assert key in lines[line - 1]
    text = explain(load(path), workers=2)
    for part in ("2 cases", "12 particles", "us at 30 Hz, Gamma 1", "not measured yet", "Not modelled", "2 processes"):
        assert part in text


SHAPE = ", radius: 2 mm, material: steel, shape: {aspect: 1.5}}"


def test_explain_names_the_aspects_and_their_price(write, monkeypatch, tmp_path):
    monkeypatch.setenv("WARPDAMP_CACHE", str(tmp_path))
    config = load(write(MIXED.replace(", radius: 2 mm, material: steel}", SHAPE)))
    row = shown(config)["spheroids"]
    assert row.on
    assert row.why == "damper.particles: 1, 1.5 (line 4)"
    assert row.cost is None  # not measured yet
    effects = Cases(config).spec(0)[0].effects
    remember("frozen", {effects: [300.0], without(effects, "spheroids"): [110.0]})
    assert shown(config)["spheroids"].cost == pytest.approx(190.0)
    one = load(ROOT / "configs" / "sphericity.yaml")  # its first aspect
    assert re.fullmatch(r"damper.particles.shape.aspect: 0\.5 \(line \d+\)", shown(one)["spheroids"].why)
    spheres = load(write(MIXED))
    assert not shown(spheres)["spheroids"].on


def test_forced_effects_are_simulated_and_said(write):
    config = load(write(MIXED + "effects: {rotation: off, ledger: totals}\n"))
    rows = shown(config)
    assert not rows["rotation"].on
    assert rows["rotation"].why == "forced off, though the scene calls for it"
    assert not rows["rolling"].on  # what cannot turn does not roll
    dataset = warpdamp.run(config, workers=1)
    assert dataset.attrs["effects_forced_off"] == "channels, rotation"
    assert "rotation=False" in dataset.attrs["effects"]
    assert (dataset["energy_dissipated"] > 0).all()
    total = dataset["particle_total_loss"] + dataset["wall_total_loss"]
    np.testing.assert_allclose(total, dataset["energy_dissipated"], rtol=1e-9)
    assert np.isnan(dataset["clearance"]).all()  # an open cup has none


@pytest.mark.parametrize(
    "effects", [Effects(), Effects(friction=False, rotation=False, dashpots=False, indicators=False)]
)
def test_the_memory_of_a_particle_is_what_is_allocated(effects, damper, loose_positions):
    batch = Batch([Case(damper(), State.at_rest(loose_positions(1), 3.73e-3), 1e-6)], effects=effects)
    contacts = [getattr(batch._contacts, name) for name in batch._types.Contacts.vars]
    arrays = [batch._particles, batch._group, batch._counts, batch._cycle_start, *contacts]
    told = 120 * particle_bytes(batch._types, len(batch._contacts.partner) / 120)
    assert told == sum(array.capacity for array in arrays) - 2 * 4  # two arrays of bounds have one more
