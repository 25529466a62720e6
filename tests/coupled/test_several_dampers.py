"""Coupled runs of several dampers on one structure: closed forms, limits, and one ledger over all."""

import math
import re

import numpy as np
import pytest
from typer.testing import CliRunner

from conftest import ROOT
from warpdamp import Batch, Case, ConfigError, Cylinder, State, load, run
from warpdamp.analysis.results import read
from warpdamp.cli.app import app
from warpdamp.coupled.identify import from_decay
from warpdamp.coupled.prediction import mode_with_dampers
from warpdamp.coupled.run import own_seed, planned, simulate
from warpdamp.errors import UsageError
from warpdamp.execution.executors import InProcess
from warpdamp.modal.apparent_mass import ComplexMass
from warpdamp.modal.card import card, read_card, write_card
from warpdamp.scene.host import BaseMotion, Force, HostStructure
from warpdamp.scene.paper import RADIUS
from warpdamp.study.explain import explain

GRAVITY = (0.0, 0.0, -9.81)


@pytest.fixture
def cavity(make_scene):
    return make_scene(enclosure=Cylinder(0.04, 0.04), gravity=GRAVITY)


def bed(scene, positions, count):
    from warpdamp.damper.settling import settle

    return settle(scene, State.at_rest(positions[:count], RADIUS))


def on_one(scene, beds, amplitudes, dt, steps, *, records=0, rows=1, **host):
    """Batch of cavities on one structure, after its run, and its ledgers at start and end."""
    cases = [
        Case(scene.on_host(HostStructure(amplitude=phi, **host)), state, dt)
        for state, phi in zip(beds, amplitudes, strict=True)
    ]
    batch = Batch(cases, max_records=records, max_rows=rows, enclosures=[len(cases)])
    start = [ledger for _, ledger in batch.read()]
    batch.advance(steps)
    return batch, start, [ledger for _, ledger in batch.read()]


def unaccounted(start, end):
    """What the structure and all cavities together have too much, over all that was lost."""
    balance = lost = 0.0
    for before, after in zip(start, end, strict=True):
        rows = type(after)(np.concatenate([before.rows, after.rows]), after.effects)
        balance += rows.coupled_residual[-1]
        lost += np.diff(rows.dissipated)[0] + rows.change("structure_loss")
    return abs(balance) / lost


