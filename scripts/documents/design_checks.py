"""Masses of the search beside those of a brute force of 2,000 cases and of another optimiser (optuna's TPE)."""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Iterable

import numpy as np
from design_problems import KEPT, RECORD, problem_text, read_text
from shared import DOCS, progress, table

from warpdamp.design.problem import Design, Problem
from warpdamp.design.run import ATTEMPTS
from warpdamp.design.search import Search, has_room
from warpdamp.design.verify import FRESH, GAMMAS, PACKINGS, orders_of, probability
from warpdamp.files import whole_file

COMPARED = (1, 2, 6)
"""The first possible problem of each kind of structure: a plate, modes in numbers, a beam."""
CASES = 2000
MOST_CONFIRMED = 40
"""Designs of the brute force that are simulated with fresh packings, at the most."""
CHECKS = DOCS / "design-checks.json"


def simulate_checks(numbers: Iterable[int], workers: int | None) -> None:
    """Solve problems by brute force and by optuna; what is done is kept."""
    done = json.loads(CHECKS.read_text()) if CHECKS.exists() else {}
    for k in numbers:
        for name, method in (("brute force", brute_force), ("optuna", optuna_search)):
            if name in done.setdefault(str(k), {}):
                continue
            config, started = read_text(problem_text(k), f"problem-{k}"), time.perf_counter()
            store = KEPT / f"check-{k}"
            search = Search(Problem(config), store, workers, progress(f"problem {k},", name), print)
            done[str(k)][name] = method(search) | {"minutes": (time.perf_counter() - started) / 60}
            with whole_file(CHECKS) as part:
                part.write_text(json.dumps(done, indent=1, sort_keys=True) + "\n")


def brute_force(search: Search) -> dict:
    """The lightest design of a grid of heights and counts that fresh packings confirm."""
    designs = grid(search)
    tried = list(zip(least_dampings(search, designs), designs, strict=True))
    return {"designs": len(designs), "cases": search.cases} | lightest_confirmed(search, tried, MOST_CONFIRMED)


def grid(search: Search) -> list[Design]:
    """Designs of every count that bound and limit allow, at as many heights as make up the cases."""
    height, count = search.problem.variables
    designs: list[Design] = []
    for levels in itertools.count(1):
        if len(designs) * GAMMAS >= CASES:
            break
        parts = (np.arange(levels) + 0.5) / levels
        values = ({height.path: height.at(part), count.path: n} for n in count.choices for part in parts)
        designs = [design for design in map(search.problem.of, values) if possible(search, design)]
    return designs


def possible(search: Search, design: Design | None) -> bool:
    """Whether a design can be, and may be: the search takes the same ones."""
    return has_room(design) and search.bounds.least_mass <= design.mass and search.problem.light_enough(design)


def optuna_search(search: Search) -> dict:
    """The lightest feasible design that optuna's TPE finds with the cases of the search's budget, if confirmed."""
    import optuna  # only this check needs it

    height, count = search.problem.variables
    wanted, tried = search.problem.target.damping, []

    def mass(trial: optuna.Trial) -> float:
        values = {
            height.path: trial.suggest_float("height", height.low, height.high, log=True),
            count.path: trial.suggest_int("count", count.choices[0], count.choices[-1]),
        }
        made = search.problem.of(values)
        if not possible(search, made):
            raise optuna.TrialPruned  # no case was run
        (least,) = least_dampings(search, [made], first=1 + len(tried))
        trial.set_constraint("damping", wanted - least)
        tried.append((least, made))
        return made.mass

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=0))
    study.optimize(mass, callbacks=[lambda study, _: study.stop() if spent(search) else None])
    return {"designs": len(tried), "cases": search.cases} | lightest_confirmed(search, tried, ATTEMPTS)


def spent(search: Search) -> bool:
    """Whether another design, at its Gammas, would exceed the budget of cases."""
    return search.cases + GAMMAS > search.problem.design.budget.cases


def least_dampings(search: Search, designs: list[Design], first: int = 1) -> list[float]:
    """Least damping of designs over the range of Gamma, each of one packing, by the seed of that."""
    orders, drives = [], []
    for design in designs:
        found, own = orders_of(search, design, first, packings=1)
        drives.append(found)
        orders += own
    effectiveness = np.array([row.effectiveness for row in search.run_apart(orders)]).reshape(len(designs), -1)
    found = zip(drives, effectiveness, designs, strict=True)
    return [float(np.min(own.damping(part, design.mass))) for own, part, design in found]


def lightest_confirmed(search: Search, tried: list[tuple[float, Design]], attempts: int) -> dict:
    """The lightest of designs that seem to meet the target and that eight fresh packings confirm, as for a claim.

    A design whose case failed has a least damping of NaN, which meets nothing.
    """
    wanted = search.problem.target.damping
    candidates = sorted((pair for pair in tried if pair[0] >= wanted), key=lambda pair: (pair[1].mass, -pair[0]))
    for attempt, (_, design) in enumerate(candidates[:attempts], 1):
        drives, orders = orders_of(search, design, FRESH + 2000, packings=PACKINGS)
        rows = search.run_apart(orders)
        effectiveness = np.array([row.effectiveness for row in rows]).reshape(PACKINGS, -1)
        effectiveness = effectiveness[np.isfinite(effectiveness).all(axis=1)]
        step = float(np.nanmean([row.step_error for row in rows]))
        met = probability(search, design, drives, effectiveness, step) if len(effectiveness) > 2 else 0.0
        print(f"{1e3 * design.mass:.3g} g: P {met:.3f}", flush=True)
        if met >= search.problem.design.confidence:
            values = {path[-1]: value for path, value in design.values.items()}
            return {"mass": design.mass, "values": values, "probability": met, "confirmed": attempt}
    return {"mass": None, "confirmed": min(len(candidates), attempts)}


def checks_section() -> str:
    """Masses of the search beside those of brute force and optuna."""
    done = json.loads(CHECKS.read_text()) if CHECKS.exists() else {}
    solved = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    rows = []
    for k in sorted(done, key=int):
        own = solved[k]["mass"] if solved.get(k, {}).get("claimed") else None
        row = [k, weight(own)]
        for name in ("brute force", "optuna"):
            found = done[k].get(name)
            row += [weight(found["mass"]), found["cases"], found["confirmed"]] if found else ["", "", ""]
        best = done[k].get("brute force", {}).get("mass")
        rows.append([*row, f"{own / best - 1:+.1%}" if own and best else ""])
    if not rows:
        return "Not run yet."
    columns = ["problem", "search", "brute force", "cases", "simulated again", "optuna", "cases", "simulated again"]
    return f"{TEXT}\n\n{table([*columns, 'search over brute force'], rows)}"


def weight(mass: float | None) -> str:
    """Mass in grams, if there is one."""
    return "none confirmed" if mass is None else f"{1e3 * mass:.3g} g"


TEXT = f"""\
The first possible problem of each kind of structure. Brute force: every count that the bound and the limit of mass
allow, at as many heights as make {CASES} cases of five Γ, one packing each; of the designs that meet the target there
the lightest that eight fresh packings confirm with 95 %, at those five Γ. optuna: its TPE with the mass as objective
and the target as constraint, one packing a design, with as many cases as the search's budget; of its feasible designs
the lightest confirmed the same way, of at most {ATTEMPTS}. A claim of the search holds between the five Γ, too."""
