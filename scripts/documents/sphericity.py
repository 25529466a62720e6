"""The shape of particles: the paper's fig. 14 with spheroids, and its three statements; writes docs/sphericity.*.

    python scripts/documents/sphericity.py                        # the document, from docs/sphericity.nc
    python scripts/documents/sphericity.py simulate [--workers N] # the runs anew

configs/sphericity.yaml with runs of one length, packing after packing, so that what is done is a whole study at any
time.  May be stopped and started again: results/sphericity keeps what is done.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from shape_statistics import Band, Collision, bands, clearances, collisions, interval, shared_part, trend
from shared import DOCS, ROOT, head, panels, progress, run_script, table, write_document

import warpdamp.accessor  # noqa: F401  gives datasets their ``damper``
from warpdamp import load, run
from warpdamp.analysis.results import write
from warpdamp.config.study import Config
from warpdamp.damper.compaction import packing_fraction
from warpdamp.modal.damping import damping_of_effectiveness
from warpdamp.scene.aspect import semi_axes
from warpdamp.scene.paper import CAVITY, COUNT, RADIUS
from warpdamp.status import Status

RUNS = DOCS / "sphericity.nc"
PACKINGS = 8
NEAR, FAR = (0.7, 1.0, 1.4), (0.5, 2.0, 2.5)
ASPECTS = sorted(NEAR + FAR)


@dataclass(frozen=True)
class Part:
    """Part of the study: modes, aspects, amplitudes, cycles, and steps a contact."""

    modes: tuple[int, ...]
    aspects: tuple[float, ...]
    gammas: tuple[float, ...]
    cycles: int
    steps: int


LOW, HIGH = (0.5, 1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 10, 12, 14), (17, 20)
FLUIDISED = (0.5, 1, 1.5, 2, 3, 5, 8, 11, 14)
PARTS = {
    "mode 1, near spheres": Part((1,), NEAR, LOW, 16, 22),
    "mode 1, far from spheres": Part((1,), FAR, LOW + HIGH, 16, 18),
    "modes 3 and 5, near spheres": Part((3, 5), NEAR, FLUIDISED, 160, 22),
    "modes 3 and 5, far from spheres": Part((3, 5), FAR, FLUIDISED, 160, 18),
}
"""What each packing is run in.  Shapes far from spheres collide with the lid at higher amplitudes; their shortest
contacts are so much shorter that fewer steps to one close the ledger as well.  Sixteen cycles of mode 1 are 0.4 s, the
paper's 0.3 s and some; 160 of mode 3 are 0.6 s: beds of spheroids take that long until they sink no more."""

BANDS = {1: (1.5, 3.0), 3: (1.5, 14.0), 5: (1.5, 14.0)}
"""Amplitudes by mode at which beds move and do not collide with the lid together."""

RESIDUAL = 0.005
SIGNIFICANT = 0.05

MOSTLY = 0.5
"""Part of a mode's cases that still drift from which on it is not judged: differences may be of beds that sink."""

KEPT = (
    "effectiveness", "effectiveness_standard_error", "clearance", "clearance_after", "status", "cycles",
    "ledger_residual", "largest_overlap", "compaction_blocks", "floor_impulse", "lid_impulse", "cpu_time",
)  # fmt: skip


def job(part: Part, packings: int) -> Config:
    """A part of the study with some packings."""
    values = load(ROOT / "configs" / "sphericity.yaml").model_dump()
    values["structure"]["modes"] = list(part.modes)
    values["excitation"]["gamma"] = list(part.gammas)
    changes = {
        "steady_state": {"fewest_cycles": part.cycles, "most_cycles": part.cycles},
        "numerics": {"steps_per_contact": part.steps},
        "seeds": list(range(1, packings + 1)),
        "sweep": {"product": {"shape.aspect": list(part.aspects)}},
    }
    return Config.model_validate(values | changes)


def simulate(workers: int | None) -> None:
    """All parts of one packing, then those of the next; what is done is written after each part."""
    parts: dict[str, xr.Dataset] = {}
    for packings in range(1, PACKINGS + 1):
        for name, part in PARTS.items():
            store = ROOT / "results" / "sphericity" / name.replace(",", "").replace(" ", "-")
            results = run(
                job(part, packings), store=store, workers=workers, report=progress(f"packing {packings},", name)
            )
            parts[name] = _by_mode(results)
            write(_together(parts), RUNS)


