"""Plan of the study that a folder of results holds."""

from __future__ import annotations

from pathlib import Path

from ..errors import StoreError
from .cases import Cases
from .load import load
from .plan import Plan, load_or_make_plan


def load_plan(folder: Path) -> Plan:
    """Plan of the study that a folder holds.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    Plan

    Raises
    ------
    StoreError
        If it holds none.
    """
    if not (folder / "study.yaml").is_file():
        raise StoreError(f"{folder}: holds no study (no study.yaml): give the folder that warpdamp run made")
    return load_or_make_plan(Cases(load(folder / "study.yaml")), folder)
