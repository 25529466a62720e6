"""What fewer steps a contact do: energies, ledger and a jam, from six steps on; writes docs/steps.md.

python scripts/documents/steps.py: the paper's damper, eight compacted beds, about two minutes.
"""

import math

import numpy as np
from shared import head, table, write_document

from warpdamp import Batch, Case, Grains, Request, prepare
from warpdamp.engine.checks import residual_share
from warpdamp.engine.ledger import maximum_energy
from warpdamp.kernels.columns import KernelStatus
from warpdamp.numerics.limits import FEWEST_STEPS_PER_CONTACT, STEPS_PER_CONTACT
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene import paper

STEPS = (6, 8, 10, 12, 16, 20, 24, 48)
"""To the shortest contact expected; the last is the reference."""
GAMMAS = (1.0, 6.0, 12.0)
SEEDS = range(1, 9)
CYCLES, LEFT_OUT = 30, 10

INTRODUCTION = f""", about the paper's damper at {paper.FREQUENCY:g} Hz: {len(SEEDS)} compacted beds,
cycles {LEFT_OUT + 1} to {CYCLES}; the same bed with every step.  Fewer than {FEWEST_STEPS_PER_CONTACT} steps to the
shortest contact expected are refused, and {STEPS_PER_CONTACT} are usual; here they are run all the same.

The residual falls with the square of the step: half a percent of the energy turned over takes some 20 steps a contact,
whatever the energy per cycle itself needs.  Below ten the largest residuals say that beds are fed with energy, at
eight steps only where they are shaken hard: dashpots act on predicted velocities, and are stable only where a step is
short beside the time in which they stop a contact."""


def run(gamma: float) -> dict[int, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Effectiveness, residual share of the ledger and largest overlap over R* of each bed, by steps a contact."""
    grains = Grains.alike(paper.RADIUS, paper.COUNT)
    states = [prepare(Request(paper.damper(gamma=0), grains, seed)).state for seed in SEEDS]
    scene = paper.damper(gamma=gamma)
    results = {}
    finest = steps_per_cycle(scene, states[0], steps_per_contact=STEPS[-1])
    for steps_per_contact in STEPS:
        steps = math.ceil(finest * steps_per_contact / STEPS[-1])  # the rule for dashpots would allow no fewer than ten
        cases = [Case(scene, state, 1 / (scene.drive.frequency * steps)) for state in states]
        batch = Batch(cases, max_rows=CYCLES + 1)
        batch.advance(CYCLES * steps)
        results[steps_per_contact] = tuple(np.transpose([_measured(batch, k) for k in range(len(cases))]))
    return results


def _measured(batch: Batch, k: int) -> tuple[float, float, float]:
    if batch.status[k] != KernelStatus.OK:
        return math.nan, math.nan, math.nan
    case, ledger = batch.cases[k], batch.cycles(k)
    per_cycle = (ledger.dissipated[-1] - ledger.dissipated[LEFT_OUT]) / (CYCLES - LEFT_OUT)
    mass = float(np.sum(case.scene.masses(case.state)))
    overlap = float(np.max(ledger["largest_overlap"]))
    return per_cycle / maximum_energy(case.scene.drive, mass), residual_share(ledger), overlap


def rows(gamma: float):
    """Rows of the table: steps, change of the effectiveness [%], ledger's residual [%], largest overlap, beds lost."""
    results = run(gamma)
    reference = results[STEPS[-1]][0]
    for steps, (effectiveness, residual, overlap) in results.items():
        change = 100 * (effectiveness / reference - 1)
        kept = np.isfinite(change)
        error = np.std(change[kept], ddof=1) / math.sqrt(kept.sum())
        yield (
            steps,
            "-" if steps == STEPS[-1] else f"{np.mean(change[kept]):+.1f} ± {error:.1f}",
            f"{100 * np.median(residual[kept]):.2f}",
            f"{100 * np.max(residual[kept]):.2f}",
            f"{np.max(overlap[kept]):.3f}",
            int((~kept).sum()),
        )


def main():
    heading = ["steps a contact", "energy [%]", "residual, median [%]", "largest [%]", "overlap over R*", "beds lost"]
    sections = []
    for gamma in GAMMAS:
        sections += [f"## Gamma {gamma:g}", table(heading, rows(gamma))]
    write_document("steps.md", head("Fewer steps a contact", __file__) + INTRODUCTION, *sections)


if __name__ == "__main__":
    main()
