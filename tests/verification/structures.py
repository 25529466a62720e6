"""Structures: a base that moves against closed forms of one mode, several dampers against their sum."""

from __future__ import annotations

import math
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from verification.suite import (
    RADIUS,
    Batch,
    Case,
    Curve,
    Material,
    Result,
    Scene,
    State,
    Surface,
    case,
)  # fmt: skip
from warpdamp import load, run
from warpdamp.config.spectra import SPECTRA
from warpdamp.coupled import forces, noise
from warpdamp.coupled.identify import first_harmonic
from warpdamp.scene.host import BaseMotion, HostStructure
from warpdamp.scene.scene import STANDARD_GRAVITY

NATURAL, MASS = 40.0, 0.5


def transmissibility(frequency, damping):
    """Acceleration of a mass on a spring and a damper over that of its base."""
    r = np.asarray(frequency) / NATURAL
    return (1 + 2j * damping * r) / (1 - r**2 + 2j * damping * r)


def on_a_base(motion: BaseMotion, damping: float, record: int) -> Scene:
    """A mass on a spring whose enclosure holds one particle of a fraction of a microgram, and no walls."""
    feather = Material(density=1e-3, youngs_modulus=3.3e9, poissons_ratio=0.37)
    smooth = Surface(1.0, 0.0)
    host = HostStructure(
        (NATURAL,), (damping,), (MASS**-0.5,), base=motion, participation=(MASS**0.5,), record=record
    )  # fmt: skip
    return Scene(feather, feather, smooth, smooth, None, (0.0, 0.0, 0.0), host=host)


