"""Scenes that many tests share."""

import os
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from warpdamp import Scene, State, Surface
from warpdamp.files import cache_folder
from warpdamp.scene import paper
from warpdamp.scene.paper import PMMA, RADIUS

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory):
    """Beds made by tests are made anew in each session, and are not left in the user's cache; kernels stay there."""
    patch = pytest.MonkeyPatch()
    patch.setenv("WARP_CACHE_PATH", os.environ.get("WARP_CACHE_PATH", str(cache_folder("kernels"))))
    patch.setenv("WARPDAMP_CACHE", str(tmp_path_factory.mktemp("cache")))
    yield
    patch.undo()


@pytest.fixture
def config_path():
    return ROOT / "configs" / "beam.yaml"


@pytest.fixture
def make_scene():
    """Scene of PMMA with one surface everywhere; no walls and no gravity unless asked for."""

    def make(restitution=0.52, friction=0.86, *, enclosure=None, gravity=(0, 0, 0), drive=None, material=PMMA):
        surface = Surface(restitution, friction)
        return Scene(material, material, surface, surface, enclosure, gravity, drive)

    return make


@pytest.fixture
def damper():
    """The paper's damper, shaken at a frequency and Gamma (no drive at Gamma 0)."""

    def make(frequency=46.0, gamma=0.0):
        return paper.damper(frequency, gamma)

    return make


@pytest.fixture
def loose_positions():
    """Common starting packing of the independent codes, without overlap: (120, 3) [m]."""

    def load(seed):
        return np.loadtxt(ROOT / "tests" / "data" / f"loose_bed_{seed}.txt")

    return load


@pytest.fixture
def two_spheres():
    """Two spheres about to meet head on along x at a relative speed."""

    def make(speed, radius=(RADIUS, RADIUS)):
        gap = 1e-5
        state = State.at_rest([[-radius[0] - gap / 2, 0, 0], [radius[1] + gap / 2, 0, 0]], radius)
        state.velocity[:, 0] = [speed / 2, -speed / 2]
        return state

    return make


@pytest.fixture
def write(tmp_path):
    """Writes a study's YAML to a file; returns its path."""

    def written(text):
        path = tmp_path / "study.yaml"
        path.write_text(text)
        return path

    return written


@pytest.fixture(scope="session")
def same():
    """Asserts that two results are alike bit for bit, but for the time spent."""

    def compare(one, other):
        assert set(one.variables) == set(other.variables)
        for name in set(one.variables) - {"cpu_time"}:
            xr.testing.assert_identical(one[name], other[name])

    return compare
