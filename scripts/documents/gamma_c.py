"""Gamma of two-sided collision against the frequency, from eight packings, and the motion there; writes docs/gamma_c.*.

    python scripts/documents/gamma_c.py                        # the document, from docs/gamma_c.nc
    python scripts/documents/gamma_c.py simulate [--workers N] # the runs anew: about twenty minutes on one core

The paper's damper, compacted, at each of ten frequencies, and at amplitudes round that at which a plastic block
collides with floor and lid best.  The motion of four packings near an optimum is recorded: where the bed is, how thick,
and when floor and lid push.  May be stopped and started again: results/gamma_c keeps what is done.
"""

from __future__ import annotations

import gamma_c_motion as motion
import numpy as np
import xarray as xr
from plastic_block import exchange
from scipy.interpolate import CubicSpline
from shared import DOCS, ROOT, head, panels, progress, run_script, table, write_document

from warpdamp import load, run
from warpdamp.analysis.optimum import BLOCK_INTERCEPT, collision_optimum, optimum
from warpdamp.analysis.results import write
from warpdamp.config.study import Config
from warpdamp.numerics.regression import Line, straight_line
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

CURVE = 301
"""Points of a curve over Gamma at which its maximum is looked for."""


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
        blocks = {f: float(collision_optimum(f, BLOCK_CLEARANCE)) for f in motion.FREQUENCIES}
        record = xr.concat([motion.record(f, job(f), block) for f, block in blocks.items()], "frequency")
        write(record.assign_attrs(title="Mean cycles of the paper's damper round the optimum of collision"), MOTION)
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


def momentum_and_timing(runs: xr.Dataset, frequency: float, seeds) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gamma, and over it what packings exchange with floor and lid over 2 m V, and their effectiveness over that.

    Between the amplitudes run, by cubic splines.
    """
    at = runs.sel(frequency=frequency, seed=seeds).mean("seed")
    gamma = at["gamma"].values
    ideal = 4 * COUNT * float(damper(gamma=0).mass(RADIUS)) * gamma * STANDARD_GRAVITY / (2 * np.pi * frequency)
    momentum = (at["floor_impulse"] + at["lid_impulse"]).values / ideal
    fine = np.linspace(gamma.min(), gamma.max(), CURVE)
    timing = at["effectiveness"].values / momentum
    return fine, CubicSpline(gamma, momentum)(fine), CubicSpline(gamma, timing)(fine)


def causes(runs: xr.Dataset, seeds, blocks: dict[float, tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Slope and intercept over f^2 of the maximum of momentum times timing, (momentum of, timing of, 2).

    Both of the block (0) or of the beds (1).
    """
    found = np.empty((2, 2, len(blocks)))
    for k, (frequency, block) in enumerate(blocks.items()):
        fine, *beds = momentum_and_timing(runs, frequency, seeds)
        for i, j in np.ndindex(2, 2):
            found[i, j, k] = fine[np.argmax((block, beds)[i][0] * (block, beds)[j][1])]
    squares = np.array(list(blocks)) ** 2
    return np.polynomial.polynomial.polyfit(squares, found.reshape(4, -1).T, 1).T.reshape(2, 2, 2)[..., ::-1]


def cause_rows(runs: xr.Dataset, clearance: float):
    """Lines of the optimum that momentum and timing give, of block and beds; errors by leaving out packings."""
    seeds = list(runs["seed"].values)
    blocks = {}
    for frequency in map(float, runs["frequency"].values):
        fine, _, _ = momentum_and_timing(runs, frequency, seeds)
        blocks[frequency] = exchange(frequency, fine, clearance)
    whole = causes(runs, seeds, blocks)
    fewer = [causes(runs, [s for s in seeds if s != out], blocks) for out in seeds]
    error = np.sqrt((len(seeds) - 1) * np.var(fewer, axis=0))
    for i, j in np.ndindex(2, 2):
        (slope, intercept), (slope_error, intercept_error) = whole[i, j], error[i, j]
        yield (
            *(("block", "beds")[i], ("block", "beds")[j]),
            *(f"{slope:.5f} ± {slope_error:.5f}", f"{intercept:.2f} ± {intercept_error:.2f}"),
        )


def picture(runs: xr.Dataset, found: dict[float, tuple[float, float]], line: Line, clearance: float) -> None:
    """Optima and lines over the square of the frequency, and momentum and timing over Gamma at the highest."""
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
    highest = float(runs["frequency"].max())
    fine, *beds = momentum_and_timing(runs, highest, runs["seed"].values)
    block = exchange(highest, fine, clearance)
    for values, style, whose in ((beds, "-", "beds"), (block, "--", "plastic block")):
        for k, (curve_of, name) in enumerate(zip(values, ("momentum", "timing"), strict=True)):
            axes[1].plot(fine, curve_of, style, color=f"C{k}", label=f"{name}, {whose}")
        axes[1].plot(fine, values[0] * values[1], style, color="k", label=f"effectiveness, {whose}")
    axes[1].set(xlabel="Gamma", title=f"{highest:g} Hz")
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
        *cause_section(runs, motions, clearance),
    )