@pytest.mark.parametrize("motion", ["force", "base"])
def test_two_like_dampers_are_one_on_half_the_mass(cavity, loose_positions, motion):
    """q'' + ... = 2 phi R is p'' + ... = (sqrt(2) phi) R of p = q / sqrt(2): to rounding, until the bed is chaotic.

    A force is then halved; participation and starting velocity are divided by sqrt(2).
    """
    state = bed(cavity, loose_positions(1), 20)
    n = 8000
    mode = {"frequency": (40.0,), "damping": (0.01,), "record": 50}
    starts = [{"velocity": (-0.4 / share,)} for share in (1, math.sqrt(2))]
    moves = {
        "force": ({"force": Force(1.2, 40.0)}, {"force": Force(0.6, 40.0)}),
        "base": (
            {"base": BaseMotion(20.0, 40.0), "participation": (0.6,)},
            {"base": BaseMotion(20.0, 40.0), "participation": (0.6 / math.sqrt(2),)},
        ),
    }[motion]
    options = {"dt": 1 / 40 / n, "steps": n, "records": n // 50, "rows": 2}
    two, *_ = on_one(cavity, [state, state], [(1.2,), (1.2,)], **options, **mode, **starts[0], **moves[0])
    one, *_ = on_one(cavity, [state], [(1.2 * math.sqrt(2),)], **options, **mode, **starts[1], **moves[1])
    assert np.array_equal(two.records(0), two.records(1))
    assert np.array_equal(two.cycles(0)["elastic_normal"], two.cycles(1)["elastic_normal"])
    scale = np.abs(one.records(0)).max(axis=0)
    weight = 9.81 * float(cavity.masses(state).sum())
    assert np.abs(one.records(0)[:, 3]).max() > 5 * weight  # pressed to the floor at first
    assert one.records(0)[-40:, 3].max() == 0.0  # and then in the air
    np.testing.assert_allclose(two.records(0) / scale, one.records(0) / scale, atol=1e-9)


def test_particles_that_move_along_weigh_where_they_are(cavity, loose_positions):
    """Beds at rest, shaken well below Gamma 1: w_n = w0 / sqrt(1 + sum_c phi_c^2 m_c), whatever the sign of phi_c."""
    beds = [bed(cavity, loose_positions(seed), 120) for seed in (1, 2)]
    masses = [float(cavity.masses(state).sum()) for state in beds]
    phi = (1.7, -0.9)
    w = 2 * math.pi * 40
    sag = -9.81 * sum(p * m for p, m in zip(phi, masses, strict=True)) / w**2
    batch, *_ = on_one(
        cavity, beds, [(p,) for p in phi], 2.5e-6, 80_000, records=2000,
        frequency=(40.0,), damping=(0.002,), position=(sag + 0.05 * 9.81 / w**2 / 1.7,), record=40,
    )  # fmt: skip
    swings = from_decay(batch.records(0))
    expected = 40 / math.sqrt(1 + sum(p**2 * m for p, m in zip(phi, masses, strict=True)))
    assert np.mean([s.frequency for s in swings]) == pytest.approx(expected, rel=2e-4)
    np.testing.assert_allclose(batch.records(1)[:, 1], batch.records(0)[:, 1] * phi[1] / phi[0], rtol=1e-12)


def test_one_ledger_over_all(cavity, loose_positions):
    """Work of the force = losses of all + gain of all, within half a percent of what was lost; structure counted once."""
    beds = [bed(cavity, loose_positions(1), 60), bed(cavity, loose_positions(2), 30)]
    n = 12_000
    _, start, end = on_one(
        cavity, beds, [(1.7, 0.5), (-1.1, 0.8)], 1 / 40 / n, 4 * n,
        frequency=(41.0, 90.0), damping=(0.003, 0.003), force=Force(4.0, 40.0), velocity=(0.2, 0.1),
    )  # fmt: skip
    assert unaccounted(start, end) < 5e-3
    for ledger in end:
        assert ledger.dissipated[-1] > 0
    for name in ("force_work", "structure_loss", "structure_energy"):
        assert end[1][name][-1] == 0
        assert end[0][name][-1] != 0


def test_energies_close_on_a_base_that_moves(cavity, loose_positions):
    beds = [bed(cavity, loose_positions(1), 40), bed(cavity, loose_positions(2), 30)]
    n = 12_000
    _, start, end = on_one(
        cavity, beds, [(1.7,), (2.5,)], 1 / 40 / n, 3 * n,
        frequency=(41.0,), damping=(0.003,), base=BaseMotion(25.0, 40.0), participation=(0.5,),
    )  # fmt: skip
    assert unaccounted(start, end) < 5e-3


def test_the_order_of_the_dampers_is_only_a_name(cavity, loose_positions):
    """Exchanged: the same to rounding before the bed is chaotic; a second run: the same bits, read or not."""
    beds = [bed(cavity, loose_positions(1), 20), bed(cavity, loose_positions(2), 12)]
    phi = [(1.7, 0.4), (-0.8, 1.1)]
    mode = {"frequency": (40.0, 95.0), "damping": (0.01, 0.01), "velocity": (0.3, 0.1), "record": 20}
    straight, *_ = on_one(cavity, beds, phi, 5e-6, 4000, records=200, **mode)
    turned, *_ = on_one(cavity, beds[::-1], phi[::-1], 5e-6, 4000, records=200, **mode)
    for k in (0, 1):
        scale = np.abs(straight.records(k)).max(axis=0)
        np.testing.assert_allclose(straight.records(k) / scale, turned.records(1 - k) / scale, atol=1e-9)
    again = Batch(straight.cases, max_records=200, enclosures=[2], skin=0.4)
    for steps in (7, 1500, 4000):
        again.advance(steps)
        again.read()
    assert np.array_equal(again.records(1), straight.records(1))


def test_a_batch_of_structures_gives_the_bits_of_each_alone(cavity, loose_positions):
    beds = [bed(cavity, loose_positions(seed), 12) for seed in (1, 2, 3)]
    mode = {"frequency": (40.0,), "damping": (0.01,), "velocity": (0.3,), "record": 20}
    cases = [
        Case(cavity.on_host(HostStructure(amplitude=(phi,), **mode)), state, 5e-6)
        for state, phi in zip(beds, (1.7, 0.9, 1.2), strict=True)
    ]
    together = Batch(cases, max_records=100, enclosures=[2, 1])
    together.advance(2000)
    pair = Batch(cases[:2], max_records=100, enclosures=[2])
    pair.advance(2000)
    for k in (0, 1):
        assert np.array_equal(together.records(k), pair.records(k))


def test_what_cannot_share_a_structure_is_refused(cavity):
    ball = State.at_rest([[0, 0, 0.02]], RADIUS)
    host = HostStructure((40.0,), (0.01,), (1.7,))
    other = HostStructure((41.0,), (0.01,), (1.7,))
    with pytest.raises(ValueError, match="differ in frequency"):
        Batch([Case(cavity.on_host(h), ball, 1e-5) for h in (host, other)], enclosures=[2])
    with pytest.raises(ValueError, match="differ in dt"):
        Batch([Case(cavity.on_host(host), ball, dt) for dt in (1e-5, 2e-5)], enclosures=[2])
    with pytest.raises(ValueError, match="are not 1 cases"):
        Batch([Case(cavity.on_host(host), ball, 1e-5)], enclosures=[2])
    with pytest.raises(ValueError, match="without a host structure"):
        Batch([Case(s, ball, 1e-5) for s in (cavity.on_host(host), cavity)], enclosures=[2])


TWO = """
structure:
  modes_given: [{frequency: 40 Hz, modal_mass: 40 kg, damping: 1 %}]
  particles_included: false
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 8, radius: 3.73 mm, material: pmma}
dampers:
  - enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
    particles: {count: 4, radius: 3.73 mm, material: pmma}
    amplitude: [PHI kg^-0.5]
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: 1}
preparation: loose
"""


def test_a_damper_on_a_node_changes_nothing(write):
    """The first one's motion and losses are those of a run without it; it takes nothing itself, and its particles rest."""
    coupled = "coupled: {duration: 0.5 s, release: {gamma: 2, mode: 1}}\n"
    both = simulate(load(write(TWO.replace("PHI", "0") + coupled)), InProcess()).isel(level=0, seed=0)
    single = TWO[: TWO.index("dampers:")] + TWO[TWO.index("materials:") :]
    alone = simulate(load(write(single + coupled)), InProcess()).isel(level=0, seed=0)
    assert both.sizes["damper"] == 2
    start = slice(0, 60)  # the loops are compiled apart: rounding differs
    for name in ("structure_displacement", "structure_acceleration", "reaction"):
        scale = float(np.abs(alone[name]).max())
        found = both[name].sel(damper=1).isel(time=start)
        np.testing.assert_allclose(found, alone[name].isel(time=start), atol=1e-8 * scale)
    np.testing.assert_allclose(both["window_frequency"], alone["window_frequency"], rtol=1e-4)
    assert float(both["particle_loss"].sel(damper=1)) == pytest.approx(float(alone["particle_loss"]), rel=0.1)
    assert float(both["particle_loss"].sel(damper=2)) < 1e-2 * float(both["particle_loss"].sel(damper=1))
    assert float(both["closure"]) < 5e-3


def test_beds_of_a_run_are_independent_and_follow_from_its_seed(write):
    coupled = "coupled: {duration: 0.5 s, release: {gamma: 2, mode: 1}}\nseeds: [1, 2]\n"
    runs, _ = planned(load(write(TWO.replace("PHI", "0.1") + coupled)))
    seeds = [[bed.seed for bed in runs[0, j].beds] for j in (0, 1)]
    assert [one[0] for one in seeds] == [1, 2]
    assert len({seed for one in seeds for seed in one}) == 4
    assert own_seed(1, 1) == seeds[0][1]


def test_shapes_keep_their_signs_among_each_other(write):
    """Two modes, in the second of which the further damper moves the other way."""
    text = TWO.replace("damping: 1 %}]", "damping: 1 %}, {frequency: 95 Hz, modal_mass: 20 kg}]")
    text = text.replace("[PHI kg^-0.5]", "[0.2 kg^-0.5, -0.1 kg^-0.5]")
    runs, _ = planned(load(write(text + "coupled: {duration: 0.5 s, release: {gamma: 2, mode: 1}}\n")))
    first, second = (scene.host.amplitude for scene in runs[0, 0].scenes)
    assert first == pytest.approx((40**-0.5, 20**-0.5))
    assert second == pytest.approx((0.2, -0.1))


def test_dampers_whose_walls_differ_are_refused(write):
    text = TWO.replace("PHI", "0.1").replace(
        "height: 20 mm, material: pmma}\n    particles", "height: 20 mm, material: pmma, lid: false}\n    particles"
    )
    with pytest.raises(ConfigError, match=r"dampers.0.enclosure.lid: in a coupled run either all dampers have"):
        simulate(load(write(text + "coupled: {duration: 0.5 s, release: {gamma: 2, mode: 1}}\n")), InProcess())


def test_the_example_of_two_dampers_runs_coupled(tmp_path):
    """Shortened: energies of each damper in the file, both along the beam's modes, and the command says who took what."""
    text = (ROOT / "configs" / "two_dampers.yaml").read_text()
    text = text.replace("duration: 1 s", "duration: 60 ms").replace("seeds: [1, 2]", "seeds: [1]\npreparation: loose")
    text = text.replace("3.3 GPa", "33 MPa").replace("count: 120", "count: 30").replace("count: 40", "count: 12")
    (tmp_path / "two.yaml").write_text(text)
    done = CliRunner().invoke(app, ["coupled", str(tmp_path / "two.yaml"), "-o", str(tmp_path), "--workers", "1"])
    assert done.exit_code == 0, done.output
    assert "% (dampers 1 to 2) of the energy lost" in done.output
    runs = read(tmp_path / "two-coupled.nc", coupled=True).isel(level=0, seed=0)
    assert (runs["particle_loss"] > 0).all()
    assert float(runs["closure"]) < 5e-3
    first, second = runs["structure_displacement"]
    # mode 1 at a quarter of the length over its middle: from 0.5, all mass there, x^2 (3 L - 4 x), to 0.54, none
    assert 0.5 < float(second[0] / first[0]) < 0.54
    text = (tmp_path / "two.yaml").read_text()
    assert "runs: 1 (levels 1, seeds 1) of 0.06 s by release, 2 dampers each" in explain(load(tmp_path / "two.yaml"))


def test_a_prediction_is_stored_and_said_beside_what_was_read(write, tmp_path):
    """`coupled --card`: at every stretch's Gamma, as the mode with both dampers' masses has it; NaN beyond the card."""
    single = TWO[: TWO.index("dampers:")] + TWO[TWO.index("materials:") :]
    cases = "seeds: [1, 2]\nsteady_state: {fewest_cycles: 8, most_cycles: 8}\n"
    part = card(run(load(write(single.replace("gamma: 1", "gamma: [0.5, 1, 1.5]") + cases)), executor="in-process"))
    write_card(part, tmp_path / "part.csv")
    file = write(TWO.replace("PHI", "0.1") + "coupled: {duration: 0.5 s, release: {gamma: 2, mode: 1}}\n")
    command = ["coupled", str(file), "-o", str(tmp_path), "--workers", "1", "--card", str(tmp_path / "part.csv")]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    runs = read(tmp_path / "study-coupled.nc", coupled=True)
    gamma, found = runs["window_gamma"].values, runs["predicted_damping_ratio"].values
    felt = ComplexMass.of(part)
    # the second damper moves 0.1 sqrt(40) = 0.632 times as much as the first, which its card does not know below 0.5
    known = (gamma * 0.1 * math.sqrt(40) >= 0.5) & (gamma <= 1.5)
    assert known.any()
    assert not known.all()
    assert np.array_equal(np.isfinite(found), known)
    masses = [felt(40.0, gamma[known] * share) for share in (1, 0.1 * math.sqrt(40))]
    loaded = (1 + 0.02j) / (1 + masses[0] / 40 + 0.01 * masses[1])
    np.testing.assert_allclose(found[known], loaded.imag / loaded.real / 2, rtol=1e-6)
    np.testing.assert_allclose(runs["predicted_frequency"].values[known], 40 * np.sqrt(loaded.real), rtol=1e-9)
    said = [line for line in done.output.splitlines() if "predicted" in line]
    assert len(said) == 1
    assert re.match(r"level 1: at Gamma \S+ to \S+ damping \S+ %, predicted \S+ %; \S+ Hz, predicted \S+ Hz", said[0])
    assert "damper 2: the card is of another damper than the study describes: particles.count 8" in done.output


@pytest.mark.parametrize(
    ("old", "new", "cards", "message"),
    [
        ("damping: 1 %}]", "damping: 1 %}, {frequency: 95 Hz, modal_mass: 20 kg}]", 1, "here are 2 and release"),
        ("release: {gamma: 2, mode: 1}", "random: {rms: 1 N, from: 20 Hz, to: 80 Hz}", 1, "here are 1 and random"),
        ("", "", 3, "the structure carries 2 dampers, and the cards are 3"),
    ],
)
def test_where_nothing_is_read_nothing_is_predicted(write, old, new, cards, message):
    """Refused before anything runs."""
    text = (TWO.replace("PHI", "0.1") + "coupled: {duration: 0.5 s, release: {gamma: 2, mode: 1}}\n").replace(old, new)
    text = text.replace("[0.1 kg^-0.5]", "[0.1 kg^-0.5, 0]") if "95 Hz" in text else text
    with pytest.raises(UsageError, match=message):
        mode_with_dampers(load(write(text)), [read_card(ROOT / "docs" / "beam.nc")] * cards)
