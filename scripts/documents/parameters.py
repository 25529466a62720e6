"""Section 4 of the paper: what each parameter of a damper does, and its Table 1; writes docs/parameters.md and pictures.

    python scripts/documents/parameters.py                                  # the document, from docs/parameters/*.nc
    python scripts/documents/parameters.py simulate [--workers N]           # all studies of configs/studies anew
    python scripts/documents/parameters.py simulate friction modulus        # some of them

May be stopped and started again: results/parameters keeps what is done, and arms that several studies have in common
are run once.  The document says what each study costs.
"""

from __future__ import annotations

import argparse

from shared import DOCS, ROOT, progress

import warpdamp
from warpdamp.analysis.results import write

STUDIES, DATA, STORE = ROOT / "configs" / "studies", DOCS / "parameters", ROOT / "results" / "parameters"
ORDER = (
    "friction", "restitution", "modulus", "shear_resistance", "density", "frequency", "gravity", "orientation_90",
    "orientation_45", "gravity_suspended", "clearance", "sensitivity_fluidisation", "bed_depth", "size",
    "sensitivity_collision",
)  # fmt: skip
"""Studies, those first whose cells in the paper's table are uncertain: what is done is a document at any time."""

KEPT = (
    "effectiveness", "effectiveness_standard_error", "energy_dissipated", "energy_mean", "energy_mean_standard_error",
    "clearance", "clearance_after", "status", "cycles", "cycles_discarded", "ledger_residual", "floor_impulse",
    "lid_impulse", "cycle_displacement", "apparent_mass", "particle_mass", "displacement", "excitation_frequency",
    "cpu_time",
)  # fmt: skip


def simulate(names: list[str], workers: int | None) -> None:
    """Run studies, or go on with them, and keep what documents need."""
    for name in names:
        results = warpdamp.run(STUDIES / f"{name}.yaml", store=STORE, workers=workers, report=progress(name))
        losses = [channel for channel in results.data_vars if channel.endswith("_loss")]
        small = results[[*KEPT, *losses]]
        for variable in small.data_vars:
            if small[variable].dtype == "float64":
                small[variable].encoding = {"dtype": "float32", "zlib": True}
        DATA.mkdir(exist_ok=True)
        write(small, DATA / f"{name}.nc")
        print(f"{name} done: {float(small['cpu_time'].sum()):.0f} core-seconds", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("simulate", nargs="?", choices=["simulate"])
    parser.add_argument("studies", nargs="*", default=list(ORDER), metavar="study")
    parser.add_argument("--workers", type=int)
    options = parser.parse_args()
    if options.simulate:
        simulate(options.studies, options.workers)


if __name__ == "__main__":
    main()
