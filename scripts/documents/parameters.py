"""Section 4 of the paper: what each parameter of a damper does, its Table 1; writes docs/parameters.md and pictures.

    python scripts/documents/parameters.py                                  # the document, from docs/parameters/*.nc
    python scripts/documents/parameters.py simulate [--workers N]           # all studies of configs/studies anew
    python scripts/documents/parameters.py simulate friction modulus        # some of them, without the document
    python scripts/documents/parameters.py simulate friction --packings 4   # with the first packings only

May be stopped and started again: results/parameters keeps what is done, and arms that several studies have in common
are run once.  The document says what each study costs.
"""

from __future__ import annotations

import argparse
import re
from functools import cache

import numpy as np
import xarray as xr
from parameters_checks import checks_section
from parameters_data import DATA, FACTORS, FAST, NEEDS, RESPONSES, SLOW, Factor, cells, nearest, results, shares
from parameters_lammps import lammps_section
from parameters_sensitivity import sensitivity_page
from parameters_shapes import drifting, shapes
from parameters_statements import rows as statement_rows
from parameters_verdicts import COLLIDED, FLUIDISED, NAMES, percent
from shared import DOCS, ROOT, head, panels, progress, table, write_document

import warpdamp
from warpdamp.analysis.effects import STEP, Verdict, holm
from warpdamp.analysis.results import write
from warpdamp.modal.damping import damping_of_effectiveness
from warpdamp.modal.from_config import modes as structure_modes
from warpdamp.report.figures import save
from warpdamp.status import FIRST_UNFINISHED, Status

STUDIES, STORE = ROOT / "configs" / "studies", ROOT / "results" / "parameters"
COMMAND = "python scripts/documents/parameters.py"
MOVING, RESIDUAL = 0.05, 0.005
LIMITS = (
    "## Range\n\nThe paper's damper, 120 particles in a cavity of 40 mm; levels and amplitudes of the studies' files, "
    "cycles and steps of the table above; spheroids as docs/sphericity.md says.  Beds that are made anew for every arm "
    "(clearance, depth, size, shape) are paired in name only: their packings differ as those of two dampers do.  A "
    "cell is of one frequency, and its effect is of the levels that have the optimum.  What wears, dust and "
    "electric charge do is not modelled."
)
ORDER = (
    "friction", "restitution", "modulus", "shear_resistance", "frequency", "density", "gravity", "orientation_90",
    "clearance", "orientation_45", "gravity_suspended", "bed_depth", "size", "sensitivity_fluidisation",
    "restitution_low", "modulus_stiff", "sensitivity_collision",
)  # fmt: skip
"""Studies, those first whose cells in the paper's table are uncertain: what is done is a document at any time."""

APART = ("frequency", "clearance", "bed_depth", "size", "sensitivity_fluidisation", "sensitivity_collision")
"""Studies with a store of their own: they have no arm in common with others, and may run beside them."""

KEPT = (
    "effectiveness", "effectiveness_standard_error", "energy_dissipated", "energy_mean", "energy_mean_standard_error",
    "clearance", "clearance_after", "status", "cycles", "cycles_discarded", "ledger_residual", "floor_impulse",
    "lid_impulse", "cycle_displacement", "apparent_mass", "particle_mass", "displacement", "excitation_frequency",
    "cpu_time", "steps",
)  # fmt: skip


def simulate(names: list[str], workers: int | None, packings: int | None) -> None:
    """Run studies, or go on with them, and keep what documents need."""
    for name in names:
        config = warpdamp.load(STUDIES / f"{name}.yaml")
        if packings:
            config = config.model_copy(update={"seeds": config.seeds[:packings]})
        results = warpdamp.run(
            config, store=STORE / (name if name in APART else "arms"), workers=workers, report=progress(name)
        )
        losses = [channel for channel in results.data_vars if channel.endswith("_loss")]
        small = results[[*KEPT, *losses]]
        for variable in small.data_vars:
            if small[variable].dtype == "float64":
                small[variable].encoding = {"dtype": "float32", "zlib": True}
        DATA.mkdir(exist_ok=True)
        write(small, DATA / f"{name}.nc")
        print(f"{name} done: {float(small['cpu_time'].sum()):.0f} core-seconds", flush=True)


