"""The order of the work: bounds, search, simulation again with fresh packings, tolerances, answer."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..config.study import Config
from ..formats.optional import needs
from ..sweep.load import load
from .assess import Assessment
from .bounds import Bounds
from .cases import Report
from .problem import Design, Problem
from .search import Search
from .tolerances import Sensitivity, sensitivity
from .verify import Verified, cases_needed, verify

ATTEMPTS = 4
"""Designs that are simulated again, at the most, until one keeps the confidence asked for; beyond the budget, if need
be: without a design that was simulated again there is no answer."""

FRONT = 12
"""Masses, in equal ratios, between which the front has its best design."""


@dataclass(frozen=True)
class Answer:
    """Answer to a design problem.

    Parameters
    ----------
    problem : Problem
    bounds : Bounds
    verified : Verified
        The design, and what fresh packings say of it.
    claimed : whether the target is met with the confidence asked for
    attempts : designs that were simulated again
    front : designs of most damping for their mass, lightest first
    runners_up : list of Assessment
    sensitivity : Sensitivity, or None where nothing is claimed
    cases : simulated, or read from the store
    """

    problem: Problem
    bounds: Bounds
    verified: Verified
    claimed: bool
    attempts: int
    front: list[Assessment]
    runners_up: list[Assessment]
    sensitivity: Sensitivity | None
    cases: int

    @property
    def design(self) -> Design:
        """The design."""
        return self.verified.design

    def configuration(self) -> Config:
        """Configuration of the damper, ready to run."""
        config = self.design.config.model_copy(update={"title": f"{self.problem.config.title}: the damper chosen"})
        return config.model_copy(update={"seeds": self.problem.config.seeds})


def design(
    config: Config | str | Path,
    store: str | Path,
    *,
    workers: int | None = None,
    report: Report = lambda stage, done: None,
    say: Callable[[str], None] = lambda line: None,
) -> Answer:
    """Look for a damper, or go on looking.

    Parameters
    ----------
    config : Config, str or Path
        Configuration with a ``design`` section, or its YAML file.
    store : str or Path
        Folder of the cases: a search that was interrupted takes from there what is done.
    workers : int, optional
        Number of workers (default: the cores of this machine).
    report : callable
        Called as ``report(stage, part_done)`` for every batch of cases.
    say : callable
        Called with a line for every step of the search.

    Returns
    -------
    Answer

    Raises
    ------
    ConfigError
        If the problem is contradictory, or its target impossible.
    StoreError
        If the store cannot be written.
    MissingLibrary
        If scikit-learn is not installed.
    """
    needs("sklearn", "designs", "design")
    if not isinstance(config, Config):
        config = load(config)
    problem = Problem(config)
    search = Search(problem, Path(store), workers, report, say)
    say(f"motion: {search.bounds.motion}: {search.bounds.why}")
    if search.bounds.least_mass:
        say(f"bound: no damper with less than {1e3 * search.bounds.least_mass:.4g} g of particles does it (eqs 5-11)")
    search.start()
    search.assess_all()
    while not search.spent(cases_needed(search, search.assessed[0].design)) and search.step():
        pass
    verified, claimed, attempts = _verified(search, say)
    found = sensitivity(search, verified) if claimed and problem.target.damping is not None else None
    search.assess_all()
    return Answer(
        problem,
        search.bounds,
        verified,
        claimed,
        attempts,
        front(search.assessed),
        search.runners_up(verified.design),
        found,
        search.cases,
    )


def _verified(search: Search, say: Callable[[str], None]) -> tuple[Verified, bool, int]:
    """The best design that fresh packings confirm; the most probable one of those tried, if none is."""
    confidence, wanted = search.problem.design.confidence, search.problem.target.damping
    tried: dict[tuple, Verified] = {}
    for attempt in range(ATTEMPTS):
        search.assess_all()
        best = next(one for one in search.assessed if one.design.key not in tried)
        say(f"simulated again with fresh packings: {1e3 * best.design.mass:.4g} g")
        verified = tried[best.design.key] = verify(search, best.design, attempt)
        say(f"least damping {100 * verified.least.least:.3g} %, P {verified.probability:.3f}")
        if wanted is None or verified.probability >= confidence:
            return verified, True, attempt + 1
        if not search.spent():
            search.step()  # what was learnt may lead elsewhere
    most = max(tried.values(), key=lambda one: one.probability)
    return most, False, len(tried)


def front(assessed: list[Assessment]) -> list[Assessment]:
    """Designs of most damping for their mass, lightest first: no lighter one has as much."""
    if not assessed:
        return []
    masses = np.array([one.design.mass for one in assessed])
    edges = np.geomspace(masses.min(), masses.max() * (1 + 1e-9), FRONT + 1)
    found: list[Assessment] = []
    for low, high in itertools.pairwise(edges):
        within = [one for one, mass in zip(assessed, masses, strict=True) if low <= mass < high]
        best = max(within, key=lambda one: one.least, default=None)
        if best and (not found or best.least > found[-1].least):
            found.append(best)
    return found
