"""Damping of a vibrating structure by a granular damper: discrete elements, closed energy ledger, modal damping.

``run`` takes a configuration to a Dataset, as ``warpdamp.run("configs/beam.yaml")``; ``Simulation`` with ``Scene`` and
``State`` advances one scene step by step.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from .version import PHYSICS_VERSION as PHYSICS_VERSION
from .version import __version__ as __version__

_HOMES = {
    "run": "study.run",
    "carry_out": "study.run",
    "collect": "study.run",
    "open_results": "accessor",
    "ConfigError": "errors",
    "PackingError": "errors",
    "SimulationError": "errors",
    "StoreError": "errors",
    "load": "sweep.load",
    "Config": "config.study",
    "prepare": "damper.preparation",
    "Request": "damper.case",
    "Batch": "engine.batch",
    "Case": "engine.batch",
    "Simulation": "engine.batch",
    "Effects": "scene.effects",
    "Ledger": "engine.ledger",
    "Cylinder": "scene.scene",
    "Drive": "scene.scene",
    "Material": "scene.scene",
    "Scene": "scene.scene",
    "Surface": "scene.scene",
    "Grains": "scene.particles",
    "State": "scene.particles",
    "curves": "report.curves",
    "draw": "report.curves",
    "peaks": "analysis.optimum",
    "corrected": "modal.apparent_mass",
    "accelerance": "modal.frf",
    "constant_force": "modal.frf",
    "read_frf": "formats.frf_file",
    "fits": "modal.identify",
}

if TYPE_CHECKING:
    from .accessor import open_results as open_results
    from .analysis.optimum import peaks as peaks
    from .config.study import Config as Config
    from .damper.case import Request as Request
    from .damper.preparation import prepare as prepare
    from .engine.batch import Batch as Batch
    from .engine.batch import Case as Case
    from .engine.batch import Simulation as Simulation
    from .engine.ledger import Ledger as Ledger
    from .errors import ConfigError as ConfigError
    from .errors import PackingError as PackingError
    from .errors import SimulationError as SimulationError
    from .errors import StoreError as StoreError
    from .formats.frf_file import read_frf as read_frf
    from .modal.apparent_mass import corrected as corrected
    from .modal.frf import accelerance as accelerance
    from .modal.frf import constant_force as constant_force
    from .modal.identify import fits as fits
    from .report.curves import curves as curves
    from .report.curves import draw as draw
    from .scene.effects import Effects as Effects
    from .scene.particles import Grains as Grains
    from .scene.particles import State as State
    from .scene.scene import Cylinder as Cylinder
    from .scene.scene import Drive as Drive
    from .scene.scene import Material as Material
    from .scene.scene import Scene as Scene
    from .scene.scene import Surface as Surface
    from .study.run import carry_out as carry_out
    from .study.run import collect as collect
    from .study.run import run as run
    from .sweep.load import load as load

__all__ = [*_HOMES, "PHYSICS_VERSION", "__version__"]


def __getattr__(name: str):
    """Import on first use: the command line must answer at once, and Warp takes its time."""
    if name not in _HOMES:
        raise AttributeError(f"module 'warpdamp' has no attribute '{name}'")
    return getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
