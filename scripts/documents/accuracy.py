"""What accuracy costs, for the paper's scene at six points; writes docs/accuracy.md from docs/accuracy.nc.

    python scripts/documents/accuracy.py                        # the document, from the committed series
    python scripts/documents/accuracy.py simulate [--workers N] # the series anew: a quarter of an hour on two cores

The series are docs/accuracy.nc and, of a dilute bed, docs/stationary.nc.  The sections on coverage, price and presets
read what the scripts of these names write to docs.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from coverage import MIXTURE, with_intervals
from shared import DOCS, ROOT, head, processes, run_script, table, write_document

from warpdamp import Batch, Case, Grains, load
from warpdamp.analysis.accuracy import averaged, chance, cheapest, step_errors, systematic, transient
from warpdamp.analysis.results import write
from warpdamp.config.study import PRESETS
from warpdamp.damper.case import Request
from warpdamp.damper.preparation import prepare
from warpdamp.numerics.limits import FEWEST_PACKINGS
from warpdamp.numerics.steady import standard_error
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.numerics.tolerance import (
    LOOSE_MEMORY,
    RESIDUAL_FACTOR,
    STEP_ERROR,
    TIGHT_FILL,
    TIGHT_MEMORY,
    bed_memory,
    combined,
    settings_for,
    step_error,
    student,
)
from warpdamp.report.accuracy import PARTS, budget, budget_table, work_precision
from warpdamp.scene.paper import RADIUS, damper
from warpdamp.study.accuracy import points_of, study

SEEDS = [1, 2, 3, 4]
USUAL = "steps_per_contact=24"
DILUTE, DILUTE_CYCLES, STATIONARY = 30, (100, 600), DOCS / "stationary.nc"
"""Spheres that hold no state; cycles left out and kept; where they are kept."""


def cycles(spec) -> int:
    """More where a cycle is cheap."""
    frequency = spec.scene.drive.frequency
    return 160 if frequency < 100 else 400 if frequency < 500 else 600


def simulate(workers: int | None) -> None:
    """Run every variation, and the dilute bed, and keep the series."""
    config = load(ROOT / "configs" / "beam.yaml").model_copy(update={"seeds": SEEDS})
    with processes(workers) as executor:
        runs = study(points_of(config), cycles, executor, report=lambda done: print(f"{100 * done:.0f} %", flush=True))
    runs = runs.assign_attrs(title="Energies of cycles of the paper's damper, by numerical choice")
    write(runs, DOCS / "accuracy.nc")
    simulate_stationary(workers)


def dilute(seed: int) -> np.ndarray:
    """Energies per cycle [J] of a bed that remembers nothing: few of the paper's spheres, thrown about."""
    scene = damper()
    request = Request(scene, Grains.alike(RADIUS, DILUTE), seed, "loose")
    steps = steps_per_cycle(scene, request.grains, steps_per_contact=24)
    case = Case(scene, prepare(request).state, 1 / (scene.drive.frequency * steps))
    batch = Batch([case], max_rows=sum(DILUTE_CYCLES) + 1)
    batch.advance(sum(DILUTE_CYCLES) * steps)
    return batch.cycles(0).per_cycle()[DILUTE_CYCLES[0] :]


def simulate_stationary(workers: int | None) -> None:
    """Run the dilute bed and keep its series."""
    with processes(workers) as executor:
        series = np.array(list(executor.map(dilute, range(1, 9))))
    title = f"Energies of cycles of {DILUTE} spheres in the paper's cavity at 46 Hz and Gamma 6"
    write(xr.Dataset({"energy": (("seed", "cycle"), series, {"units": "J"})}, attrs={"title": title}), STATIONARY)


def stationary_section() -> list[str]:
    """What averaging leaves where nothing else is in the way."""
    series = xr.load_dataset(STATIONARY)["energy"].values
    found = np.array(averaged(series, (5, 10, 20, 40, 80)))
    slope = np.polyfit(np.log(found[:, 0]), np.log(found[:, 1]), 1)[0]
    rows = []
    for n, observed in found:
        claims = [standard_error(part) for row in series for part in np.split(row, range(int(n), len(row), int(n)))]
        claimed = rms(np.array(claims)) / series.mean()
        rows.append([f"{n:g}", f"{100 * observed:.1f} %", f"{100 * claimed:.1f} %"])
    packing = chance(series).packing
    return [
        "## Where cycles are stationary",
        f"{DILUTE} spheres in the same cavity at 46 Hz and Gamma 6: thrown about, they hold no state.  Eight beds, "
        f"{series.shape[1]} cycles each after {DILUTE_CYCLES[0]}: error of averages over n cycles, as observed from "
        "window to window, and as one window claims it (root mean squares).  It falls with the slope "
        f"**{slope:.2f}** (one over the root: -0.5); beds differ by {100 * packing:.1f} % beyond it.",
        table(["n", "observed", "claimed"], rows),
    ]


