"""Versions: of the package, of its physics, and of what a finished case holds."""

from __future__ import annotations

__version__ = "0.1.0"


PHYSICS_VERSION = 6
"""Raised whenever a change alters results, so that cached beds and stored results of old physics are not mixed in.

6: the factors 4/3 and 8/15 of Hertz's law have all digits of float64; they were those of float32, 3e-8 too large.
Beds are compacted until no block brings a larger clearance: shaking ended too early, 0.3 mm before in the paper's bed.
"""


RESULTS_VERSION = 3
"""Raised whenever a finished case holds something new, so that stored results of before are run again, too."""
