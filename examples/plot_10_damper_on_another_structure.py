"""
A damper on another structure
=============================

Results of a damper over frequency serve every structure. Here the map of the paper's damper goes onto a strip of steel
clamped at one end, at several places, with nothing simulated: the modes come from finite elements, the damping of each
is (2 / pi) times effectiveness, particle mass and squared mass-normalised amplitude.
"""

from pathlib import Path

import matplotlib.pyplot as plt

import warpdamp
from warpdamp import Material
from warpdamp.modal.beam import Beam, PointMass, beam_modes
from warpdamp.modal.section import Rectangle

DOCS = Path("../docs")  # seen from examples/
results = warpdamp.open_results(DOCS / "frequency_map.nc")
steel = Material(density=7800, youngs_modulus=210e9, poissons_ratio=0.3)
strip = Beam(0.4, Rectangle(width=0.03, thickness=0.012), steel, supports=("clamped", "free"))

fig, ax = plt.subplots(figsize=(8, 4.5), layout="constrained")
for position in (0.2, 0.3, 0.4):
    modes = beam_modes(strip, PointMass(0.224, position), highest=1)
    damping = results.damper.damping(modes)["damping_ratio"].squeeze()
    ax.plot(damping["gamma"], 100 * damping, label=f"at {1e3 * position:.0f} mm: {float(modes.frequency[0]):.1f} Hz")
ax.set(xlabel=r"$\Gamma$ at the damper", ylabel="damping ratio of mode 1 [%]")
ax.legend()
