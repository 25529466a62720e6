"""Apparent mass of a damper: what a structure feels, as a describing function of frequency and amplitude.

The enclosure at x = Re(X exp(j w t)) is pushed by its particles with the first harmonic F1 = w^2 X (m' - j m''):
m' is the apparent mass and m'' = W / (pi w^2 X^2) the mass in quadrature, which carries the work W of a cycle.  A block
that never leaves the floor has m' = m, m'' = 0; the ideal impact damper m'' = (4 / pi) m, the complex mass of the
paper's appendix A.

Modes in a Dataset carry the particles as a rigid mass m, so that a structure feels m_app - m on top of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.results import over_packings
from ..errors import ModalError
from ..variables import describe
from .damping import strain_energy

if TYPE_CHECKING:
    import xarray as xr

REACH = 0.05
"""Part of a frequency within which a damper's complex mass is taken for that at the frequency: a mode of the paper's
beam moves by 3 % at most as its damper's mass changes with Gamma (docs/frf.md)."""
ROUNDING = 1e-6
"""Part by which a frequency may lie outside: studies are run at modes rounded to a microhertz."""


_NEEDED = ("apparent_mass", "harmonic_work", "displacement", "excitation_frequency")
"""Variables of results that the complex mass follows from."""


def _require(dataset: xr.Dataset) -> None:
    needed = ("apparent_mass", "quadrature_mass") if "quadrature_mass" in dataset else _NEEDED
    if lacking := [name for name in needed if name not in dataset]:
        raise ModalError(f"the results have no {' and no '.join(lacking)}: take the file that `warpdamp run` wrote")


def complex_mass(dataset: xr.Dataset) -> xr.Dataset:
    """Apparent mass m' and mass in quadrature m'' [kg] of every case, mean over seeds.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results.

    Returns
    -------
    xarray.Dataset
        ``apparent_mass`` and ``quadrature_mass`` on (frequency, gamma, swept scalars), each with its standard error
        from the spread of the seeds (NaN with a single seed).  Of a card its own.

    Raises
    ------
    ModalError
        If the Dataset lacks what they follow from.
    """
    _require(dataset)
    found = dataset
    if "quadrature_mass" not in dataset:
        acceleration = (2 * np.pi * dataset["excitation_frequency"]) ** 2 * dataset["displacement"]
        quadrature = dataset["harmonic_work"] / (np.pi * acceleration * dataset["displacement"])
        found = dataset.assign(quadrature_mass=quadrature)
    mean = dataset[[]].drop_dims("seed", errors="ignore")
    for name in ("apparent_mass", "quadrature_mass"):
        mean[name], mean[f"{name}_standard_error"] = over_packings(found, name)
    return describe(mean)


def corrected(dataset: xr.Dataset) -> xr.Dataset:
    """Natural frequency, strain energy and damping of every mode with the mass that it feels at each Gamma.

    The paper counts the particles as a rigid mass m (its limitation iii).  Here the modes are recomputed with m' in its
    place, as found at each mode's frequency (see ``loaded_modes``): frequency and shape change, and at a given Gamma
    the displacement Gamma g / w^2 with them.  The mass in quadrature is kept, so zeta = m'' phi^2 / 2; the bare
    structure's damping is added unchanged.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results of a study with a structure.

    Returns
    -------
    xarray.Dataset
        On (mode, gamma, swept scalars): see ``warpdamp.variables.VARIABLES``; ``natural_frequency``, ``strain_energy``
        and ``damping_ratio`` are the uncorrected ones.

    Raises
    ------
    ModalError
        If the Dataset has no modes.

    Examples
    --------
    >>> from warpdamp import corrected, open_results
    >>> modes = corrected(open_results("docs/beam.nc"))
    >>> first = modes["corrected_natural_frequency"].sel(mode=1)
    >>> [round(float(first.sel(gamma=gamma)), 1) for gamma in (0.5, 5)]  # particles at rest, and flying [Hz]
    [39.5, 40.4]
    """
    import xarray as xr

    require_modes(dataset)
    felt = per_mode(dataset, complex_mass(dataset))
    own, amplitude = dataset["natural_frequency"], dataset["mode_amplitude"]
    particles = dataset["particle_mass"]

    def modes(extra):
        core = [["mode"]]
        return xr.apply_ufunc(loaded_modes, own, amplitude, extra, input_core_dims=core * 3, output_core_dims=core * 2)

    empty, _ = modes(-particles * xr.ones_like(own))
    frequency, shape = modes(felt["apparent_mass"] - particles)
    displacement = per_mode(dataset, dataset["displacement"])
    inherent = dataset["inherent_damping"]
    out = felt.assign(
        natural_frequency=own,
        empty_natural_frequency=empty,
        corrected_natural_frequency=frequency,
        corrected_natural_frequency_standard_error=frequency * shape**2 / 2 * felt["apparent_mass_standard_error"],
        corrected_mode_amplitude=shape,
        strain_energy=strain_energy(displacement, amplitude, own),
        corrected_strain_energy=strain_energy(displacement * (own / frequency) ** 2, shape, frequency),
        damping_ratio=dataset["damping_ratio"],
        damping_ratio_standard_error=dataset["damping_ratio_standard_error"],
        corrected_damping_ratio=(dataset["damping_ratio"] - inherent) * (shape / amplitude) ** 2 + inherent,
    )
    out.attrs = dict(dataset.attrs)
    return describe(out.transpose("mode", "gamma", ...))


