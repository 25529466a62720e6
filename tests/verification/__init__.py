"""Verification cases: what the code is compared with, and how far off it may be."""
