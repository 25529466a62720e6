"""What can go wrong, by name."""

from __future__ import annotations


class ConfigError(ValueError):
    """What is wrong with a configuration: one line an error, each with its place."""


class SimulationError(ArithmeticError):
    """A run that went wrong: what, where, and what to change."""


class PackingError(ValueError):
    """The particles do not fit, or do not come to rest; ``key`` names the configuration's key to look at."""

    def __init__(self, message: str, key: str = "damper.particles.count"):
        super().__init__(message, key)
        self.key = key

    def __str__(self) -> str:
        return self.args[0]


class StoreError(OSError):
    """A folder of results that cannot be used: why, and what to do."""


class ModalError(ValueError):
    """What cannot be had from these results or this FRF; says why, and what to do."""


class MissingLibrary(ModuleNotFoundError):
    """A library of an extra is not installed; says how to install it."""
