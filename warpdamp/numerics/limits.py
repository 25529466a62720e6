"""Usual and fewest steps and packings: constants that configurations are read with, too."""

STEPS_PER_CONTACT = 24
"""Usual steps to the shortest contact: a bed's ledger then closes to half a percent (docs/acceptance.md)."""

FEWEST_STEPS_PER_CONTACT = 10
"""Fewest steps to a contact: below, it is not resolved and a forced step is refused."""

FEWEST_STEPS_PER_CYCLE = 50
"""Fewest steps to a cycle, so that the drive's motion is followed to 0.1 %."""

FEWEST_PACKINGS = 3
"""Fewest packings of a point that an accuracy is asked of: fewer say nothing of how they scatter."""
