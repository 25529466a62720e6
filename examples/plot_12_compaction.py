"""
How a bed compacts
==================

Clearance of freshly made beds while they are shaken without friction, block by block, in the paper's cavity: sixteen
packings that start apart and end together.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import xarray as xr

DOCS = Path("../docs")  # seen from examples/
beds = xr.open_dataset(DOCS / "beds.nc").isel(bed=0)

fig, ax = plt.subplots(figsize=(8, 4.5), layout="constrained")
ax.plot(beds["block"], 1e3 * beds["series"].transpose("block", "seed"), color="C0", alpha=0.5, lw=1)
ax.set(xlabel="block", ylabel="clearance [mm]", title=str(beds["bed"].values))

# %%
# Mean and standard deviation between packings, before and after.

for name, clearance in (("loose", beds["loose"]), ("compacted", beds["clearance"].isel(stage=0))):
    print(f"{name}: {1e3 * float(clearance.mean()):.2f} mm, s.d. {1e3 * float(clearance.std(ddof=1)):.2f} mm")
