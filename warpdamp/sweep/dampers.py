"""Several dampers on one structure: the configuration of each alone."""

from __future__ import annotations

from ..config.damper import WALLS, between
from ..config.study import Config
from .cases import Cases


def every_damper(config: Config) -> list[Config]:
    """Configurations with each of the dampers as the only one, all else unchanged but materials that are not used.

    They keep the structure of all dampers, and are for what is in the cavities.

    Raises
    ------
    ConfigError
        If the configuration is of more than one combination of single values.
    """
    varied = [path for axis in Cases(config).axes for path in axis.paths]
    if varied:
        key = ".".join(map(str, varied[0]))
        raise config.error(varied[0], f"{key} takes one value where there are several dampers")
    return [_only(config, damper) for damper in (config.damper, *config.dampers)]


def _only(config: Config, damper) -> Config:
    """Configuration of one damper, without a structure and shaken at no frequency yet."""
    named = {*damper.materials().values()}
    grains = {part.material for part in damper.mixture} | {WALLS}
    pairs = {key: value for key, value in config.contact.pairs.items() if grains.issuperset(between(key))}
    return config.model_copy(
        update={
            "damper": damper,
            "dampers": [],
            "structure": None,
            "coupled": None,
            "materials": {name: value for name, value in config.materials.items() if name in named},
            "contact": config.contact.model_copy(update={"pairs": pairs}),
        }
    )