def rms(values) -> float:
    """Root mean square."""
    return float(np.sqrt((values**2).mean()))


def name(runs, p) -> str:
    """Of a point."""
    return f"{float(runs['frequency'][p]):.4g} Hz, Gamma {float(runs['gamma'][p]):g}"


def relative_cost(errors, variation) -> float:
    """Of a cycle, over that of the usual choice."""
    return float((errors["cost"].sel(variation=variation) / errors["cost"].sel(variation=USUAL)).median())


def systematic_section(runs, errors) -> list[str]:
    """Errors of every variation."""
    rows = []
    for variation in runs["variation"].values:
        cells = []
        for p in range(runs.sizes["point"]):
            at = errors.isel(point=p).sel(variation=variation)
            cells.append(f"{100 * float(at['error']):+.1f} ± {100 * float(at['error_standard_error']):.1f}")
        rows.append([str(variation), *cells, f"{relative_cost(errors, variation):.2f}"])
    heading = ["variation", *(name(runs, p) for p in range(runs.sizes["point"])), "cost"]
    usual = runs["effectiveness"].sel(variation=USUAL).values
    skins = (runs["effectiveness"].sel(variation=v).values for v in ("skin=0.05", "skin=0.5"))
    same = all(np.array_equal(other, usual, equal_nan=True) for other in skins)
    return [
        "## Each choice by itself",
        "Error of the energy per cycle against the reference [%], with its standard error, bed by bed from the same "
        "start; cost per cycle relative to the usual choice (24 steps a contact, float64, compacted bed).",
        table(heading, rows),
        f"The neighbour skin changes {'no bit of any cycle' if same else 'RESULTS, which is an error'}.",
    ]


def step_section(runs, errors) -> list[str]:
    """The step's law, and the ledger's residual as its witness."""
    rows, ratios = [], []
    for p in range(runs.sizes["point"]):
        law = step_errors(errors.isel(point=p))
        residual = abs(runs["residual"].isel(point=p)).mean("seed")
        shown = [
            f"{100 * law[n][0]:.2f} / {100 * float(residual.sel(variation=f'steps_per_contact={n:g}')):.2f}"
            for n in law
        ]
        slope = np.polyfit(
            np.log(list(law)), np.log([float(residual.sel(variation=f"steps_per_contact={n:g}")) for n in law]), 1
        )[0]
        ratios.append(law[10.0][0] / float(residual.sel(variation="steps_per_contact=10")))
        rows.append([name(runs, p), *shown, f"{slope:.2f}"])
    steps = [f"{n:g}" for n in step_errors(errors.isel(point=0))]
    coarse = errors.sel(variation="steps_per_contact=10")
    weight = 1 / coarse["error_standard_error"] ** 2
    pooled, chance_of_it = float((weight * coarse["error"]).sum() / weight.sum()), float(weight.sum()) ** -0.5
    left = float(abs(runs["residual"].sel(variation="steps_per_contact=10")).mean())
    return [
        "## The step",
        "Upper bound of the step's error by a law of second order, fitted to all steps (one standard error included), "
        "and the ledger's residual [%]; slope of the residual's fall.",
        table(["point", *(f"N = {n}" for n in steps), "slope"], rows),
        f"All six points together are off by {100 * pooled:+.2f} ± {100 * chance_of_it:.2f} % at N = 10, which is "
        f"{100 * pooled * (10 / 24) ** 2:+.2f} % at N = 24, and {pooled / left:.1f} times the residual.  Point by "
        f"point chance is larger than that: bounds of {min(ratios):.1f} to {max(ratios):.1f} times the residual.  A "
        f"study takes {RESIDUAL_FACTOR:g} times the residual as a case's step error, and {100 * STEP_ERROR:g} % at 24 "
        "steps when it chooses the step beforehand.",
    ]


