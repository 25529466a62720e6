"""Contacts side by side: that the compiler makes vectors of them, and that nobody can tell from the results."""

import os
import platform
import re
import subprocess
import sys

import numpy as np
import pytest

from warpdamp import Batch, Case, Effects, State
from warpdamp.kernels import lanes
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene.paper import RADIUS

COMPILE = """
from warpdamp.kernels.options import UNIQUE
UNIQUE["module_options"]["cpu_compiler_flags"] += " -Rpass=loop-vectorize"
from warpdamp.scene.effects import Effects
from warpdamp.engine.compiling import compile_kernels
from warpdamp.kernels.groups import Group, Kernels
compile_kernels(Kernels(Effects({effects}), Group.STEPS))
"""


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="the vectors are those of x86-64")
@pytest.mark.parametrize("effects", ["", "rolling=True, sizes=True, materials=True", "spheroids=True"])
def test_both_loops_over_contacts_are_vectors(effects, tmp_path):
    """The compiler says so: one loop over pairs and one over walls, eight wide, in the kernel that runs the steps."""
    (tmp_path / "compile.py").write_text(COMPILE.format(effects=effects))
    environment = os.environ | {"WARP_CACHE_PATH": str(tmp_path / "cache")}
    command = [sys.executable, str(tmp_path / "compile.py")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    remark = rf"advance\w*\.cpp:(\d+):.*vectorized loop \(vectorization width: {lanes.LANES},"
    assert len(set(re.findall(remark, done.stdout + done.stderr))) == 2


OTHER_LOADS = """
import sys
import numpy as np
from warpdamp.kernels import options
flag = " -target-feature +prefer-no-gather"
flags = options.UNIQUE["module_options"]["cpu_compiler_flags"]
options.UNIQUE["module_options"]["cpu_compiler_flags"] = flags.replace(flag, "") if flag in flags else flags + flag
from warpdamp import Batch, Case, State
from warpdamp.scene.paper import RADIUS, damper
start = np.load(sys.argv[1])
batch = Batch([Case(damper(), State.at_rest(start["position"], RADIUS), float(start["dt"]))])
batch.advance(2000)
np.save(sys.argv[2], batch.read()[0][0].velocity)
"""


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="the instruction is that of x86-64")
def test_how_the_lanes_are_loaded_is_no_part_of_the_results(damper, loose_positions, tmp_path):
    """Gathered or one by one, as ``gathers_are_fast`` says: the same bits after 2,000 steps."""
    scene, state = damper(46.0, 6.0), State.at_rest(loose_positions(1), RADIUS)
    dt = 1 / 46 / steps_per_cycle(scene, state)
    batch = Batch([Case(scene, state, dt)])
    batch.advance(2000)
    np.savez(tmp_path / "start.npz", position=state.position, dt=dt)
    (tmp_path / "run.py").write_text(OTHER_LOADS)
    command = [sys.executable, str(tmp_path / "run.py"), str(tmp_path / "start.npz"), str(tmp_path / "velocity.npy")]
    subprocess.run(command, check=True)
    assert np.array_equal(np.load(tmp_path / "velocity.npy"), batch.read()[0][0].velocity)


def test_the_last_lanes_are_filled_and_not_added(make_scene):
    """Chains of 1 to 17 touching pairs: the energy in the springs is that of so many pairs, whatever the rest of eight."""
    overlap = 1e-6
    scene = make_scene(1.0, 0.0)
    energies = []
    for pairs in range(1, 18):
        places = np.arange(pairs + 1)[:, None] * [2 * RADIUS - overlap, 0, 0]
        batch = Batch([Case(scene, State.at_rest(places, RADIUS), 1e-9)])
        batch.advance(1)
        state, ledger = batch.read()[0]
        energies.append(ledger["elastic_normal"][0])
        mean = np.abs(state.velocity.mean(axis=0)).max()
        assert mean <= 1e-15 * np.abs(state.velocity).max()  # no force was added once only
    np.testing.assert_allclose(energies, energies[0] * np.arange(1, 18), rtol=1e-8)  # an overlap is 1e-4 of a radius


def test_one_lane_moves_a_bed_as_eight_do(damper, loose_positions, monkeypatch):
    """Only the order of sums differs: 1e-9 after 600 steps, as for an effect at zero."""
    scene = damper(46.0, 6.0)
    state = State.at_rest(loose_positions(1), RADIUS)
    state.velocity[:] = np.random.default_rng(1).normal(scale=0.3, size=(120, 3))
    n = steps_per_cycle(scene, state)
    results = []
    for count in (lanes.LANES, 1):
        monkeypatch.setattr(lanes, "LANES", count)
        batch = Batch([Case(scene, state, 1 / 46 / n)], effects=Effects())
        batch.advance(600)
        results.append(batch.read()[0])
    (eight, ledger), (one, single_ledger) = results
    assert not np.array_equal(eight.velocity, one.velocity)
    np.testing.assert_allclose(one.velocity, eight.velocity, atol=1e-9 * np.abs(eight.velocity).max())
    assert single_ledger.dissipated[0] == pytest.approx(ledger.dissipated[0], rel=1e-7)


def test_notes_of_a_step_are_no_part_of_a_checkpoint(damper, loose_positions):
    scene = damper(46.0, 6.0)
    state = State.at_rest(loose_positions(1), RADIUS)
    n = steps_per_cycle(scene, state)
    case = Case(scene, state, 1 / 46 / n)
    through, halfway, again = (Batch([case], max_rows=2) for _ in range(3))
    through.advance(n)
    halfway.advance(n // 2)
    kept = halfway.checkpoint()
    assert not any("touching" in name for name in kept)
    again.restore(kept)
    again.advance(n)
    assert np.array_equal(again.cycles(0).rows, through.cycles(0).rows)
