"""Grid of a study: what its configuration sweeps, read and checked; no case is constructed for it."""

from __future__ import annotations

import math

from ..config.study import Config
from ..config.sweep import as_list
from .axes import CASE, FREQUENCY, GAMMA, OWN, SEED, coordinate_names, dotted
from .carried import leg_axes, refuse_one_amplitude
from .exclude import Exclusions
from .reader import read_axes

CHOSEN = {
    ("numerics", "steps_per_contact"),
    ("numerics", "step"),
    *(("steady_state", key) for key in ("recipe", "standard_error", "fewest_cycles")),
}
"""Scalars that a tolerance chooses."""


class Grid:
    """Axes of a study, and the combinations that are left out.

    Parameters
    ----------
    config : Config

    Raises
    ------
    ConfigError
        If an axis cannot be read.
    """

    def __init__(self, config: Config):
        self.config, self.axes = read_axes(config)
        self.axes += leg_axes(config)
        self.carried = {path for axis in self.axes if axis.name == CASE for path in axis.paths if path in OWN}
        """Which of frequency, gamma and seed change along the dimension ``case``."""
        excitation = self.config.excitation
        self.gammas = [math.nan] if GAMMA in self.carried else as_list(excitation.gamma)
        self.seeds = [0] if SEED in self.carried else self.config.seeds
        self.modal = excitation.frequency == "modes" and FREQUENCY not in self.carried
        self.excluded = Exclusions(self.config)
        self._refuse_what_the_tolerance_chooses()
        refuse_one_amplitude(self.config, self.axes, self.gammas)

    def _refuse_what_the_tolerance_chooses(self) -> None:
        chosen = [path for axis in self.axes for path in axis.paths if path in CHOSEN or path[0] == "accuracy"]
        if self.config.accuracy is not None and chosen:
            raise self.config.error(("sweep",), f"{dotted(chosen[0])} is chosen by accuracy.tolerance for all cases")

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions, those that ``case`` carries among them."""
        return ("frequency", "gamma", *(axis.name for axis in self.axes), "seed")

    def names(self) -> dict:
        """Names of the swept scalars, by path."""
        return coordinate_names(path for axis in self.axes for path in axis.paths)
