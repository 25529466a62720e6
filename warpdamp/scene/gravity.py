"""The standard acceleration of gravity."""

STANDARD_GRAVITY = 9.81
"""g [m/s^2] that turns Gamma into an acceleration (the paper's value)."""
