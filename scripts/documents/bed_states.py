"""How beds change while they are shaken: the paper's damper at Gamma 6, cycle by cycle; writes docs/bed-states.md.

    python scripts/documents/bed_states.py            # the document, from docs/bed-states.nc
    python scripts/documents/bed_states.py simulate   # the runs anew: about four minutes on two cores

Three packings, loose and compacted, with the usual step and with half of it.
"""

from __future__ import annotations

import itertools
import sys

import numpy as np
import xarray as xr
from shared import DOCS, head, panels, processes, table, write_document

from warpdamp import Batch, Case, Grains, Request, prepare
from warpdamp.analysis.results import write
from warpdamp.engine.ledger import maximum_energy
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene.paper import COUNT, FREQUENCY, GAMMA, RADIUS, damper

SEEDS, PREPARATIONS, STEPS = (1, 2, 3), ("loose", "compacted"), (24, 48)
CYCLES, BLOCK = 400, 20


def shaken(preparation: str, seed: int, steps: int) -> np.ndarray:
    """Effectiveness of every cycle."""
    scene, grains = damper(), Grains.alike(RADIUS, COUNT)
    n = steps_per_cycle(scene, grains, steps_per_contact=steps)
    bed = prepare(Request(scene, grains, seed, preparation)).state
    batch = Batch([Case(scene, bed, 1 / FREQUENCY / n)], max_rows=CYCLES + 1)
    batch.advance(CYCLES * n)
    mass = float(np.sum(scene.masses(grains)))
    return batch.cycles(0).per_cycle() / maximum_energy(scene.drive, mass)


def simulate() -> None:
    """All runs, side by side."""
    jobs = [(p, s, n) for n in reversed(STEPS) for p in PREPARATIONS for s in SEEDS]  # the dearer first
    with processes() as executor:
        runs = dict(zip(jobs, executor.map(shaken, *zip(*jobs, strict=True)), strict=True))
    values = [[[runs[p, s, n] for s in SEEDS] for p in PREPARATIONS] for n in STEPS]
    dataset = xr.Dataset(
        {"effectiveness": (("steps_per_contact", "preparation", "seed", "cycle"), np.array(values))},
        {"steps_per_contact": list(STEPS), "preparation": list(PREPARATIONS), "seed": list(SEEDS)},
        {"title": f"The paper's damper at {FREQUENCY:g} Hz and Gamma {GAMMA:g}, cycle by cycle"},
    )
    dataset["effectiveness"].attrs.update(units="1", long_name="energy of the cycle over the ideal impact damper's")
    write(dataset, DOCS / "bed-states.nc")


def document() -> None:
    """Write docs/bed-states.md and its picture."""
    eps = xr.load_dataset(DOCS / "bed-states.nc")["effectiveness"]
    blocks = eps.coarsen(cycle=BLOCK).mean()
    windows = (slice(5, 13), slice(40, 100), slice(100, 200), slice(200, 400))
    heading = ["bed", "seed", "steps a contact", "cycles 6-13", "41-100", "101-200", "201-400"]
    rows = []
    for bed in itertools.product(PREPARATIONS, SEEDS, STEPS):
        own = eps.sel(dict(zip(("preparation", "seed", "steps_per_contact"), bed, strict=True)))
        rows.append([*bed, *(f"{float(own.isel(cycle=w).mean()):.3f}" for w in windows)])
    late = eps.isel(cycle=slice(100, None))
    levels = late.coarsen(cycle=100).mean()
    spread, noise = float(levels.std() / levels.mean()), float(late.std("cycle").mean() / late.mean())
    per_step = {n: levels.sel(steps_per_contact=n).values.ravel() for n in STEPS}
    means = {n: v.mean() for n, v in per_step.items()}
    beds = len(SEEDS) * len(PREPARATIONS)
    errors = {n: levels.sel(steps_per_contact=n).mean("cycle").values.std(ddof=1) / np.sqrt(beds) for n in STEPS}
    write_document(
        "bed-states.md",
        head("States of a bed", __file__) + f" from docs/bed-states.nc: the paper's damper at {FREQUENCY:g} Hz "
        f"and Gamma {GAMMA:g}, {CYCLES} cycles of six beds, each with 24 and with 48 steps to the shortest contact.",
        f"![Effectiveness in blocks of {BLOCK} cycles](bed-states.png)",
        "Mean effectiveness:",
        table(heading, rows),
        f"From cycle 100 on, means of 100 cycles differ by {100 * spread:.0f} % (standard deviation); single cycles "
        f"scatter by {100 * noise:.0f} % about the level of their bed, so that 100 uncorrelated ones would be known "
        f"to {10 * noise:.1f} %.  The step is not the cause: over all beds {means[24]:.3f} ± {errors[24]:.3f} with 24 "
        f"steps a contact and {means[48]:.3f} ± {errors[48]:.3f} with 48.",
        "A bed of this fill, five and a half spheres across, has no single answer at this amplitude, however long one "
        "waits: it goes from one state to another after tens to hundreds of cycles.  Short runs, and the 0.3 s of the "
        "paper's recipe are 13 cycles, see the state that the preparation left.  Claims therefore carry "
        "`memory_error`, and packings are what averages it out (docs/accuracy.md).",
    )
    _picture(blocks)


def _picture(blocks: xr.DataArray) -> None:
    figure, axes = panels(len(PREPARATIONS), (9, 3.6), sharey=True)
    cycle = (np.arange(blocks.sizes["cycle"]) + 0.5) * BLOCK
    for ax, p in zip(axes, PREPARATIONS, strict=True):
        for k, s in enumerate(SEEDS):
            for n, style in zip(STEPS, ("-", ":"), strict=True):
                own = blocks.sel(preparation=p, seed=s, steps_per_contact=n)
                ax.plot(cycle, own, style, color=f"C{k}", label=f"seed {s}, {n} steps a contact")
        ax.set(title=p, xlabel="cycle")
    axes[0].set_ylabel("effectiveness [-]")
    axes[1].legend(fontsize=6)
    figure.savefig(DOCS / "bed-states.png")


if __name__ == "__main__":
    if "simulate" in sys.argv[1:]:
        simulate()
    document()
