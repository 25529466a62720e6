"""Studies of beds brought to a state, and carried along a path of amplitudes."""

import numpy as np
import pytest
import xarray as xr

import warpdamp
from conftest import ROOT
from warpdamp import ConfigError
from warpdamp.analysis.results import write
from warpdamp.damper.case import REACHED
from warpdamp.report.curves import draw
from warpdamp.study.accuracy import points_of
from warpdamp.study.explain import explain

SMALL = {
    "enclosure: {diameter: 40 mm, height: 40 mm": "enclosure: {diameter: 20 mm, height: 25 mm",
    "count: 120": "count: 14",
    "youngs_modulus: 3.3 GPa": "youngs_modulus: 33 MPa",
    "gamma: [1, 2, 3, 4, 5, 6, 8, 10]": "gamma: [1, 3, 6]",
    "seeds: [1, 2, 3, 4]": "seeds: [1]\nsteady_state: {fewest_cycles: 8, most_cycles: 8}",
}
"""Fewer particles and amplitudes of configs/hysteresis.yaml."""


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The example with a small damper, and a preparation of its own if one is named."""

    def write_study(preparation=None):
        text = (ROOT / "configs" / "hysteresis.yaml").read_text()
        changes = SMALL | ({"{carried: {path: [up, down, up]}}": preparation} if preparation else {})
        for old, new in changes.items():
            assert old in text
            text = text.replace(old, new)
        path = tmp_path_factory.mktemp("study") / "study.yaml"
        path.write_text(text)
        return path

    return write_study


def test_the_example_of_hysteresis_runs_each_amplitude_from_the_bed_before(written, tmp_path):
    path = written()
    dataset = warpdamp.run(path, executor="in-process")
    assert dataset["effectiveness"].dims == ("frequency", "gamma", "leg", "seed")
    assert list(dataset["leg_direction"].values) == ["up", "down", "up"]
    ways = [dataset.isel(frequency=0, seed=0).sel(leg=leg) for leg in (1, 2, 3)]
    before, after, effectiveness = (
        np.concatenate([ways[0][name], ways[1][name][::-1], ways[2][name]])
        for name in ("clearance", "clearance_after", "effectiveness")
    )
    np.testing.assert_array_equal(before[1:], after[:-1])
    assert len(np.unique(effectiveness)) == 9
    write(dataset, tmp_path / "legs.nc")
    assert list(xr.load_dataset(tmp_path / "legs.nc")["leg_direction"].values) == ["up", "down", "up"]
    assert len(draw(dataset).axes) >= 1
    assert "1 carried bed, each through all amplitudes up, then down, then up" in explain(warpdamp.load(path))


def test_the_state_asked_for_is_swept_like_any_scalar(written):
    """Beds have it to 0.05 mm; what cannot be reached is a case that failed, with what can be had."""
    swept = warpdamp.run(written("{clearance: [2 mm, 2.6 mm, 9 mm]}"), executor="in-process")
    asked = swept["preparation_clearance"]
    assert asked.dims == ("preparation_clearance",)
    assert asked.attrs["units"] == "m"
    assert swept["preparation"].item() == "given clearance"
    reached = swept["clearance"].isel(gamma=0, seed=0, frequency=0)
    np.testing.assert_allclose(reached[:2], [2e-3, 2.6e-3], atol=REACHED)
    assert np.isnan(reached[2])
    messages = np.unique(swept["message"].isel(preparation_clearance=2))
    assert len(messages) == 1
    assert "a clearance of 9.00 mm cannot be reached: this bed has " in messages[0]


@pytest.mark.parametrize("preparation", ["carried", "{clearance: 2 mm}"])
def test_a_study_of_accuracy_prepares_beds_itself(written, preparation):
    with pytest.raises(
        ConfigError, match=r"study.yaml:18:1: preparation: is '.*', and a study of accuracy takes loose"
    ):
        points_of(warpdamp.load(written(preparation)))


def test_a_state_that_cannot_be_reached_is_refused_at_its_key(written):
    path = written("{packing_fraction: 0.7}")
    with pytest.raises(ConfigError) as refused:
        warpdamp.run(path, executor="in-process")
    place, _, said = str(refused.value).removeprefix(f"{path}:").partition(": ")
    assert place.endswith(":15")
    assert said.startswith(
        "preparation.packing_fraction: a packing fraction of 0.700 cannot be reached: this bed has 0."
    )
