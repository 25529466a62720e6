"""Twenty design problems drawn at random: solved, and every damper claimed simulated with 64 fresh packings."""

from __future__ import annotations

import json
import shutil
import time
from pathlib import Path

import numpy as np
from shared import DOCS, ROOT, table

import warpdamp
import warpdamp.modal.from_config
from warpdamp.config.study import Config
from warpdamp.design.bounds import largest_damping
from warpdamp.design.problem import Problem
from warpdamp.design.run import Answer, design
from warpdamp.design.search import Search
from warpdamp.design.verify import FRESH, orders_of
from warpdamp.errors import ConfigError
from warpdamp.files import whole_file

KEPT = ROOT / "results" / "design"
RECORD = DOCS / "design-problems.json"

STRUCTURES = {
    "beam": "beam: {{length: {a:.0f} mm, width: 20 mm, thickness: {t:.2g} mm, material: steel_structural}}\n"
    "  point_mass: {{mass: {m:.0f} g, position: {x:.0f} mm}}\n  modes: [1]",
    "plate": "plate: {{length: {a:.0f} mm, width: {b:.0f} mm, thickness: {t:.2g} mm, material: steel_structural}}\n"
    "  point_mass: {{mass: {m:.0f} g, position: [{x:.0f} mm, {y:.0f} mm], footprint: 20 mm}}\n  modes: [1]",
    "given": "modes_given: [{{frequency: {f:.4g} Hz, modal_mass: {mm:.4g} kg}}]\n  particles_included: true",
}
PROBLEM = """\
title: Problem {k}, {kind}{impossible}
structure:
  {structure}
damper:
  enclosure: {{diameter: 24 mm, height: 24 mm, material: pmma_terzioglu}}
  particles: {{count: 16, radius: {r:.3g} mm, material: pmma_terzioglu}}
contact: {{}}
excitation: {{gamma: [{low:.3g}, {high:.3g}]}}
preparation: compacted
steady_state: {{standard_error: 5 %, most_cycles: 100}}
design:
  target: {{damping: {zeta:.5g}, gamma: [{low:.3g}, {high:.3g}]}}
  variables:
    enclosure.height: {{from: {h0:.3g} mm, to: {h1:.3g} mm}}
    particles.count: {{from: 8, to: 48}}
  limits: {{mass: {limit:.4g} g}}
  budget: {{cases: 140}}
"""
COUNT, IMPOSSIBLE = 20, (3, 7, 11, 15, 19)


def problem_text(k: int) -> str:
    """Problem number k (1 to 20): structure, range of Gamma, target and limit of mass drawn at random.

    A possible one asks for 15 to 35 % of what an ideal damper of the allowed mass gives, an impossible one for 105 to
    200 %; which is which is drawn before, and no part of what the search is told.
    """
    rng = np.random.default_rng([19, k])
    kind = ("beam", "plate", "given")[k % 3]
    values = {"a": rng.uniform(200, 600), "b": rng.uniform(150, 300), "t": rng.uniform(3, 8), "m": rng.uniform(20, 200)}
    values |= {"x": rng.uniform(0.3, 0.7) * values["a"], "y": rng.uniform(0.3, 0.7) * values["b"]}
    values |= {"f": 20 * 100 ** rng.random(), "mm": rng.uniform(0.1, 1.0)}
    low = 0.5 * 8 ** rng.random()
    high = min(20.0, low * rng.uniform(1.5, 4))
    limit = rng.uniform(5, 9)  # g; 48 spheres of 3.73 mm weigh 9.6 g
    part = rng.uniform(1.05, 2.0) if k in IMPOSSIBLE else rng.uniform(0.15, 0.35)
    text = PROBLEM.format(
        k=k, kind=kind, impossible="", structure=STRUCTURES[kind].format(**values), r=3.73, low=low, high=high,
        zeta=0.01, h0=20, h1=60, limit=limit,
    )  # fmt: skip
    config = read_text(text.replace("design:", "#").split("#")[0], f"ideal-{k}")
    modes = warpdamp.modal.from_config.modes(config, particles=limit / 1e3)
    ideal = float(np.min(largest_damping(limit / 1e3, modes.amplitude, modes.inherent_damping)))
    return text.replace("damping: 0.01,", f"damping: {part * ideal:.5g},")


