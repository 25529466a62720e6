"""Search for a design: cases first where bounds say it lies, then where they decide the question."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .assess import Assessment, assess, drives_of
from .bounds import Bounds, find_bounds
from .cases import Order, Report, Row, run_orders
from .emulation import Emulation, emulate
from .problem import Design, Problem

SAMPLE = 512
"""Designs, of a low-discrepancy set, from which bounds and candidates are taken."""
FULLEST = 0.97
"""Fill, over the packing fraction of a compacted bed, up to which designs are taken: beyond, nothing moves."""
CLEARLY, ALIKE = 0.98, 0.1
"""Part of the fill of a bed that could not be made, up to which others are tried; difference of particles across, in
ratio, within which that counts."""
FIRST_DRIVES, NEXT_DRIVES = 4, 3
"""Drives of a design at the start, and each time that it is chosen again."""
BATCH = 4
"""Designs that are run at a time."""
HEAVIEST_START = 6.0
"""Mass over the least one that the first designs have at the most."""
APART = 0.04
"""Distance, in parts of the ranges, below which two designs count as one."""
IMPROVEMENT = 0.01
"""Improvement expected, relative, below which the search ends."""
LOCAL, SPREADS = 16, (0.12, 0.04)
"""Candidates drawn about each of the best, and how far."""
KEPT = 8


def has_room(design: Design | None) -> bool:
    """Whether a design can be, and its particles have room to move."""
    return design is not None and design.fill <= FULLEST * design.packing


class Search:
    """Search of one problem.

    Parameters
    ----------
    problem : Problem
    store : Path
        Folder of the finished cases.
    workers : int or None
    report : callable
        See ``warpdamp.run``.
    say : callable
        Called with one line a step.
    """

    def __init__(self, problem: Problem, store: Path, workers: int | None, report: Report, say: Callable[[str], None]):
        self.problem, self.store, self.workers, self.report, self.say = problem, store, workers, report, say
        self.started = time.monotonic()
        self.rows: list[Row] = []
        self.cases = 0
        every = self._sample()
        self.bounds: Bounds = find_bounds(problem, every)
        self.sample = [design for design in every if problem.light_enough(design)]
        self.seeds: dict[tuple, int] = {}
        self.assessed: list[Assessment] = []

    def _sample(self) -> list[Design]:
        """Designs of a low-discrepancy set that can be."""
        from scipy.stats import qmc

        unit = qmc.Sobol(len(self.problem.variables), seed=np.random.default_rng(0)).random(SAMPLE)
        found, seen = [], set()
        for part in unit:
            design = self.problem.make(part)
            if has_room(design) and design.key not in seen:
                seen.add(design.key)
                found.append(design)
        return found

    def _parts(self, design: Design) -> np.ndarray:
        return np.array([variable.part(design.values[variable.path]) for variable in self.problem.variables])

    @property
    def masses(self) -> tuple[float, float]:
        """Range of the masses of all designs [kg]."""
        masses = [design.mass for design in self.sample]
        return min(masses) / 2, max(masses) * 2

    def spent(self, reserved: int = 0) -> bool:
        """Whether the budget, less some cases, is spent."""
        budget = self.problem.design.budget
        minutes = (time.monotonic() - self.started) / 60
        return (budget.cases is not None and len(self.rows) + reserved >= budget.cases) or (
            budget.minutes is not None and minutes >= budget.minutes * (1 if not reserved else 0.6)
        )

    def run(self, orders: list[Order]) -> list[Row]:
        """Run cases, and keep them for the emulator."""
        found = self.run_apart(orders)
        self.rows += found
        return found

    def run_apart(self, orders: list[Order]) -> list[Row]:
        """Run cases that are not of the variables alone."""
        self.cases += len(orders)
        return run_orders(self.problem, orders, self.store, workers=self.workers, report=self.report)

    def start(self) -> None:
        """Run the first designs."""
        count = max(8, 4 * len(self.problem.variables))
        least = self.bounds.least_mass
        near = [d for d in self.sample if d.mass >= least and (least == 0 or d.mass <= HEAVIEST_START * least)]
        chosen = (near or sorted(self.sample, key=lambda d: abs(d.mass - 2 * least)))[:count]
        orders = []
        for k, design in enumerate(chosen):
            drives = drives_of(self.problem, design, self.masses, points=2 * FIRST_DRIVES)
            modes = len(np.unique(drives.mode))
            each = max(2, FIRST_DRIVES // modes)
            for mode in range(modes):
                gammas = drives.gamma[drives.mode == mode]
                places = (np.arange(each) * len(gammas) / each + k % (len(gammas) // each)).astype(int)
                orders += [Order(design, mode, float(gammas[place]), self._seed(design)) for place in places]
            self._next_seed(design)
        self.say(f"start: {len(chosen)} designs, {len(orders)} cases")
        self.run(orders)

    def _seed(self, design: Design) -> int:
        return self.seeds.get(design.key, 1)

    def _next_seed(self, design: Design) -> None:
        self.seeds[design.key] = self._seed(design) + 1

    def assess_all(self) -> Emulation:
        """Assess the sample and candidates near its best; returns the emulator."""
        emulation = emulate(self.problem, self.rows)
        allowed = [d for d in self.sample if d.mass >= self.bounds.least_mass and self._packs(d)]
        first = self._allowed(assess(emulation, allowed, self.masses))
        near = self._near(sorted(first, key=self._rank)[:KEPT], {d.key for d in self.sample})
        second = self._allowed(assess(emulation, near, self.masses))
        self.sample += near
        self.assessed = sorted([*first, *second], key=self._rank)
        return emulation

    def _packs(self, design: Design) -> bool:
        """Whether no bed as full failed, in a cavity of about as many particles across."""
        across = design.cavity.diameter / design.radius
        failed = {row.order.design.key: row.order.design for row in self.rows if not row.known}
        return not any(
            design.fill > CLEARLY * other.fill and abs(across * other.radius / other.cavity.diameter - 1) < ALIKE
            for other in failed.values()
        )

    def _allowed(self, found: list[Assessment]) -> list[Assessment]:
        limit = self.problem.design.limits.force
        return [one for one in found if limit is None or one.force <= limit]

    def _near(self, best: list[Assessment], seen: set[tuple]) -> list[Design]:
        """Designs drawn about the best ones; the same each time."""
        rng, found = np.random.default_rng(len(self.rows)), []
        for one in best:
            centre = self._parts(one.design)
            for k in range(LOCAL):
                part = np.clip(centre + SPREADS[k % 2] * rng.standard_normal(len(centre)), 0.0, 1 - 1e-9)
                design = self.problem.make(part)
                if has_room(design) and design.key not in seen:
                    seen.add(design.key)
                    fits = self.problem.light_enough(design) and self._packs(design)
                    if design.mass >= self.bounds.least_mass and fits:
                        found.append(design)
        return found

    def _rank(self, one: Assessment) -> tuple:
        """Order of designs: those that meet the target with confidence first, the best first among them.

        Of others the more probable first; where none is probable at all, that of most damping, not the lightest.
        """
        confident = one.probability >= self.problem.design.confidence
        if self.problem.design.goal == "mass":
            return (0, one.design.mass) if confident else (1, -one.probability, -one.least, one.design.mass)
        return (0 if confident or self.problem.target.damping is None else 1, -float(np.mean(one.merit)))

    def expected(self, one: Assessment, reference: float) -> float:
        """Improvement that running a design is expected to bring, relative to the best one so far."""
        if self.problem.design.goal == "mass":
            return one.probability * max(0.0, 1 - one.design.mass / reference)
        return one.probability * float(np.mean(np.maximum(0.0, one.merit - reference))) / reference

    def step(self) -> bool:
        """Run the next designs; returns whether more of them are expected to bring something."""
        self.assess_all()
        best = self.assessed[0]
        confident = self._rank(best)[0] == 0
        if self.problem.design.goal == "mass":
            reference = best.design.mass if confident else max(one.design.mass for one in self.assessed) * 1.01
        else:
            reference = float(np.mean(best.merit))
        worth = sorted(self.assessed, key=lambda one: -self.expected(one, reference))
        most = self.expected(worth[0], reference)
        chosen = self._apart([best, *worth] if confident else worth)
        self.say(
            f"{len(self.rows)} cases: best {1e3 * best.design.mass:.4g} g, least damping {100 * best.least:.3g} % "
            f"({100 * best.interval[0]:.3g} to {100 * best.interval[1]:.3g} %), P {best.probability:.2f}; "
            f"improvement expected {100 * most:.2g} %"
        )
        if confident and most < IMPROVEMENT and self.seeds.get(best.design.key, 1) > 2:
            return False
        orders = []
        for one in chosen:
            where = np.argsort(-one.decisive, kind="stable")[:NEXT_DRIVES]
            seed = self._seed(one.design)
            orders += [Order(one.design, int(one.drives.mode[k]), float(one.drives.gamma[k]), seed) for k in where]
            self._next_seed(one.design)
        self.run(orders)
        return True

    def _apart(self, ranked: list[Assessment], count: int = BATCH) -> list[Assessment]:
        """The first of a ranking that are no neighbours of each other."""
        chosen: list[Assessment] = []
        for one in ranked:
            parts = self._parts(one.design)
            if all(np.linalg.norm(parts - self._parts(other.design)) > APART for other in chosen):
                chosen.append(one)
            if len(chosen) == count:
                break
        return chosen

    def runners_up(self, claimed: Design, count: int = 3) -> list[Assessment]:
        """The next best designs that are no neighbours of the one claimed, nor of each other."""
        own = next((one for one in self.assessed if one.design.key == claimed.key), None)
        others = [one for one in self.assessed if one.design.key != claimed.key]
        return self._apart([own, *others] if own else others, count + bool(own))[bool(own) :]
