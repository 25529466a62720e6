"""
Constant force: folds and jumps
===============================

A shaker that holds its force meets a nonlinear structure: past the optimum damping falls with amplitude, so that a peak
can have several states. All branches are followed; dashed ones are not stable.
"""

from pathlib import Path

import numpy as np

import warpdamp
from warpdamp.report.frf import force_curves

DOCS = Path("../docs")  # seen from examples/
results = warpdamp.open_results(DOCS / "beam.nc")
response = warpdamp.constant_force(results, [0.2, 0.5, 0.8, 1.1], (35, 45))
figure = force_curves(response)

# %%
# Largest stable response at each force.

stable = response["response_gamma"].where(response["stable"] == 1)
for force in np.unique(response["force"]):
    print(f"{force:g} N: Gamma {float(stable.where(response['force'] == force).max()):.2f}")
