"""Modal damping from energy per cycle: the chain of the paper's eqs 4-11.

The whole chain is the identity zeta = (2 / pi) eps m phi^2, m the mass of the particles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.results import over_packings

if TYPE_CHECKING:
    import xarray as xr

    from ..modes import Modes


def strain_energy(displacement, amplitude, frequency):
    """Largest strain energy of the structure in a cycle, w^2 (X / phi)^2 / 2 [J] (eqs 9-11).

    Parameters
    ----------
    displacement : float or array
        X at the damper [m].
    amplitude : float or array
        Mass-normalised mode shape phi at the damper [kg^-0.5].
    frequency : float or array
        Natural frequency [Hz].

    Returns
    -------
    float or array
        Broadcast against each other.
    """
    scale = displacement / amplitude
    return 0.5 * scale**2 * (2 * math.pi * frequency) ** 2


def damping_ratio(energy, displacement, amplitude, frequency):
    """Damping ratio zeta = E / (4 pi E_strain) [-] (eq. 6), from the energy dissipated per cycle.

    Parameters
    ----------
    energy : float or array
        E [J].
    displacement, amplitude, frequency : float or array
        See ``strain_energy``.

    Returns
    -------
    float or array
        Broadcast against each other.
    """
    return energy / (4 * math.pi * strain_energy(displacement, amplitude, frequency))


def damping_of_effectiveness(effectiveness, particle_mass, amplitude):
    """Damping ratio zeta = (2 / pi) eps m phi^2 [-]: eqs 4 to 11 in one, in which frequency and amplitude cancel.

    Parameters
    ----------
    effectiveness : float or array
        eps [-].
    particle_mass : float or array
        m [kg].
    amplitude : float or array
        Mass-normalised mode shape phi at the damper [kg^-0.5].

    Returns
    -------
    float or array
        Broadcast against each other.
    """
    return 2 / math.pi * effectiveness * particle_mass * amplitude**2


def normalised_damping(energy, speed, total_mass):
    """Energy per cycle over 0.5 m_total v^2 [-], v = Gamma g / w (eq. 19 with the square on the speed alone).

    Parameters
    ----------
    energy : float or array
        [J].
    speed : float or array
        v [m/s].
    total_mass : float or array
        Mass of the empty damper and its particles [kg].

    Returns
    -------
    float or array
        Broadcast against each other.
    """
    return energy / (0.5 * total_mass * speed**2)


def several_dampers(dataset: xr.Dataset | Sequence[xr.Dataset], dampers: Sequence[Modes], *, reference: int = 0):
    """Damping of a structure with several dampers, each shaken as hard as its own place moves.

    The energies of all dampers add up over the one strain energy of the mode: at Gamma of the reference damper,
    damper j is shaken with Gamma ``|phi_j / phi_ref|`` and

        ``zeta(Gamma) = sum_j zeta_j(Gamma |phi_j / phi_ref|) + inherent damping``,

    zeta_j that of damper j alone against its own Gamma.  It holds as far as the structure's response is one real mode.

    Parameters
    ----------
    dataset : results of a study of one damper, or of each
        Run at the natural frequencies of the structure with all dampers on it, in the order of its modes.
    dampers : the modes of that structure as each damper sees them (``Modes.at``)
    reference : number of the damper whose Gamma is the axis

    Returns
    -------
    xarray.Dataset
        ``damping_ratio(mode, gamma)`` and its standard error, and ``damper_share(damper, mode, gamma)``, with any swept
        scalars of the study.  NaN where a damper is shaken outside the Gammas of its study: nothing is extrapolated.
        Standard errors are added up, not squared: equal dampers share their beds.

    Raises
    ------
    ValueError
        If a study was run at other frequencies than those of the modes, or if a mode has a node at the reference.
    """
    import xarray as xr

    datasets = [dataset] * len(dampers) if isinstance(dataset, xr.Dataset) else list(dataset)
    seen = dampers[reference]
    if np.any(seen.on_node):
        raise ValueError(f"mode {seen.number[seen.on_node][0]} has a node at the reference damper: choose another")
    gamma = datasets[reference]["gamma"]
    each = [_share(own, modes, seen, gamma.values) for own, modes in zip(datasets, dampers, strict=True)]
    share, error = (xr.concat(part, "damper").assign_coords(gamma=gamma) for part in zip(*each, strict=True))
    inherent = xr.DataArray(seen.inherent_damping, dims="mode")
    result = xr.Dataset(
        {
            "damping_ratio": share.sum("damper", skipna=False) + inherent,
            "damping_ratio_standard_error": error.sum("damper", skipna=False),
            "damper_share": share,
        }
    ).assign_coords(mode=seen.number)
    names = ("modal damping ratio of all dampers", "its standard error", "what each damper adds to it")
    for name, long_name in zip(result, names, strict=True):
        result[name].attrs = {"units": "1", "long_name": long_name}
    return result


def _share(dataset: xr.Dataset, modes: Modes, reference: Modes, gamma: np.ndarray):
    """Damping that one damper adds to each mode, at Gammas of the reference; and its standard error."""
    import xarray as xr

    run_at, natural = np.asarray(dataset["frequency"]), modes.frequency
    if run_at.shape != natural.shape or not np.allclose(run_at, natural, rtol=0.01):
        raise ValueError(
            f"the study was run at {_listed(run_at)} Hz, the modes lie at {_listed(natural)} Hz: run it with "
            f"excitation.frequency: [{_listed(natural)}]"
        )
    phi, on_node = xr.DataArray(modes.amplitude, dims="mode"), xr.DataArray(modes.on_node, dims="mode")
    ratio = np.abs(phi / xr.DataArray(reference.amplitude, dims="mode"))
    per_joule = damping_ratio(1.0, dataset["displacement"], 1.0, dataset["frequency"])
    curves = [per_joule * energy for energy in over_packings(dataset, "energy_dissipated")]

    def at_own_gamma(curve, part):
        return _known(gamma * part, dataset["gamma"].values, curve)

    own = [
        xr.apply_ufunc(
            at_own_gamma,
            curve.drop_vars("frequency").rename(frequency="mode"),
            ratio,
            input_core_dims=[["gamma"], []],
            output_core_dims=[["gamma"]],
            exclude_dims={"gamma"},
            vectorize=True,
        )
        for curve in curves
    ]
    # on its node a damper adds nothing, whatever it would do at Gammas it was never run at
    return [(phi**2 * curve).where(~on_node, 0.0) for curve in own]


def _known(wanted: np.ndarray, gamma: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """A curve between its points; NaN beyond them, but for what rounding puts there."""
    inside = np.clip(wanted, gamma[0], gamma[-1])
    return np.where(np.isclose(inside, wanted, rtol=1e-6, atol=0), np.interp(inside, gamma, curve), np.nan)


def _listed(values) -> str:
    return ", ".join(f"{value:.6g}" for value in values)
