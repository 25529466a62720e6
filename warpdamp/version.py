"""Versions: of the package, of its physics, and of what a finished case holds."""

from __future__ import annotations

__version__ = "0.1.0"


PHYSICS_VERSION = 5
"""Raised whenever a change alters results, so that cached beds and stored results of old physics are not mixed in.

5: contacts are computed eight side by side and added in the order of the list: other round-off, the same physics.  Beds
are compacted without friction, until their clearance no longer rises.
"""


RESULTS_VERSION = 3
"""Raised whenever a finished case holds something new, so that stored results of before are run again, too."""