def number(cell: xr.Dataset | None, factor: Factor) -> str:
    """Effect of a cell with its interval, and over what."""
    if cell is None:
        return not_run(factor)
    if not np.isfinite(cell["effect"]):
        return "-"
    if factor.study in ("frequency", "clearance", "density") and "exponent" in cell:
        value, error = float(cell["exponent"]), float(cell["exponent_standard_error"])
        power = f", as its power {value:.2f} ± {error:.2f}"
    else:
        power = ""
    if not cell.attrs["per"].startswith(STEP):
        return percent(*(float(cell[f"effect{end}"]) for end in ("", "_low", "_high"))) + f" by doubling{power}"
    return percent(*(float(cell[f"change{end}"]) for end in ("", "_low", "_high"))) + " over the range"


def not_run(factor: Factor) -> str:
    """What to run for a factor."""
    if factor.study == "sphericity":
        return "fewer than three packings: `python scripts/documents/sphericity.py simulate`"
    needed = {"orientation": "gravity orientation_45 orientation_90"}.get(factor.study, factor.study)
    return f"not run: `{COMMAND} simulate {needed}`"


def verdict(cell: xr.Dataset | None) -> str:
    """Verdict of a cell in the table's words."""
    if cell is None:
        return "not run"
    word = str(cell["verdict"].item())
    if word == Verdict.NONE:
        return word
    if word == Verdict.NOT_AFFECTED:
        ends = max(abs(float(cell[f"change_{end}"])) for end in ("low", "high"))
        return f"not affected within {100 * ends:.1f} %"
    if word == Verdict.UNDECIDED:
        return f"undecided ({float(cell['packings_needed']):.0f} packings would decide)"
    return word


def agreement(cell: xr.Dataset | None, expected: tuple[str, ...]) -> str:
    """Whether a verdict is what the paper's words say."""
    if cell is None:
        return ""
    if expected == NEEDS:
        missing = np.isnan(cell["level"].values)  # levels rise: the first is none
        return "agrees" if missing[0] and not missing[1:].all() else "**differs**"
    if not expected:
        return "the paper left it open"
    word = str(cell["verdict"].item())
    if word == Verdict.UNDECIDED:
        return "undecided"
    return "agrees" if word in expected else "**differs**"


def in_words(factor: Factor, cell: xr.Dataset | None, expected: tuple[str, ...]) -> str:
    """Verdict of a cell, and at which levels there is no such optimum."""
    if cell is None:
        return verdict(cell)
    if expected == NEEDS and np.isnan(cell["level"].values[0]):
        return f"does not exist without gravity; with it {verdict(cell)}"
    return verdict(cell) + existence(factor, cell)


def existence(factor: Factor, cell: xr.Dataset) -> str:
    """Levels at which a response does not exist, where it does at others."""
    level = cell["level"]
    missing = [
        f"{factor.shown * v:.4g}" for v, y in zip(level[factor.key].values, level.values, strict=True) if np.isnan(y)
    ]
    return f"; none at {', '.join(missing)} {factor.unit}".rstrip() if 0 < len(missing) < level.size else ""


def table_rows():
    """Table 1 again: a row for each cell."""
    for factor in FACTORS:
        for response, cell, words, expected in zip(
            RESPONSES, cells(factor), factor.words, factor.expected, strict=True
        ):
            yield (
                factor.title, NAMES[response], in_words(factor, cell, expected), number(cell, factor),
                "" if cell is None or not np.isfinite(cell["p_value"]) else f"{adjusted()[factor.title, response]:.2g}",
                words, agreement(cell, expected),
            )  # fmt: skip


@cache
def adjusted() -> dict[tuple[str, str], float]:
    """P-values of all cells together, by Holm."""
    own = {(f.title, r): c for f in FACTORS for r, c in zip(RESPONSES, cells(f), strict=True) if c is not None}
    return dict(zip(own, holm([float(c["p_value"]) for c in own.values()]), strict=True))


