"""The dip between the two optima of mode 1 in sixteen compacted packings; writes docs/dip.md.

python scripts/documents/dip.py                        # the document, from docs/dip.nc
python scripts/documents/dip.py simulate               # the runs anew: about five minutes on one core
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from shared import DOCS, head, mean_and_error, run_script, table, write_document

from warpdamp import Batch, Case, Drive, Grains, Request, prepare
from warpdamp.analysis.results import write
from warpdamp.damper.compaction import measured_clearance
from warpdamp.engine.ledger import maximum_energy
from warpdamp.numerics.regression import straight_line
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene.paper import COUNT, RADIUS, damper
from warpdamp.scene.scene import STANDARD_GRAVITY
from warpdamp.version import PHYSICS_VERSION

RUNS = DOCS / "dip.nc"
FREQUENCY, GAMMAS, SEEDS = 39.5, (3.0, 3.5, 4.0), range(1, 17)
CYCLES, STEPS, AT_ONCE = 90, 16, 8
WINDOWS = {"31-90": slice(30, 90), "11-90": slice(10, 90), "1-90": slice(0, 90), "21-60": slice(20, 60)}
"""Cycles that are averaged."""


def simulate(_workers: int | None) -> None:
    """Energy of every cycle, and the clearance before and after."""
    rest = damper(gamma=0)
    beds = [prepare(Request(rest, Grains.alike(RADIUS, COUNT), seed)) for seed in SEEDS]
    parts = [shaken(rest, beds[first : first + AT_ONCE]) for first in range(0, len(beds), AT_ONCE)]
    energy, after = (np.concatenate(values) for values in zip(*parts, strict=True))
    keep(energy, np.array([bed.clearance for bed in beds]), after)


def keep(energy: np.ndarray, before: np.ndarray, after: np.ndarray) -> None:
    """Write what was measured: effectiveness (seed, gamma, cycle), clearances (seed,) and (seed, gamma) [m]."""
    columns = {
        "effectiveness": (("seed", "gamma", "cycle"), energy),
        "clearance": ("seed", before),
        "clearance_after": (("seed", "gamma"), after),
    }
    runs = xr.Dataset(columns, {"seed": list(SEEDS), "gamma": list(GAMMAS), "cycle": np.arange(1, CYCLES + 1)})
    runs.attrs = {"title": "The paper's damper between its two optima", "physics_version": PHYSICS_VERSION}
    write(runs, RUNS)


def shaken(rest, beds) -> tuple[np.ndarray, np.ndarray]:
    """Effectiveness of every cycle (bed, gamma, cycle) and the clearance after (bed, gamma) [m]."""
    cases, steps = [], []
    for bed in beds:
        for gamma in GAMMAS:
            scene = rest.driven(Drive(FREQUENCY, gamma * STANDARD_GRAVITY))
            steps.append(steps_per_cycle(scene, bed.state, steps_per_contact=STEPS))
            cases.append(Case(scene, bed.state, 1 / (FREQUENCY * steps[-1])))
    batch = Batch(cases, max_rows=CYCLES + 1)
    batch.advance(CYCLES * np.array(steps))
    mass = COUNT * float(rest.mass(RADIUS))
    energy = [batch.cycles(k).per_cycle() / maximum_energy(case.scene.drive, mass) for k, case in enumerate(cases)]
    after = [measured_clearance(rest, state) for state, _ in batch.read()]
    return np.reshape(energy, (len(beds), len(GAMMAS), CYCLES)), np.reshape(after, (len(beds), len(GAMMAS)))


def window_rows(runs: xr.Dataset):
    """Means, and the depth of the dip packing by packing, by the cycles averaged."""
    for name, window in WINDOWS.items():
        values = runs["effectiveness"].isel(cycle=window).mean("cycle")
        cells = [f"{m:.3f} ± {e:.3f}" for m, e in (mean_and_error(values.sel(gamma=g)) for g in GAMMAS)]
        depth, error = mean_and_error(values.sel(gamma=GAMMAS[0]) - values.sel(gamma=list(GAMMAS[1:])).mean("gamma"))
        yield name, *cells, f"{depth:+.3f} ± {error:.3f}", f"{depth / error:.1f}"


def clearance_rows(runs: xr.Dataset):
    """What a millimetre of clearance changes, amplitude by amplitude."""
    values = runs["effectiveness"].isel(cycle=WINDOWS["31-90"]).mean("cycle")
    before = 1e3 * runs["clearance"].values
    for gamma in GAMMAS:
        own = values.sel(gamma=gamma).values
        rough = np.full(len(own), own.std(ddof=1))
        line = straight_line(before - before.mean(), own, rough)
        after = 1e3 * float(runs["clearance_after"].sel(gamma=gamma).mean())
        yield f"{gamma:g}", f"{line.slope:+.3f} ± {line.slope_standard_error:.3f}", f"{after:.2f}"


def document() -> None:
    """Write docs/dip.md."""
    runs = xr.load_dataset(RUNS)
    before = 1e3 * runs["clearance"]
    write_document(
        "dip.md",
        head("The dip between the two optima of mode 1", __file__) + f" from docs/dip.nc, of physics version "
        f"{runs.attrs['physics_version']}: {len(SEEDS)} compacted packings of the paper's damper, {FREQUENCY:g} Hz, "
        f"{CYCLES} cycles, {STEPS} steps a contact, packing by packing from the same beds.",
        "## How deep it is",
        "Effectiveness at each Gamma, and that at 3 less the mean of 3.5 and 4, over its standard error (asked for: "
        "more than two), by the cycles that are averaged: they do not matter.",
        table(["cycles", *(f"Gamma {gamma:g}" for gamma in GAMMAS), "dip", "over its error"], window_rows(runs)),
        "## What it goes with",
        f"The clearance: before, {float(before.mean()):.2f} mm, standard deviation {float(before.std(ddof=1)):.2f} "
        "between packings.  Change of the effectiveness by clearance before, and the mean clearance after:",
        table(["Gamma", "per mm", "clearance after [mm]"], clearance_rows(runs)),
        "Beds that are less compact dissipate more above the first optimum, and show a shoulder instead of a dip.",
    )


if __name__ == "__main__":
    run_script(__doc__, simulate, document)
