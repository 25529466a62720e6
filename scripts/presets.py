"""What the presets of accuracy really err by, against packings of their own; writes docs/presets.nc.

    python scripts/presets.py

Modes 3 and 5 of the main job on every eighth amplitude.  The reference: eight other packings, 60 to 200 cycles each at
24 steps a contact.  A few minutes on two cores.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from price import job

from warpdamp import run
from warpdamp.results import NOT_RUN, write
from warpdamp.tolerance import PRESETS

DOCS = Path(__file__).parents[1] / "docs"


def small(**changes):
    """Modes 3 and 5 of the job that prices a tolerance."""
    config = job(**changes)
    return config.model_copy(update={"structure": config.structure.model_copy(update={"modes": [3, 5]})})


def main() -> None:
    """Run the presets and the reference."""
    length = {"fewest_cycles": 60, "most_cycles": 200, "standard_error": 0.02}
    reference = run(small(seeds=list(range(101, 109)), steady_state=length))["energy_dissipated"]
    mean, spread = reference.mean("seed"), reference.std("seed", ddof=1) / np.sqrt(reference.sizes["seed"])
    off, claimed, packings, cost = [], [], [], []
    for preset in PRESETS:
        found = run(small(accuracy=preset))
        off.append((found["energy_mean"] / mean - 1).values.ravel())
        claimed.append((found["energy_mean_standard_error"] / found["energy_mean"]).values.ravel())
        packings.append(found["packings"].values.ravel())
        cost.append(float(found["cpu_time"].where(found["status"] != NOT_RUN).sum()))
    result = xr.Dataset(
        {
            "off": (("preset", "point"), np.array(off)),
            "claimed": (("preset", "point"), np.array(claimed)),
            "packings": (("preset", "point"), np.array(packings)),
            "cpu_time": ("preset", cost),
            "reference_error": ("point", (spread / mean).values.ravel()),
        },
        {"preset": list(PRESETS)},
    )
    write(result, DOCS / "presets.nc")
    print(result, result["off"].values, result["claimed"].values, result["packings"].values)


if __name__ == "__main__":
    main()
