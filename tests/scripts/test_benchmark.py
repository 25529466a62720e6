"""The benchmark's table is sound, and every peer gets the same scene.  No peer is run, nothing is timed."""

import re

import numpy as np
import pytest
from benchmarks import benchmark, document, peers, scaling, startup
from benchmarks.damper import DT, cavity, damper

from warpdamp import State, load
from warpdamp.scene.paper import FREQUENCY, RADIUS, STEPS_PER_CYCLE


@pytest.fixture
def three_spheres():
    return State.at_rest([[0.01 / 3, 0, RADIUS], [-0.01 / 7, 0.008, RADIUS], [0, -0.01 / 11, 0.02]], RADIUS)


def test_every_metric_is_measured_once_and_asks_for_something_sensible():
    names = [metric.name for metric in benchmark.METRICS]
    assert len(set(names)) == len(names)
    for metric in benchmark.METRICS:
        assert metric.group in benchmark.GROUPS, metric.name
        assert (metric.required is None) == (metric.sense == ""), metric.name
        if metric.aimed is not None:
            assert metric.meets(metric.aimed, metric.required), f"{metric.name}: aimed lower than required"
    assert {metric.group for metric in benchmark.METRICS} == set(benchmark.GROUPS)


def test_a_metric_stands_for_its_group_and_an_unknown_name_is_refused():
    assert benchmark.groups_of(["yade_ratio", "commands"]) == ["peers", "commands"]
    assert benchmark.groups_of([]) == list(benchmark.GROUPS)
    with pytest.raises(ValueError, match=r"no metric or group 'nonsense': take one of peers, "):
        benchmark.groups_of(["nonsense"])


def test_limits_are_judged_by_their_sense():
    lines, missed = benchmark.verdicts({"yade_ratio": 13.0, "cost_spread": 1.8})
    assert missed == 1
    assert lines == [
        "required yade_ratio >= 12: 13 pass",
        "aimed yade_ratio >= 14: 13 MISS",
        "required cost_spread <= 1.3: 1.8 MISS",
    ]


def test_a_document_says_what_was_measured_missed_and_left_out():
    samples = {"lammps_ratio": [1.8, 1.9, 2.3]}
    text = "\n".join(document.blocks(benchmark.__file__, benchmark.METRICS, samples, ["- a machine"]))
    assert "| 1.9 (1.8 to 2.3) | >= 3.5 **miss** | >= 4 **miss** |" in text
    assert "| yade_ratio | speed over that of YADE | 1 | not measured | >= 12 | >= 14 |" in text


def test_the_scene_reaches_a_peer_to_the_last_bit(tmp_path, three_spheres):
    scene = damper()
    peers.write_scene(tmp_path, scene, three_spheres, steps=123, every=10)
    words = [line.split() for line in (tmp_path / "scene.in").read_text().splitlines()]
    assert all(first == "variable" and third == "index" for first, _, third, _ in words)
    assert {name: float(value) for _, name, _, value in words} == peers.scene_variables(scene, 123, 10)

    bed = np.loadtxt(tmp_path / "bed.data", skiprows=11)
    assert np.array_equal(bed[:, 4:], three_spheres.position)
    assert np.array_equal(bed[:, 2], 2 * three_spheres.radius)
    assert np.all(bed[:, 3] == scene.particle.density)


def test_a_moving_bed_is_refused(tmp_path, three_spheres):
    three_spheres.velocity[0, 2] = 0.1
    with pytest.raises(ValueError, match="start from spheres at rest"):
        peers.write_scene(tmp_path, damper(), three_spheres, steps=1)


@pytest.mark.parametrize("peer", peers.PEERS, ids=lambda peer: peer.name)
def test_every_deck_takes_every_number_of_the_scene(peer):
    """A number that a deck did not take would be its own, and could differ."""
    deck = (peers.DECKS / peer.command[-1]).read_text()
    assert "scene.in" in deck
    assert "bed.data" in deck
    code = "\n".join(line.partition("#")[0] for line in deck.splitlines())
    used = set(re.findall(r'\$\{(\w+)\}|scene\["(\w+)"\]', code))
    variables = peers.scene_variables(damper(), 123_457, 10)
    for name in variables:
        assert (name, "") in used or ("", name) in used, name
    written = {float(x) for x in re.findall(r"(?<![\w.])\d+\.?\d*(?:e[-+]?\d+)?(?!\w)", code)}
    assert not written & set(variables.values())


def test_the_results_of_a_deck_are_read(tmp_path):
    (tmp_path / "cpu.txt").write_text("1000000000 12 3\n3500000000 14 5\n")
    assert peers.read_results(tmp_path)[0] == 2.5
    assert not len(peers.read_results(tmp_path)[1])
    (tmp_path / "power.txt").write_text("# comment\n10870 0.25\n21740 0.75\n")
    assert peers.read_results(tmp_path)[1].tolist() == [0.25, 0.75]


def test_a_peer_that_is_not_installed_is_named_with_how_to_have_it(monkeypatch, capsys):
    monkeypatch.setattr(peers.shutil, "which", lambda *args, **options: None)
    assert peers.installed() == []
    said = capsys.readouterr().err
    for peer in peers.PEERS:
        assert f"{peer.name} is not installed and is left out: {peer.install}" in said


def test_the_step_divides_the_cycle_and_the_lean_sampling_too():
    assert round(1 / (FREQUENCY * DT)) == STEPS_PER_CYCLE
    assert STEPS_PER_CYCLE % peers.LEAN == 0


def test_a_larger_cavity_keeps_the_fill():
    per_particle = cavity().volume / 120
    for count in scaling.SIZES:
        assert cavity(count).volume / count == pytest.approx(per_particle, rel=1e-12)  # round-off of a cube root


@pytest.mark.parametrize("changes", [startup.SWEEP, startup.SMALL])
def test_the_configurations_of_the_benchmark_are_valid(tmp_path, changes):
    config = load(startup.changed_beam(tmp_path, changes))
    assert config.damper.particles.count == changes["damper"]["particles"]["count"]
