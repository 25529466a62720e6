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
from warpdamp import Cylinder, Grains, Request, load, prepare, run
from warpdamp.config.spectra import SPECTRA
from warpdamp.coupled import forces, noise
from warpdamp.coupled.identify import first_harmonic, from_decay
from warpdamp.scene.host import BaseMotion, Force, HostStructure
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


def on_one_structure(beds, amplitudes, dt, steps, record, **host):
    """Batch of cavities on one structure after its run, and ledgers at start and end of each."""
    cases = [
        Case(scene.on_host(HostStructure(amplitude=phi, record=record, **host)), state, dt)
        for (scene, state), phi in zip(beds, amplitudes, strict=True)
    ]
    batch = Batch(cases, max_records=1 + steps // record, enclosures=[len(cases)])
    start = [ledger for _, ledger in batch.read()]
    batch.advance(steps)
    return batch, start, [ledger for _, ledger in batch.read()]


def settled(count: int, seed: int):
    """Cavity of the paper with so many particles at rest on its floor."""
    material = Material(920, 33e6, 0.37)
    scene = Scene(material, material, Surface(0.52, 0.5), Surface(0.52, 0.5), Cylinder(0.04, 0.04))
    return scene, prepare(Request(scene, Grains.alike(RADIUS, count), seed, "loose")).state


@case(
    "Several dampers in coupled runs",
    setup="Two cavities on one structure, 40 Hz, released with a velocity: (a) one layer of particles at rest in each, far "
    "below Gamma 1, phi = 1.7 and -0.9 kg^-1/2; (b) the same bed in both, phi = 1.2, thrown by 9 g; (c) 40 and 25 particles, "
    "two modes, thrown by a force for four cycles.",
    reference="(a) particles that move along weigh where they are: w0 / sqrt(1 + sum phi_c^2 m_c); (b) one damper on half the "
    "modal mass, phi sqrt(2), in every record; (c) work of the force = losses of all + gains of all, the structure's once",
    tolerance="(a) 2e-4, the beds are elastic; (b) 1e-9 of the largest: rounding, in 50 ms before a bed is chaotic; (c) 0.5 % of "
    "what was lost, that of coupled runs of one damper",
)
def several_coupled(fine):
    result = Result([])
    w = 2 * math.pi * 40
    beds, phi = [settled(16, 1), settled(16, 2)], (1.7, -0.9)
    masses = [float(np.sum(scene.masses(state))) for scene, state in beds]
    sag = -9.81 * sum(p * m for p, m in zip(phi, masses, strict=True)) / w**2
    steps = 60_000 if fine else 30_000
    batch, *_ = on_one_structure(
        beds,
        [(p,) for p in phi],
        5e-6,
        steps,
        20,
        frequency=(40.0,),
        damping=(0.002,),
        position=(sag,),
        velocity=(2e-3,),
    )
    found = np.mean([swing.frequency for swing in from_decay(batch.records(0))])
    expected = 40 / math.sqrt(1 + sum(p**2 * m for p, m in zip(phi, masses, strict=True)))
    result.add("a: natural frequency [Hz]", expected, found, 2e-4 * expected)

    same = [settled(16, 1)] * 2
    mode = {"frequency": (40.0,), "damping": (0.01,)}
    two, *_ = on_one_structure(same, [(1.2,)] * 2, 5e-6, 10_000, 50, velocity=(-0.4,), **mode)
    half = 1.2 * math.sqrt(2)
    one, *_ = on_one_structure(same[:1], [(half,)], 5e-6, 10_000, 50, velocity=(-0.4 / math.sqrt(2),), **mode)
    for column, name in ((1, "place [m]"), (2, "acceleration [m/s^2]"), (3, "reaction [N]")):
        exact, found = one.records(0)[:, column], two.records(0)[:, column]
        k = int(np.argmax(np.abs(found - exact)))
        result.add(f"b: {name} where it differs most", exact[k], found[k], 1e-9 * np.abs(exact).max())

    host = {"frequency": (41.0, 90.0), "damping": (0.003, 0.003), "force": Force(4.0, 40.0), "velocity": (0.2, 0.1)}
    n = 12_000 if fine else 6_000
    _, start, end = on_one_structure(
        [settled(40, 1), settled(25, 2)], [(1.7, 0.5), (-1.1, 0.8)], 1 / 40 / n, 4 * n, 50, **host
    )
    both = [type(b)(np.concatenate([a.rows, b.rows]), b.effects) for a, b in zip(start, end, strict=True)]
    lost = sum(float(np.diff(ledger.dissipated)[0]) + ledger.change("structure_loss") for ledger in both)
    balance = lost + sum(float(ledger.coupled_residual[-1]) for ledger in both)
    result.add("c: energy lost, as the work and the gains say [J]", lost, balance, 5e-3 * lost)
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