def records_of(scenes, dt, steps):
    """Records of scenes that advance together."""
    start = State.at_rest([[0, 0, 0]], RADIUS)
    most = [1 + (n - 1) // s.host.record for s, n in zip(scenes, steps, strict=True)]
    batch = Batch([Case(s, start, h) for s, h in zip(scenes, dt, strict=True)], max_records=max(most))
    batch.advance(steps)
    return [batch.records(k) for k in range(len(scenes))]


@case(
    "Transmissibility of one mode on a base that moves",
    setup="A mass of 0.5 kg at 40 Hz with 5 % of damping; its base moves with 0.5 g, steady after 1 s.",
    reference="(1 + 2 j zeta r) / (1 - r^2 + 2 j zeta r), r = f / f_n",
    tolerance="1e-4 of the closed form: 1,600 steps a cycle, and of the start exp(-12) is left",
)
def base_motion(fine):
    result = Result([])
    ratios = np.array([0.3, 0.6, 0.9, 1.0, 1.1, math.sqrt(2), 2.0, 4.0] if fine else [0.5, 1.0, 2.0])
    scenes = [on_a_base(BaseMotion(0.5 * STANDARD_GRAVITY, r * NATURAL), 0.05, 50) for r in ratios]
    steps = [1600 * math.ceil(r * NATURAL * 1.2) for r in ratios]
    found = []
    for r, records in zip(ratios, records_of(scenes, 1 / (1600 * ratios * NATURAL), steps), strict=True):
        late = records[-5 * 32 :]
        answer = first_harmonic(late[:, 0], late[:, 2], r * NATURAL) / (-0.5j * STANDARD_GRAVITY)
        exact = complex(transmissibility(r * NATURAL, 0.05))
        found.append(abs(answer))
        result.add(f"r = {r:.3g}: size", abs(exact), abs(answer), 1e-4 * abs(exact))
        result.add(f"r = {r:.3g}: phase [rad]", np.angle(exact), np.angle(answer), 1e-4)
    grid = np.geomspace(0.25, 4.2, 200)
    result.curves = [
        Curve("warpdamp", ratios, np.array(found), "o"),
        Curve("closed form", grid, np.abs(transmissibility(grid * NATURAL, 0.05))),
    ]
    result.axes = ("f / f_n", "transmissibility")
    return result


@case(
    "Power spectral densities: gRMS in and out",
    setup="Noise of a flat spectrum, 0.01 g^2/Hz from 2 to 800 Hz, moves the base of a mass at 40 Hz with 2.5 % of damping; "
    "the second of two equal periods is read.  Spectra of standards: the noise alone, 20 s.",
    reference="out: the root of int |T|^2 G df, and Miles 1954, sqrt(pi / 2 f_n Q G (1 + 4 zeta^2)), of white noise without "
    "end; in: the closed form of a table's own area, and the figure that its standard prints",
    tolerance="integral 0.1 %: lines lie 0.05 Hz apart in a band of 2 Hz.  Lines have the amplitudes of the density and only their "
    "phases are random, so that a whole period has no statistical error (normal noise: 1 / (2 sqrt(pi zeta f_n T)), "
    "6 % in 20 s).  Miles 1 %: white noise ends at 800 Hz here.  Standards round their figures: 1 %",
)
def spectra(fine):
    result = Result([])
    period, damping = (20.0, 0.025) if fine else (5.0, 0.025)
    table = [(2.0, 0.01 * STANDARD_GRAVITY**2), (800.0, 0.01 * STANDARD_GRAVITY**2)]
    samples, step = noise.samples(table, 1, period)
    twice = BaseMotion(samples=np.concatenate([samples[:-1], samples]), sample_step=step)
    records = records_of([on_a_base(twice, damping, 4)], [step / 2], [round(4 * period / step)])[0]
    late = records[len(records) // 2 :, 2]
    out = math.sqrt(np.mean(late**2)) / STANDARD_GRAVITY
    frequency = np.linspace(2.0, 800.0, 400_001)
    exact = math.sqrt(np.trapezoid(0.01 * np.abs(transmissibility(frequency, damping)) ** 2, frequency))
    miles = math.sqrt(math.pi / 2 * NATURAL / (2 * damping) * 0.01 * (1 + 4 * damping**2))
    result.add("out: gRMS, against the integral", exact, out, 1e-3 * exact)
    result.add("out: gRMS, against Miles", miles, out, 1e-2 * miles)
    result.add("in: gRMS, flat", math.sqrt(7.98), forces.root_mean_square(samples) / STANDARD_GRAVITY, 2e-3)
    for name, spectrum in SPECTRA.items():
        given = list(spectrum.breakpoints)
        closed = noise.rms(given)
        realised = forces.root_mean_square(noise.samples(given, 1, 20.0 if fine else 4.0)[0])
        result.add(f"in: {name}: gRMS of the noise", closed, realised, 1e-3 * closed)
        result.add(f"in: {name}: gRMS as printed", spectrum.rms, closed, 1e-2 * spectrum.rms)
    return result


TWO_DAMPERS = """
structure:
  modes_given: [{{frequency: 40 Hz, amplitude: 2 kg^-0.5}}, {{frequency: 90 Hz, amplitude: 1.5 kg^-0.5}}]
  particles_included: true
damper:
  enclosure: {{diameter: 24 mm, height: 20 mm, material: pmma}}
  particles: {{count: 8, radius: 3.73 mm, material: pmma}}
{further}
materials:
  pmma: {{density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}}
contact: {{restitution: 0.52, friction: 0.5}}
excitation: {{gamma: {gamma}}}
preparation: loose
steady_state: {{fewest_cycles: {cycles}, most_cycles: {cycles}}}
"""
FURTHER = """dampers:
  - enclosure: {{diameter: 24 mm, height: 20 mm, material: pmma}}
    particles: {{count: 8, radius: 3.73 mm, material: pmma}}
    amplitude: [{} kg^-0.5, {} kg^-0.5]"""


def damping_of(folder, cycles, gamma, further=""):
    """Damping ratios (mode, gamma) that the dampers of a structure of two modes add."""
    file = Path(folder) / "study.yaml"
    file.write_text(TWO_DAMPERS.format(further=further, gamma=gamma, cycles=cycles))
    return run(load(file), executor="in-process")["damping_ratio"].transpose("mode", "gamma").values


@case(
    "Several dampers against their sum",
    setup="Eight particles in a cavity on a structure of two modes at 40 and 90 Hz, Gamma 2 and 4; a second damper of the "
    "same filling at the same place, at half the shape of mode 1, and on the node of mode 1.",
    reference="twice the damping of one; that of one at Gamma and a quarter of that of one at Gamma / 2, (phi_2 / phi_1)^2; "
    "that of one",
    tolerance="1e-9: the same beds under the same drive give the same bits",
)
def several(fine):
    result = Result([])
    cycles = 40 if fine else 8
    with TemporaryDirectory() as folder:
        one = damping_of(folder, cycles, [2, 4])
        half = damping_of(folder, cycles, [1, 2])
        same = damping_of(folder, cycles, [2, 4], FURTHER.format(2, 1.5))
        farther = damping_of(folder, cycles, [2, 4], FURTHER.format(-1, 1.5))
        on_node = damping_of(folder, cycles, [2, 4], FURTHER.format(0, 1.5))
    expected = {
        "at one place": (2 * one, same),
        "at half the shape of mode 1": (one + np.array([half[0] / 4, one[1]]), farther),
        "on the node of mode 1": (one * [[1], [2]], on_node),
    }
    for name, (sums, found) in expected.items():
        for mode, gamma in np.ndindex(sums.shape):
            value = sums[mode, gamma]
            result.add(f"{name}: mode {mode + 1}, Gamma {(2, 4)[gamma]}", value, found[mode, gamma], 1e-9 * value)
    return result
