"""An analysis: open a Dataset, draw its curves, and find the best point of each.

python scripts/best_friction.py [FILE.nc]
"""

import sys
from pathlib import Path

import xarray as xr

import warpdamp

path = Path(sys.argv[1] if len(sys.argv) > 1 else "results/friction.nc")
dataset = xr.open_dataset(path)
zeta, error = dataset["damping_ratio"], dataset["damping_ratio_standard_error"]

warpdamp.curves(dataset).savefig(path.with_suffix(".png"))

for mode in zeta["mode"].values:
    for friction in zeta["friction"].values:
        at = {"mode": mode, "friction": friction}
        for peak in warpdamp.peaks(dataset["gamma"], zeta.sel(at), error.sel(at)):
            print(
                f"mode {mode}, friction {friction:g}: {peak.height:.4f} ± {peak.standard_error:.4f} at Γ {peak.gamma:g}"
            )

best = zeta.where(zeta == zeta.max(), drop=True)
print("best of all:", {name: best[name].values.item() for name in best.dims})
