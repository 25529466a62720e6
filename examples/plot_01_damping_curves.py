"""
Damping over amplitude
======================

The main job's results: the damping ratio that the damper gives each mode of the paper's beam, over the amplitude
Gamma. Bars are standard errors between packings; hollow points are cases that were not steady. The optima are those of
a curve fitted through all packings, with standard errors; where none can be named, it says why.
"""

from pathlib import Path

from rich.console import Console

import warpdamp
from warpdamp.report.tables import summary

DOCS = Path("../docs")  # seen from examples/
results = warpdamp.open_results(DOCS / "beam.nc")
figure = warpdamp.draw(results)

# %%
# The same table that ``warpdamp run`` prints.

Console(width=100).print(summary(results))

# %%
# The numbers behind it, as a Dataset.

optima = results.damper.optimum("damping_ratio").sel(mode=1)
print(f"collision at Gamma {float(optima['gamma_collision']):.2f}")