def loaded_modes(frequency, amplitude, extra) -> tuple[np.ndarray, np.ndarray]:
    """Modes of a structure, given by its modes, with a mass added at the damper's point.

    Stiffness diag(w_r^2), mass I + phi phi^T extra.  With one mode alone it is w^2 (1 + phi^2 extra) = w_r^2.

    Parameters
    ----------
    frequency, amplitude : (..., m) arrays [Hz], [kg^-0.5]
    extra : (..., m) array [kg]
        The mass that each mode feels; NaN gives NaN.

    Returns
    -------
    frequency, amplitude : (..., m) arrays
        Of mode r with the mass ``extra[r]``.

    Raises
    ------
    ModalError
        If more mass is taken away than a mode has.
    """
    frequency, amplitude, extra = np.broadcast_arrays(frequency, amplitude, extra)
    count, known = frequency.shape[-1], np.isfinite(extra)
    w = 2 * np.pi * frequency
    lean = amplitude / w  # in the coordinates y = w q the problem is symmetric: (W^-1 M W^-1) y = y / w^2
    bare, attached = np.eye(count) / w[..., None] ** 2, lean[..., :, None] * lean[..., None, :]
    rank = np.argsort(np.argsort(-frequency, axis=-1), axis=-1)  # mass does not change the order of modes
    found, added = np.empty((2, *frequency.shape)), np.where(known, extra, 0.0)
    for r in range(count):
        inverse, vectors = np.linalg.eigh(bare + added[..., r, None, None] * attached)  # ascending: the lowest is last
        if np.any(inverse[..., 0] <= 0):
            raise ModalError("more mass is taken away than the structure's modes have: give the mass of the particles")
        k = rank[..., r, None]
        found[0, ..., r] = 1 / np.sqrt(np.take_along_axis(inverse, k, axis=-1)[..., 0])
        vector = np.take_along_axis(vectors, k[..., None, :], axis=-1)[..., 0]
        found[1, ..., r] = found[0, ..., r] * np.einsum("...i,...i->...", lean, vector)
    found[:, ~known] = np.nan
    return found[0] / (2 * np.pi), np.copysign(found[1], amplitude)


def per_mode(dataset: xr.Dataset, values):
    """Values at the modes' frequencies, on the dimension ``mode`` instead of ``frequency``.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results of a study at the modes of a structure.
    values : xarray.DataArray or xarray.Dataset
        On ``frequency``, one for each mode.
    """
    return values.rename(frequency="mode").assign_coords(mode=dataset["mode"])


def require_modes(dataset: xr.Dataset) -> None:
    """Refuse a Dataset of a damper without a structure.

    Parameters
    ----------
    dataset : xarray.Dataset

    Raises
    ------
    ModalError
        If the Dataset has no modes.
    """
    if "natural_frequency" not in dataset:
        raise ModalError("these results have no modes: run a study with a structure and `frequency: modes`")