def _by_mode(results: xr.Dataset) -> xr.Dataset:
    by_mode = results[list(KEPT)].drop_vars("frequency").rename(frequency="mode")
    known = {name: results[name] for name in ("natural_frequency", "mode_amplitude", "particle_mass")}
    return by_mode.assign_coords(mode=results["mode"]).assign(known)


def _together(parts: dict[str, xr.Dataset]) -> xr.Dataset:
    first, *others = parts.values()
    for other in others:
        first = first.combine_first(other)
    first.attrs = {"title": "Spheroids in the paper's damper on its beam, compacted packings"}
    return first


def aspects(results: xr.Dataset) -> list[float]:
    """Aspects of a Dataset."""
    return results["aspect"].values.tolist()


def shape_rows(results: xr.Dataset):
    """Semi-axes, clearances and packing fractions of every shape."""
    for aspect in aspects(results):
        a, b = semi_axes(RADIUS, aspect)
        (before, error), (after, after_error) = (
            clearances(results, aspect, name) for name in ("clearance", "clearance_after")
        )
        fraction = packing_fraction((RADIUS,) * COUNT, CAVITY, before)
        blocks = float(results["compaction_blocks"].sel(aspect=aspect, mode=1).mean())
        yield (
            f"{aspect:g}",
            f"{1e3 * a:.2f}, {1e3 * b:.2f}",
            f"{1e3 * before:.2f} ± {1e3 * error:.2f}",
            f"{1e3 * after:.2f} ± {1e3 * after_error:.2f}",
            f"{fraction:.3f}",
            f"{blocks:.1f}",
        )


QUANTITIES = {
    "gamma_fluidisation": "Gamma_f",
    "effectiveness_fluidisation": "eps_f",
    "gamma_collision": "Gamma_c",
    "effectiveness_collision": "eps_c",
}


def optimum_rows(found: xr.Dataset):
    """Both optima of every mode and shape, then their trends."""
    for mode in found["mode"].values:
        of_mode = found.sel(mode=mode)
        for aspect in aspects(found):
            at = of_mode.sel(aspect=aspect)
            yield f"{mode}", f"{aspect:g}", *(_pair(at[name], at[f"{name}_standard_error"]) for name in QUANTITIES)
        trends = (trend(aspects(found), of_mode[name], of_mode[f"{name}_standard_error"]) for name in QUANTITIES)
        yield f"{mode}", "slope over \\|ln aspect\\|", *("-" if own is None else f"{own}" for own in trends)


def _pair(value, error) -> str:
    return f"{float(value):.3g} ± {float(error):.2g}" if np.isfinite(value) else "-"


def collision_rows(own: dict[float, Collision]):
    """Gamma of collision beside the block's; its rise over that of spheres, and the part that clearance explains."""
    sphere = own[1.0]
    for shape in own.values():
        ratio = "{:.2f} ± {:.2f}".format(*shape.over_block)
        if shape is sphere:
            yield "1", f"{shape.block:.2f}", ratio, "", "", "", ""
            continue
        parts = [own_part(sphere) for own_part in (shape.rise, shape.explained, shape.left)]
        shown = ["{:+.2f} ± {:.2f}".format(*part) for part in parts]
        share = f"{100 * parts[1][0] / parts[0][0]:.0f} %"
        yield f"{shape.aspect:g}", f"{shape.block:.2f}", ratio, *shown[:2], share, shown[2]


def band_rows(own: list[Band]):
    """Every mode's band: each shape beside spheres, and whether that is more than chance."""
    for band in own:
        low, high = BANDS[band.mode]
        shown = (f"{100 * value:+.1f} %" for aspect, value in band.differences.items() if aspect != 1)
        yield f"{band.mode}", f"{low:g}-{high:g}", f"{band.values[1.0].mean():.3f}", *shown, f"{band.p:.2g}", band.trend


