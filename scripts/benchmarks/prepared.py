"""LAMMPS from warpdamp's own compacted beds, over the amplitudes of mode 1; writes docs/two_optima_lammps.nc.

    python scripts/benchmarks/prepared.py

The packings 1 and 2 of scripts/documents/two_optima.py, which draws this curve beside its own.  A quarter of an hour on
one core; may be stopped and started again: docs/two_optima_lammps.nc keeps what is done.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np
import xarray as xr
from documents.shared import DOCS

from benchmarks.peers import PEERS, run_peer, version
from warpdamp import Drive, Grains, Request, State, prepare
from warpdamp.analysis.results import write
from warpdamp.engine.ledger import maximum_energy
from warpdamp.scene.paper import COUNT, RADIUS, damper
from warpdamp.scene.scene import STANDARD_GRAVITY

RUNS = DOCS / "two_optima_lammps.nc"
FREQUENCY, GAMMAS, SEEDS = 39.5, (3, 6, 4, 8, 5, 10, 2, 7), (1, 2)
CYCLE, EVERY, CYCLES, DISCARDED = 9000, 10, 60, 20
"""Steps of a cycle, and from one sample of the power to the next; cycles, and those left out at the start."""


def effectiveness(gamma: float, seed: int) -> float:
    """Power put in over that of the ideal impact damper, from a compacted bed without its contacts' memory."""
    rest = damper(gamma=0)
    bed = prepare(Request(rest, Grains.alike(RADIUS, COUNT), seed))
    scene = rest.driven(Drive(FREQUENCY, gamma * STANDARD_GRAVITY))
    state = State.at_rest(bed.state.position, RADIUS)
    _, power = run_peer(PEERS[0], scene, state, CYCLES * CYCLE, EVERY, CYCLE)
    ideal = maximum_energy(scene.drive, COUNT * float(scene.mass(RADIUS))) * FREQUENCY
    return float(np.mean(power[DISCARDED:])) / ideal


def main() -> None:
    """Run what is not there yet."""
    done = xr.load_dataset(RUNS)["effectiveness"].to_series().dropna().to_dict() if RUNS.exists() else {}
    for gamma in GAMMAS:
        for seed in SEEDS:
            if (float(gamma), seed) in done:
                continue
            done[float(gamma), seed] = effectiveness(gamma, seed)
            print(f"Gamma {gamma}, packing {seed}: {done[float(gamma), seed]:.3f}", flush=True)
            gammas = sorted({key[0] for key in done})
            values = [[done.get((g, s), np.nan) for s in SEEDS] for g in gammas]
            runs = xr.Dataset({"effectiveness": (("gamma", "seed"), values)}, {"gamma": gammas, "seed": list(SEEDS)})
            runs.attrs = {"title": "LAMMPS from compacted beds of warpdamp", "version": version(PEERS[0])}
            write(runs.assign_attrs(frequency=FREQUENCY, cycles=CYCLES, discarded=DISCARDED), RUNS)


if __name__ == "__main__":
    main()