def summary() -> str:
    """How many cells there are of each kind."""
    every = [cell for factor in FACTORS for cell in cells(factor)]
    run = [str(cell["verdict"].item()) for cell in every if cell is not None]
    counts = ", ".join(f"{run.count(word)} {word}" for word in dict.fromkeys(sorted(run)))
    sure = [c for c in every if c is not None and str(c["verdict"].item()) in (Verdict.HIGHER, Verdict.LOWER)]
    known = {key for key, p in adjusted().items() if p < 0.05}
    return (
        f"{len(run)} of 48 cells have a verdict: {counts}.  Of the {len(sure)} that are higher or lower {len(known)} "
        "are so by Holm's rule over all cells as well."
    )


def cost_rows():
    """What every study took."""
    done = {name: xr.load_dataset(path) for name in ORDER if (path := DATA / f"{name}.nc").exists()}
    total = 0.0
    for name in ORDER:
        if name not in done:
            yield (
                name,
                "",
                "",
                "",
                "",
                "",
                "",
                f"not run; what it takes: `warpdamp explain configs/studies/{name}.yaml`",
            )
            continue
        runs = done[name]
        ran = runs["effectiveness"].notnull()
        residual = runs["ledger_residual"].where(ran & (runs["effectiveness"] > MOVING))
        above = int((residual > RESIDUAL).sum())
        worst = f"{100 * float(residual.max()):.2f} %" + (f", {above} above {100 * RESIDUAL:g} %" if above else "")
        left_out = runs["status"].isin([int(s) for s in (Status.EXCLUDED, Status.REFUSED, Status.NOT_RUN)])
        failed = int(((runs["status"] >= FIRST_UNFINISHED) & ~left_out).sum())
        seconds = float(runs["cpu_time"].where(ran).sum())
        total += seconds
        packings = "4, sampled" if "seed" not in runs.dims else runs.sizes["seed"]
        state = f"{failed} failed" if failed else "finished"
        yield name, int(ran.sum()), packings, *resolution(runs), f"{seconds:.0f}", worst, state
    yield "together", "", "", "", "", f"{total:.0f}", "", ""


def resolution(runs: xr.Dataset) -> tuple[str, str]:
    """Cycles of a study's cases, and its steps a contact, at each frequency if they differ."""
    cycles = np.unique(runs["cycles"].where(runs["effectiveness"].notnull()))
    if "steps_per_contact" in runs.coords:
        steps = list(dict.fromkeys(runs["steps_per_contact"].values.tolist()))
    else:
        steps = [float(re.search(r"steps_per_contact: ([\d.]+)", runs.attrs["configuration"])[1])]
    return tuple(" / ".join(f"{v:g}" for v in values) for values in (cycles[np.isfinite(cycles)], steps))


def factor_page(factor: Factor) -> str:
    """One factor: its levels, the optima there, and the mechanisms off the ledger's channels."""
    runs = results(factor.study)
    if runs is None:
        return f"### {factor.title}\n\n{not_run(factor)}."
    lines = [f"### {factor.title}", ""]
    columns = [level_column(factor, cell) for cell in cells(factor)]
    labels = sorted({value for column in columns for value in column})
    rows = [[f"{value:.4g}", *(column.get(value, "-") for column in columns)] for value in labels]
    lines.append(table([first_column(factor), *(NAMES[r] for r in RESPONSES)], rows))
    tests = [
        f"{NAMES[r]}: {tests_of_shape(c)}, standard error {100 * float(c['paired_standard_error']):.1f} % paired, "
        f"{100 * float(c['unpaired_standard_error']):.1f} % unpaired"
        for r, c in zip(RESPONSES, cells(factor), strict=True)
        if c is not None and np.isfinite(c["effect"])
    ]
    lines += ["", "; ".join(tests) + "."] if tests else []
    if factor.study == "sphericity":
        share = drifting(shapes()[0])[3]
        lines += [
            "",
            f"{100 * share:.0f} % of the cases of mode 3, from which Γ_f and ε_f are read, were still drifting when "
            "they ended: what they say of fluidisation is of beds on their way.  Where the clearance of each shape "
            "comes in is in [sphericity.md](sphericity.md).",
        ]
    elif factor.study != "frequency":
        for frequency, gamma in ((FAST, FLUIDISED), (SLOW, COLLIDED)):
            lines += ["", mechanism(factor, runs, frequency, gamma)]
    return "\n".join(lines)


