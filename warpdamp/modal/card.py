"""A granular damper as a part: its complex mass over frequency and Gamma, with what is known of it, in one small file.

The card of a damper holds m' and m'' of ``apparent_mass``, and the effectiveness eps, each the mean over packings with
its standard error and the half-width of its 95 % interval; the mass m of the particles; the range of frequency and
Gamma that it holds for; versions, seeds and the resolved configuration of the study.  From

    E = 4 eps m (w X)^2,    X = Gamma g / w^2

(eqs 4, 5) comes the energy per cycle, so that a card is a Dataset that ``accelerance``, ``constant_force`` and
``dataset.damper.damping`` take; ``damping`` is for one damper or several.  It has no modes: these take a structure.

A card made of a study at frequencies of a list holds from the first to the last.  One of a study at the modes of a
structure holds near each of them: see ``apparent_mass.REACH``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.results import over_packings, ran, read, worst_status, write
from ..errors import ModalError
from ..numerics.tolerance import student
from ..scene.scene import STANDARD_GRAVITY
from ..variables import describe
from ..version import __version__
from .apparent_mass import REACH, ComplexMass, complex_mass
from .card_csv import NEEDED, CardTable, check_range, limits, read_csv, write_csv
from .damping import several_dampers

if TYPE_CHECKING:
    import xarray as xr

    from ..modes import Modes

VERSION = 1
"""Of what a card holds, as its attribute ``card``."""
MEASURED = ("apparent_mass", "quadrature_mass", "effectiveness")
COLUMNS = (
    *(f"{name}{part}" for name in MEASURED for part in ("", "_standard_error", "_interval")),
    "packings",
    "status",
)
"""Variables of a card on (frequency, gamma); the others follow from these."""
LONG_NAMES = {
    **{f"{name}_standard_error": f"standard error of {name}, mean over packings" for name in MEASURED},
    "energy_dissipated_standard_error": "standard error of energy_dissipated, mean over packings",
}


def card(results: xr.Dataset) -> xr.Dataset:
    """Card of the damper of a study, mean over packings; Gammas at which a case failed are left out.

    The standard error of m' is that of the mean over packings by their spread.  m'' and the effectiveness also have the
    relative error of ``energy_mean``, with the state of the bed, averaging and step, where that is larger.

    Parameters
    ----------
    results : xarray.Dataset
        Results of a study of one damper, swept scalars selected.  A card is returned as it is.

    Returns
    -------
    xarray.Dataset
        ``COLUMNS`` on (frequency, gamma), and what follows from these; ``particle_mass`` [kg].

    Raises
    ------
    ModalError
        If the results have swept scalars left, fewer than two Gammas or packings, or several dampers.

    Examples
    --------
    >>> from warpdamp import open_results
    >>> from warpdamp.modal.card import card
    >>> part = card(open_results("docs/beam.nc"))
    >>> at = part.sel(gamma=5).isel(frequency=0)  # the paper's damper at its optimum
    >>> [f"{1e3 * float(at[name]):.0f} g" for name in ("apparent_mass", "quadrature_mass", "quadrature_mass_interval")]
    ['8 g', '19 g', '3 g']
    """
    if is_card(results):
        return results
    felt = ComplexMass.of(results)
    kept = results.sortby(["frequency", "gamma"]).sel(gamma=felt.gamma)
    packings = ran(kept).sum("seed") if "seed" in kept.dims else 0 * worst_status(kept) + 1
    if (alone := packings.where(packings < 2, drop=True)).size:
        at = f"Gamma {alone['gamma'].values[0]:g}, {alone['frequency'].values[0]:.4g} Hz"
        raise ModalError(f"one packing at {at} has no interval: run with two seeds or more, as seeds: [1, 2, 3]")
    mean = complex_mass(kept)
    mean["effectiveness"], mean["effectiveness_standard_error"] = over_packings(kept, "effectiveness")
    table = {"packings": packings, "status": worst_status(kept)}
    for name in MEASURED:
        error = mean[f"{name}_standard_error"]
        interval = student(packings - 1.0) * error
        if "energy_mean" in kept and name != "apparent_mass":
            part = np.abs(mean[name] / kept["energy_mean"])
            error = np.fmax(error, part * kept["energy_mean_standard_error"])
            interval = np.fmax(interval, part * kept["energy_mean_interval"])
        table |= {name: mean[name], f"{name}_standard_error": error, f"{name}_interval": interval}
    values = {name: table[name].transpose("frequency", "gamma").values for name in COLUMNS}
    mass = float(np.max(kept["particle_mass"]))
    return _dataset(CardTable(felt.frequency, felt.gamma, values, mass, _attributes(results, felt)))


def _attributes(results: xr.Dataset, felt: ComplexMass) -> dict:
    """What is known of the card, beside that of the results."""
    reach = REACH if felt.of_modes else 0.0
    left_out = sorted({float(gamma) for gamma in results["gamma"].values} - set(felt.gamma.tolist()))
    attributes = dict(results.attrs) | {
        "title": f"{results.attrs.get('title', '')}: the damper as a part".removeprefix(": "),
        "history": f"{results.attrs.get('history', '')}\nwarpdamp {__version__} card".strip(),
        "card": VERSION,
        "frequencies": "modes" if felt.of_modes else "list",
        "frequency_range": [float(felt.frequency[0] * (1 - reach)), float(felt.frequency[-1] * (1 + reach))],
        "gamma_range": [float(felt.gamma[0]), float(felt.gamma[-1])],
        "preparation": str(results["preparation"].values) if "preparation" in results.coords else "",
    }
    return attributes | ({"gamma_left_out": left_out} if left_out else {})


def is_card(dataset: xr.Dataset) -> bool:
    """Whether a Dataset is a card."""
    return "card" in dataset.attrs and "effectiveness" in dataset


def _dataset(table: CardTable) -> xr.Dataset:
    """Card with all that follows from its table."""
    import xarray as xr

    on = ("frequency", "gamma")
    dataset = xr.Dataset(
        {name: (on, values) for name, values in table.values.items()},
        {
            "frequency": ("frequency", table.frequency, {"units": "Hz", "long_name": "excitation frequency"}),
            "gamma": ("gamma", table.gamma, {"units": "1", "long_name": "acceleration amplitude over g"}),
        },
    )
    w = 2 * np.pi * dataset["frequency"]
    dataset["particle_mass"] = table.particle_mass
    dataset["excitation_frequency"] = dataset["frequency"].drop_vars("frequency")
    dataset["displacement"] = (dataset["gamma"] * STANDARD_GRAVITY / w**2).transpose(*on)
    ideal = 4 * table.particle_mass * (w * dataset["displacement"]) ** 2
    dataset["energy_dissipated"] = ideal * dataset["effectiveness"]
    dataset["energy_dissipated_standard_error"] = ideal * dataset["effectiveness_standard_error"]
    describe(dataset)
    for name, long_name in LONG_NAMES.items():
        dataset[name].attrs["long_name"] = long_name
    dataset.attrs = {name: np.array(v) if isinstance(v, list) else v for name, v in table.attributes.items()}
    return dataset


def _table(part: xr.Dataset) -> CardTable:
    """What a card's Dataset follows from."""
    return CardTable(
        part["frequency"].values,
        part["gamma"].values,
        {name: part[name].transpose("frequency", "gamma").values for name in COLUMNS},
        float(part["particle_mass"]),
        dict(part.attrs),
    )


