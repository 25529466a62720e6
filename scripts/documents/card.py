"""The paper's damper as a card, on the paper's beam solved in three ways; writes docs/card.md from docs/beam.nc.

python scripts/documents/card.py
"""

import tempfile
from pathlib import Path

import numpy as np
import xarray as xr
from shared import DOCS, ROOT, head, table, write_document

from card_beam import COUPLED, DIRECT, FRF, compared
from nastran_tables import read_bush
from warpdamp.modal.apparent_mass import REACH, ComplexMass
from warpdamp.modal.card import card, damping, read_card, write_card
from warpdamp.modal.card_nastran import write_nastran
from warpdamp.modal.from_config import modes as structure_modes
from warpdamp.sweep.load import load

GAMMAS = (1.0, 2.0, 3.0, 5.0, 8.0, 14.0)
SHOWN = (1.0, 2.0, 5.0, 14.0)
NASTRAN_GAMMA = 5.0
FREQUENCY_LIMIT, DAMPING_LIMIT = 0.5, 2.0  # asked for [%]
TEXT = """{head} from [beam.nc](beam.nc), the results of the main job; nothing is simulated.

A card is a damper without a structure: the complex mass m′ − j m″ that the structure feels, over frequency and Γ.

```sh
warpdamp card results/beam.nc                                    # results/beam.card.nc; -o damper.csv for a table
warpdamp card results/beam.nc --gamma 5 -o damper.bdf            # for Nastran, at one amplitude
warpdamp frf results/beam.card.nc --structure configs/beam.yaml  # also --constant-force
warpdamp damping one.csv two.csv --structure configs/two_dampers.yaml   # a card for each damper, in their order
```

In Python `warpdamp.modal.card` has `card`, `read_card`, `write_card` and `damping`; `accelerance` and `constant_force`
take a card with `structure=`, and `dataset.damper.damping(modes)` is that of a card, too.

## What is in it

On frequency and Γ: m′, m″ and the effectiveness ε, means over packings, each with its standard error and the half-width
of its 95 % interval (Student's t over the packings; of m″ and ε at least the relative interval of the energy per
cycle); the number of packings and the worst status. Beside them the mass of the particles, the range, versions, physics
version, seeds and the resolved configuration. The CSV table has the same to the last digit: names with units in
brackets, one row for each frequency and Γ, and above them lines `# name: value` in JSON.

{part}

## Where it holds

- Γ from {low_gamma:g} to {high_gamma:g}; above it is refused, below it a response at constant force takes the values at
  the lowest and says so (`within_range`).
- This one was made at the modes of a structure, and holds within {reach:g} % of {frequencies} Hz: a mode elsewhere is
  refused. One from a run with a list of `excitation.frequency` holds from the first to the last.
- Modes outside a band that is asked for are the residuals of those in it.

## Three ways to the beam's damping

The paper's beam with this card at its middle, by (a) `warpdamp frf`, whose beam is a solid and whose FRF is the sum of
modes 1, 3 and 5; (b) a harmonic solution of an Euler-Bernoulli beam by Hermite elements of scikit-fem at every
frequency; (c) frequency-based substructuring, H = H_s − H_s (H_s + 1/Z)⁻¹ H_s, with H_s from the bare beam's modes in
closed form and Z = −ω² (m_empty + m′ − j m″). (b) and (c) share the card's numbers with (a), and nothing else
([card_beam.py](../tests/card_beam.py)). All three FRFs are fitted by least squares in the half-power band.

{ways}

Largest difference from (a): {frequency:.2f} % in frequency ({frequency_limit:g} % allowed: **{frequency_held}**) and
{damping:.2f} % in damping ({damping_limit:g} % allowed: **{damping_held}**). The frequencies of (b) and (c) are lower
because a clamp stops Poisson's contraction of a solid, which beam theory leaves out ([modes.md](modes.md)); from each
other they differ by {between_frequency:.1g} % and {between_damping:.1g} %.

## Without an FRF

`warpdamp damping`, by energies, on the structure of the study: the study's own damping ratios within {own:.0e}.

## Nastran

A grounded CBUSH with PBUSHT: K = ω² (m − m′), B = ω m″ on top of the rigid mass m of the particles, a CONM2 that normal
modes count, too. The head of the file gives both entries. The tables hold at one Γ, in frequency response. Read back
and taken straight between their points, the force at Γ {nastran_gamma:g} lies within {nastran:.1g} % of that of the
card's complex mass, anywhere in the range. No Nastran was at hand: the entries are those of the manuals that
[card_nastran.py](../warpdamp/modal/card_nastran.py) names.
"""


