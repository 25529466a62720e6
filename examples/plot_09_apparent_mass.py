"""
The mass that the structure feels
=================================

The paper takes the particles for a rigid mass. A bed in flight is not felt at all: its apparent mass, measured from the
first harmonic of the reaction, falls, and may rise again where bed and wall move together. Natural frequencies and,
through the shapes of higher modes, damping follow.
"""

from pathlib import Path

import matplotlib.pyplot as plt

import warpdamp
from warpdamp.report.frf import against_gamma

DOCS = Path("../docs")  # seen from examples/
results = warpdamp.open_results(DOCS / "beam.nc")

fig, ax = plt.subplots(figsize=(8, 4), layout="constrained")
for number, frequency in zip(results["mode"].values, results["frequency"].values, strict=True):
    felt = 1e3 * results["apparent_mass"].sel(frequency=frequency).mean("seed")
    ax.plot(results["gamma"], felt, label=f"mode {number}, {frequency:.0f} Hz")
ax.axhline(1e3 * float(results["particle_mass"].max()), color="k", lw=0.8, label="all particles")
ax.set(xlabel=r"$\Gamma$", ylabel="apparent mass [g]")
ax.legend()

# %%
# Frequency and damping, corrected for it.

figure = against_gamma(warpdamp.corrected(results))