def flat_top() -> str:
    """Why the place of the optimum of fluidisation is known worse than its height."""
    runs = results("restitution")
    if runs is None:
        return ""
    eps = runs["effectiveness"].sel(frequency=FAST, restitution=0.52, gamma=[1.4, 1.7, 2.0]).mean("seed").values
    return (
        "  Γ_f is known worse than ε_f: the paper's damper has an effectiveness of "
        + ", ".join(f"{value:.3f}" for value in eps)
        + " at Γ 1.4, 1.7 and 2, and which of them is on top depends on a single packing."
    )


def first_column(factor: Factor) -> str:
    """Heading of the levels."""
    return "aspect" if factor.study == "sphericity" else f"{factor.title} [{factor.unit or '1'}]"


def level_column(factor: Factor, cell: xr.Dataset | None) -> dict[float, str]:
    """One response level by level, with its own standard error."""
    if cell is None:
        return {}
    shown = cell["aspect"] if factor.study == "sphericity" else factor.shown * cell[factor.key]
    values = zip(shown.values.tolist(), cell["level"].values, cell["level_standard_error"].values, strict=True)
    return {value: f"{top:.3g} ± {error:.2g}" if np.isfinite(top) else "none" for value, top, error in values}


def tests_of_shape(cell: xr.Dataset) -> str:
    """What speaks against a response that only rises or only falls, and against a straight line."""
    if cell["level"].notnull().sum() < 3:
        return "two levels"
    p = float(cell["p_monotony"])
    monotony = "no step against the slope" if p >= 1 else f"largest step against the slope p {p:.2g}"
    return f"{monotony}, straightness p {float(cell['p_straight']):.2g}"


def mechanism(factor: Factor, runs: xr.Dataset, frequency: float, gamma: float) -> str:
    """Where the energy goes at one amplitude, level by level."""
    dim = runs[factor.key].dims[0]
    runs = runs.sortby(factor.key)
    gamma = gamma if factor.study != "clearance" else 8.5
    at = nearest(runs, frequency, gamma)
    part, eps = shares(at), at["effectiveness"].mean("seed")
    after = 1e3 * at["clearance_after"].mean("seed")
    lid = (at["lid_impulse"].mean("seed") / at["floor_impulse"].mean("seed")).where(eps > MOVING)
    rows = []
    for k, value in enumerate(runs[factor.key].values):
        own = [f"{float(part[kind].isel({dim: k})):.2f}" for kind in part]
        other = (float(a.isel({dim: k})) for a in (eps, after, lid))
        rows.append([f"{factor.shown * value:.4g}", *own, *(f"{v:.3g}" if np.isfinite(v) else "-" for v in other)])
    heading = [
        first_column(factor),
        *(f"{kind} / loss" for kind in part),
        "ε",
        "clearance after [mm]",
    ]
    return f"At {frequency:g} Hz, Γ {float(at['gamma']):g}:\n\n" + table([*heading, "lid / floor impulse"], rows)


FIGURES = {
    "density": ("density", "Fig. 15", "{:g} kg/m³", 1.0), "modulus": ("youngs_modulus", "Fig. 16", "x {:g}", 1 / 3.3e9),
    "restitution": ("restitution", "Fig. 17", "e = {:g}", 1.0), "friction": ("friction", "Fig. 18", "µ = {:g}", 1.0),
}  # fmt: skip


