"""What the presets of accuracy err by, against packings of their own; writes docs/presets.nc.

    python scripts/documents/presets.py [fast] [balanced] [reference] [--workers N]

The main job on every eighth of its amplitudes.  What presets are measured by: 16 other packings, 100 cycles each, 16
steps a contact.  Core-minutes, beds included: those 8, fast 3, balanced 10, reference an hour and more; without names,
all.  May be stopped and started again (results/presets keeps what is done); the file holds those that were run.
"""

from __future__ import annotations

import argparse

import numpy as np
import xarray as xr
from price import job
from shared import DOCS, ROOT, progress

from warpdamp import run
from warpdamp.analysis.results import write
from warpdamp.config.study import PRESETS, Config
from warpdamp.variables import NOT_RUN

OTHERS, CYCLES, STEPS = range(101, 117), 100, 16


def kept(name: str, config: Config, workers: int | None) -> xr.Dataset:
    """A study, or what was left of it."""
    return run(config, store=ROOT / "results" / "presets" / name, workers=workers, report=progress(name))


def bought(preset: str, truth: xr.DataArray, workers: int | None) -> xr.Dataset:
    """What a preset claims at each point, what it is off by, and what it cost."""
    found = kept(preset, job(accuracy=preset), workers)
    mean, ran = found["energy_mean"], found["status"] != NOT_RUN
    return xr.Dataset(
        {
            "off": mean / truth - 1,
            "claimed": found["energy_mean_standard_error"] / mean,
            "interval": found["energy_mean_interval"] / mean,
            "step_error": found["discretisation_error"].where(ran).mean("seed") / mean,
            "packings": found["packings"],
            "within_tolerance": found["within_tolerance"],
            "cycles": found["cycles"].where(ran).mean("seed"),
            "cpu_time": found["cpu_time"].where(ran).sum("seed"),
        }
    )


def main() -> None:
    """Run the other packings and the presets."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("presets", nargs="*", choices=[[], *PRESETS], default=[])
    parser.add_argument("--workers", type=int)
    options = parser.parse_args()
    length = {"fewest_cycles": CYCLES, "most_cycles": CYCLES}
    numerics = {"steps_per_contact": STEPS}
    truth = job(seeds=list(OTHERS), steady_state=length, numerics=numerics)
    others = kept("others", truth, options.workers)["energy_dissipated"]
    mean = others.mean("seed")
    parts: dict[str, xr.Dataset] = {}
    for preset in options.presets or PRESETS:
        parts[preset] = bought(preset, mean, options.workers)
        keep(parts, others)


def keep(parts: dict[str, xr.Dataset], others: xr.DataArray) -> None:
    """Write the presets that were run."""
    presets = xr.concat(list(parts.values()), xr.Variable("preset", list(parts)))
    scatter = others.std("seed", ddof=1) / others.mean("seed")
    presets["reference_error"] = scatter / np.sqrt(others.sizes["seed"])
    presets["one_packing"] = scatter
    presets.attrs = {
        "title": "Presets of accuracy against other packings",
        "packings": len(OTHERS),
        "reference": f"{len(OTHERS)} other packings, {CYCLES} cycles each",
    }
    write(presets, DOCS / "presets.nc")


if __name__ == "__main__":
    main()