@dataclass(frozen=True)
class ComplexMass:
    """Complex mass m' - j m'' of the damper as a function of frequency and Gamma.

    Between Gammas by monotone cubics (PCHIP): no overshoot, and no corner to trip a continuation.  Between frequencies
    in the logarithm of f: straight if the damper was run at a list of frequencies; if it was run at a structure's modes
    by a step that is flat at each of them, so that round a mode its own values hold.  Beyond the first and the last
    frequency, the nearest one's values.  Below the lowest Gamma the values there (a bed about to rest is linear: see
    ``within``); above the highest, refused.

    Parameters
    ----------
    frequency : (k,) array, increasing [Hz]
    gamma : (n,) array, increasing [-]
    mass : (k, n) complex array [kg]
    of_modes : whether the frequencies are a structure's modes
    band : lowest and highest frequency [Hz] that it may be used at, of a card; None: anywhere, with the nearest values
    """

    frequency: np.ndarray
    gamma: np.ndarray
    mass: np.ndarray
    of_modes: bool = True
    band: tuple[float, float] | None = None

    @classmethod
    def of(cls, dataset: xr.Dataset) -> ComplexMass:
        """Complex mass of a Dataset, mean over seeds; Gammas at which a case failed are left out.

        Parameters
        ----------
        dataset : xarray.Dataset
            Results, swept scalars selected.

        Returns
        -------
        ComplexMass

        Raises
        ------
        ModalError
            If the Dataset has swept scalars left, fewer than two Gammas, or several dampers, or lacks variables.
        """
        if "damper" in dataset.dims:
            raise ModalError("these are results of several dampers, which have no one mass: give those of one damper")
        _require(dataset)
        swept = [d for d in dataset["apparent_mass"].dims if d not in ("frequency", "gamma", "seed")]
        if swept:
            first = {d: dataset[d].values[0].item() for d in swept}
            choice = ", ".join(f"{d}={value:g}" for d, value in first.items())
            raise ModalError(f"the results have the axes {', '.join(swept)}: choose one value of each, as {choice}")
        felt = complex_mass(dataset).transpose("frequency", "gamma")
        mass = (felt["apparent_mass"] - 1j * felt["quadrature_mass"]).sortby(["frequency", "gamma"])
        mass = mass.dropna("gamma")
        if mass.sizes["gamma"] < 2:
            raise ModalError("a describing function needs results at two Gammas or more: run with a list of gamma")
        of_modes = "natural_frequency" in dataset or dataset.attrs.get("frequencies") == "modes"
        band = dataset.attrs.get("frequency_range")
        return cls(
            mass["frequency"].values,
            mass["gamma"].values,
            mass.values,
            of_modes,
            None if band is None else (float(band[0]), float(band[1])),
        )

    def __call__(self, frequency, gamma) -> np.ndarray:
        """Complex mass m' - j m'' at frequencies and Gammas, broadcast against each other [kg].

        Parameters
        ----------
        frequency, gamma : arrays
            [Hz], [-].

        Returns
        -------
        complex array
            [kg].

        Raises
        ------
        ModalError
            If a Gamma is above the highest.
        """
        frequency, gamma = np.broadcast_arrays(np.asarray(frequency, float), np.asarray(gamma, float))
        highest = self.gamma[-1]
        if np.any(gamma > highest * (1 + 1e-12)):
            raise ModalError(
                f"Gamma {gamma.max():g} is above {highest:g}, the highest in the results: run with larger gamma"
            )
        values = self._over_gamma(np.clip(gamma, self.gamma[0], highest))  # (..., k, 2)
        mass = values[..., 0] + 1j * values[..., 1]
        return np.sum(mass * self.weights(frequency), axis=-1)

    def holds_at(self, frequency) -> np.ndarray:
        """Whether the mass is known at resonances [Hz], (...) array of bool: anywhere, if it is not that of a card.

        A card made at the modes of a structure holds near these.
        """
        frequency = np.asarray(frequency, float)
        if self.band is None:
            return np.ones(frequency.shape, bool)
        if not self.of_modes:
            return self._in_band(frequency)
        return np.min(np.abs(frequency[..., None] / self.frequency - 1), axis=-1) <= REACH * (1 + ROUNDING)

    def require_modes_at(self, frequency) -> None:
        """Refuse resonances [Hz] that a card says nothing about.

        Raises
        ------
        ModalError
            Names the range of the card.
        """
        frequency = np.ravel(np.asarray(frequency, float))
        self.require_in_band(frequency)
        for f in frequency[~self.holds_at(frequency)]:
            known = ", ".join(f"{own:.4g}" for own in self.frequency)
            raise ModalError(
                f"a mode at {f:.4g} Hz: the card was made at the modes of a structure and holds within "
                f"{100 * REACH:g} % of {known} Hz: make one from a run with a list of excitation.frequency"
            )

    def require_in_band(self, frequency) -> None:
        """Refuse frequencies [Hz] outside the band of a card.

        Raises
        ------
        ModalError
            Names the band.
        """
        frequency = np.ravel(np.asarray(frequency, float))
        for f in frequency[~self._in_band(frequency)]:
            low, high = self.band
            raise ModalError(f"{f:.4g} Hz is outside the range of the card, {low:.4g} to {high:.4g} Hz")

    def _in_band(self, frequency: np.ndarray) -> np.ndarray:
        low, high = self.band or (0.0, np.inf)
        return (frequency >= low * (1 - ROUNDING)) & (frequency <= high * (1 + ROUNDING))

    def within(self, gamma) -> np.ndarray:
        """Whether Gammas lie in the range of the results.

        Parameters
        ----------
        gamma : (...) array

        Returns
        -------
        (...) array of bool
        """
        return (np.asarray(gamma) >= self.gamma[0]) & (np.asarray(gamma) <= self.gamma[-1])

    @cached_property
    def _over_gamma(self):
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.gamma, np.stack([self.mass.T.real, self.mass.T.imag], axis=-1))

    def weights(self, frequency) -> np.ndarray:
        """(..., k) shares of the frequencies in the value at another one [Hz]."""
        count = len(self.frequency)
        place = np.interp(np.log(frequency), np.log(self.frequency), np.arange(count))
        below = np.minimum(place.astype(int), max(count - 2, 0))
        part = place - below
        if self.of_modes:
            part = part**2 * (3 - 2 * part)
        share = np.zeros((*place.shape, count))
        np.put_along_axis(share, below[..., None], (1 - part)[..., None], axis=-1)
        if count > 1:
            np.put_along_axis(share, below[..., None] + 1, part[..., None], axis=-1)
        return share
