"""The benchmark as a document: what was measured, on what machine, with which versions."""

import os
import statistics

from documents import shared

from .peers import PEERS, version

INTRODUCTION = """ with `--document`. Medians of several rounds, smallest and largest in brackets. Times of stepping are
processor time without start-up, compiling and the making of batches; the codes run in turn, so that ratios are of the
same minutes. Times of starting and of two cores are wall times and need an idle machine."""

HOW = """## What is compared

All codes start from the same bed at rest, one of another seed in each round, and take the same step for ten cycles: 120
spheres of PMMA in a 40 x 40 mm cylinder, 46 Hz, Gamma 6, 2e-6 s. Their decks are in `scripts/benchmarks/decks`, and
take every number of the scene from the same two files. LAMMPS and LIGGGHTS have no account of the energy for this:
their decks sum the power put in, at every step as warpdamp's ledger does, or lean, every ten steps. YADE has a tally of
its own, and is lean without it.

The laws differ in detail, and a shaken bed is chaotic, so the effectivenesses agree only within the scatter between
beds: all are Hertz-Mindlin with Coulomb friction; warpdamp's contacts never pull and its dashpots are calibrated for
that; the peers' may pull at the end of a contact; LIGGGHTS' tangential dashpot rests while a contact slides; YADE's
cylinder has 64 flat sides and moves through the laboratory.

The costs in one cavity are of the first 500 steps from rest of a settled bed at the paper's fill, the cavity growing
with the bed; one search for neighbours is among warpdamp's, as often as a shaken bed needs it. A sweep is timed from
the submission of its first case to the end of its last; its workers have started before, for its beds.
"""


def machine() -> list[str]:
    """What is measured on, its load before anything was run, and the peers' versions."""
    lines = [f"- {shared.machine()}", f"- load {os.getloadavg()[0]:.1f} before the first measurement"]
    return lines + [f"- {p.name}: {version(p) if p.program else f'not installed ({p.install})'}" for p in PEERS]


def blocks(script: str, metrics, samples: dict[str, list[float]], lines: list[str]) -> list[str]:
    """The parts of the document that ``script`` writes."""
    rows = [_row(metric, samples.get(metric.name)) for metric in metrics]
    figures = shared.table(["metric", "what", "unit", "measured", "required", "aimed at"], rows)
    return [shared.head("Benchmark", script) + INTRODUCTION, "\n".join(lines), figures, HOW]


def _row(metric, values: list[float] | None) -> list[str]:
    if values is None:
        measured = "not measured"
    else:
        measured = f"{statistics.median(values):.4g}"
        if len(values) > 1:
            measured += f" ({min(values):.4g} to {max(values):.4g})"
    limits = [_limit(metric, limit, values) for limit in (metric.required, metric.aimed)]
    return [metric.name, metric.meaning, metric.unit, measured, *limits]


def _limit(metric, limit: float | None, values: list[float] | None) -> str:
    if limit is None:
        return ""
    said = f"{metric.sense} {limit:g}"
    if values is None or metric.meets(statistics.median(values), limit):
        return said
    return f"{said} **miss**"
