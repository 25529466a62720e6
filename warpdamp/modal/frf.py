"""Frequency response of a structure with a granular damper: accelerance at controlled Gamma and at constant force.

The force acts where the damper sits, as the shaker does in the experiment.  The structure is the sum of its modes, the
damper a complex mass on top of the rigid one that the modes carry: with H the receptance of the modes and
dm = m_app(f, Gamma) - m, the force that unit acceleration takes is the dynamic mass

    Z(f, Gamma) = 1 / A = dm - 1 / (w^2 H(w)).

At controlled Gamma this is a linear FRF for every Gamma.  At constant force, Z(f, Gamma) Gamma g = F is harmonic
balance: see ``response``.  Modes that are not given are left out: no residuals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ModalError
from ..scene.scene import STANDARD_GRAVITY
from ..variables import describe
from .apparent_mass import ComplexMass, require_modes
from .harmonic_balance import branches

if TYPE_CHECKING:
    import xarray as xr

    from ..modes import Modes

BACKGROUND = 60
"""Frequencies per octave between resonances."""
ROUND_A_RESONANCE = 25
"""Frequencies on each modal circle, evenly spaced along it."""
PER_DECADE = 40
"""Amplitudes per decade in the search for branches."""


@dataclass(frozen=True)
class ModalModel:
    """Structure given by its modes at the damper's point.

    Parameters
    ----------
    frequency : (m,) array
        Natural frequencies [Hz].
    amplitude : (m,) array
        Mass-normalised mode shapes [kg^-0.5].
    damping_ratio : (m,) array
        Hysteretic [-]: loss factor eta = 2 zeta.
    particle_mass : float
        Mass of the particles already in the modes [kg].
    """

    frequency: np.ndarray
    amplitude: np.ndarray
    damping_ratio: np.ndarray
    particle_mass: float

    @classmethod
    def of(cls, dataset: xr.Dataset) -> ModalModel:
        """Modal model of a study's results, with the damping that the bare structure was given.

        Raises
        ------
        ModalError
            If the results have no modes.
        """
        require_modes(dataset)
        return cls(
            dataset["natural_frequency"].values,
            dataset["mode_amplitude"].values,
            dataset["inherent_damping"].values,
            float(dataset["particle_mass"]),
        )

    @classmethod
    def of_modes(cls, modes: Modes, damping_ratio, particle_mass: float) -> ModalModel:
        """Modal model of any modes.

        Parameters
        ----------
        modes : Modes
        damping_ratio : float or (m,) array
            Hysteretic [-].
        particle_mass : float
            Mass of the particles that the modes carry [kg]; 0: none.
        """
        damping = np.broadcast_to(np.asarray(damping_ratio, float), modes.frequency.shape)
        return cls(modes.frequency, modes.amplitude, damping, particle_mass)

    def _receptance(self, frequency) -> tuple[np.ndarray, np.ndarray]:
        """H = sum phi^2 / (w_r^2 (1 + j eta) - w^2) [m/N], and where it is infinite: at modes without damping."""
        w = 2 * np.pi * np.asarray(frequency, float)[..., None]
        denominator = self._stiffness - w**2
        pole = denominator == 0
        return np.sum(self.amplitude**2 / np.where(pole, 1.0, denominator), axis=-1), pole.any(axis=-1)

    def dynamic_mass(self, frequency) -> np.ndarray:
        """Dynamic mass, force per acceleration, without the particles [kg]; add their complex mass.

        Parameters
        ----------
        frequency : (...) array
            [Hz].

        Returns
        -------
        (...) complex array
            [kg].
        """
        w = 2 * np.pi * np.asarray(frequency, float)
        found, at_pole = self._receptance(frequency)
        return -self.particle_mass - np.where(at_pole, 0.0, 1 / (w**2 * found))

    def resonances(self, mass: ComplexMass, gamma: float) -> tuple[np.ndarray, np.ndarray]:
        """Natural frequencies [Hz] and damping ratios with the damper linearised at a Gamma, by complex modes.

        Eigenvalues w^2 (1 + j eta) of (diag w_r^2 (1 + j eta_r), I + phi phi^T dm), dm taken at the frequency found.

        Parameters
        ----------
        mass : ComplexMass
        gamma : float

        Returns
        -------
        frequency, damping_ratio : (m,) arrays
            [Hz], [-].
        """
        found = []
        for own, rank in zip(self.frequency, np.argsort(np.argsort(self.frequency)), strict=True):
            frequency, before = float(own), 0.0
            for _ in range(100):
                extra = mass(frequency, gamma) - self.particle_mass
                loaded = np.eye(len(self.frequency)) + extra * np.outer(self.amplitude, self.amplitude)
                square = np.linalg.eigvals(np.linalg.solve(loaded, np.diag(self._stiffness)))
                square = square[np.argsort(square.real)][rank]
                frequency, before = float(np.sqrt(square.real) / (2 * np.pi)), frequency
                if abs(frequency - before) < 1e-12 * frequency:
                    break
            found.append((frequency, square.imag / square.real / 2))
        frequencies, ratios = np.array(found).T
        return frequencies, ratios

    @property
    def _stiffness(self) -> np.ndarray:
        return (2 * np.pi * self.frequency) ** 2 * (1 + 2j * self.damping_ratio)


def accelerance(
    dataset: xr.Dataset, gamma=None, frequency=None, *, band=None, structure: ModalModel | None = None
) -> xr.Dataset:
    """Accelerance of the structure at controlled Gamma, as a shaker controller measures it [m s^-2 N^-1].

    Parameters
    ----------
    dataset : xarray.Dataset
        Results of a study, swept scalars selected.
    gamma : array or None
        Amplitudes [-] (default: those of the results).
    frequency : (n,) array or None
        [Hz] (default: dense round every resonance in the band).
    band : (float, float) or None
        Lowest and highest frequency [Hz] (default: from half the lowest mode to 1.25 times the highest).
    structure : ModalModel or None
        Default: the study's own.

    Returns
    -------
    xarray.Dataset
        ``accelerance_real`` and ``accelerance_imaginary`` on (gamma, frequency); on (mode, gamma) the frequency
        [Hz] and damping ratio of every resonance with the damper linearised there.

    Raises
    ------
    ModalError
        If the results have no modes or swept scalars left, if a Gamma is outside their range, or if a frequency is not
        above 0 or outside the range of a card.

    Examples
    --------
    >>> from warpdamp import accelerance, open_results
    >>> frf = accelerance(open_results("docs/beam.nc"), gamma=[2.0, 5.0])
    >>> [round(100 * float(zeta), 1) for zeta in frf["resonance_damping_ratio"].sel(mode=1)]  # [%]
    [1.8, 2.8]
    """
    import xarray as xr

    mass, own = ComplexMass.of(dataset), structure or ModalModel.of(dataset)
    gamma = mass.gamma if gamma is None else np.atleast_1d(np.asarray(gamma, float))
    if not mass.within(gamma).all():
        raise ModalError(f"gamma: the results reach from {mass.gamma[0]:g} to {mass.gamma[-1]:g}, {gamma} does not fit")
    resonance = np.array([own.resonances(mass, g) for g in gamma])  # (gamma, 2, mode)
    _require_known(mass, resonance, band if frequency is None else (np.min(frequency), np.max(frequency)))
    if frequency is None:
        frequency = _grid(resonance, _band(own, mass, band))
    frequency = np.asarray(frequency, float)
    if not (np.isfinite(frequency) & (frequency > 0)).all():
        raise ModalError("frequency: expected finite frequencies above 0 Hz")
    mass.require_in_band(frequency)
    moved = own.dynamic_mass(frequency) + mass(frequency, gamma[:, None])
    if not moved.all():
        at = frequency[np.argwhere(moved == 0)[0, -1]]
        raise ModalError(f"frequency: {at:g} Hz is that of a mode without any damping: give inherent_damping")
    response = 1 / moved
    resonance = np.where(mass.holds_at(resonance[:, :1]), resonance, np.nan)  # other modes of a card's structure
    out = xr.Dataset(
        {
            "accelerance_real": (("gamma", "frequency"), response.real),
            "accelerance_imaginary": (("gamma", "frequency"), response.imag),
            "resonance_frequency": (("mode", "gamma"), resonance[:, 0].T),
            "resonance_damping_ratio": (("mode", "gamma"), resonance[:, 1].T),
        },
        {
            "gamma": ("gamma", gamma, {"units": "1", "long_name": "acceleration amplitude over g"}),
            "frequency": ("frequency", frequency, {"units": "Hz", "long_name": "excitation frequency"}),
            "mode": ("mode", _mode_numbers(dataset, own), {"units": "1", "long_name": "mode"}),
        },
    )
    out.attrs = _attributes(dataset, "accelerance at controlled Gamma")
    return describe(out)


def constant_force(dataset: xr.Dataset, forces, band=None, *, structure: ModalModel | None = None) -> xr.Dataset:
    """Response to harmonic forces of constant amplitude: every branch, stable or not.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results of a study, swept scalars selected.
    forces : float or array
        Amplitudes [N].
    band : (float, float) or None
        Lowest and highest frequency [Hz] (default: from half the lowest mode to 1.25 times the highest).
    structure : ModalModel or None
        Default: the study's own.

    Returns
    -------
    xarray.Dataset
        On ``point``, in the order in which each branch is followed: ``force``, ``branch``, ``excitation_frequency``,
        ``response_gamma``, the accelerance, ``stable``, and ``within_range``: whether Gamma lies in the results' range
        (below it, the values at their lowest Gamma are used).

    Raises
    ------
    ModalError
        If the results have no modes or swept scalars left, if a force drives the damper above their highest Gamma, or
        if a frequency is outside the range of a card.
    """
    import xarray as xr

    mass, own = ComplexMass.of(dataset), structure or ModalModel.of(dataset)
    resonance = np.array([own.resonances(mass, g) for g in mass.gamma])
    _require_known(mass, resonance, band)
    frequency = _grid(resonance, _band(own, mass, band))
    if not np.size(forces):
        raise ModalError("forces: give an amplitude, or several [N]")

    def damper(f, acceleration):  # rounding may carry the edge of the grid past the highest Gamma
        return mass(f, np.minimum(acceleration / STANDARD_GRAVITY, mass.gamma[-1]))

    rows = []
    for force in np.atleast_1d(np.asarray(forces, float)):
        _bounded(own, mass, force, frequency)
        quiet = force / np.abs(own.dynamic_mass(frequency) + mass(frequency, mass.gamma[0]))
        lowest = 0.5 * min(quiet.min(), mass.gamma[0] * STANDARD_GRAVITY)
        highest = mass.gamma[-1] * STANDARD_GRAVITY
        count = 2 + int(PER_DECADE * np.log10(highest / lowest))
        found = branches(own.dynamic_mass, damper, force, frequency, np.geomspace(lowest, highest, count))
        for number, branch in enumerate(found, start=1):
            response = branch.amplitude / force * np.exp(1j * branch.phase)
            rows.append((force, number, branch, response))
    names = ("force", "branch", "excitation_frequency", "response_gamma", "accelerance_real", "accelerance_imaginary")
    columns = {name: [] for name in (*names, "stable", "within_range")}
    for force, number, branch, response in rows:
        level = branch.amplitude / STANDARD_GRAVITY
        same = np.ones(len(level))
        values = (force * same, number * same.astype(int), branch.frequency, level, response.real, response.imag)
        for name, value in zip(columns, (*values, branch.stable, mass.within(level)), strict=True):
            columns[name].append(value)
    out = xr.Dataset({name: ("point", np.concatenate(parts)) for name, parts in columns.items()})
    out.attrs = _attributes(dataset, "response at constant force")
    return describe(out)


def chosen(dataset: xr.Dataset, choices: list[str]) -> xr.Dataset:
    """Results at given values of their swept scalars.

    Parameters
    ----------
    dataset : xarray.Dataset
    choices : list of str
        Each as ``friction=0.5``.

    Returns
    -------
    xarray.Dataset
        Without the dimensions chosen.

    Raises
    ------
    ModalError
        If there is no such axis or value; says which there are.
    """
    for choice in choices:
        name, _, value = choice.partition("=")
        if name not in dataset.dims or name in ("frequency", "gamma", "mode", "seed"):
            raise ModalError(f"{choice}: the results have no swept scalar '{name}'")
        have = dataset[name].values
        if have.dtype.kind not in "fiu":
            if value not in have:
                raise ModalError(f"{choice}: choose from {', '.join(map(str, have))}")
            dataset = dataset.sel({name: value})
            continue
        try:
            nearest = int(np.argmin(np.abs(have - float(value))))
        except ValueError:
            raise ModalError(f"{choice}: expected a number after '='") from None
        if not np.isclose(have[nearest], float(value), rtol=1e-6):
            raise ModalError(f"{choice}: choose from {', '.join(f'{v:g}' for v in have)}")
        dataset = dataset.isel({name: nearest})
    return dataset


def complex_accelerance(frf: xr.Dataset) -> xr.DataArray:
    """Accelerance [m s^-2 N^-1] as complex numbers, which netCDF does not hold.

    Parameters
    ----------
    frf : xarray.Dataset
        With ``accelerance_real`` and ``accelerance_imaginary``.

    Returns
    -------
    xarray.DataArray
    """
    return frf["accelerance_real"] + 1j * frf["accelerance_imaginary"]


def _bounded(own: ModalModel, mass: ComplexMass, force: float, frequency) -> None:
    """Refuse a force whose response leaves the range of Gamma.

    Raises
    ------
    ModalError
    """
    highest = mass.gamma[-1]
    needed = highest * STANDARD_GRAVITY * np.abs(own.dynamic_mass(frequency) + mass(frequency, highest))
    k = int(np.argmin(needed))
    if not force > 0:
        raise ModalError(f"a force of {force:g} N: expected an amplitude above 0 N")
    if not force < needed[k]:
        raise ModalError(
            f"a force of {force:g} N drives the damper above Gamma {highest:g}, the highest in the results, at "
            f"{frequency[k]:.4g} Hz: take a force between 0 and {needed[k]:.3g} N or another band, "
            "or run with larger gamma"
        )


def _band(own: ModalModel, mass: ComplexMass, asked) -> tuple[float, float]:
    """The band that is asked for, or one about all modes, as far as the damper is known."""
    if asked is None:
        low, high = mass.band or (0.0, np.inf)
        return max(low, 0.5 * float(own.frequency.min())), min(high, 1.25 * float(own.frequency.max()))
    low, high = map(float, asked)
    if not 0 < low < high < np.inf:
        raise ModalError(f"band: expected two frequencies above 0 Hz, the lower one first, got {low:g} and {high:g}")
    if low > 1.25 * own.frequency.max():
        highest = f"the highest mode, {float(own.frequency.max()):.4g} Hz"
        raise ModalError(f"band: {low:g} Hz is far above {highest}: the modes say nothing there")
    mass.require_in_band([low, high])
    return low, high


def _require_known(mass: ComplexMass, resonance: np.ndarray, band) -> None:
    """Refuse resonances in the band, or all if none is asked for, at which a card holds nothing.

    Modes outside the band that is asked for are its residuals: there the damper does not matter.

    Raises
    ------
    ModalError
    """
    found = resonance[:, 0]
    low, high = (0.0, np.inf) if band is None else band
    mass.require_modes_at(found[(found >= low) & (found <= high)])


def _grid(resonance: np.ndarray, band) -> np.ndarray:
    """Frequencies evenly spaced in the logarithm, and evenly spaced along the modal circle of every resonance.

    Parameters
    ----------
    resonance : (gamma, 2, mode) array
        Frequencies [Hz] and damping ratios.
    band : lowest and highest [Hz]
    """
    background = np.geomspace(*band, 2 + int(BACKGROUND * np.log2(band[1] / band[0])))
    angle = np.radians(np.linspace(-86, 86, ROUND_A_RESONANCE))
    centre, damping = resonance[:, 0].ravel(), np.maximum(resonance[:, 1].ravel(), 1e-6)
    square = 1 + 2 * damping[:, None] * np.tan(angle)  # w^2 = w_r^2 (1 + 2 zeta tan(angle))
    close = centre[:, None] * np.sqrt(np.where(square > 0, square, np.nan))
    every = np.concatenate([background, close[np.isfinite(close)]])
    return np.unique(every[(every >= band[0]) & (every <= band[1])])


def _mode_numbers(dataset: xr.Dataset, own: ModalModel) -> np.ndarray:
    named = "mode" in dataset and dataset.sizes["mode"] == len(own.frequency)
    return dataset["mode"].values if named else np.arange(1, len(own.frequency) + 1)


def _attributes(dataset: xr.Dataset, what: str) -> dict:
    title = dataset.attrs.get("title", "")
    return {**dataset.attrs, "title": f"{title}: {what}" if title else what}
