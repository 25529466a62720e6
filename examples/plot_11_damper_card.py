"""
A card: the damper as a part
============================

A card holds the damper's complex mass over frequency and Gamma with intervals, range and provenance; it is what goes
into another program. Here its real and imaginary part with 95 % intervals, at the lowest frequency of the main job.
"""

from pathlib import Path

import matplotlib.pyplot as plt

import warpdamp
from warpdamp.modal.card import card

DOCS = Path("../docs")  # seen from examples/
part = card(warpdamp.open_results(DOCS / "beam.nc"))

fig, ax = plt.subplots(figsize=(8, 4.5), layout="constrained")
at = part.isel(frequency=0)
for name, label in (("apparent_mass", "in phase, m'"), ("quadrature_mass", "in quadrature, m''")):
    mean, interval = 1e3 * at[name], 1e3 * at[f"{name}_interval"]
    ax.plot(at["gamma"], mean, label=label)
    ax.fill_between(at["gamma"], mean - interval, mean + interval, alpha=0.2)
ax.set(xlabel=r"$\Gamma$", ylabel="mass [g]", title=f"{float(at['frequency']):.1f} Hz", ylim=(-10, 40))
ax.legend()

# %%
# The range that it holds in; outside it a card is refused.

print("Gamma", part.attrs["gamma_range"], "at", [round(float(f), 1) for f in part["frequency"]], "Hz")
