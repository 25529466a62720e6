"""What can go wrong, by name: all derive from ``WarpdampError``."""

from __future__ import annotations


class WarpdampError(Exception):
    """What a user can put right: says in one line what is wrong, where, and what to do."""


class UsageError(WarpdampError, ValueError):
    """A call, an option or a file that cannot be used as it was given."""


class ConfigError(WarpdampError, ValueError):
    """What is wrong with a configuration: one line an error, each with its place."""


class SimulationError(WarpdampError, ArithmeticError):
    """A run that went wrong: what, where, and what to change."""


class PackingError(WarpdampError, ValueError):
    """The particles do not fit, or do not come to rest; ``key`` names the configuration's key to look at."""

    def __init__(self, message: str, key: str = "damper.particles.count"):
        super().__init__(message, key)
        self.key = key

    def __str__(self) -> str:
        return self.args[0]


class StoreError(WarpdampError):
    """A folder of results or of a cache that cannot be used: why, and what to do."""


class ExecutorError(WarpdampError):
    """Workers that are not there, or do not come back."""


class ModalError(WarpdampError, ValueError):
    """What cannot be had from these results, modes or FRFs: why, and what to do."""


class MissingLibrary(WarpdampError, ImportError):
    """A library of an extra is not installed; says how to install it."""
