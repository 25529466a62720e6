"""Gamma of two-sided collision against the frequency, from eight packings, and the motion there; writes docs/gamma_c.*.

    python scripts/documents/gamma_c.py                        # the document, from docs/gamma_c.nc
    python scripts/documents/gamma_c.py simulate [--workers N] # the runs anew: about twenty minutes on one core

The paper's damper, compacted, at each of ten frequencies, and at amplitudes round that at which a plastic block
collides with floor and lid best.  The motion of four packings near an optimum is recorded: where the bed is, how thick,
and when floor and lid push.  May be stopped and started again: results/gamma_c keeps what is done.
"""

from __future__ import annotations

import itertools

import numpy as np
import xarray as xr
from shared import DOCS, ROOT, head, panels, progress, run_script, table, write_document

from warpdamp import Batch, Case, Drive, Grains, Request, load, prepare, run
from warpdamp.analysis.optimum import BLOCK_INTERCEPT, collision_optimum, optimum
from warpdamp.analysis.results import write
from warpdamp.config.study import Config
from warpdamp.numerics.regression import Line, straight_line
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene.paper import COUNT, RADIUS, damper
from warpdamp.scene.scene import STANDARD_GRAVITY

RUNS, MOTION = DOCS / "gamma_c.nc", DOCS / "gamma_c_motion.nc"
FREQUENCIES = (40, 56, 28, 64, 48, 32, 60, 36, 52, 44)
"""[Hz]; below, the optima of fluidisation and collision are one.  In this order what is done is a map at any time."""

RATIOS = np.array([0.8, 0.95, 1.1, 1.25, 1.4, 1.55])
"""Gamma over that of the plastic block."""

SEEDS, CYCLES, STEPS = list(range(1, 9)), 36, 12
PAPER_SLOPE, PAPER_EQUATION, BLOCK_SLOPE = 0.0029, 0.0028, 0.00287
"""Slopes [1/Hz^2]: of the paper's simulations, of its eq. 20, and of a plastic block with 2.257 mm under gravity."""

BLOCK_CLEARANCE = 2.2e-3
"""Eq. 2's clearance [m], round whose optimum amplitudes are taken."""

KEPT = (
    "effectiveness", "effectiveness_standard_error", "clearance", "clearance_after", "status", "cycles",
    "floor_impulse", "lid_impulse", "ledger_residual", "cpu_time",
)  # fmt: skip

MOTION_SEEDS, MOTIONS = (1, 2, 3, 4), {40.0: 6.0, 64.0: 14.5}
MOTION_CYCLES, RECORDED, SAMPLES = 40, 20, 48
"""Cycles, those at the end that are recorded, and records of a cycle; motions: Gamma near the optimum, by frequency."""


MOTION_COLUMNS = "motion", "packing", "clearance [mm]", "travel [mm]", "thickness [mm]", "floor", "lid"
MOTION_WORDS = (
    "The travel made is a sixth to a quarter less than the clearance at rest: a bed in flight is 0.4 to 0.7 mm thicker "
    "than at rest, and the middle of the lid's push comes before a block would hit it.  Pushes take 0.12 to 0.16 of a "
    "cycle, at 64 Hz as at 40.  So the optimum does not lie above the block's because the bed travels farther; what "
    "part the time that a push takes has in it was not measured."
)


def job(frequency: float) -> Config:
    """One frequency."""
    values = load(ROOT / "configs" / "frequency_map.yaml").model_dump()
    block = float(collision_optimum(frequency, BLOCK_CLEARANCE))
    values["excitation"] |= {"frequency": [frequency], "gamma": [round(float(r * block), 3) for r in RATIOS]}
    changes = {
        "steady_state": {"fewest_cycles": CYCLES, "most_cycles": CYCLES},
        "numerics": {"steps_per_contact": STEPS},
        "seeds": SEEDS,
    }
    return Config.model_validate(values | changes)