def part_table(part):
    heading = ["f [Hz]", "Γ", "m′ [g]", "m″ [g]", "ε", "packings"]
    rows = []
    for frequency in part["frequency"].values:
        for gamma in SHOWN:
            at = part.sel(frequency=frequency, gamma=gamma)
            masses = (
                f"{1e3 * float(at[name]):.3g} ± {1e3 * float(at[f'{name}_interval']):.2g}"
                for name in ("apparent_mass", "quadrature_mass")
            )
            effectiveness = f"{float(at['effectiveness']):.3g} ± {float(at['effectiveness_interval']):.2g}"
            rows.append([f"{frequency:.2f}", f"{gamma:g}", *masses, effectiveness, f"{int(at['packings'])}"])
    return table(heading, rows)


def three_ways(part, modes):
    """The table of all numbers, and the largest differences [%]."""
    rows, differences = [], []
    for mode in modes.number:
        for gamma in GAMMAS:
            found = compared(part, modes, int(mode), gamma)
            a, b, c = (np.array(found[way]) for way in (FRF, DIRECT, COUPLED))
            differences.append(100 * np.abs([b / a - 1, c / a - 1, c / b - 1]))
            numbers = [f"{f:.3f}" for f, _ in (a, b, c)] + [f"{100 * zeta:.4g}" for _, zeta in (a, b, c)]
            worst = [f"{x:.2f}" for x in np.max(differences[-1][:2], axis=0)]
            rows.append([f"{mode}", f"{gamma:g}", *numbers, *worst])
    heading = ["mode", "Γ", *(f"f ({k}) [Hz]" for k in "abc"), *(f"ζ ({k}) [%]" for k in "abc"), "Δf [%]", "Δζ [%]"]
    largest = np.max(differences, axis=0)
    return table(heading, rows), {
        "frequency": largest[:2, 0].max(), "damping": largest[:2, 1].max(),
        "between_frequency": largest[2, 0], "between_damping": largest[2, 1],
    }  # fmt: skip


def nastran_difference(part):
    """Largest relative difference of the force by Nastran's tables from that of the card [%]."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "damper.bdf"
        write_nastran(part, file, NASTRAN_GAMMA)
        stiffness, viscous = read_bush(file)
    felt, rigid = ComplexMass.of(part), float(part["particle_mass"])
    frequency = np.geomspace(*felt.band, 20_001)
    w = 2 * np.pi * frequency
    force = np.interp(frequency, *stiffness) + 1j * w * np.interp(frequency, *viscous)
    return 100 * np.max(np.abs(force / (-(w**2) * (felt(frequency, NASTRAN_GAMMA) - rigid)) - 1))


def main():
    results = xr.load_dataset(DOCS / "beam.nc")
    with tempfile.TemporaryDirectory() as folder:
        write_card(card(results), Path(folder) / "beam.card.csv")
        part = read_card(Path(folder) / "beam.card.csv")
    modes = structure_modes(load(ROOT / "configs" / "beam.yaml"), particles=float(part["particle_mass"]))
    ways, largest = three_ways(part, modes)
    own = damping([part], [modes])["damping_ratio"] / results["damping_ratio"] - 1
    text = TEXT.format(
        head=head("A damper as a part", __file__),
        part=part_table(part),
        low_gamma=part.attrs["gamma_range"][0],
        high_gamma=part.attrs["gamma_range"][1],
        reach=100 * REACH,
        frequencies=", ".join(f"{f:.4g}" for f in part["frequency"].values),
        ways=ways,
        **largest,
        frequency_limit=FREQUENCY_LIMIT,
        frequency_held="held" if largest["frequency"] <= FREQUENCY_LIMIT else "missed",
        damping_limit=DAMPING_LIMIT,
        damping_held="held" if largest["damping"] <= DAMPING_LIMIT else "missed",
        own=float(np.abs(own).max()),
        nastran_gamma=NASTRAN_GAMMA,
        nastran=nastran_difference(part),
    )
    write_document("card.md", text)


if __name__ == "__main__":
    main()
