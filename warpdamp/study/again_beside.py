"""Cases of several dampers on one structure run again and recorded, in one phase of the drive."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.results import provenance
from ..config.sweep import as_list
from ..damper.trajectory import CYCLES, FRAMES, record
from ..errors import UsageError
from ..modal.from_config import amplitudes
from ..sweep.cases import Cases
from ..sweep.choice import Choice, candidates, only, same
from ..sweep.resolve import self_contained, with_tolerance
from .again import Again, again, chain_of, opened, particle_steps, refuse_failed, refuse_long, simulated
from .several import cases_of, studies

if TYPE_CHECKING:
    import xarray as xr

    from ..config.study import Config
    from ..modes import Modes

REMARK = "the case run again by itself; the results hold means over packings only"


def again_all(
    source: str | Path,
    choice: Choice,
    *,
    frames: int = FRAMES,
    shown: int = CYCLES,
    anyway: bool = False,
    most: float = np.inf,
    report: Callable[[float], None] = lambda done: None,
) -> list[Again]:
    """Run a case of a study again and record its last cycles: of several dampers, that of each of them.

    Dampers that move against the first are recorded half a cycle apart, so that frames are of one moment.  One on a
    node of the mode is not shaken, and left out.

    Parameters
    ----------
    source, choice, frames, shown, anyway, most, report
        As of ``warpdamp.study.again.again``; of several dampers Gamma is that of the first.

    Returns
    -------
    list of Again
        One for each damper that moves.

    Raises
    ------
    UsageError
        If there is no such case, or it takes too long.
    SimulationError
        If it fails.
    """
    source = Path(source)
    dataset, config = opened(source)
    if not config.dampers:
        return [again(source, choice, frames=frames, shown=shown, anyway=anyway, most=most, report=report)]
    alone, seen = studies(config)
    mode, gamma = _chosen(config, seen[0], dataset, choice)
    moves = amplitudes(config, seen[0])
    moving = [k for k, modes in enumerate(seen) if not modes.on_node[mode]]
    chains = [_chain(config, alone[k], seen, k, mode, gamma, choice.seed) for k in moving]
    values = [simulated(chain, criteria) for _, chain, criteria in chains]
    cycles = [[int(own["cycles"]) for own in each] for each in values]
    for (name, _, _), each in zip(chains, values, strict=True):
        for own in each:
            refuse_failed(name, own)
    steps = sum(particle_steps(chain, own) for (_, chain, _), own in zip(chains, cycles, strict=True))
    refuse_long(source, steps, most)
    shown = min(shown, *(own[-1] - 1 for own in cycles))
    found: list[Again] = []

    def done(part: float) -> None:
        report((len(found) + part) / len(moving))

    for k, (name, chain, _), own, counts in zip(moving, chains, values, cycles, strict=True):
        against = moves[k, mode] < 0  # positive at the first damper
        trajectory = record(
            [spec for _, spec in chain],
            counts,
            frames=frames,
            shown=shown,
            early=0.5 if against else 0.0,
            report=done,
        )
        found.append(Again(config.title, name, provenance()["source"], trajectory, own[-1], {}, REMARK))
    return found


def _chosen(config: Config, modes: Modes, dataset: xr.Dataset | None, choice: Choice) -> tuple[int, int]:
    """Row of the mode and of Gamma; of results those of the largest damping among what a choice leaves."""
    gammas = as_list(config.excitation.gamma)
    known = {"mode": list(modes.number), "gamma": gammas, "frequency": list(modes.frequency)}
    left = np.ones((len(modes.number), len(gammas)), bool)
    for name, text in choice.wanted().items():
        if name == "seed":
            continue
        if name not in known:
            raise UsageError(f"there is no {name} to choose by: the cases differ in {', '.join(known)}, seed")
        fits = np.array([same(value, text) for value in known[name]])
        if not fits.any():
            listed = ", ".join(f"{value:g}" for value in known[name])
            raise UsageError(f"there is no case with {name} {text}: there is {listed}")
        left &= fits if name == "gamma" else fits[:, None]
    if dataset is None and left.sum() > 1:
        name = "mode" if left.any(axis=1).sum() > 1 else "gamma"
        raise UsageError(f"there are {left.sum()} such cases: choose by {name} as well")
    damping = np.zeros(left.shape) if dataset is None else np.nan_to_num(dataset["damping_ratio"].values, nan=-1.0)
    i, k = np.unravel_index(int(np.argmax(np.where(left, damping, -np.inf))), left.shape)
    return int(i), int(k)


def _chain(config: Config, own: Config, seen: list[Modes], damper: int, mode: int, gamma: int, seed: int | None):
    """Label, cases and criteria of one damper's case."""
    rows = list(cases_of(config, seen[damper], seen[0]))
    number, (_, _, frequency, shaken) = next((n, row) for n, row in enumerate(rows) if row[:2] == (mode, gamma))
    cases = Cases(with_tolerance(self_contained(own)))
    at = {"case": str(number)} if len(rows) > 1 else {}
    chosen = only(cases, candidates(cases, Choice(seed=seed, at=at)))
    packing = f", seed {cases.spec(chosen)[0].bed.seed}" if len(cases.seeds) > 1 else ""
    name = f"damper {damper + 1}: mode {seen[0].number[mode]}, {frequency:.4g} Hz, Γ {shaken:.4g}{packing}"
    return name, *chain_of(cases, chosen)
