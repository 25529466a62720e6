"""Another device: the same kernels, compiled for it; what this machine lacks is refused by name."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from warpdamp import Effects, Grains, PackingError, Request, State, prepare
from warpdamp.engine import device
from warpdamp.engine.batch import Batch, Case
from warpdamp.kernels.advance import stepper
from warpdamp.kernels.lanes import lanes_for
from warpdamp.kernels.neighbours import neighbour_search
from warpdamp.numerics.timestep import Numerics
from warpdamp.scene.paper import RADIUS

HOPPER = 90
"""Compute capability 9.0, sm_90."""

SETS = {
    "paper": Effects(),
    "everything": Effects(rolling=True, sizes=True, materials=True, structure=True),
    "float32": Effects(precision="float32"),
}


@pytest.mark.parametrize("name", SETS)
def test_the_kernels_compile_for_sm_90(name, tmp_path):
    """Ahead of time, which needs no such device: an ELF file for a CUDA device each."""
    if wp.get_cuda_toolkit_version() is None:
        pytest.skip("this build of Warp has no compiler for CUDA")
    effects = replace(SETS[name], device="cuda")
    kernels = [*stepper(effects, lanes_for(effects)), *neighbour_search(effects)]
    for kernel in kernels:
        (file,) = wp.compile_aot_module(kernel.module, arch=HOPPER, use_ptx=False, module_dir=tmp_path / kernel.key)
        assert file.read_bytes()[:4] == b"\x7fELF"
        assert f"sm{HOPPER}" in file.name


def test_threads_of_another_device_are_lanes_themselves():
    assert lanes_for(Effects(device="cuda")) == 1 < lanes_for(Effects())


def test_a_device_that_is_not_there_is_refused_by_name(damper, monkeypatch):
    monkeypatch.setattr(wp, "is_cuda_available", lambda: False)
    request = Request(damper(46.0, 6.0), Grains.alike(RADIUS, 3), 1, numerics=Numerics(device="cuda"))
    with pytest.raises(PackingError, match="there is no cuda device here: take cpu") as caught:
        prepare(request)
    assert caught.value.key == "numerics.device"


@pytest.mark.skipif("cuda" not in device.present(), reason="needs a CUDA device")
def test_a_bed_moves_as_on_the_processor(damper, loose_positions):
    """Six hundred steps: other round-off, 1e-9 as for an effect at zero (see test_lanes)."""
    scene, state = damper(46.0, 6.0), State.at_rest(loose_positions(1), RADIUS)
    state.velocity[:] = np.random.default_rng(1).normal(scale=0.3, size=(120, 3))
    ends = []
    for where in ("cpu", "cuda"):
        batch = Batch([Case(scene, state, 2e-6)], effects=Effects(device=where))
        batch.advance(600)
        ends.append(batch.read()[0][0].velocity)
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-9 * np.abs(ends[0]).max())