def pictures() -> list[str]:
    """Figs 15 to 18 in the paper's form, and the lines of the document that show them."""
    lines = []
    for study, (key, title, label, scale) in FIGURES.items():
        runs = results(study)
        if runs is None:
            continue
        figure, axes = panels(3, (13, 3.8))
        for ax, frequency, mode in zip(axes, runs["frequency"].values, (1, 3, 5), strict=True):
            for value in runs[key].values:
                at = runs.sel(frequency=frequency, **{key: value})
                if not at["effectiveness"].notnull().any():
                    continue  # an arm that was not run at this frequency
                mass = at["particle_mass"].mean().item()
                zeta = 100 * damping_of_effectiveness(at["effectiveness"], mass, amplitude(mass)[mode])
                n = zeta.notnull().sum("seed")
                mean, error = zeta.mean("seed"), zeta.std("seed", ddof=1) / np.sqrt(n)
                known = mean.notnull().values
                style = {"fmt": "o-", "ms": 3, "capsize": 2, "label": label.format(scale * value)}
                ax.errorbar(at["gamma"].values[known], mean.values[known], error.values[known], **style)
            ax.set(xlabel="Γ", title=f"mode {mode}, {frequency:g} Hz", ylim=(0, None))
        axes[0].set_ylabel("damping ratio [%]")
        axes[0].legend(fontsize=7)
        save(figure, DOCS / f"parameters_{study}.png")
        lines.append(f"![{title}: damping of modes 1, 3 and 5 over Γ by {study}](parameters_{study}.png)")
    return lines


@cache
def amplitude(mass: float) -> dict[int, float]:
    """Mass-normalised shapes of the paper's beam at the damper, by mode, with particles of a mass [kg]."""
    modes = structure_modes(warpdamp.load(ROOT / "configs" / "beam.yaml"), particles=mass)
    return dict(zip(map(int, modes.number), map(float, modes.amplitude), strict=True))


def document() -> None:
    """Write the page from what has been run."""
    write_document(
        "parameters.md",
        head("What each parameter does", __file__)
        + " from `docs/parameters/*.nc`, the studies in `configs/studies`.  The damper is the "
        "paper's, with what a study changes; Γ_f and ε_f are read at 280 Hz (mode 3), Γ_c and ε_c at 39.5 Hz (mode 1), "
        "where each stands alone.  Where forces are what changes, all arms start from the same beds.",
        "## Table 1 again",
        summary()
        + "  Effects are slopes of the logarithm of the response, in per cent, with 95 % intervals of Student's t over "
        "packings left out in turn (`dataset.damper.effect_of`).  Higher or lower: at least three standard errors from "
        "none; not affected: an interval within 5 % over the whole range; p is Holm's, over all cells at once: "
        "cells at three errors of few packings need not pass it.",
        table(["factor", "response", "verdict", "effect", "p", "the paper's table", "agreement"], table_rows()),
        "## The paper's statements, sections 4.1 to 4.4",
        table(["section", "statement", "verdict", "figures"], statement_rows()),
        "## Figures 15 to 18",
        "Means over packings with their standard errors, of the beam's damping ratio at the studies' frequencies.",
        *pictures(),
        "## Factor by factor",
        "Optima by level with their own standard errors (none: no maximum stands out; -: not run there), and where the "
        "energy goes (dashpots normal and tangential; friction: slip and what contacts give up of their memory).  The "
        "test of monotony asks what speaks against a response that only rises or only falls: the one-sided p of the "
        "step between neighbouring levels that goes most clearly against the slope, times the number of steps; small "
        "means not monotonic, and 1 that no step goes against it surely.  The p of straightness is that of a bend "
        "as large as this one if the logarithms lie on a straight line: small means bent." + flat_top(),
        *(factor_page(factor) for factor in FACTORS),
        "## Checks",
        *checks_section(),
        *lammps_section(),
        *sensitivity_page(),
        "## What it cost",
        "Core-seconds of advancing cases, as each core took them beside other work; beds and clearances come on top; "
        "what several studies have in common is counted in each, and run once.  Each part goes on where it was left: "
        f"`{COMMAND} simulate NAME`.  Residual of the energy ledger: the largest among cases with an effectiveness "
        f"above {MOVING:g}; asked for was {100 * RESIDUAL:g} %.",
        table(
            ["study", "cases", "packings", "cycles", "steps a contact", "core-seconds", "residual", "state"],
            cost_rows(),
        ),
        LIMITS,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("simulate", nargs="?", choices=["simulate"])
    parser.add_argument("studies", nargs="*", metavar="study")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--packings", type=int, help="only the first of each study's packings")
    options = parser.parse_args()
    if options.simulate:
        simulate(options.studies or list(ORDER), options.workers, options.packings)
    if not options.studies:
        document()


if __name__ == "__main__":
    main()
