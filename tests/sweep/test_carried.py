"""Chains of cases whose beds are carried on: their order, and what their keys depend on."""

import numpy as np
import pytest

from warpdamp import load
from warpdamp.execution.batching import batches
from warpdamp.sweep.cases import Cases
from warpdamp.sweep.plan import make_plan

BASE = """
structure: {modes_given: [{number: 1, frequency: 40 Hz, amplitude: 2}], particles_included: true}
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 16, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 330 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: [1, 3, 6], frequency: [40 Hz, 80 Hz]}
preparation: PREPARATION
seeds: [1, 2]
"""
UP, BOTH = "{carried: {path: [up]}}", "{carried: {path: [up, down]}}"


@pytest.fixture
def plan(tmp_path):
    def made(preparation, *changes, sweep=""):
        text = BASE.replace("PREPARATION", preparation) + sweep
        for old, new in changes:
            text = text.replace(old, new)
        path = tmp_path / "study.yaml"
        path.write_text(text)
        return make_plan(Cases(load(path)))

    return made


def amplitudes(plan, chain):
    """Legs and Gammas of the cases of a chain, in the order in which they run."""
    members = np.flatnonzero(plan.chain == chain)
    index = np.unravel_index(members[np.argsort(plan.turn[members])], plan.cases.shape)
    gamma = np.array(plan.cases.gammas)[index[1]]
    return [(int(leg), float(g)) for leg, g in zip(index[2], gamma, strict=True)]


def test_amplitudes_are_run_along_the_path(plan):
    both = plan(BOTH)
    assert both.cases.dims == ("frequency", "gamma", "leg", "seed")
    assert both.cases.shape == (2, 3, 2, 2)
    chains = np.unique(both.chain)
    assert len(chains) == 4  # two frequencies, two beds
    for chain in chains:
        assert amplitudes(both, chain) == [(0, 1), (0, 3), (0, 6), (1, 6), (1, 3), (1, 1)]
    down = plan("{carried: {path: [down, up]}}")
    assert amplitudes(down, down.chain[0]) == [(0, 6), (0, 3), (0, 1), (1, 1), (1, 3), (1, 6)]


def test_batches_keep_the_order_of_the_path(plan):
    both = plan(BOTH)
    chains = [chain for batch in batches(both, both.to_run(), 1) for chain in batch]
    assert sorted(map(len, chains)) == [6] * 4
    assert all((both.turn[chain] == np.arange(6)).all() for chain in chains)


def test_keys_hold_the_amplitudes_before(plan):
    """A leg that is added changes nothing before it; an amplitude that is added changes all that follows."""
    word, up, both = (plan(how).keys for how in ("carried", UP, BOTH))
    legs = both.reshape(2, 3, 2, 2)
    np.testing.assert_array_equal(word, up)
    np.testing.assert_array_equal(legs[:, :, 0].ravel(), up)
    assert len(set(both)) == both.size
    more = plan(BOTH, ("[1, 3, 6]", "[1, 3, 6, 8]")).keys.reshape(2, 4, 2, 2)
    np.testing.assert_array_equal(more[:, :3, 0], legs[:, :, 0])
    assert not set(more[:, :, 1].ravel()) & set(legs[:, :, 1].ravel())


def test_points_that_differ_in_the_structure_only_have_the_same_chains(plan):
    """The damper does not know the structure: an amplitude occurs once in a chain, whatever else is swept."""
    sweep = "sweep: {product: {structure.modes_given.0.amplitude: [2, 3]}}\n"
    for how in ("carried", BOTH):
        swept, alone = plan(how, sweep=sweep), plan(how)
        assert swept.turn.max() == alone.turn.max()
        assert set(swept.keys) == set(alone.keys)


def test_chains_of_one_batch_are_equally_long(plan):
    """They are run side by side, amplitude by amplitude."""
    short = plan(BOTH, sweep="sweep: {exclude: [{gamma: 6, seed: 2}]}\n")
    made = list(batches(short, short.to_run(), 1))
    assert sorted(len(chain) for batch in made for chain in batch) == [4, 4, 6, 6]
    assert all(len({len(chain) for chain in batch}) == 1 for batch in made)