def statements(
    found: xr.Dataset, own: dict[float, Collision], fluidised: list[Band], moving: dict[int, float]
) -> list[str]:
    """The paper's statements, one by one, with what came out."""
    others, sphere = [shape for shape in own.values() if shape.aspect != 1], own[1.0]
    higher, beyond = (
        sum(value > 2 * error for value, error in (getattr(shape, name)(sphere) for shape in others))
        for name in ("rise", "left")
    )
    at = found.sel(mode=1)
    collision, height = (
        trend(aspects(found), at[name], at[f"{name}_standard_error"])
        for name in ("gamma_collision", "effectiveness_collision")
    )
    share, error = shared_part(own)
    judged = [band for band in fluidised if moving[band.mode] < MOSTLY]
    unlike = [f"mode {band.mode}" for band in judged if band.p < SIGNIFICANT]
    left_out = ", ".join(f"mode {band.mode}" for band in fluidised if band not in judged)
    largest = ", ".join(
        f"{100 * max(map(abs, band.differences.values())):.1f} % in mode {band.mode}" for band in fluidised
    )
    return [
        "1. *The optimum of collision occurs at higher amplitudes for non-spherical particles.*  "
        f"{_verdict(higher, len(others))}: of {len(others)} shapes {higher} lie more than two standard errors above "
        f"spheres; slope over |ln aspect| {collision}.  Slope of its height, which Table 1 says is not affected: "
        f"{height}.",
        "2. *There are two causes: they pack more closely, which leaves more clearance, and they resist shear more.*  "
        f"The clearance explains {100 * share:.0f} ± {100 * error:.0f} % of the rises of all shapes together, if they "
        f"collide as far above a plastic block as spheres do; {beyond} of {len(others)} rise by more than two standard "
        "errors beyond that, for which a resistance to shear is left.  That was not measured by itself.",
        "3. *Where beds do not collide with the lid, shape does not matter: all shapes yield the same curve, in all "
        f"three modes.*  {_verdict(len(judged) - len(unlike), len(fluidised))}: means over amplitudes of "
        f"fluidisation differ from those of spheres by up to {largest}; by more than chance (p below {SIGNIFICANT:g}) "
        f"in {', '.join(unlike) or 'none of them'}.  Not judged, for most of their cases were still drifting: "
        f"{left_out or 'none'}.",
    ]


def _verdict(held: int, of: int) -> str:
    return f"**{'Confirmed' if held == of else 'In part' if held else 'Not confirmed'}**"


def curves_picture(results: xr.Dataset) -> None:
    """Damping ratios over Gamma with their intervals, as in fig. 14."""
    figure, axes = panels(3, (13, 4))
    for ax, mode in zip(axes, results["mode"].values, strict=True):
        own = results.sel(mode=mode)
        ratio = 100 * damping_of_effectiveness(own["effectiveness"], own["particle_mass"], own["mode_amplitude"])
        for k, aspect in enumerate(aspects(results)):
            curve = ratio.sel(aspect=aspect).dropna("gamma", how="all")
            style = {"fmt": "o-", "ms": 2.5, "lw": 1, "color": f"C{k}", "label": f"{aspect:g}"}
            ax.errorbar(curve["gamma"], curve.mean("seed"), interval(curve), **style)
        frequency = float(own["natural_frequency"])
        ax.set(xlabel="Gamma", ylabel="damping ratio [%]", title=f"mode {mode}, {frequency:.0f} Hz")
    axes[0].legend(title="aspect", fontsize=7)
    figure.savefig(DOCS / "sphericity.png")


def optima_picture(results: xr.Dataset, found: xr.Dataset, own: dict[float, Collision]) -> None:
    """Gamma of collision, its height, and clearances over the aspect."""
    figure, axes = panels(3, (13, 4), sharex=True)
    at, shown = found.sel(mode=1), aspects(found)
    axes[0].errorbar(shown, at["gamma_collision"], at["gamma_collision_standard_error"], fmt="o-", label="beds")
    factor = own[1.0].over_block[0]
    axes[0].plot(shown, [factor * own[a].block for a in shown], "s--", ms=4, label="by the clearance alone")
    for name, label in (("collision", "eps_c"), ("fluidisation", "eps_f")):
        axes[1].errorbar(
            shown, at[f"effectiveness_{name}"], at[f"effectiveness_{name}_standard_error"], fmt="o-", label=label
        )
    heights, errors = np.array([clearances(results, a) for a in shown]).T
    axes[2].errorbar(shown, 1e3 * heights, 1e3 * errors, fmt="o-", label="clearance at rest")
    names = ("Gamma of collision", "effectiveness of mode 1's optima", "clearance [mm]")
    for ax, name in zip(axes, names, strict=True):
        ax.set(xlabel="aspect", ylabel=name, xscale="log", xticks=shown, xticklabels=[f"{a:g}" for a in shown])
        ax.minorticks_off()
        ax.legend(fontsize=7)
    figure.savefig(DOCS / "sphericity-optima.png")


