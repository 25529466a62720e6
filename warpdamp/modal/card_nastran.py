"""Cards of dampers for Nastran: a bush to ground whose stiffness and damping depend on frequency.

The force that the particles take on top of a rigid mass m that moves with the structure,

    -w^2 (m' - m - j m'') x = (K + j w B) x,    K = w^2 (m - m'),    B = w m'',

is that of a grounded CBUSH with the tables K and B of a PBUSHT (there is no table of a mass).  It is linear: the tables
hold at one Gamma.  K and B are nominally 0 (PBUSH), so that normal modes and the modal base carry m, as a CONM2.

References
----------
Autodesk Nastran 2025 Reference Manual, PBUSHT: tables of stiffness and of force per velocity over frequency, each
beside its entry on the PBUSH of the same number.
https://help.autodesk.com/cloudhelp/2025/ITA/NSTRN-Reference/files/GUID-A544DE9B-E51F-45D5-99AB-DCA1D308A7FF.htm
Altair OptiStruct 2021, PBUSHT: K and B are for frequency response analysis only; the normal modes take the PBUSH.
https://2021.help.altair.com/2021/hwsolvers/os/topics/solvers/os/pbusht_bulk_r.htm
"""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ModalError
from ..files import whole_file
from ..scene.scene import STANDARD_GRAVITY
from .apparent_mass import ComplexMass

if TYPE_CHECKING:
    import xarray as xr

SUFFIXES = (".bdf", ".dat")
FIRST_NUMBER = 9001
"""Of the property and its tables: above those of most models."""
STEP = 0.02
"""Of the tables over the frequency: a straight line then misses w^2 by the square of it over 4, 1e-4."""
COMPONENTS = 6
COLUMNS = 76
"""Of a comment."""


def write_nastran(part: xr.Dataset, file: str | Path, gamma: float) -> None:
    """Write the complex mass of a card at one Gamma as PBUSH, PBUSHT and TABLED1 in kg, m, s, N.

    Parameters
    ----------
    part : xarray.Dataset
        Card.
    file : str or Path
        Replaced if it exists.
    gamma : float
        Acceleration amplitude over g [-].

    Raises
    ------
    ModalError
        If Gamma is outside the range of the card.
    """
    felt = ComplexMass.of(part)
    if not felt.within(gamma):
        raise ModalError(f"Gamma {gamma:g} is outside the range of the card, {felt.gamma[0]:g} to {felt.gamma[-1]:g}")
    frequency = _frequencies(felt)
    w, mass = 2 * np.pi * frequency, felt(frequency, gamma)
    rigid = float(part["particle_mass"])
    stiffness, viscous = FIRST_NUMBER + 1, FIRST_NUMBER + 2
    nominal = _small("PBUSH", FIRST_NUMBER, "K", *["0.0"] * COMPONENTS) + _small("", "", "B", *["0.0"] * COMPONENTS)
    # along the component 1 of the bush: its coordinate system turns it
    tables = _small("PBUSHT", FIRST_NUMBER, "K", stiffness) + _small("", "", "B", viscous)
    text = [*_head(part, felt, gamma, rigid), nominal, tables]
    text += [_table(stiffness, frequency, w**2 * (rigid - mass.real)), _table(viscous, frequency, -w * mass.imag)]
    with whole_file(Path(file)) as path:
        path.write_text("".join(text), encoding="ascii", errors="replace", newline="\n")


def _frequencies(felt: ComplexMass) -> np.ndarray:
    """Frequencies of the tables [Hz]: those of the card, and others between as far apart as ``STEP``."""
    low, high = felt.band
    steps = 1 + int(np.ceil(np.log(high / low) / STEP))
    return np.unique(np.concatenate([np.geomspace(low, high, steps + 1), felt.frequency, (low, high)]))


def _head(part: xr.Dataset, felt: ComplexMass, gamma: float, rigid: float) -> list[str]:
    low, high = felt.band
    at = [f"{f:.4g} Hz: m' {1e3 * m.real:.4g} g, m'' {-1e3 * m.imag:.4g} g" for f, m in _told(felt, gamma)]
    told = (
        str(part.attrs.get("title", "")),
        f"Complex mass m' - j m'' of a granular damper at Gamma {gamma:g} (acceleration amplitude at the damper over "
        f"{STANDARD_GRAVITY:g} m/s^2), from {low:.5g} to {high:.5g} Hz.  It holds at that amplitude of the response "
        "only, and in frequency response only.  Beyond the ends of the tables it means nothing: stay inside.",
        *at,
        "Units: kg, m, s, N.  K = w^2 (m - m') [N/m], B = w m'' [N s/m].",
        f"The model carries the particles, m = {rigid:.6g} kg, as a rigid mass at the damper beside the empty one, and "
        "a bush to ground along component 1 of its coordinate system; with GRID and CID of yours:",
        f"  CONM2,{FIRST_NUMBER},GRID,,{rigid:.6g}",
        f"  CBUSH,{FIRST_NUMBER},{FIRST_NUMBER},GRID,,,,,CID",
        str(part.attrs.get("source", "")),
    )
    return [f"$ {line}\n" for text in told for line in wrap(text, COLUMNS, drop_whitespace=True)]


def _told(felt: ComplexMass, gamma: float, most: int = 10):
    """Some of the card's frequencies [Hz], and the masses there [kg]."""
    chosen = felt.frequency[np.unique(np.linspace(0, len(felt.frequency) - 1, most).round().astype(int))]
    return zip(chosen, felt(chosen, gamma), strict=True)


def _small(*fields) -> str:
    """A line of fields of eight columns."""
    return "".join(f"{field:<8}" for field in fields).rstrip() + "\n"


def _table(number: int, x: np.ndarray, y: np.ndarray) -> str:
    """TABLED1 in wide fields: straight between the points."""
    fields = [f"{value:<16}" for xy in zip(map(_real, x), map(_real, y), strict=True) for value in xy] + ["ENDT"]
    lines = [f"{'*':<8}{''.join(fields[k : k + 4]).rstrip()}\n" for k in range(0, len(fields), 4)]
    lines += ["*\n"] * (len(lines) % 2)  # wide lines come in pairs
    return f"{'TABLED1*':<8}{number}\n*\n" + "".join(lines)


def _real(value: float) -> str:
    """A number in a wide field: at most 16 characters, with a decimal point."""
    return f"{value:.8E}"
