"""
What accuracy costs
===================

Every numerical choice varied at six points of the main job: its error against the processor time that it takes.
"""

from pathlib import Path

import xarray as xr

from warpdamp.report.accuracy import budget, work_precision

DOCS = Path("../docs")  # seen from examples/
runs = xr.open_dataset(DOCS / "accuracy.nc")
figure = work_precision(runs)

# %%
# Where the error of a point comes from.

figure = budget(runs)
