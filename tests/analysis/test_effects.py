"""Effects of factors against made-up curves whose effects are known: their size, their errors, and the verdicts."""

import math

import numpy as np
import pytest
import xarray as xr

from warpdamp.accessor import Damper
from warpdamp.analysis.effects import RESPONSES, Fit, Verdict, decide, effect_of, holm
from warpdamp.analysis.optimum import collision_optimum
from warpdamp.errors import UsageError

GAMMA = np.array([1, 1.5, 2, 2.5, 3, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5, 10, 12])
FREQUENCY, CLEARANCE = 40.0, 2.9e-3  # the block's optimum of collision lies at 7.0


def made(rng, levels, *, place=0.0, height=0.0, bump=0.0, noise=0.01, packings=6, own=0.05):
    """A study whose collision optimum is displaced by ``2^place`` and raised by ``2^height`` a doubling.

    Packings differ by ``own`` in the place of their optimum, at every level alike; ``bump`` raises the middle level.
    """
    levels = np.asarray(levels, float)
    doublings = np.log2(np.where(levels > 0, levels, 1) / levels[levels > 0][0])
    shift = own * rng.standard_normal(packings)
    x = GAMMA[:, None, None]
    high = 7.0 * 2 ** (place * doublings)[:, None] * (1 + shift)
    top = 0.65 * 2 ** (height * doublings)[:, None] * (1 + bump * (np.arange(len(levels)) == len(levels) // 2))[:, None]
    eps = 0.45 * np.exp(-(((x - 2.4) / 1.1) ** 2)) + top * np.exp(-(((x - high) / 2.4) ** 2))
    eps = eps * (1 + noise * rng.standard_normal(eps.shape))
    dims = ("gamma", "friction", "seed")
    about = {"configuration_key": "contact.friction", "units": "1"}
    return xr.Dataset(
        {
            "effectiveness": (dims, eps),
            "effectiveness_standard_error": (dims, np.full(eps.shape, 0.006)),
            "clearance": (dims, np.full(eps.shape, CLEARANCE)),
            "status": (dims, np.zeros(eps.shape, int)),
            "excitation_frequency": ((), FREQUENCY),
        },
        {"gamma": GAMMA, "friction": ("friction", levels, about), "seed": np.arange(packings)},
    )


def test_the_block_is_where_the_made_up_optimum_is():
    assert float(collision_optimum(FREQUENCY, CLEARANCE)) == pytest.approx(7.0, abs=0.03)


def test_effects_are_what_they_are_within_their_intervals():
    """Of 12 studies: 95 % intervals hold the truth in at least 9 (fewer come once in 500); pulls have no bias."""
    rng = np.random.default_rng(0)
    inside, pulls = {"gamma_collision": 0, "effectiveness_collision": 0}, []
    for _ in range(12):
        found = effect_of(made(rng, [1, 2, 4], place=0.1, height=-0.08), "contact.friction")
        assert found.attrs["per"] == "doubling"
        for name, truth in (("gamma_collision", 0.1), ("effectiveness_collision", -0.08)):
            at = found.sel(response=name)
            inside[name] += bool(at["effect_low"] <= 2**truth - 1 <= at["effect_high"])
            pulls.append(float((at["exponent"] - truth) / at["exponent_standard_error"]))
            if abs(at["exponent"]) >= 3 * at["exponent_standard_error"]:
                assert at["verdict"] == ("higher" if truth > 0 else "lower")
    assert min(inside.values()) >= 9, inside
    assert abs(np.median(pulls)) < 0.8


def test_what_has_no_effect_is_seldom_called_one():
    """Of 12 studies of nothing at most 2 of each response are called higher or lower: 3 errors of 5 degrees are 3 %."""
    rng = np.random.default_rng(1)
    verdicts = [effect_of(made(rng, [1, 2, 4]), "friction")["verdict"] for _ in range(12)]
    for name in RESPONSES[2:]:
        called = [str(v.sel(response=name).item()) for v in verdicts]
        assert sum(v in ("higher", "lower") for v in called) <= 2
        assert called.count("not affected") >= 8, called


def test_pairing_takes_out_what_packings_have_in_common():
    """Packings differ by 10 % in the place of their optimum, alike at every level: paired errors do not see it."""
    found = effect_of(made(np.random.default_rng(2), [1, 2, 4], place=0.1, own=0.1), "friction")
    at = found.sel(response="gamma_collision")
    assert at["paired_standard_error"] < 0.5 * at["unpaired_standard_error"]
    assert at["verdict"] == "higher"
    assert float(at["level"].sel(friction=4) / at["level"].sel(friction=1)) == pytest.approx(2**0.2, rel=0.03)


def test_a_bump_is_not_monotonic_and_a_level_without_an_optimum_is_left_out():
    rng = np.random.default_rng(3)
    found = effect_of(made(rng, [1, 2, 4], bump=0.3, noise=0.005), "friction").sel(response="effectiveness_collision")
    assert found["verdict"] == "not monotonic"
    assert found["p_straight"] < 0.01
    flat = made(rng, [0.5, 1, 2, 4], place=0.1)
    flat["effectiveness"][:, 0] = 0.3 - 0.01 * flat["gamma"]
    found = effect_of(flat, "friction")
    assert np.isnan(found["level"].sel(response="gamma_collision", friction=0.5))
    assert found["verdict"].sel(response="gamma_collision") == "higher"
    flat["effectiveness"][:] = 0.3 - 0.01 * flat["gamma"]
    assert set(effect_of(flat, "friction")["verdict"].values) == {"does not exist"}


def test_the_curve_away_from_the_optima_and_a_step():
    data = made(np.random.default_rng(4), [1, 2, 4], noise=0.0)
    data["effectiveness"] = data["effectiveness"] * data["friction"] ** 0.2
    found = effect_of(data, "friction")
    np.testing.assert_allclose(found["curve_effect"].dropna("gamma"), 2**0.2 - 1, rtol=1e-9)
    stepped = effect_of(data, "friction", step=1.5)
    assert stepped.attrs["per"] == "step of 1.5"
    rise = stepped["effect"].sel(response="effectiveness_collision")
    assert 1.1 < 1 + float(rise) < 1.2  # a rise of 32 % over 3 is some 15 % over 1.5
    zero = effect_of(made(np.random.default_rng(5), [0, 1, 2]), "friction")
    assert zero.attrs["per"] == "step of 2"
    assert "exponent" not in zero


def test_levels_with_fewer_packings_count_as_far_as_they_go():
    data = made(np.random.default_rng(6), [1, 2, 4], place=0.1)
    data["effectiveness"][:, 2, 3:] = np.nan
    data["status"][:, 2, 3:] = -1
    found = effect_of(data, "friction").sel(response="gamma_collision")
    assert found["verdict"] == "higher"
    assert float(found["exponent"]) == pytest.approx(0.1, abs=0.05)


def fit(slope, error):
    return Fit(slope, error, error, 0.5, 1.0, 1.0, False, 7, 2.0)


@pytest.mark.parametrize(
    ("slope", "error", "verdict"),
    [
        (0.1, 0.02, Verdict.HIGHER), (-0.1, 0.02, Verdict.LOWER), (0.0, 0.005, Verdict.NOT_AFFECTED),
        (0.02, 0.02, Verdict.UNDECIDED),
    ],
)  # fmt: skip
def test_a_verdict_and_what_would_decide_it(slope, error, verdict):
    found, needed = decide(fit(slope, error), 2.36 * error)
    assert found == verdict
    assert math.isfinite(needed) == (verdict == Verdict.UNDECIDED)
    if verdict == Verdict.UNDECIDED:  # nine times the packings make three errors of one; none would make it unaffected
        assert 60 <= needed <= 72


def test_holm():
    np.testing.assert_allclose(holm([0.01, 0.04, np.nan, 0.03]), [0.03, 0.06, np.nan, 0.06])
    assert holm([0.9, 0.8]).max() == 1.0


def test_factors_that_are_none_are_named():
    data = made(np.random.default_rng(7), [1, 2])
    with pytest.raises(
        UsageError, match=r"'fraction' is not one factor of these results: take one of contact.friction"
    ):
        Damper(data).effect_of("fraction")
    with pytest.raises(UsageError, match="two levels and three packings, got 2 and 2"):
        effect_of(data.isel(seed=[0, 1]), "friction")
