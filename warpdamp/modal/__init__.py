"""Modes of structures, and modal damping and frequency response from dissipated energy."""
