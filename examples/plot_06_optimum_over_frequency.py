"""
The optimum over frequency
==========================

Where the bed meets floor and lid in turn, the optimum's Gamma rises with the square of the frequency: the same travel,
the clearance, at every frequency (eq. 1 of the paper, and 1.08 more by gravity, of a plastic block).
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import warpdamp
from warpdamp.analysis.optimum import collision_optimum

DOCS = Path("../docs")  # seen from examples/
results = warpdamp.open_results(DOCS / "frequency_map.nc").sel(frequency=slice(None, 70))
optima = results.damper.optimum()
frequency = results["frequency"].values
clearance = float(results["clearance"].median())

fig, ax = plt.subplots(figsize=(8, 4.5), layout="constrained")
for name in ("collision", "fluidisation"):
    gamma, error = optima[f"gamma_{name}"], optima[f"gamma_{name}_standard_error"]
    ax.errorbar(frequency**2, gamma.squeeze(), error.squeeze(), fmt="o", label=f"optimum of {name}")
line = np.linspace(frequency.min(), frequency.max(), 50)
ax.plot(line**2, collision_optimum(line, clearance), label=f"plastic block, clearance {1e3 * clearance:.2f} mm")
ax.set(xlabel=r"$f^2$ [Hz$^2$]", ylabel=r"$\Gamma$", xlim=(0, 5000), ylim=(0, 14))
ax.legend()