def read_card(file: str | Path) -> xr.Dataset:
    """Card from its netCDF file or table, or of the results in a file.

    Parameters
    ----------
    file : str or Path
        ``.csv``, or netCDF.

    Raises
    ------
    ModalError
        If a table is no card or is damaged; names its line.  If results give none: see ``card``.
    UsageError
        If there is no such file, or it holds neither a card nor results.
    """
    file = Path(file)
    if file.suffix.lower() == ".csv":
        return _dataset(read_csv(file, COLUMNS, VERSION))
    found = read(file)
    if not is_card(found):
        return card(found)
    if found.attrs["card"] != VERSION:
        raise ModalError(f"{file}: is a card of version {found.attrs['card']}, read is {VERSION}: write it again")
    missing = [name for name in (*COLUMNS, "particle_mass") if name not in found]
    missing += [name for name in NEEDED if name not in found.attrs]
    if missing:
        raise ModalError(f"{file}: is a damaged card: it has no {missing[0]}: write it again")
    _check(file, found)
    return found


def _check(file: Path, part: xr.Dataset) -> None:
    """Refuses what no card can hold."""
    on = ("frequency", "gamma")
    if any(set(part[name].dims) != set(on) for name in COLUMNS) or part["particle_mass"].ndim:
        raise ModalError(f"{file}: is a damaged card: its variables are not on frequency and gamma: write it again")
    for name, (holds, expected) in limits((*on, *COLUMNS)).items():
        values = part[name].transpose(*(dim for dim in on if dim in part[name].dims))
        if values.dtype.kind not in "fiu":
            raise ModalError(f"{file}: is a damaged card: {name} holds no numbers: write it again")
        bad = np.argwhere(~holds(values.values))
        if len(bad):
            where = ", ".join(f"{dim} {float(part[dim][k]):g}" for dim, k in zip(values.dims, bad[0], strict=True))
            wrong = f"{name} at {where} is {float(values.values[tuple(bad[0])]):g}, expected {expected}"
            raise ModalError(f"{file}: is a damaged card: {wrong}: write it again")
    axes = [part[name].values for name in on]
    if any(np.any(np.diff(axis) <= 0) for axis in axes):
        raise ModalError(f"{file}: is a damaged card: its frequencies or Gammas do not rise: write it again")
    attributes = {name: np.asarray(part.attrs[name]).tolist() for name in NEEDED}
    check_range(file, attributes, part["particle_mass"].item(), *axes)


