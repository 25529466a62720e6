"""Loading of a study from its YAML file."""

from __future__ import annotations

from pathlib import Path

from ..config.reading import read
from ..config.study import Config
from .exclude import refuse_exclusions_in_vain
from .grid import Grid


def load(path: str | Path) -> Config:
    """Read and validate a configuration, its sweep included.

    Parameters
    ----------
    path : str or Path
        YAML file.

    Returns
    -------
    Config
        Validated configuration in SI units.

    Raises
    ------
    ConfigError
        One line for every error: file:line:column: key: what is wrong.

    Examples
    --------
    >>> from warpdamp import load
    >>> config = load("configs/beam.yaml")
    >>> config.damper.particles.count, config.damper.enclosure.height  # [m]
    (120, 0.04)
    >>> load("configs/beam_modes.csv")
    Traceback (most recent call last):
    warpdamp.errors.ConfigError: configs/beam_modes.csv:1:1: not a warpdamp configuration: ...
    """
    config = read(path)
    refuse_exclusions_in_vain(Grid(config))  # what else is wrong with a sweep is said by making it
    return config