def simulate(workers: int | None) -> None:
    """The motion, and all frequencies, from the same beds."""
    if not MOTION.exists():
        parts = [xr.concat([motion(f, seed) for seed in MOTION_SEEDS], "seed") for f in MOTIONS]
        write(xr.concat(parts, "frequency", combine_attrs="override"), MOTION)
    parts = []
    for frequency in FREQUENCIES:
        store = ROOT / "results" / "gamma_c" / f"{frequency:g}"
        results = run(job(frequency), store=store, workers=workers, report=progress(f"{frequency:g} Hz"))
        part = results[list(KEPT)].rename(gamma="ratio").assign_coords(ratio=RATIOS)
        parts.append(part.assign(gamma=(("frequency", "ratio"), results["gamma"].values[None])))
        together = xr.concat(parts, "frequency", combine_attrs="override").sortby("frequency")
        together.attrs = {"title": "The paper's damper round the optimum of two-sided collision, eight packings"}
        write(together, RUNS)
        print(f"{frequency:g} Hz done", flush=True)


def motion(frequency: float, seed: int) -> xr.Dataset:
    """One packing near its optimum, at parts of its cycles, seen from the enclosure."""
    rest = damper(gamma=0)
    bed = prepare(Request(rest, Grains.alike(RADIUS, COUNT), seed))
    scene = rest.driven(Drive(frequency, MOTIONS[frequency] * STANDARD_GRAVITY))
    n = steps_per_cycle(scene, bed.state, steps_per_contact=STEPS)
    batch = Batch([Case(scene, bed.state, 1 / (frequency * n))], max_rows=MOTION_CYCLES + 1)
    first = (MOTION_CYCLES - RECORDED) * SAMPLES
    rows = []
    for sample in range(first, MOTION_CYCLES * SAMPLES + 1):
        batch.advance(round(sample * n / SAMPLES))
        ((state, ledger),) = batch.read()
        rows.append(_at(state, ledger))
    columns = {name: ("time", np.array([row[name] for row in rows])) for name in rows[0]}
    time = np.arange(first, MOTION_CYCLES * SAMPLES + 1) / SAMPLES
    result = xr.Dataset(columns, {"time": time}).assign(clearance=bed.clearance, at_rest=_thick(bed.state))
    return result.expand_dims(frequency=[frequency], seed=[seed])


def _at(state, ledger) -> dict[str, float]:
    """Mean height, how thick the bed is, and running totals of what floor and lid gave and of the dissipation."""
    totals = {name: float(ledger[name][-1]) for name in ("floor_impulse", "lid_impulse")}
    return {"height": float(state.position[:, 2].mean()), "thickness": _thick(state), **totals}


def _thick(state) -> float:
    """Distance of the upper and the lower quarter's mean heights, over their share of a uniform bed's [m]."""
    heights = np.sort(state.position[:, 2])
    quarter = len(heights) // 4
    return float(heights[-quarter:].mean() - heights[:quarter].mean()) / 0.75 + 2 * RADIUS


def curve(runs: xr.Dataset, frequency: float) -> xr.Dataset:
    """One frequency over Gamma, as ``optimum`` wants it."""
    at = runs.sel(frequency=[frequency])
    return at.assign_coords(gamma=("ratio", at["gamma"].values[0])).swap_dims(ratio="gamma").drop_vars("ratio")


def collision(runs: xr.Dataset, frequency: float) -> tuple[float, float]:
    """Gamma of collision, and the larger of its posterior's error and the jackknife's over packings."""
    whole = curve(runs, frequency)
    found = optimum(whole)
    value, error = (float(found[f"gamma_collision{s}"].item()) for s in ("", "_standard_error"))
    seeds = whole["seed"].values
    fewer = [optimum(whole.sel(seed=[s for s in seeds if s != out]))["gamma_collision"].item() for out in seeds]
    n = np.isfinite(fewer).sum()
    jackknife = np.sqrt((n - 1) * np.nanvar(fewer))
    return value, max(error, float(jackknife))


def cycle_of(pushes: np.ndarray) -> np.ndarray:
    """Mean over the cycles of what was added between records, (samples,)."""
    return np.diff(pushes).reshape(-1, SAMPLES).mean(axis=0)


