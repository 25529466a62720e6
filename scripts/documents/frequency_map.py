"""The phase map of the paper's damper: run or go on with it, fit both optima, and write docs/frequency_map.*.

python scripts/documents/frequency_map.py [--config CONFIG] [--store DIR] [--docs DIR] [--workers N] [--collect]

May be stopped and started again; --collect only draws what is there.
"""

import argparse
from pathlib import Path

import numpy as np
from shared import DOCS, ROOT, head, progress, table, write_document

import warpdamp
from warpdamp.analysis.results import write
from warpdamp.numerics.regression import straight_line
from warpdamp.report.curves import draw
from warpdamp.report.figures import save
from warpdamp.scene.scene import STANDARD_GRAVITY

PAPER_SLOPE, PAPER_LINE = 0.0028, "3 - 0.0037 f"
KEPT = (
    "effectiveness", "effectiveness_standard_error", "energy_dissipated", "apparent_mass", "clearance", "status",
    "cycles", "ledger_residual", "floor_impulse", "lid_impulse", "cycle_displacement", "displacement", "particle_mass",
)  # fmt: skip


def fitted(dataset, optima):
    """Lines of the document: both optima against frequency, with uncertainties."""
    frequency = optima["frequency"].values
    clearance = dataset["clearance"].mean().item()
    bed = dataset["preparation"].item()
    lines = []
    expected = 4 * np.pi * clearance / STANDARD_GRAVITY
    for name, x, what in (("collision", frequency**2, "f^2"), ("fluidisation", frequency, "f")):
        y, error = optima[f"gamma_{name}"].values, optima[f"gamma_{name}_standard_error"].values
        try:
            line = straight_line(x, y, error)
        except ValueError as problem:
            lines.append(f"- Gamma of {name} against {what}: {problem}.")
            continue
        lines.append(
            f"- Gamma of {name} = ({line.intercept:.3f} ± {line.intercept_standard_error:.3f}) + "
            f"({line.slope:.3g} ± {line.slope_standard_error:.1g}) {what}, from {np.isfinite(y).sum()} frequencies; "
            f"chi^2 per degree of freedom {line.scatter:.2g}."
        )
        if name == "collision":
            lines.append(
                f"  Eq. 20 with the clearance measured: slope {expected:.5f}; with eq. 2's, as the paper has it, "
                f"{PAPER_SLOPE}. A plastic block under gravity has the intercept 1.08."
            )
        else:
            lines.append(f"  The paper's line: {PAPER_LINE}.")
    return f"Clearance measured ({bed} bed): {1e3 * clearance:.3f} mm.", "\n".join(lines)


def gammas(optima):
    """Both optima at each frequency."""
    for k, frequency in enumerate(optima["frequency"].values):
        cells = []
        for name in ("fluidisation", "collision"):
            gamma, error = (float(optima[f"gamma_{name}{s}"][k]) for s in ("", "_standard_error"))
            cells.append(f"{gamma:.2f} ± {error:.2f}" if np.isfinite(gamma) else "-")
        yield f"{frequency:g}", *cells


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", type=Path, default=ROOT / "configs" / "frequency_map.yaml")
    parser.add_argument("--store", type=Path, default=Path("results/frequency_map"))
    parser.add_argument("--docs", type=Path, default=DOCS)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--collect", action="store_true")
    options = parser.parse_args()
    if not options.collect:
        warpdamp.carry_out(options.config, options.store, workers=options.workers, report=progress())
    dataset = warpdamp.collect(options.store)
    optima = dataset.damper.optimum()
    options.docs.mkdir(parents=True, exist_ok=True)
    save(draw(dataset), options.docs / "frequency_map.png")
    save(dataset.damper.regime_map(), options.docs / "frequency_map_regimes.png")
    small = dataset[[name for name in KEPT if name in dataset]]
    write(small, options.docs / "frequency_map.nc")
    status = dataset["status"].values
    write_document(
        "frequency_map.md",
        head("Phase map", __file__) + f" from `{options.config.name}`: {status.size} cases, "
        f"{int(np.sum(status < 20))} of them finished, {int(np.sum(status == 0))} of those steady with the standard "
        f"error asked for; residual of the energy ledger at most {100 * float(small['ledger_residual'].max()):.2g} %; "
        f"{float(dataset['cpu_time'].sum()) / 3600:.2g} hours of processor time. Data: `frequency_map.nc`.",
        "![Effectiveness over frequency and Gamma](frequency_map.png)",
        "![Regimes of motion over frequency and Gamma](frequency_map_regimes.png)",
        "Optima are maxima of a Gaussian process through the points of each frequency, with standard errors from its "
        "posterior (`dataset.damper.optimum()`).",
        *fitted(dataset, optima),
        table(["f [Hz]", "Gamma of fluidisation", "Gamma of collision"], gammas(optima)),
        folder=options.docs,
    )


if __name__ == "__main__":
    main()