def averaging_section(runs) -> list[str]:
    """What averaging leaves."""
    rows = []
    for p in range(runs.sizes["point"]):
        own = runs["effectiveness"].isel(point=p).sel(variation=USUAL).values
        point = chance(own)
        counts = [n for n in (5, 10, 20, 40, 80) if n <= np.isfinite(own[0]).sum() // 6]
        found = np.array(averaged(own, counts))
        slope = np.polyfit(np.log(found[:, 0]), np.log(found[:, 1]), 1)[0]
        loose = runs["effectiveness"].isel(point=p).sel(variation="preparation=loose").values
        cut = [f"{100 * transient(loose, k):.0f}" for k in (0, 10, 40)]
        rows.append(
            [name(runs, p), f"{100 * point.one_cycle:.1f}", f"{slope:.2f}", f"{100 * point.packing:.1f}"]
            + [f"{100 * transient(own, k):.1f}" for k in (0, 10, 40)]
            + cut
        )
    return [
        "## Averaging, discarding, packings",
        "Standard error of one uncorrelated cycle [%] (n of them leave it over root n); slope of the observed error of "
        "averages over n cycles (-0.5 where cycles are stationary); standard deviation between packings [%]; error of "
        "an average over half the run after 0, 10, 40 cycles discarded [%], compacted and loose beds: a loose bed "
        "drifts, and no averaging mends that; nor does it mend what beds in different states (docs/bed-states.md) "
        "differ by, which is why slopes are flatter than -0.5 here.",
        table(["point", "one cycle", "slope", "packings", "0", "10", "40", "loose, 0", "loose, 10", "loose, 40"], rows),
    ]


def budget_section(runs) -> list[str]:
    """What the error is made of."""
    rows = [[name(runs, p), *(f"{100 * part:.2f}" for part in parts)] for p, parts in enumerate(budget_table(runs))]
    return [
        "## Error budget",
        "Of 24 steps a contact, 60 cycles averaged, three packings [% of the energy per cycle].",
        table(["point", *PARTS], rows),
        "![budget](accuracy-budget.png)",
    ]


def cheapest_section(runs, errors) -> list[str]:
    """What an error costs at the least."""
    rows = []
    for p in range(runs.sizes["point"]):
        own = runs["effectiveness"].isel(point=p).sel(variation=USUAL).values
        cells = []
        for tolerance in (0.1, 0.05, 0.02, 0.01):
            best = cheapest(step_errors(errors.isel(point=p)), chance(own), tolerance)
            cells.append("not reached" if best is None else f"N {best[0]:g}, {best[1]} x {best[2]}: {best[3]:.2g}")
        rows.append([name(runs, p), *cells])
    return [
        "## The cheapest settings for an error",
        "Steps a contact, packings x cycles averaged: core-seconds (a transient of half the cycles averaged included, "
        "the beds not).",
        table(["point", "10 %", "5 %", "2 %", "1 %"], rows),
        "![work and precision](accuracy.png)",
        "What `accuracy: {tolerance: ...}` chooses:",
        table(
            ["preset", "tolerance", "steps a contact", "step's error at most", "left to each case"],
            [
                [name, f"{100 * preset['tolerance']:g} %", f"{chosen.steps_per_contact:.0f}"]
                + [f"{100 * step_error(chosen.steps_per_contact):.2f} %", f"{100 * chosen.standard_error:.2f} %"]
                for name, preset in PRESETS.items()
                for chosen in [settings_for(preset["tolerance"])]
            ],
        ),
        "The motion is float64 at every tolerance, unless `numerics.precision` says otherwise: a bed that hardly moves "
        "drowns in the rounding of float32 ([stability.md](stability.md)).  The costs above are of the code that the "
        "runs are of; what float32 takes today is in [effects.md](effects.md).",
    ]


def coverage_section() -> list[str]:
    """Whether intervals hold."""
    cases = with_intervals(xr.load_dataset(DOCS / "coverage.nc"))
    cases = cases.isel(case=np.flatnonzero(cases["draw"] == "tested"))
    gamma, part = cases["gamma"], cases["fill"]
    groups = {"all": part > 0} | {str(name): cases["bed"] == name for name in np.unique(cases["bed"])}
    groups |= {f"filled below {TIGHT_FILL:g}": part < TIGHT_FILL, f"to {TIGHT_FILL:g} and more": part >= TIGHT_FILL}
    groups |= {"Gamma below 4": gamma < 4, "Gamma 4 to 8": (gamma >= 4) & (gamma < 8), "Gamma above 8": gamma >= 8}
    return [
        "## Do the intervals hold?",
        "Written from `coverage.py`: each case runs as with a tolerance of 5 %; the reference is the mean of the "
        "same bed over five times as many cycles afterwards.  Share of steady cases whose 95 % "
        "interval, of this one packing, holds the reference (asked for: 93-97 %), with its standard error; the share "
        "that the average over cycles alone would hold; the interval's mean half-width, the reference's own standard "
        "error, and by how much claims are off (root mean square, and at most).",
        "The average over cycles alone is not enough: a bed stays in one state for hundreds of cycles, with small "
        f"fluctuations about a level that is its own.  Each claim therefore carries {100 * LOOSE_MEMORY:g} % for the "
        f"state that its bed happens to be in, {100 * TIGHT_MEMORY:g} % where the cavity is filled to {TIGHT_FILL:g} "
        "and more ([bed-states.md](bed-states.md) says what another draw measures of it).  Packings "
        "are in different states and average this part out.",
        table(
            COVERAGE_COLUMNS, (coverage_row(name, cases.isel(case=np.flatnonzero(of))) for name, of in groups.items())
        ),
        missed(cases),
        "A study takes three packings and more.  The mean of three, its interval as a study claims it, and the mean of "
        "their references:",
        table(["cases", "points", "covered", "half-width"], packings_rows(cases)),
    ]


def missed(cases: xr.Dataset) -> str:
    """Which single packings miss."""
    outside = (abs(cases["claimed"] - cases["reference"]) > cases["interval"]) & (cases["status"] == 0)
    off = cases.isel(case=np.flatnonzero(outside))
    mixed = off.isel(case=np.flatnonzero(off["bed"] == MIXTURE))
    ratio = (mixed["reference"] / mixed["claimed"]).values
    return (
        f"Of the {off.sizes['case']} that miss {mixed.sizes['case']} are mixtures, and {int(np.sum(ratio > 1))} of "
        f"these dissipate more afterwards, up to {ratio.max():.1f} times what was claimed: such beds go over from one "
        "motion to another after some tens or hundreds of cycles, which no shorter average can know."
    )


def packings_rows(cases: xr.Dataset):
    """Whether the interval of the mean over the packings of a point holds the mean of their references, by bed."""
    steady = cases.isel(case=np.flatnonzero(cases["status"] == 0))
    held: dict[str, list[tuple[bool, float]]] = {"all": []}
    for (bed, _), own in steady.groupby(["bed", "point"]):
        if own.sizes["case"] < FEWEST_PACKINGS:
            continue
        claimed = own["claimed"].values
        memory = np.array([bed_memory(fill) for fill in own["fill"].values]) * claimed
        answer = combined(claimed, own["standard_error"].values, own["degrees_of_freedom"].values, memory)
        off = abs(answer.mean - float(own["reference"].mean()))
        found = bool(off <= answer.interval), float(answer.interval / answer.mean)
        held["all"].append(found)
        held.setdefault(str(bed), []).append(found)
    for name, found in held.items():
        inside, width = np.mean(found, axis=0)
        yield name, len(found), f"{100 * inside:.0f} %", f"{100 * width:.1f} %"


COVERAGE_COLUMNS = (
    *("cases", "drawn", "steady", "covered", "by averaging alone"),
    *("half-width", "reference", "off, rms", "off, most"),
)


def coverage_row(label: str, cases: xr.Dataset) -> tuple[str, ...]:
    """Coverage of some cases."""
    steady = cases.isel(case=np.flatnonzero(cases["status"] == 0))
    claimed, reference = steady["claimed"], steady["reference"]
    off = abs(claimed - reference)
    held, averaged_only = (float((off <= steady[name]).mean()) for name in ("interval", "averaging_interval"))
    chance_of = np.sqrt(held * (1 - held) / steady.sizes["case"])
    return (
        label,
        cases.sizes["case"],
        steady.sizes["case"],
        f"{100 * held:.0f} ± {100 * chance_of:.0f} %" if 0 < held < 1 else f"{100 * held:.0f} %",
        f"{100 * averaged_only:.0f} %",
        f"{100 * float((steady['interval'] / claimed).mean()):.1f} %",
        f"{100 * float((steady['reference_standard_error'] / reference).mean()):.1f} %",
        f"{100 * rms(claimed / reference - 1):.1f} %",
        f"{100 * float((off / reference).max()):.0f} %",
    )


def price_section() -> list[str]:
    """What a tolerance saves."""
    price = xr.load_dataset(DOCS / "price.nc")
    off = (price["claimed"] / price["fixed"]).values - 1
    claimed = rms(price["claimed_error"] / price["claimed"])
    bought, paid = float(price["tolerance_cpu_time"]), float(price["fixed_cpu_time"])
    return [
        "## What a tolerance saves",
        "Written from `price.py`: the main job at Gamma 2, 6 and 13, at `tolerance: 5 %`, and at the paper's "
        f"step of 2e-6 s with one fixed length, {int(price['fixed_cycles'])} cycles, with which every case has the "
        f"standard error that the tolerance gives it.  Core-seconds of the cases: {bought:.0f} against {paid:.0f}, "
        f"**{100 * bought / paid:.0f} %** (asked for: at most 25 %), for {int(price['tolerance_cases'])} cases against "
        f"{int(price['fixed_cases'])}.  Cycles a case took: median {float(price['cycles'].median()):.0f}, largest "
        f"{float(price['cycles'].max()):.0f}.  Points within the tolerance: {int(price['within_tolerance'].sum())} of "
        f"{price.sizes['point']}; the others say that they are not.  Against the fixed runs, which use three of the "
        f"same packings, energies are off by {100 * rms(off):.1f} % (root mean square; at most "
        f"{100 * abs(off).max():.0f} %), and the standard error claimed is {100 * claimed:.1f} % (root mean square).",
    ]


def presets_section() -> list[str]:
    """What the presets err by."""
    presets = xr.load_dataset(DOCS / "presets.nc")
    rows = []
    for preset in presets["preset"].values:
        at, tolerance = presets.sel(preset=preset), PRESETS[str(preset)]["tolerance"]
        statistical = np.sqrt(at["claimed"] ** 2 - at["step_error"] ** 2)
        reference = student(at.attrs["packings"] - 1) * at["reference_error"]
        held = abs(at["off"]) <= np.hypot(at["interval"] * (1 + at["off"]), reference)
        rows.append(
            [preset, f"{100 * tolerance:g} %", f"{100 * rms(at['claimed']):.1f} %", f"**{100 * rms(at['off']):.1f} %**"]
            + [f"{100 * float(abs(at['off']).max()):.1f} %", f"{int(held.sum())} of {held.size}"]
            + [f"{int(at['within_tolerance'].sum())} of {held.size}"]
            + [f"{100 * float((at['step_error'] / statistical).max()):.0f} %"]
            + [f"{int(at['packings'].min())} to {int(at['packings'].max())}"]
            + [f"{float(at['cycles'].mean()):.0f}", f"{float(at['cpu_time'].sum()):.0f}"]
        )
    heading = "preset, tolerance, claimed, off, at most, interval holds, within tolerance, step, packings, cycles"
    return [
        "## What the presets err by",
        "Written from `presets.py`: the main job at Gamma 2, 6 and 13 in modes 1, 3 and 5, against the mean of "
        f"{presets.attrs['reference']}, known to {100 * rms(presets['reference_error']):.1f} % (standard error; root "
        f"mean squares over points, as all here).  One packing over those cycles is off by "
        f"{100 * rms(presets['one_packing']):.1f} %.  Claimed: the standard error, all parts together; interval holds: "
        "off by no more than both 95 % intervals, in quadrature; step: its error over the statistical one, both as "
        "claimed, at most; packings a point; cycles a case; core-seconds of the cases, beds not counted.",
        table([*heading.split(", "), "core-seconds"], rows),
        *(f"Not measured: {preset}." for preset in PRESETS if preset not in presets["preset"].values),
    ]


def document() -> None:
    """Write docs/accuracy.md and its pictures."""
    runs = xr.load_dataset(DOCS / "accuracy.nc")
    errors = systematic(runs)
    work_precision(runs).savefig(DOCS / "accuracy.png")
    budget(runs).savefig(DOCS / "accuracy-budget.png")
    write_document(
        "accuracy.md",
        head("What accuracy costs", __file__) + " from docs/accuracy.nc: the paper's damper at six points, "
        f"{runs.sizes['seed']} compacted beds, 160, 400 and 600 cycles a run in modes 1, 3 and 5.  The reference is "
        "float64 with 48 steps a contact over all of them; the first third of every run is left out.",
        *systematic_section(runs, errors),
        *step_section(runs, errors),
        *averaging_section(runs),
        *stationary_section(),
        *budget_section(runs),
        *cheapest_section(runs, errors),
        *(coverage_section() if (DOCS / "coverage.nc").exists() else []),
        *(price_section() if (DOCS / "price.nc").exists() else []),
        *(presets_section() if (DOCS / "presets.nc").exists() else []),
    )


if __name__ == "__main__":
    run_script(__doc__, simulate, document)
