"""
Packings and error bars
=======================

A bed that is made anew is another bed. What one packing shows is exact for that packing, and no more than a sample of
the damper: eight of them spread as drawn here. The band is the mean with twice its standard error.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

DOCS = Path("../docs")  # seen from examples/
results = xr.open_dataset(DOCS / "two_optima.nc").sel(mode=1)
effectiveness = results["effectiveness"]
mean = effectiveness.mean("seed")
error = effectiveness.std("seed", ddof=1) / np.sqrt(effectiveness.sizes["seed"])

fig, ax = plt.subplots(figsize=(8, 4.5), layout="constrained")
ax.plot(results["gamma"], effectiveness.transpose("gamma", "seed"), color="0.7", lw=0.8)
ax.fill_between(results["gamma"], mean - 2 * error, mean + 2 * error, alpha=0.3)
ax.plot(results["gamma"], mean, label="mean over packings")
ax.set(xlabel=r"$\Gamma$", ylabel="effectiveness", title="Mode 1, eight packings")
ax.legend()

# %%
# How many packings a mean needs follows from their spread: that of a single one, over the square root of their number.

spread = (effectiveness.std("seed", ddof=1) / mean).sel(gamma=slice(4, None)).mean()
for wanted in (0.05, 0.03, 0.02):
    print(f"{100 * wanted:.0f} % takes {np.ceil((float(spread) / wanted) ** 2):.0f} packings")
