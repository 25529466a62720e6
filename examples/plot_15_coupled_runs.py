"""
The prediction against a structure that answers
===============================================

The paper's method prescribes the motion of the cavity. Here a modal oscillator and the particles advance together
instead: driven by a harmonic force (one point a run), or released (a trail of points, from which damping is read as it
decays), beside the prediction, all with the same inherent damping taken off.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import xarray as xr

import warpdamp

DOCS = Path("../docs")  # seen from examples/
runs = xr.open_dataset(DOCS / "coupling.nc")
inherent = runs.attrs["inherent_damping"]
prediction = warpdamp.corrected(warpdamp.open_results(DOCS / "beam.nc")).sel(mode=1)

fig, ax = plt.subplots(figsize=(8, 4.5), layout="constrained")
released = runs.where(runs["kind"] == "released", drop=True)
ax.plot(released["gamma"].values.ravel(), 100 * (released["damping_ratio"].values.ravel() - inherent), ".", ms=3,
        color="0.6", label="released")  # fmt: skip
held = runs.where(runs["kind"] == "held", drop=True)
half = held.isel(window=slice(held.sizes["window"] // 2, None)).mean("window")
ax.plot(half["gamma"], 100 * (half["damping_ratio"] - inherent), "o", label="harmonic force")
ax.plot(prediction["gamma"], 100 * prediction["corrected_damping_ratio"], "k-", label="predicted")
ax.set(xlabel=r"$\Gamma$", ylabel="damping ratio of mode 1 [%]", xlim=(0, 14.5), ylim=(0, 4))
ax.legend()