def read_text(text: str, name: str) -> Config:
    """Configuration of a text, from a file of that name in the folder of the results."""
    KEPT.mkdir(parents=True, exist_ok=True)
    path = KEPT / f"{name}.yaml"
    path.write_text(text)
    return warpdamp.load(path)


def simulate_problems(numbers: list[int], workers: int | None) -> None:
    """Solve problems, and simulate every damper that is claimed with 64 fresh packings."""
    done = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    for k in numbers:
        if str(k) in done:
            continue
        text = problem_text(k)
        config, started = read_text(text, f"problem-{k}"), time.perf_counter()
        store = KEPT / f"problem-{k}"
        try:
            answer = design(config, store, workers=workers, say=print)
        except ConfigError as error:
            said = str(error).partition(": ")[2]
            done[str(k)] = {"refused": said, "minutes": (time.perf_counter() - started) / 60}
        else:
            found = {"claimed": answer.claimed, "mass": answer.design.mass, "probability": answer.verified.probability}
            found |= {"minutes": (time.perf_counter() - started) / 60, "cases": answer.cases}
            found |= {"bound": answer.bounds.least_mass, "motion": answer.bounds.motion}
            if answer.claimed:
                found["fresh"] = fresh(answer, store, workers)
            done[str(k)] = found
        done[str(k)]["impossible"] = k in IMPOSSIBLE
        with whole_file(RECORD) as part:
            part.write_text(json.dumps(done, indent=1, sort_keys=True) + "\n")
        shutil.rmtree(store, ignore_errors=True)


def fresh(answer: Answer, store: Path, workers: int | None) -> dict:
    """Least damping of a damper over 64 packings that nothing has seen, and whether it meets the target."""
    search = Search(Problem(answer.problem.config), store, workers, lambda *_: None, print)
    drives, orders = orders_of(search, answer.design, FRESH + 1000, packings=64)
    rows = search.run_apart(orders)
    effectiveness = np.array([row.effectiveness for row in rows]).reshape(64, -1)
    damping = drives.damping(np.nanmean(effectiveness, axis=0), answer.design.mass)
    error = drives.damping(np.nanstd(effectiveness, axis=0) / 8, answer.design.mass) - drives.inherent
    least = int(np.argmin(damping))
    wanted = answer.problem.target.damping
    return {
        "least": float(damping[least]),
        "standard_error": float(error[least]),
        "wanted": wanted,
        "met": bool(damping[least] >= wanted),
    }


def problems_section() -> str:
    """What was solved of the twenty problems."""
    done = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    rows = []
    for k in sorted(map(int, done)):
        own = done[str(k)]
        if "refused" in own:
            rows.append([k, "impossible" if own["impossible"] else "possible", f"refused: {own['refused']}", "", ""])
            continue
        said = (
            f"{1e3 * own['mass']:.3g} g (bound {1e3 * own['bound']:.3g} g), P {own['probability']:.3f}, {own['motion']}"
        )
        said = said if own["claimed"] else f"no claim: {said}"
        checked = own.get("fresh")
        what = "impossible" if own["impossible"] else "possible"
        verdict = ""
        if checked:
            verdict = (
                f"{'met' if checked['met'] else '**missed**'}: {100 * checked['least']:.3g} ± "
                f"{100 * checked['standard_error']:.1g} % of {100 * checked['wanted']:.3g} %"
            )
        rows.append([k, what, said, verdict, f"{own['minutes']:.0f}"])
    refused = [own for own in done.values() if own["impossible"]]
    unclaimed = sum(not own.get("claimed", True) for own in done.values())
    claims = [own["fresh"] for own in done.values() if "fresh" in own]
    said = (
        f"Run so far: {len(done)} of {COUNT}. Of the {len(refused)} impossible ones among them "
        f"{sum('refused' in own for own in refused)} were refused by a bound; of {len(claims)} claims "
        f"{sum(claim['met'] for claim in claims)} were met by 64 fresh packings; {unclaimed} problems ended "
        "without a claim."
    )
    columns = ["problem", "drawn as", "answer", "64 fresh packings", "minutes"]
    return "\n\n".join([said, table(columns, rows)] if rows else [said])
