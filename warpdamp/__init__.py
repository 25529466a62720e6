"""warpdamp: how much vibration a granular damper takes out of a structure."""

__version__ = "0.1.0"

PHYSICS_VERSION = 1
"""Raised whenever a change alters results, so that cached beds and stored results of old physics are not mixed in."""
