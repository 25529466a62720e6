"""Exceptions by name, which all derive from ``WarpdampError``, and how their messages quote a file."""

from __future__ import annotations


class WarpdampError(Exception):
    """Error that a user can correct: one line says what is wrong, where, and what to do."""


class UsageError(WarpdampError, ValueError):
    """Call, option or file that cannot be used as it was given."""


class ConfigError(WarpdampError, ValueError):
    """Errors of a configuration: one line each, with its place in the file."""


class SimulationError(WarpdampError, ArithmeticError):
    """Run that failed: what happened, where, and what to change."""


class PackingError(WarpdampError, ValueError):
    """Particles that do not fit, or do not come to rest; ``key`` names the configuration's key to look at."""

    def __init__(self, message: str, key: str = "damper.particles.count"):
        super().__init__(message, key)
        self.key = key

    def __str__(self) -> str:
        return self.args[0]


class StoreError(WarpdampError):
    """Folder of results or of a cache that cannot be used: why, and what to do."""


class ExecutorError(WarpdampError):
    """Workers that cannot be reached, or do not return."""


class ModalError(WarpdampError, ValueError):
    """Results, modes or FRFs that do not provide what was asked of them: why, and what to do."""


class MissingLibrary(WarpdampError, ImportError):
    """Library of an extra that is not installed; says how to install it."""


def printable(line: str) -> str:
    """Line with unprintable characters and line breaks spelt out."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in line)
