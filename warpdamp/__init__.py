"""warpdamp: how much vibration a granular damper takes out of a structure.

>>> import warpdamp
>>> dataset = warpdamp.run("configs/beam.yaml")

The researcher's door is ``Simulation`` with ``Scene`` and ``State``.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

__version__ = "0.1.0"

PHYSICS_VERSION = 4
"""Raised whenever a change alters results, so that cached beds and stored results of old physics are not mixed in."""

RESULTS_VERSION = 2
"""Raised whenever a finished case holds something new, so that stored results of before are run again, too."""

_HOMES = {
    "run": "study",
    "carry_out": "study",
    "collect": "study",
    "open_results": "accessor",
    "StoreError": "files",
    "load": "config",
    "Config": "config",
    "ConfigError": "config",
    "PackingError": "guards",
    "prepare": "packing",
    "Request": "packing",
    "Batch": "engine",
    "Case": "engine",
    "Simulation": "engine",
    "SimulationError": "guards",
    "Effects": "effects",
    "Ledger": "ledger",
    "Cylinder": "scene",
    "Drive": "scene",
    "Grains": "scene",
    "Material": "scene",
    "Scene": "scene",
    "State": "scene",
    "Surface": "scene",
    "curves": "plot",
    "draw": "plot",
    "peaks": "optimum",
    "corrected": "modal.apparent",
    "accelerance": "modal.frf",
    "constant_force": "modal.frf",
    "fits": "modal.measured",
}

if TYPE_CHECKING:
    from .accessor import open_results as open_results
    from .config import Config as Config
    from .config import ConfigError as ConfigError
    from .config import load as load
    from .effects import Effects as Effects
    from .engine import Batch as Batch
    from .engine import Case as Case
    from .engine import Simulation as Simulation
    from .files import StoreError as StoreError
    from .guards import PackingError as PackingError
    from .guards import SimulationError as SimulationError
    from .ledger import Ledger as Ledger
    from .modal.apparent import corrected as corrected
    from .modal.frf import accelerance as accelerance
    from .modal.frf import constant_force as constant_force
    from .modal.measured import fits as fits
    from .optimum import peaks as peaks
    from .packing import Request as Request
    from .packing import prepare as prepare
    from .plot import curves as curves
    from .plot import draw as draw
    from .scene import Cylinder as Cylinder
    from .scene import Drive as Drive
    from .scene import Grains as Grains
    from .scene import Material as Material
    from .scene import Scene as Scene
    from .scene import State as State
    from .scene import Surface as Surface
    from .study import carry_out as carry_out
    from .study import collect as collect
    from .study import run as run

__all__ = [*_HOMES, "PHYSICS_VERSION", "__version__"]


def __getattr__(name: str):
    """Import on first use: the command line must answer at once, and Warp takes its time."""
    if name not in _HOMES:
        raise AttributeError(f"module 'warpdamp' has no attribute '{name}'")
    return getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
