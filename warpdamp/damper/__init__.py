"""The damper by itself: particles placed and prepared, then shaken until the energy per cycle is steady."""
