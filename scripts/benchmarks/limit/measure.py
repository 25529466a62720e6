"""What the contact law costs in plain C on this machine: the limit that the kernels are held against.

    python scripts/benchmarks/limit/measure.py      (needs gcc or clang)

One pair at a time and eight side by side, on the touching pairs of the jammed bed of `warpdamp.study.cost.frozen`.
"""

from __future__ import annotations

import ctypes
import os
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from warpdamp.scene.contact import contact_constants
from warpdamp.scene.effects import Effects
from warpdamp.study.cost import frozen, jammed_bed

HERE = Path(__file__).parent
FLAGS = ("-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math", "-shared", "-fPIC")
ROUNDS, REPEATS = 9, 20_000


def built(width: int, folder: Path) -> ctypes.CDLL:
    """The C loop for so many pairs side by side."""
    library = folder / f"contacts{width}.so"
    compiler = os.environ.get("CC", "gcc")
    subprocess.run([compiler, *FLAGS, f"-DW={width}", str(HERE / "contacts.c"), "-lm", "-o", str(library)], check=True)
    return ctypes.CDLL(str(library))


def spent(library, scene, state, dt: float) -> float:
    """Nanoseconds per touching pair."""
    n = len(state.pairs) // 8 * 8
    first, second = (np.ascontiguousarray(state.pairs[:n, k], np.int32) for k in (0, 1))
    fields = ("x", "hv", "hs", "v", "s", "f", "t", "listed")
    particles = np.zeros(len(state), dtype=[(name, float, 3) for name in fields])
    particles["x"] = state.position
    for name, values in (("hv", state.velocity), ("v", state.velocity), ("hs", state.spin), ("s", state.spin)):
        particles[name] = values
    radius, mass = float(state.radius[0]), float(scene.masses(state)[0])
    c = contact_constants(scene.particle, scene.particle, scene.particle_contact)
    names = ("modulus", "shear_modulus", "normal_damping", "tangential_damping", "friction")
    constants = np.array([radius, radius / 2, mass / 2, *(c[name] for name in names), dt])
    a, xi = state.pair_history.radius[:n].copy(), state.pair_history.stretch[:n].copy()
    ledger = np.zeros(4)
    arrays = (first, second, particles, a, xi, constants, ledger)
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in arrays]
    times = []
    for _ in range(ROUNDS):
        started = time.process_time()
        for _ in range(REPEATS):
            library.contacts(n, *pointers)
        times.append((time.process_time() - started) / REPEATS / n * 1e9)
    assert np.isfinite(ledger).all()
    return statistics.median(times)


def main() -> None:
    """Print ns per contact in C, and what the kernels take for the same bed."""
    scene, state = jammed_bed()
    with tempfile.TemporaryDirectory() as folder:
        scalar, lanes = (spent(built(width, Path(folder)), scene, state, 1e-18) for width in (1, 8))
    bare = Effects(side=False, floor=False, lid=False, indicators=False)
    step = statistics.median(frozen([bare])[bare])
    print(f"plain_c_one_pair_ns {scalar:.1f}")
    print(f"plain_c_eight_pairs_ns {lanes:.1f}")
    print(f"touching_pairs {len(state.pairs)}")
    print(f"kernel_without_walls_ns_per_step_and_pair {step * len(state) / len(state.pairs):.1f}")


if __name__ == "__main__":
    main()
