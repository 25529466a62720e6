"""
Map of frequency and Gamma
==========================

A damper without a structure over frequency and amplitude, here every second of the frequencies that were run: its
effectiveness, and the lines of both optima. ``draw`` makes a map where there are two axes.
"""

from pathlib import Path

import warpdamp

DOCS = Path("../docs")  # seen from examples/
results = warpdamp.open_results(DOCS / "frequency_map.nc").isel(frequency=slice(None, None, 2))
figure = warpdamp.draw(results)
