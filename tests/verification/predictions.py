"""Coupled runs of several dampers beside what the dampers' cards, each made alone, predict."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from verification.suite import Curve, Result, case
from warpdamp import load, run
from warpdamp.coupled.prediction import mode_with_dampers, with_prediction
from warpdamp.coupled.run import simulate
from warpdamp.execution.executors import InProcess
from warpdamp.modal.card import card
from warpdamp.report.coupled_verdicts import compared

INHERENT = 0.005
STUDY = """
structure:
  modes_given: [{{frequency: 40 Hz, amplitude: {phi} kg^-0.5, damping: 0.5 %}}]
  particles_included: false
damper:
  enclosure: {{diameter: 24 mm, height: 20 mm, material: pmma}}
  particles: {{count: {count}, radius: 3.73 mm, material: pmma}}
materials:
  pmma: {{density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}}
contact: {{restitution: 0.52, friction: 0.5}}
excitation: {{gamma: {gamma}}}
preparation: loose
seeds: {seeds}
"""
CYCLES = "steady_state: {{fewest_cycles: {cycles}, most_cycles: {cycles}}}\n"
BOTH = """dampers:
  - enclosure: {{diameter: 24 mm, height: 20 mm, material: pmma}}
    particles: {{count: 8, radius: 3.73 mm, material: pmma}}
    amplitude: [-1.4 kg^-0.5]
coupled: {{duration: {duration}, levels: {levels}, harmonic: {{amplitude: 0.1 N, frequency: 39.9 Hz}}}}
"""


def both_ways(folder: Path, fine: bool):
    """Means of what was read and predicted, by level of the force."""

    def study(text: str):
        file = folder / "study.yaml"
        file.write_text(text)
        return load(file)

    def card_of(count: int, phi: float, gammas: list[float]):
        gammas = gammas if fine else gammas[:4]
        options = {"cycles": 80, "seeds": [1, 2, 3, 4]} if fine else {"cycles": 40, "seeds": [1, 2]}
        text = STUDY.format(count=count, phi=phi, gamma=gammas, seeds=options["seeds"])
        return card(run(study(text + CYCLES.format(**options)), executor="in-process"))

    cards = [card_of(16, 2, [1.5, 2, 2.5, 3, 3.5, 4]), card_of(8, 1.4, [1.05, 1.4, 1.75, 2.1, 2.45, 2.8])]
    runs = {"duration": "4 s", "levels": [0.8, 1, 1.25, 1.5]} if fine else {"duration": "3 s", "levels": [1]}
    seeds = [1, 2, 3] if fine else [1]
    config = study(STUDY.format(count=16, phi=2, gamma=1, seeds=seeds) + BOTH.format(**runs))
    return compared(with_prediction(simulate(config, InProcess()), mode_with_dampers(config, cards)))


@case(
    "Several dampers in coupled runs against their cards",
    setup="Sixteen and eight particles in two cavities on one mode, 40 Hz, 0.5 %, phi = 2 and -1.4 kg^-1/2, driven by a force "
    "at its resonance to Gamma 1.7 to 3; each damper's card is made of a study of it alone, in prescribed motion.",
    reference="w^2 (1 + sum_c phi_c^2 (m_c' - j m_c'')) = w_0^2 (1 + 2 j zeta_0), each damper at the Gamma of its own place",
    tolerance="damping: 5 % of what the dampers add; frequency: 0.15 %, a fifth of what particles at rest would move it by.  Both "
    "sides are means over a few packings of chaotic beds, whose standard error here is 2 % (shortened: 10 %, one packing)",
)
def against_cards(fine):
    result, part = Result([]), 0.05 if fine else 0.1
    with TemporaryDirectory() as folder:
        found = both_ways(Path(folder), fine)
    for level in found["level"].values:
        one = {name: float(value) for name, value in found.sel(level=level).items()}
        at = f"Gamma {one['low']:.2f} to {one['high']:.2f}"
        added = one["predicted_damping_ratio"] - INHERENT
        result.add(f"{at}: damping ratio", one["predicted_damping_ratio"], one["window_damping_ratio"], part * added)
        natural = one["predicted_frequency"]
        result.add(f"{at}: natural frequency [Hz]", natural, one["window_frequency"], 1.5e-3 * natural)
    middle = (found["low"] + found["high"]) / 2
    result.curves = (
        [
            Curve("coupled", middle.values, 100 * found["window_damping_ratio"].values, "o"),
            Curve("cards", middle.values, 100 * found["predicted_damping_ratio"].values),
        ]
        if fine
        else []
    )
    result.axes = ("Γ", "damping ratio [%]")
    return result
