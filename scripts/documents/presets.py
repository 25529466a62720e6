"""What the presets of accuracy err by, against packings of their own; writes docs/presets.nc.

    python scripts/documents/presets.py

The main job on every eighth of its amplitudes.  The reference: 32 other packings, 200 cycles each, 24 steps a contact.
Half an hour on two cores; may be stopped and started again (results/presets keeps what is done).
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from price import job
from shared import DOCS, ROOT, progress

from warpdamp import run
from warpdamp.analysis.results import write
from warpdamp.config.study import PRESETS, Config
from warpdamp.variables import NOT_RUN

OTHERS, CYCLES = range(101, 133), 200


def kept(name: str, config: Config) -> xr.Dataset:
    """A study, or what was left of it."""
    return run(config, store=ROOT / "results" / "presets" / name, report=progress(name))


def bought(preset: str, truth: xr.DataArray) -> xr.Dataset:
    """What a preset claims at each point, what it is off by, and what it cost."""
    found = kept(preset, job(accuracy=preset))
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
    """Run the reference and the presets."""
    length = {"fewest_cycles": CYCLES, "most_cycles": CYCLES}
    others = kept("others", job(seeds=list(OTHERS), steady_state=length))["energy_dissipated"]
    truth = others.mean("seed")
    presets = xr.concat([bought(preset, truth) for preset in PRESETS], xr.Variable("preset", list(PRESETS)))
    presets["reference_error"] = others.std("seed", ddof=1) / np.sqrt(others.sizes["seed"]) / truth
    presets["one_packing"] = others.std("seed", ddof=1) / truth
    presets.attrs = {
        "title": "Presets of accuracy against other packings",
        "packings": len(OTHERS),
        "reference": f"{len(OTHERS)} other packings, {CYCLES} cycles each",
    }
    write(presets, DOCS / "presets.nc")
    print(presets)


if __name__ == "__main__":
    main()
