"""
Constant force: folds and jumps
===============================

A shaker that holds its force meets a nonlinear structure. In mode 3 damping falls with the amplitude: the peak grows
faster than the force, and where it grows fastest there are several states at one force and frequency, a fold. All
branches are followed; what is not stable is dashed. The fold drawn here is smaller than what three packings leave
uncertain of the damping: it shows how folds look, not that this beam has one.
"""

from pathlib import Path

import numpy as np

import warpdamp
from warpdamp.report.frf import force_curves

DOCS = Path("../docs")  # seen from examples/
results = warpdamp.open_results(DOCS / "beam.nc")
response = warpdamp.constant_force(results, [0.3, 0.5, 0.56, 0.62], (280, 285))
figure = force_curves(response)

# %%
# Largest stable response at each force, and how much of its branches is not stable.

stable = response["response_gamma"].where(response["stable"] == 1)
for force in np.unique(response["force"]):
    own = response["force"] == force
    largest, unstable = float(stable.where(own).max()), int((response["stable"] == 0).where(own, False).sum())
    print(f"{force:g} N: Gamma {largest:.2f}; {unstable} of {int(own.sum())} points unstable")
