"""Analyses as methods of a Dataset: ``dataset.damper.optimum()``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from .analysis.effects import effect_of
from .analysis.emulator import Emulator
from .analysis.optimum import optimum
from .analysis.regimes import regime
from .analysis.results import kind_of, over_packings
from .errors import UsageError
from .files import netcdf_errors
from .modal.apparent_mass import ROUNDING
from .modal.card import at_frequencies, is_card
from .modal.damping import damping_of_effectiveness
from .report.curves import draw
from .report.maps import regime_map

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .modes import Modes


@xr.register_dataset_accessor("damper")
class Damper:
    """Analyses of a results Dataset, as its attribute ``damper``.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results.
    """

    def __init__(self, dataset: xr.Dataset):
        self._dataset = dataset

    def optimum(self, of: str = "effectiveness") -> xr.Dataset:
        """Gamma of fluidisation and of two-sided collision [-]; see ``warpdamp.analysis.optimum.optimum``.

        Parameters
        ----------
        of : str
            Variable with a ``_standard_error``.

        Returns
        -------
        xarray.Dataset
            ``gamma_fluidisation``, ``gamma_collision``, the heights there and standard errors.

        Raises
        ------
        ValueError
            If Gamma is not a dimension.
        """
        return optimum(self._dataset, of)

    def effect_of(self, factor: str, *, step: float | None = None) -> xr.Dataset:
        """Effect of a swept scalar on both optima and the curve; see ``warpdamp.analysis.effects.effect_of``.

        Parameters
        ----------
        factor : str
            The scalar's key, as ``contact.friction``, or its coordinate's name.
        step : float, optional
            Change of the factor, in its unit, that an effect is stated for (default: a doubling; where a level is zero
            or negative, all of the range).

        Returns
        -------
        xarray.Dataset
            Signed relative effects with 95 % intervals, tests and a verdict for each of ``gamma_fluidisation``,
            ``effectiveness_fluidisation``, ``gamma_collision`` and ``effectiveness_collision``.

        Raises
        ------
        UsageError
            If there is no such factor, it has one level, or there are fewer than three packings.
        """
        return effect_of(self._dataset, factor, step=step)

    def regime(self) -> xr.DataArray:
        """Regime of motion of every case; see ``warpdamp.analysis.regimes.regime``.

        Returns
        -------
        xarray.DataArray
            Numbers of ``warpdamp.analysis.regimes.Regime``.

        Raises
        ------
        ValueError
            If the results lack an indicator: ``effects.indicators`` was off.
        """
        return regime(self._dataset)

    def emulator(self) -> Emulator:
        """Emulator of the effectiveness between the cases of a sweep, with intervals.

        Returns
        -------
        warpdamp.analysis.emulator.Emulator
            ``predict(frequency=..., gamma=..., ...)`` gives the effectiveness, its interval and whether to trust it;
            ``cross_validation()`` and ``cases_to_halve()`` say how good it is, and what would make it better.

        Raises
        ------
        UsageError
            If a swept scalar is no number, or there are too few finished cases.

        Examples
        --------
        >>> from warpdamp import open_results
        >>> emulator = open_results("docs/beam.nc").damper.emulator()
        >>> emulator.names
        ['frequency', 'gamma']
        >>> at = emulator.predict(frequency=40.0, gamma=[4.0, 40.0])
        >>> at["trusted"].values.tolist()
        [1, 0]
        """
        return Emulator(self._dataset)

    def damping(self, modes: Modes) -> xr.Dataset:
        """Damping ratio of any structure's modes with this damper, (2 / pi) eps m phi^2 [-], mean over seeds.

        Effectiveness is taken linearly between the frequencies that were run, of a card as its complex mass.

        Parameters
        ----------
        modes : Modes
            Modes as the damper sees them, with the particles as a rigid mass.

        Returns
        -------
        xarray.Dataset
            ``damping_ratio`` and ``damping_ratio_standard_error`` on (mode, gamma, swept scalars).

        Raises
        ------
        ValueError
            If a mode's frequency lies outside those that were run, or there is no frequency dimension.

        References
        ----------
        Terzioglu & Rongong, Selection of granular damper parameters to achieve optimum vibration attenuation on
        vibrating structures, eqs 4-11.
        """
        dataset = self._dataset
        if "damper" in dataset.dims:
            raise ValueError(
                "results of several dampers: the damping is in `damping_ratio`, of modes that carry them all"
            )
        if "frequency" not in dataset["effectiveness"].dims:
            raise ValueError("damping of modes needs frequency as a dimension of the Dataset")
        if is_card(dataset):
            dataset = at_frequencies(dataset, np.unique(modes.frequency))
        low, high = float(dataset["frequency"].min()), float(dataset["frequency"].max())
        outside = [f for f in np.asarray(modes.frequency) if not low * (1 - ROUNDING) <= f <= high * (1 + ROUNDING)]
        if outside:
            raise ValueError(f"a mode at {outside[0]:.1f} Hz lies outside the frequencies run, {low:g} to {high:g} Hz")
        number = xr.DataArray(np.asarray(modes.number), dims="mode", attrs={"units": "1", "long_name": "mode"})
        frequency, amplitude = np.clip(modes.frequency, low, high), np.asarray(modes.amplitude)
        frequency, amplitude = (xr.DataArray(a, dims="mode") for a in (frequency, amplitude))
        value, error = over_packings(dataset, "effectiveness")
        variance = error**2
        if dataset.sizes["frequency"] > 1:
            value, variance = (a.interp(frequency=frequency) for a in (value, variance))
        else:
            value, variance = (a.isel(frequency=0) for a in (value, variance))
        mass = dataset["particle_mass"]
        zeta = xr.Dataset(
            {
                "damping_ratio": damping_of_effectiveness(value, mass, amplitude),
                "damping_ratio_standard_error": damping_of_effectiveness(np.sqrt(variance), mass, amplitude),
            }
        ).assign_coords(mode=number)
        for name in zeta.data_vars:
            zeta[name].attrs.update(units="1", long_name=name.replace("_", " "))
        return zeta.drop_vars("frequency", errors="ignore")

    def plot(self) -> Figure:
        """Figure that suits the dimensions: curves over Gamma, maps, or scattered cases; see ``report.curves.draw``.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ValueError
            If no case is finished.
        """
        return draw(self._dataset)

    def regime_map(self) -> Figure:
        """Map of the regimes over frequency and Gamma; see ``warpdamp.report.maps.regime_map``.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ValueError
            If the results lack an indicator: ``effects.indicators`` was off.
        """
        return regime_map(self._dataset)


def open_results(path: str | Path) -> xr.Dataset:
    """Open a results file; its Dataset has the analyses ``.damper``.

    Parameters
    ----------
    path : str or Path
        netCDF file that ``warpdamp run`` or ``warpdamp collect`` wrote.

    Returns
    -------
    xarray.Dataset
        Read from the file when needed; see ``warpdamp.variables.VARIABLES`` for its variables.

    Raises
    ------
    UsageError
        If there is no such file, or it is not a results file.

    Examples
    --------
    >>> from warpdamp import open_results
    >>> results = open_results("docs/beam.nc")
    >>> dict(results.sizes)
    {'frequency': 3, 'gamma': 21, 'seed': 3, 'mode': 3}
    >>> first = results["damping_ratio"].sel(mode=1)
    >>> float(first.idxmax("gamma"))  # Gamma of the most damping
    6.0
    """
    with netcdf_errors(path):
        dataset = xr.open_dataset(path)
    if "status" not in dataset:
        dataset.close()
        raise UsageError(f"{path}: {kind_of(dataset)} (it has no status)")
    return dataset
