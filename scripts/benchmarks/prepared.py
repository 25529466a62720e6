"""LAMMPS from warpdamp's own compacted beds, over the amplitudes of mode 1; writes docs/two_optima_lammps.nc.

    python scripts/benchmarks/prepared.py

The beds of scripts/documents/two_optima.py, which draws these curves beside its own, from rest and without their
contacts' memory.  Two laws: LAMMPS' usual one, whose contacts pull at their end, and what LAMMPS offers that is the
same as warpdamp's.  A quarter of a minute a case; may be stopped and started again: the file keeps what is done.
"""

import itertools
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "documents"))

import numpy as np
import xarray as xr
from documents.shared import DOCS
from documents.two_optima import job

from benchmarks.peers import PEERS, run_peer, version
from warpdamp import Drive, Request, Scene, State, prepare
from warpdamp.analysis.results import write
from warpdamp.engine.ledger import maximum_energy
from warpdamp.scene.contact import dashpot
from warpdamp.scene.scene import STANDARD_GRAVITY
from warpdamp.sweep.cases import Cases

RUNS = DOCS / "two_optima_lammps.nc"
FREQUENCY, CYCLE, EVERY, CYCLES = 39.5, 8000, 10, 90
"""Of mode 1 [Hz]; steps of a cycle (16 a contact at Gamma 6), from one sample of the power to the next; cycles."""

CASES = (
    *itertools.product(("same",), (1, 2, 3, 4, 5, 6), (3.0, 6.0, 3.5, 8.0, 5.0, 4.0, 7.0, 2.5)),
    *itertools.product(("usual",), (1, 2, 3, 4, 5, 6), (3.0, 6.0)),
)
"""Law, packing, Gamma; in this order."""


def law(name: str, scene: Scene) -> str | None:
    """A contact law in LAMMPS' words; None: as the deck has it.

    The same as warpdamp's: no tension, the restitution that then gives the dashpot which returns that asked for, a
    tangential dashpot with the tangential stiffness, and a spring's force that falls with the contact radius.
    """
    if name == "usual":
        return None
    surface, nu = scene.particle_contact, scene.particle.poissons_ratio
    strength = dashpot(surface.restitution)
    textbook = math.exp(-math.pi * strength / math.sqrt(1 - strength**2))
    tangential = math.sqrt(2 * (1 - nu) / (2 - nu))
    return (
        f"hertz/material {scene.particle.youngs_modulus!r} {textbook!r} {nu!r} tangential mindlin_rescale/force NULL "
        f"{tangential!r} {surface.friction!r} damping coeff_restitution limit_damping"
    )


def effectiveness(name: str, gamma: float, bed: Request) -> np.ndarray:
    """Power put in over that of the ideal impact damper, by cycle."""
    scene = bed.scene.driven(Drive(FREQUENCY, gamma * STANDARD_GRAVITY))
    state = State.at_rest(prepare(bed).state.position, np.array(bed.grains.radius))
    _, power = run_peer(PEERS[0], scene, state, CYCLES * CYCLE, EVERY, CYCLE, law(name, scene))
    ideal = maximum_energy(scene.drive, float(np.sum(scene.masses(state)))) * FREQUENCY
    return power / ideal


def keep(done: dict[tuple[str, int, float], np.ndarray]) -> None:
    """Write what there is; cases that were not run are not numbers."""
    laws, seeds, gammas = (sorted(set(values)) for values in zip(*done, strict=True))
    missing = np.full(CYCLES, np.nan)
    values = [[[done.get((a, s, g), missing) for g in gammas] for s in seeds] for a in laws]
    axes = {"law": laws, "seed": seeds, "gamma": gammas, "cycle": np.arange(1, CYCLES + 1)}
    runs = xr.Dataset({"effectiveness": (tuple(axes), values)}, axes)
    runs.attrs = {"title": "LAMMPS from compacted beds of warpdamp", "version": version(PEERS[0])}
    write(runs.assign_attrs(frequency=FREQUENCY, steps_per_cycle=CYCLE), RUNS)


def stored() -> dict[tuple[str, int, float], np.ndarray]:
    """What an earlier run has done."""
    if not RUNS.exists():
        return {}
    runs = xr.load_dataset(RUNS)["effectiveness"].stack(case=("law", "seed", "gamma")).transpose("case", "cycle")
    return {case: row.values for case, row in zip(runs["case"].values, runs, strict=True) if np.isfinite(row).all()}


def main() -> None:
    """Run what is not there yet."""
    beds = {spec.bed.seed: spec.bed for spec in Cases(job((1,))).specs()}
    done = stored()
    for case in CASES:
        if case in done:
            continue
        name, seed, gamma = case
        done[case] = effectiveness(name, gamma, beds[seed])
        print(f"{name} law, packing {seed}, Gamma {gamma}: {done[case][30:].mean():.3f}", flush=True)
        keep(done)


if __name__ == "__main__":
    main()
