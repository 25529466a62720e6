"""What cards of the dampers predict, beside a mode that was read off coupled runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..errors import UsageError
from ..modal.apparent_mass import ComplexMass
from ..modal.card_damper import difference
from ..modal.from_config import amplitudes
from ..modal.from_config import modes as modes_of
from ..modal.resonance import LoadedMode
from ..variables import describe

if TYPE_CHECKING:
    import xarray as xr

    from ..config.study import Config


def mode_with_dampers(config: Config, cards: Sequence[xr.Dataset]) -> LoadedMode:
    """The one mode of a structure with the dampers that cards are of, in their order.

    Parameters
    ----------
    config : Config
        Of coupled runs.
    cards : Sequence of xarray.Dataset
        A card for each damper, or one for all.

    Raises
    ------
    UsageError
        If no mode will be read, beside which the prediction could stand, or if there are more or fewer cards.
    """
    own = config.coupled
    if own is None:
        raise config.error("coupled", "missing: it says what moves the structure, as release: {gamma: 10, mode: 1}")
    modes = modes_of(config, particles=0.0)
    if len(modes.number) != 1 or not (own.release or own.signals.harmonic):
        raise UsageError(
            "--card: a prediction stands beside a mode that is read, and one is read where the structure has one mode "
            f"(structure.modes) and a harmonic signal or a release moves it; here are {len(modes.number)} and "
            f"{own.source}"
        )
    dampers = 1 + len(config.dampers)
    if len(cards) not in (1, dampers):
        raise UsageError(f"--card: the structure carries {dampers} dampers, and the cards are {len(cards)}")
    return LoadedMode(
        float(modes.frequency[0]),
        float(modes.inherent_damping[0]),
        amplitudes(config, modes)[:, 0],
        [ComplexMass.of(part) for part in _one_each(config, cards)],
    )


def differences(config: Config, cards: Sequence[xr.Dataset]) -> list[str]:
    """Sentences on where cards are of other dampers than the configuration describes."""
    return [said for k, part in enumerate(_one_each(config, cards), 1) if (said := difference(part, config, k))]


def _one_each(config: Config, cards: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """A card for each damper; one that is given is that of all."""
    return list(cards) * (1 + len(config.dampers) if len(cards) == 1 else 1)


def with_prediction(runs: xr.Dataset, mode: LoadedMode) -> xr.Dataset:
    """Coupled runs with frequency and damping ratio predicted at the Gamma of every stretch that a mode was read in.

    Parameters
    ----------
    runs : xarray.Dataset
        With ``window_gamma``.
    mode : LoadedMode

    Returns
    -------
    xarray.Dataset
        With ``predicted_frequency`` and ``predicted_damping_ratio``; NaN at Gammas that the cards do not reach.
    """
    frequency, damping = mode.at(runs["window_gamma"].values)
    dims = runs["window_gamma"].dims
    return describe(runs.assign(predicted_frequency=(dims, frequency), predicted_damping_ratio=(dims, damping)))
