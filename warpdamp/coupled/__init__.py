"""Coupled runs: forces on a structure that answers its particles, and what an experimenter identifies from them."""
