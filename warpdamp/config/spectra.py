"""Power spectral densities of a base's acceleration that test standards name."""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Spectrum:
    """Breakpoints of a power spectral density, straight between them on logarithmic scales.

    Parameters
    ----------
    breakpoints : of (frequency [Hz], density [g^2/Hz])
    rms : what the source gives for the whole [g]
    source : str
    """

    breakpoints: tuple[tuple[float, float], ...]
    rms: float
    source: str


SPECTRA = {
    "NAVMAT P-9492": Spectrum(
        ((20.0, 0.01), (80.0, 0.04), (350.0, 0.04), (2000.0, 0.007)),
        6.0,
        "NAVMAT P-9492, Navy Manufacturing Screening Program (1979): 20 to 80 Hz +3 dB/octave, 0.04 g^2/Hz to 350 Hz, "
        "then -3 dB/octave to 2000 Hz",
    ),
    "GEVS general qualification": Spectrum(
        ((20.0, 0.026), (50.0, 0.16), (800.0, 0.16), (2000.0, 0.026)),
        14.1,
        "GSFC-STD-7000A, General Environmental Verification Standard, Table 2.4-3: qualification of components of "
        "22.7 kg or less",
    ),
    "MIL-STD-810H general minimum integrity": Spectrum(
        ((20.0, 0.04), (1000.0, 0.04), (2000.0, 0.01)),
        7.7,
        "MIL-STD-810H, Method 514.8, Annex E, Category 24, Figure 514.8E-1, general minimum integrity exposure: "
        "0.04 g^2/Hz from 20 to 1000 Hz, then -6 dB/octave to 2000 Hz",
    ),
}
"""By the names that a configuration takes."""

WITHOUT_BREAKPOINTS = {
    re.compile(
        r"MIL.?STD.?810.*", re.IGNORECASE
    ): "MIL-STD-810 has a spectrum for each category of Method 514, of which "
    "'MIL-STD-810H general minimum integrity' (Category 24) is held here: take it, or",
}
"""Standards that are known by name only, and what is to be said of each."""
