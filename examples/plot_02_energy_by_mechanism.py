"""
Energy by mechanism
===================

Every loss of energy is counted by its own formula as it happens, for contacts between particles and with the walls
apart; none is what is left of the others. So the sum of the areas can be held against the work that the enclosure put
in (line), and against that of the first harmonic of the reaction (dots): three accounts of the same energy. Where
the line falls short, at the lowest amplitudes, beds give up energy that they had stored, as while they sink.
"""

from pathlib import Path

import matplotlib.pyplot as plt

import warpdamp

DOCS = Path("../docs")  # seen from examples/
results = warpdamp.open_results(DOCS / "beam.nc").isel(frequency=0).mean("seed")
gamma = results["gamma"].values

losses = {
    name: results[name].values
    for name in results.data_vars
    if name.endswith("_loss") and "total" not in name and float(results[name].max()) > 0
}
fig, ax = plt.subplots(figsize=(8, 4.5), layout="constrained")
share = results["energy_dissipated"].values
ax.stackplot(
    gamma,
    [loss / share for loss in losses.values()],
    labels=[name.removesuffix("_loss").replace("_", " ") for name in losses],
)
ax.plot(gamma, results["work_input"] / share, "k-", label="work of the enclosure")
ax.plot(gamma, results["harmonic_work"] / share, "ko", ms=3, label="work of the first harmonic")
ax.set(xlabel=r"$\Gamma$", ylabel="share of the energy dissipated", ylim=(0, 1.1))
ax.legend(loc="upper left", bbox_to_anchor=(1, 1))

# %%
# How well the ledger closes: the energy not accounted for, over the energy dissipated, in the worst of these cases.

print(f"ledger residual at most {100 * float(results['ledger_residual'].max()):.2f} %")