def write_card(part: xr.Dataset, file: str | Path) -> None:
    """Write a card as netCDF or, with all its digits, as a table.

    Parameters
    ----------
    part : xarray.Dataset
        Card.
    file : str or Path
        ``.nc`` or ``.csv``; replaced if it exists.

    Raises
    ------
    ModalError
        If the suffix is neither.
    """
    file = Path(file)
    if file.suffix.lower() == ".nc":
        write(part, file)
    elif file.suffix.lower() == ".csv":
        write_csv(file, _table(part))
    else:
        raise ModalError(f"{file}: name a file that ends in .nc or .csv, or in .bdf or .dat for Nastran")


def at_frequencies(part: xr.Dataset, frequency) -> xr.Dataset:
    """Card at other frequencies, between its own as ``ComplexMass`` is; errors with the same weights.

    Parameters
    ----------
    part : xarray.Dataset
        Card.
    frequency : (m,) array [Hz]

    Returns
    -------
    xarray.Dataset
        Card; its range is that of ``part``.

    Raises
    ------
    ModalError
        If a frequency is outside the range of the card.
    """
    felt, table = ComplexMass.of(part), _table(part)
    frequency = np.atleast_1d(np.asarray(frequency, float))
    felt.require_modes_at(frequency)
    weights = felt.weights(frequency)  # (m, k)
    used = weights[..., None] > 0
    values = {name: weights @ value for name, value in table.values.items()}
    values["packings"] = np.min(np.where(used, table.values["packings"], np.iinfo(int).max), axis=1)
    values["status"] = np.max(np.where(used, table.values["status"], -1), axis=1)
    return _dataset(CardTable(frequency, table.gamma, values, table.particle_mass, table.attributes))


def damping(cards: Sequence[xr.Dataset], seen: Sequence[Modes]) -> xr.Dataset:
    """Damping of a structure with a damper or several, each known by its card; see ``damping.several_dampers``.

    Parameters
    ----------
    cards : cards, one for each damper
    seen : the modes of the structure, with the particles of all, as each damper sees them

    Raises
    ------
    ModalError
        If a mode is outside the range of a card.
    ValueError
        If a mode has a node at the first damper.
    """
    at_modes = [at_frequencies(part, modes.frequency) for part, modes in zip(cards, seen, strict=True)]
    result = several_dampers(at_modes, seen)
    return result.assign(natural_frequency=("mode", seen[0].frequency, {"units": "Hz", "long_name": "with particles"}))