def when(profile: np.ndarray) -> tuple[float, float]:
    """Middle of a push, in cycles, and how long it lasts from a tenth to nine tenths of it."""
    phase = (np.arange(SAMPLES) + 0.5) / SAMPLES
    middle = float(np.angle(np.sum(profile * np.exp(2j * np.pi * phase))) / (2 * np.pi)) % 1
    turned = np.roll(profile, SAMPLES // 2 - int(middle * SAMPLES))
    share = np.concatenate([[0], np.cumsum(turned) / turned.sum()])
    first, last = np.interp((0.1, 0.9), share, np.arange(SAMPLES + 1) / SAMPLES)
    return middle, last - first


def block_hits(frequency: float, gamma: float, clearance: float) -> tuple[float, float]:
    """When a plastic block with this clearance hits floor and lid [cycles], each flight from rest."""
    scale, lift = STANDARD_GRAVITY / (2 * np.pi * frequency) ** 2, np.arcsin(1 / gamma)
    theta = np.linspace(0, 4 * np.pi, 20_000)

    def flown(start):
        since = theta - start
        path = gamma * (np.cos(start) * since + np.sin(start) - np.sin(theta)) - since**2 / 2
        return scale * np.where(since > 0, path, 0.0)

    lid = theta[np.argmax(flown(lift) >= clearance)]
    floor = theta[np.argmax(flown(max(lid, np.pi - lift)) <= -clearance)]
    return float(floor / (2 * np.pi)) % 1, float(lid / (2 * np.pi)) % 1


def motion_rows(motions: xr.Dataset):
    """Of every packing: travel made, how thick the bed is, when and how long floor and lid push, and a block's hits."""
    for frequency, seed in itertools.product(motions["frequency"].values, motions["seed"].values):
        at = motions.sel(frequency=frequency, seed=seed)
        heights = at["height"].values[:-1].reshape(-1, SAMPLES)
        thick = at["thickness"].values[:-1].reshape(-1, SAMPLES)
        travel = float(np.mean(np.ptp(heights, axis=1)))
        clearance, rest = float(at["clearance"]), float(at["at_rest"])
        least, most = (1e3 * (float(edge(thick, axis=1).mean()) - rest) for edge in (np.min, np.max))
        pushes = [when(cycle_of(at[f"{wall}_impulse"].values)) for wall in ("floor", "lid")]
        hits = block_hits(frequency, MOTIONS[frequency], clearance)
        yield (
            f"{frequency:g} Hz, Gamma {MOTIONS[frequency]:g}",
            seed,
            f"{1e3 * clearance:.2f}",
            f"{1e3 * travel:.2f}",
            f"{least:+.2f} / {most:+.2f}",
            *(f"{middle:.2f}, {length:.2f}; {hit:.2f}" for (middle, length), hit in zip(pushes, hits, strict=True)),
        )


def picture(runs: xr.Dataset, found: dict[float, tuple[float, float]], line: Line, clearance: float) -> None:
    """Optima and lines over the square of the frequency, and one packing's motion."""
    figure, axes = panels(2, (11, 4))
    squares = np.array(list(found)) ** 2
    values, errors = np.array(list(found.values())).T
    axes[0].errorbar(squares, values, errors, fmt="o", ms=4, label="beds")
    axes[0].plot(squares, line.intercept + line.slope * squares, label="their line")
    axes[0].plot(
        squares, collision_optimum(np.sqrt(squares), clearance), "--", label="plastic block, clearance at rest"
    )
    axes[0].plot(squares, collision_optimum(np.sqrt(squares), clearance, gravity=False), ":", label="eq. 1")
    axes[0].set(xlabel="f^2 [Hz^2]", ylabel="Gamma of collision")
    axes[0].legend(fontsize=7)
    at = xr.load_dataset(MOTION).isel(frequency=0, seed=0)
    time = at["time"].values - at["time"].values[0]
    axes[1].plot(time, 1e3 * (at["height"] - at["height"].min()), label="mean height [mm]")
    axes[1].plot(time, 1e3 * (at["thickness"] - at["at_rest"]), label="thickness over that at rest [mm]")
    for wall in ("floor", "lid"):
        push = np.diff(at[f"{wall}_impulse"].values)
        axes[1].fill_between(
            time[1:], push / push.max(), alpha=0.4, step="pre", label=f"push of the {wall}, over its largest"
        )
    axes[1].set(xlim=(0, 4), xlabel="cycles", title="40 Hz, Gamma 6, packing 1")
    axes[1].legend(fontsize=7)
    figure.savefig(DOCS / "gamma_c.png")


def document() -> None:
    """Write docs/gamma_c.md and its picture."""
    runs, motions = xr.load_dataset(RUNS), xr.load_dataset(MOTION)
    found = {float(f): collision(runs, f) for f in runs["frequency"].values}
    values, errors = np.array(list(found.values())).T
    line = straight_line(np.array(list(found)) ** 2, values, errors)
    clearance, after = (float(runs[name].mean()) for name in ("clearance", "clearance_after"))
    picture(runs, found, line, clearance)
    write_document(
        "gamma_c.md",
        head("Gamma of collision over frequency", __file__)
        + f" from docs/gamma_c.nc (of physics version 6): {len(SEEDS)} compacted packings, "
        f"{len(found)} frequencies, {len(RATIOS)} amplitudes, {CYCLES} cycles, {STEPS} steps a contact; "
        f"{runs['status'].size} cases in {float(runs['cpu_time'].sum()):.0f} core-seconds.  Optima are maxima of a "
        "Gaussian process through all packings; their error is the larger of its posterior's and that of leaving "
        "packings out one at a time.",
        "![Gamma of collision over the square of the frequency, and the motion](gamma_c.png)",
        table(["f [Hz]", "Gamma of collision", "plastic block", "over the block's"], optimum_rows(found, clearance)),
        f"**Gamma_c = ({line.slope:.5f} ± {line.slope_standard_error:.5f}) f^2 + ({line.intercept:.2f} ± "
        f"{line.intercept_standard_error:.2f})**, chi^2 per degree of freedom {line.scatter:.1f}.",
        table(["", "slope [1/Hz^2]", "intercept"], lines(line, clearance, after)),
        "## The motion",
        "Four packings of physics version 5 near two "
        f"optima, {RECORDED} cycles after {MOTION_CYCLES - RECORDED}, {SAMPLES} records a "
        "cycle, seen from the enclosure.  Clearance: at rest.  Travel: of the centre of mass, from its lowest to its "
        "highest in a cycle.  Thickness: least and largest in a cycle, less that at rest.  Pushes of floor and lid: "
        "middle of their impulse, time from a tenth to nine tenths of it; and when a plastic block of the same "
        "clearance hits [cycles; the enclosure moves up fastest at 0.00 and down fastest at 0.50].",
        table(MOTION_COLUMNS, motion_rows(motions)),
        MOTION_WORDS,
    )


def optimum_rows(found: dict[float, tuple[float, float]], clearance: float):
    """Optima beside the plastic block's with the clearance measured."""
    for frequency, (value, error) in found.items():
        block = float(collision_optimum(frequency, clearance))
        yield (
            f"{frequency:g}",
            f"{value:.2f} ± {error:.2f}",
            f"{block:.2f}",
            f"{value / block:.2f} ± {error / block:.2f}",
        )


def lines(line: Line, clearance: float, after: float):
    """The line of the beds beside others."""
    per_metre = 4 * np.pi / STANDARD_GRAVITY
    return [
        (
            "beds",
            f"{line.slope:.5f} ± {line.slope_standard_error:.5f}",
            f"{line.intercept:.2f} ± {line.intercept_standard_error:.2f}",
        ),
        ("the paper's simulations", f"{PAPER_SLOPE}", "not given"),
        ("eq. 20, clearance of eq. 2 (2.18 mm)", f"{PAPER_EQUATION}", "0"),
        (f"eq. 20, clearance at rest before ({1e3 * clearance:.2f} mm)", f"{per_metre * clearance:.5f}", "0"),
        (f"eq. 20, clearance at rest after ({1e3 * after:.2f} mm)", f"{per_metre * after:.5f}", "0"),
        ("plastic block under gravity, 2.257 mm", f"{BLOCK_SLOPE}", f"{BLOCK_INTERCEPT}"),
        (
            "plastic block under gravity, clearance at rest",
            f"{BLOCK_SLOPE * clearance / 2.257e-3:.5f}",
            f"{BLOCK_INTERCEPT}",
        ),
    ]


if __name__ == "__main__":
    run_script(__doc__, simulate, document)
