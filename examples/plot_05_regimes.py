"""
Regimes of motion
=================

Which motion a bed is in is told from its impulses on floor and lid, and from how far its particles get within a cycle.
"""

from pathlib import Path

import warpdamp
from warpdamp.analysis.regimes import Regime

DOCS = Path("../docs")  # seen from examples/
results = warpdamp.open_results(DOCS / "frequency_map.nc")
figure = results.damper.regime_map()

# %%
# The labels are a variable like any other.

labels = results.damper.regime()
for regime in Regime:
    print(f"{regime.name.lower():<22} {int((labels == regime).sum()):>4} cases")
