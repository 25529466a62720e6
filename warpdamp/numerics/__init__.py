"""Numerical choices: step, length of a run, tolerance, and fits."""
