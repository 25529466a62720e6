"""Time and memory of modes on fine meshes.

    python scripts/benchmarks/fem.py

Prints one line ``name value`` for each metric: wall time [s], processor time [s] and peak memory [GB] of a fresh
process that has imported everything, of a beam whose section is 240 quadrilaterals and of a solid of 8,640 tetrahedra;
the solid also with particles' mass on it, the factors being there.  Asked for are 20 s and 1 GB for each.
"""

import resource
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

STEEL = (7800.0, 210e9, 0.3)


def _measured(solve: Callable) -> dict[str, float]:
    wall, cpu = time.perf_counter(), time.process_time()
    modes = solve()
    return {
        "time": time.perf_counter() - wall,
        "cpu_time": time.process_time() - cpu,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9,
        "mesh_error": float(modes.mesh_error.max()),
    }


def section(highest: int) -> dict[str, float]:
    """A beam of 580 mm with a section 20 x 4 mm of 20 x 12 quadrilaterals, a mass in its middle."""
    from skfem import MeshQuad

    from warpdamp import Material
    from warpdamp.modal.beam import Beam, PointMass, beam_modes
    from warpdamp.modal.section import MeshedSection

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "section.msh"
        MeshQuad.init_tensor(np.linspace(-0.01, 0.01, 21), np.linspace(-0.002, 0.002, 13)).save(file)
        beam = Beam(0.58, MeshedSection(file), Material(*STEEL))
        found = _measured(lambda: beam_modes(beam, PointMass(0.2, 0.29), highest=highest))
    return {f"section_{highest}_modes_{name}": value for name, value in found.items()}


def solid(highest: int) -> dict[str, float]:
    """A clamped block of 200 x 120 x 60 mm with a mass on it, 8,640 tetrahedra; then with 10 g more."""
    from skfem import MeshTet

    from warpdamp import Material
    from warpdamp.modal.solid import Clamp, MeshedSolid, StandingMass, solid_modes

    damper = StandingMass(0.05, (0.15, 0.06, 0.06), 0.02)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "block.vtk"
        sides = (np.linspace(0, side, n + 1) for side, n in ((0.2, 20), (0.12, 12), (0.06, 6)))
        MeshTet.init_tensor(*sides).save(file)
        block = MeshedSolid(file, Material(*STEEL), (Clamp(box=((0.0, 0.0), None, None)),))
        empty = _measured(lambda: solid_modes(block, damper, highest=highest))
        filled = _measured(lambda: solid_modes(block, damper.loaded(0.01), highest=highest))
    return {f"solid_{name}": value for name, value in empty.items()} | {"solid_second_mass_time": filled["time"]}


def main():
    for job, highest in ((section, 1), (section, 5), (solid, 5)):
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as fresh:
            for name, value in fresh.submit(job, highest).result().items():
                print(f"{name} {value:.4g}", flush=True)


if __name__ == "__main__":
    main()
