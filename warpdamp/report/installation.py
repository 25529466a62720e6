"""What is installed: versions, devices, caches, and the extras that are missing."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
from pathlib import Path

from ..files import cache_path
from ..version import PHYSICS_VERSION, RESULTS_VERSION, __version__

SHOWN = ("warp-lang", "numpy", "scipy", "xarray", "netCDF4", "scikit-fem", "matplotlib")
"""Libraries whose versions matter for results and their files."""
_REQUIREMENT = re.compile(r"(?P<name>[A-Za-z0-9._-]+)[^;]*(?:;.*extra\s*==\s*['\"](?P<extra>[^'\"]+)['\"])?")


def versions() -> dict[str, str]:
    """Versions by name, warpdamp's own first."""
    own = {
        "warpdamp": f"{__version__} (physics {PHYSICS_VERSION}, results {RESULTS_VERSION})",
        "Python": f"{platform.python_version()} on {platform.system()} {platform.machine()}",
    }
    return own | {name: importlib.metadata.version(name) for name in SHOWN}


def devices() -> dict[str, str]:
    """Devices that a study can run on, by the names that Warp gives them; starts Warp."""
    import warp as wp

    from ..engine.device import present

    gpus = {gpu.alias: f"{gpu.name}, {gpu.total_memory / 2**30:.0f} GiB" for gpu in wp.get_cuda_devices()}
    return {kind: f"{os.cpu_count()} cores" for kind in present() if kind == "cpu"} | gpus


def caches() -> dict[str, str]:
    """Folders of the cache, with the files in each and their size."""
    return {kind: _contents(folder) for kind, folder in cache_folders().items()}


def cache_folders() -> dict[str, Path]:
    """Folders of the cache by what is in them."""
    kernels = os.environ.get("WARP_CACHE_PATH")
    return {"beds": cache_path("beds"), "kernels": Path(kernels) if kernels else cache_path("kernels")}


def _contents(folder: Path) -> str:
    files = [path for path in folder.rglob("*") if path.is_file()]
    return f"{folder}: {len(files)} files, {sum(path.stat().st_size for path in files) / 1e6:.1f} MB"


def extras() -> dict[str, str]:
    """Extras of the package: installed, or the line that installs what is missing."""
    wanted: dict[str, list[str]] = {}
    for requirement in importlib.metadata.requires("warpdamp") or ():
        parts = _REQUIREMENT.match(requirement)
        if parts["extra"]:
            wanted.setdefault(parts["extra"], []).append(parts["name"])
    return {extra: _state(extra, names) for extra, names in sorted(wanted.items())}


def _state(extra: str, names: list[str]) -> str:
    missing = [name for name in names if not _installed(name)]
    return f"{', '.join(missing)} missing: pip install 'warpdamp[{extra}]'" if missing else "installed"


def _installed(name: str) -> bool:
    try:
        importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return False
    return True