def cause_section(runs: xr.Dataset, motions: xr.Dataset, clearance: float) -> list[str]:
    """Why beds need more than eq. 1 says."""
    mean = motion.means(motions).sel(frequency=slice(40, None))
    below, near = (mean.sel(ratio=ratio) for ratio in (0.95, 1.1))
    rest = float(motions["clearance"].mean())

    def shorter(travel: xr.DataArray) -> float:
        return 100 - 100 * float(travel) / rest

    def span(values: xr.DataArray) -> str:
        return f"{float(values.min()):.2f} to {float(values.max()):.2f}"

    return [
        "## Why the slope is above eq. 1's",
        "Effectiveness is momentum times timing: the mean impulse of floor and lid in a cycle over 2 m V, V the "
        "largest speed of the enclosure; and the work over what these impulses would do at V (friction at the side "
        "included).  Where the maximum over Gamma lies if either is that of the beds, or that of a plastic block "
        "under gravity with their clearance at rest; lines over f^2 through the ten frequencies, errors by leaving "
        "packings out one at a time (maxima of splines through six amplitudes; those of the Gaussian process, above, "
        "give a slope a little larger):",
        table(["momentum of", "timing of", "slope [1/Hz^2]", "intercept"], cause_rows(runs, clearance)),
        "So the time of collision is not the cause: with the block's momentum, the beds' timing would put the "
        f"optimum below the block's.  The cause is the momentum.  {momenta(runs, clearance)}, and what that gains is "
        "worth more than what pushes lose that come too early.",
        "## The motion",
        f"Four of the packings, mean of {motion.RECORDED} cycles after {motion.CYCLES - motion.RECORDED}, "
        f"{motion.SAMPLES} records a cycle, seen from the enclosure; mean clearance at rest "
        f"{1e3 * rest:.2f} mm.  Gamma also over that of a block with 2.2 mm.  Travel: of "
        "the centre of mass, from its lowest to its highest.  Thickness: least and largest, less that at rest.  Speed: "
        "half of the range of the bed's velocity in the laboratory, over V.  Floor, lid: middles of their pushes "
        "[cycles; the enclosure moves up fastest at 0 and down fastest at 0.5].  Middle, length: cosine of the phases "
        "of the pushes, and what their length takes off the work; side: part of the work by friction at the side.",
        table(motion.COLUMNS, motion.rows(motions)),
        "From 40 Hz on, at 0.95 and at 1.1 times the block's Gamma:",
        f"- Thickness in flight: the bed travels {span(1e3 * below['travel'])} and {span(1e3 * near['travel'])} mm, "
        f"{shorter(near['travel'].max()):.0f} to {shorter(below['travel'].min()):.0f} % less than its clearance, for "
        "it is thicker in flight, and not as thin as at rest even under impact.  By itself that would lower the "
        "optimum.",
        f"- Speed of flight: {span(below['speed'])} and {span(near['speed'])} of V.  A bed that travels less is as "
        "slow as it takes to arrive in time, half a cycle later: at 0.95 the middles of the pushes are within "
        f"{float(abs(np.stack([below['floor'], below['lid'] - 0.5])).max()):.2f} cycles of the best moment.  Both "
        "errors of eq. 1, in travel and in speed, cancel there.",
        f"- Length of the pushes: their factor is {span(mean['length'])} at all frequencies and amplitudes, so that it "
        "lowers the effectiveness and does not move the optimum.",
        "- No rebound: at 0.95 the bed is slower than the wall that it leaves, not faster, and thicker than at rest: "
        "the wall recedes before its push has gone through the bed.",
        f"- From 0.95 to 1.1 times the block's Gamma the momentum rises from ({span(below['momentum'])}) to "
        f"({span(near['momentum'])}), while pushes that come early take the middle's factor from "
        f"({span(below['middle'])}) to ({span(near['middle'])}) only.  The higher the frequency, the less of the "
        "momentum a bed has at the same ratio, as gravity collects it on the floor less: that is why the slope is "
        "larger, and not a constant added.",
    ]


def momenta(runs: xr.Dataset, clearance: float) -> str:
    """Momentum of a plastic block and of the beds, from 40 Hz on, by Gamma over that of the block's optimum."""
    block, bed, later = [], [], []
    for frequency in map(float, runs["frequency"].sel(frequency=runs["frequency"] >= 40).values):
        fine, own, _ = momentum_and_timing(runs, frequency, list(runs["seed"].values))
        ratio = fine / float(collision_optimum(frequency, clearance))
        block.append(np.interp(0.9, ratio, exchange(frequency, fine, clearance)[0]))
        bed.append(np.interp(0.9, ratio, own))
        later.append(np.interp(1.4, ratio, own))
    spans = (f"{min(values):.2f} to {max(values):.2f}" for values in (block, bed, later))
    return (
        "From 40 Hz on, at 0.9 times the Gamma of its optimum, a plastic block has {} of the momentum 2 m V, a bed {}; "
        "a bed's goes on rising, to {} at 1.4 times"
    ).format(*spans)


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