def drifting(results: xr.Dataset) -> dict[int, float]:
    """Part of each mode's cases that still drifted when they ended."""
    still = (results["status"] == Status.DRIFTING).sum(["gamma", "aspect", "seed"])
    ran = results["effectiveness"].notnull().sum(["gamma", "aspect", "seed"])
    return {mode: float((still / ran).sel(mode=mode)) for mode in BANDS}


def what_was_run(results: xr.Dataset) -> str:
    """Packings, amplitudes, lengths, and how well the ledger closed."""
    ran = results["effectiveness"].notnull()
    counts = ran.any("gamma").sum("seed").max("mode").values
    residual = float(results["ledger_residual"].max())
    above = int((results["ledger_residual"] > RESIDUAL).sum())
    shown = ", ".join(f"{100 * part:.0f} % in mode {mode}" for mode, part in drifting(results).items())
    lengths = "; ".join(
        f"{name} ({', '.join(f'{a:g}' for a in part.aspects)}): Gamma {part.gammas[0]:g} to {part.gammas[-1]:g}, "
        f"{part.cycles} cycles, {part.steps} steps a contact"
        for name, part in PARTS.items()
    )
    return (
        f" from docs/sphericity.nc: {' / '.join(str(int(n)) for n in counts)} compacted packings of aspects "
        f"{' / '.join(f'{a:g}' for a in aspects(results))}, with the same seeds; {lengths}; "
        f"{int(ran.sum())} cases in {float(results['cpu_time'].sum()):.0f} core-seconds.  After so few cycles a part "
        f"of them still drifts: {shown}.  Largest residual "
        f"of the ledger {100 * residual:.2f} % of a cycle's dissipation; above {100 * RESIDUAL:g} %: {above} cases."
    )


def document() -> None:
    """Write docs/sphericity.md and its pictures."""
    whole = xr.load_dataset(RUNS)
    results = whole.isel(aspect=whole["effectiveness"].notnull().any(["mode", "gamma", "seed"]).values)
    for name in ("natural_frequency", "mode_amplitude", "particle_mass"):  # of one mass, so of all shapes
        others = [dim for dim in results[name].dims if dim != "mode"]
        results[name] = results[name].mean(others)
    found = results.damper.optimum()
    own = collisions(results, found)
    during = collisions(results.assign(clearance=(results["clearance"] + results["clearance_after"]) / 2), found)
    fluidised = bands(results, BANDS)
    curves_picture(results)
    optima_picture(results, found, own)
    columns = ["aspect", "plastic block", "over the block's", "over spheres", "of it by clearance", "share", "left"]
    write_document(
        "sphericity.md",
        head("The shape of particles", __file__) + what_was_run(whole),
        "Spheroids of the paper's mass, aspect d1 / d2 along over across their axis, on the paper's beam (its section "
        "4.1, which is by experiment).  Intervals are of 95 % (Student's t over packings), other errors are standard "
        "errors.",
        "![Damping ratio over Gamma in three modes, six shapes](sphericity.png)",
        "## The paper's statements",
        "\n".join(statements(found, own, fluidised, drifting(results))),
        "## Optima",
        "Maxima of a Gaussian process through the points of all packings (`dataset.damper.optimum()`); - where none "
        "stands out.  Slopes: weighted least squares over |ln aspect|, p from Student's t.",
        table(["mode", "aspect", *QUANTITIES.values()], optimum_rows(found)),
        "![Optima of mode 1 and clearances over the aspect](sphericity-optima.png)",
        "## Clearance",
        "At rest before and after the cases of mode 1, means over packings; packing fraction before, eq. 2.",
        table(
            ["aspect", "a, b [mm]", "clearance [mm]", "after the cases [mm]", "packing fraction", "blocks of shaking"],
            shape_rows(results),
        ),
        "Gamma of collision of mode 1 beside that of a plastic block of the same clearance, and its rise over that of "
        "spheres; clearance before the cases:",
        table(columns, collision_rows(own)),
        "With the mean of the clearances before and after the cases:",
        table(columns, collision_rows(during)),
        "## Fluidisation",
        "Effectiveness in the mean over amplitudes at which beds move and do not collide with the lid together: that "
        "of spheres, the other shapes beside it, probability of such differences by chance, slope over |ln aspect|.",
        table(
            [
                "mode",
                "Gamma",
                "spheres",
                *(f"{a:g}" for a in aspects(results) if a != 1),
                "p",
                "slope over \\|ln aspect\\|",
            ],
            band_rows(fluidised),
        ),
    )


if __name__ == "__main__":
    run_script(__doc__, simulate, document)
