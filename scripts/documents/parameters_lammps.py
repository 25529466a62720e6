"""Effects in LAMMPS beside those in warpdamp, from the same beds: a tenth of the cases of two studies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr
from parameters_data import change_of, results
from shared import DOCS, table

RUNS = DOCS / "parameters_lammps.nc"
COMMAND = "python scripts/benchmarks/studied.py"
DISCARDED = {280.0: 8, 39.5: 4}
"""Cycles left out at the start of a run of LAMMPS, by frequency [Hz]."""


@dataclass(frozen=True)
class Pair:
    """What a factor does at one frequency and amplitude, from its lower to its higher level, in both codes."""

    study: str
    levels: tuple[float, float]
    frequency: float
    gamma: float
    packings: int
    own: tuple[float, float, float]
    other: tuple[float, float, float]
    heights: tuple[float, float]

    @property
    def alike(self) -> bool:
        """Whether the intervals of both effects meet."""
        return self.own[1] <= self.other[2] and self.other[1] <= self.own[2]

    @property
    def sign(self) -> str:
        """Whether both have the same sign, where both know it."""
        if self.own[1] <= 0 <= self.own[2] or self.other[1] <= 0 <= self.other[2]:
            return "not known" if self.own[0] * self.other[0] > 0 else "not known, means differ"
        return "the same" if self.own[0] * self.other[0] > 0 else "**differs**"


def pairs() -> Iterator[Pair]:
    """Effects in both codes, over the packings that both have run."""
    runs = xr.load_dataset(RUNS)
    keys = ("study", "frequency", "gamma")
    places = list(zip(*(runs[key].values.tolist() for key in keys), strict=True))
    for study, frequency, gamma in sorted(set(places)):
        at = runs.isel(case=[k for k, place in enumerate(places) if place == (study, frequency, gamma)])
        mean = at["effectiveness"].isel(cycle=slice(DISCARDED[frequency], None)).mean("cycle")
        of = {(x, s): float(m) for x, s, m in zip(at["level"].values, at["seed"].values, mean.values, strict=True)}
        low, high = sorted({level for level, _ in of})
        here = results(study)
        if here is None:
            continue
        here = here["effectiveness"].sel(frequency=frequency, gamma=gamma, **{study: [low, high]})
        seeds = [s for s in here["seed"].values if all((x, s) in of for x in (low, high))]
        seeds = [s for s in seeds if np.isfinite(here.sel(seed=s)).all()]
        if len(seeds) < 3:
            continue
        own = np.log(here.sel(seed=seeds).transpose(study, "seed").values)
        other = np.log([[of[x, s] for s in seeds] for x in (low, high)])
        effects = (change_of(values[1] - values[0]) for values in (own, other))
        heights = (float(np.exp(own).mean()), float(np.exp(other).mean()))
        yield Pair(study, (low, high), frequency, gamma, len(seeds), *effects, heights)


def lammps_section() -> list[str]:
    """Blocks of the document."""
    heading = "### Another code"
    found = list(pairs()) if RUNS.exists() else []
    if not found:
        return [heading, f"not run: `{COMMAND}`."]
    runs = xr.load_dataset(RUNS)
    counts = {name: int((runs["study"] == name).sum()) for name in dict.fromkeys(runs["study"].values.tolist())}
    of = {name: int(results(name)["effectiveness"].notnull().sum()) for name in counts}
    said = ", ".join(f"{n} of {of[name]} cases of {name}" for name, n in counts.items())
    cycles = " and ".join(f"{3 * n} cycles at {f:g} Hz" for f, n in DISCARDED.items())
    known = [pair for pair in found if not pair.sign.startswith("not known")]
    same = sum(pair.sign == "the same" for pair in known)
    alike = sum(pair.alike for pair in found)
    shown = ((100 * np.array(pair.own), 100 * np.array(pair.other), pair) for pair in found)
    rows = [
        (
            pair.study, f"{pair.levels[0]:g} to {pair.levels[1]:g}", f"{pair.frequency:g} Hz, Γ {pair.gamma:g}",
            pair.packings, f"{own[0]:+.1f} % ({own[1]:+.1f} to {own[2]:+.1f})",
            f"{other[0]:+.1f} % ({other[1]:+.1f} to {other[2]:+.1f})", pair.sign, "yes" if pair.alike else "**no**",
            f"{pair.heights[0]:.3f}, {pair.heights[1]:.3f}",
        )
        for own, other, pair in shown
    ]  # fmt: skip
    return [
        heading,
        f"{said} repeated with LAMMPS ({runs.attrs['version']}; `{COMMAND}`, docs/parameters_lammps.nc) from the same "
        f"beds without their contacts' memory, in {cycles}, the first third left out.  "
        "Effects on the effectiveness from the lower to the higher level, with 95 % intervals over packings.  Where "
        f"both codes know the sign it is the same in {same} of {len(known)}; the intervals meet in {alike} of "
        f"{len(found)}.  The last column is the mean effectiveness of both levels in warpdamp and in LAMMPS.",
        table(["factor", "from, to", "where", "packings", "warpdamp", "LAMMPS", "sign", "intervals meet", "ε"], rows),
    ]
