"""LAMMPS on a tenth of the cases of two studies, from warpdamp's own beds; writes docs/parameters_lammps.nc.

    python scripts/benchmarks/studied.py

The lowest and the highest level of friction and of restitution, so that what each does can be had from both codes;
scripts/documents/parameters.py lays them side by side.  A quarter of an hour on one core; may be stopped and started
again: docs/parameters_lammps.nc keeps what is done.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np
import xarray as xr
from documents.shared import DOCS, ROOT

from benchmarks.peers import PEERS, run_peer, version
from warpdamp import State, load, prepare
from warpdamp.analysis.results import write
from warpdamp.engine.ledger import maximum_energy
from warpdamp.scene.paper import COUNT, RADIUS
from warpdamp.sweep.cases import Cases

RUNS = DOCS / "parameters_lammps.nc"
EVERY = 10
"""Steps from one sample of the power to the next."""

CYCLES = {280.0: 24, 39.5: 12}
"""Cycles of a run by frequency [Hz]; LAMMPS needs twelve times the time of the studies' own runs, and gets fewer."""

DISCARDED = {280.0: 8, 39.5: 4}
"""Of them, left out at the start."""


@dataclass(frozen=True)
class Tenth:
    """Cases of a study: the factor, two of its levels, and at each frequency [Hz] amplitudes and packings."""

    study: str
    section: str
    factor: str
    levels: tuple[float, float]
    places: dict[float, tuple[tuple[float, ...], int]]


TENTHS = (
    Tenth("friction", "contact", "friction", (0.2, 1.2), {280.0: ((1.4, 1.7, 2.0, 2.5), 8), 39.5: ((6.0,), 8)}),
    Tenth("restitution", "contact", "restitution", (0.3, 0.9), {280.0: ((1.4, 2.0), 8), 39.5: ((6.0,), 8)}),
)


def cases(tenth: Tenth) -> Iterator[tuple[tuple, object]]:
    """Where each case stands (frequency, Gamma, level, packing), and the case itself; packing by packing."""
    study = Cases(load(ROOT / "configs" / "studies" / f"{tenth.study}.yaml"))
    found = {}
    for point in study.points():
        level = float(getattr(getattr(point.config, tenth.section), tenth.factor))
        if level not in tenth.levels:
            continue
        for _, position in study.numbers(point):
            frequency, gamma, seed = study.drive_at(point, position)
            gammas, packings = tenth.places.get(frequency, ((), 0))
            if gamma in gammas and seed <= packings:
                found[frequency, gamma, level, seed] = study.spec_at(point, position)[0]
    for place in sorted(found, key=lambda place: (place[3], -place[0], place[1:3])):
        yield place, found[place]


def power(spec, cycles: int) -> np.ndarray:
    """Power put in, cycle by cycle, over that of the ideal impact damper, from a bed without its contacts' memory."""
    bed = prepare(spec.bed)
    state = State.at_rest(bed.state.position, RADIUS)
    cycle = EVERY * int(np.ceil(spec.steps_per_cycle / EVERY))
    _, watts = run_peer(PEERS[0], spec.scene, state, cycles * cycle, EVERY, cycle)
    drive = spec.scene.drive
    return watts / (maximum_energy(drive, COUNT * float(spec.scene.mass(RADIUS))) * drive.frequency)


def keep(done: dict[tuple, np.ndarray]) -> None:
    """Write what is done: effectiveness by cycle, and where each case stands."""
    names = ("study", "frequency", "gamma", "level", "seed")
    longest = max(map(len, done.values()))
    values = np.full((len(done), longest), np.nan, "float32")
    for row, own in zip(values, done.values(), strict=True):
        row[: len(own)] = own
    coords = {name: ("case", list(column)) for name, column in zip(names, zip(*done, strict=True), strict=True)}
    runs = xr.Dataset({"effectiveness": (("case", "cycle"), values)}, coords)
    runs.attrs = {"title": "LAMMPS on cases of two studies, from beds of warpdamp", "version": version(PEERS[0])}
    write(runs, RUNS)


def kept() -> dict[tuple, np.ndarray]:
    """What an earlier call has left."""
    if not RUNS.exists():
        return {}
    runs = xr.load_dataset(RUNS)
    columns = [runs[name].values.tolist() for name in ("study", "frequency", "gamma", "level", "seed")]
    rows = runs["effectiveness"].values
    return {key: row[np.isfinite(row)] for key, row in zip(zip(*columns, strict=True), rows, strict=True)}


def main() -> None:
    """Run what is not there yet."""
    done = kept()
    for tenth in TENTHS:
        for place, spec in cases(tenth):
            key = (tenth.study, *place)
            if key not in done:
                done[key] = power(spec, CYCLES[place[0]])
                print(*key, f"{np.mean(done[key][DISCARDED[place[0]] :]):.3f}", flush=True)
                keep(done)


if __name__ == "__main__":
    main()
