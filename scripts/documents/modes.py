"""Modes against closed forms: every figure of docs/modes.md, and the files that configs/ take their modes from.

python scripts/documents/modes.py

Takes about two minutes.  Writes docs/modes.md, docs/modes.png, configs/beam_modes.csv and
configs/bracket.msh.
"""

from dataclasses import replace

import numpy as np
from shared import DOCS, ROOT, head, table, write_document

from beam_theory import Timoshenko, circle, rectangle, tube
from plate_theory import LEISSA, SIDE, STEEL, THICKNESS, UNIT, loaded_pinned_plate
from warpdamp import Material, load
from warpdamp.formats.mode_csv import write_csv
from warpdamp.modal.beam import Beam, PointMass, beam_modes
from warpdamp.modal.from_config import beam, modes
from warpdamp.modal.section import Circle, Rectangle, Tube
from warpdamp.modal.solid import Plate, StandingMass, plate_modes
from warpdamp.report.figures import save
from warpdamp.report.mode_shapes import shapes

LENGTH, MODES = 0.58, 4
LOADS = {"none": (), "0.2 kg in the middle": ((0.2, 0.29, 0.0),), "two": ((0.2, 0.21, 2e-5), (0.1, 0.41, 0.0))}
SUPPORTS = [("clamped", "clamped"), ("clamped", "free"), ("pinned", "pinned"), ("free", "free"), ("clamped", "pinned")]
SECTIONS = {
    "strip 20 x 4, across 4": (Rectangle(0.02, 0.004), "thickness", lambda nu: rectangle(0.02, 0.004, nu)),
    "strip 20 x 4, across 20": (Rectangle(0.02, 0.004), "width", lambda nu: rectangle(0.004, 0.02, nu)),
    "rod 10": (Circle(0.01), "thickness", lambda nu: circle(0.01, nu)),
    "tube 20 x 2": (Tube(0.02, 0.002), "width", lambda nu: tube(0.02, 0.002, nu)),
}


def steel(nu):
    return Material(7800, 210e9, nu)


def beam_section():
    rows, worst = [], {}
    for name, (section, bends, theory) in SECTIONS.items():
        for supports in SUPPORTS if name == "strip 20 x 4, across 4" else SUPPORTS[:4]:
            for load_name, masses in LOADS.items():
                first, *others = [PointMass(*mass) for mass in masses] or [PointMass(0.0, 0.2)]
                cells = []
                for nu in (0.3, 0.0):
                    own = Beam(LENGTH, section, steel(nu), supports, bends, tuple(others))
                    found = beam_modes(own, first, highest=MODES).frequency
                    exact, _, _ = Timoshenko(LENGTH, theory(nu), steel(nu), supports, masses).modes(MODES)
                    off = 100 * (found / exact - 1)
                    worst[nu] = max(worst.get(nu, 0.0), np.abs(off).max())
                    cells.append(" ".join(f"{x:+.2f}" for x in off))
                rows.append([name, "-".join(supports), load_name, *cells])
    rod = [
        beam_modes(Beam(LENGTH, Circle(0.04), steel(nu)), PointMass(0.0, 0.2), highest=MODES).frequency
        / Timoshenko(LENGTH, circle(0.04, nu), steel(nu), SUPPORTS[0]).modes(MODES)[0]
        for nu in (0.3, 0.0)
    ]
    stubby = (", nu = 0: ").join(" ".join(f"{x:+.2f}" for x in 100 * (off - 1)) for off in rod)
    limits = f"Largest difference {worst[0.3]:.2f} % with nu = 0.3 (limit 0.5 %), {worst[0.0]:.3f} % with nu = 0."
    return (
        "Steel beams of 580 mm against Timoshenko's theory, solved exactly (`tests/beam_theory.py`); `two` is 0.2 kg "
        "with 20 kg mm^2 at 210 mm and 0.1 kg at 410 mm.  A clamp stops Poisson's contraction, which beam theory "
        "leaves out; with nu = 0 what is left is the mesh.",
        limits,
        table(["section [mm]", "supports", "masses", "nu = 0.3: modes 1-4 off by [%]", "nu = 0:"], rows),
        f"What a clamp adds grows with depth over length: a clamped rod of 40 mm is off by {stubby} %.",
    )


def plate_section():
    edge_rows, mass_rows = [], []
    for edges, expected in LEISSA.items():
        found = plate_modes(Plate(SIDE, SIDE, THICKNESS, STEEL, edges), StandingMass(0.0, (0.12, 0.16), 0.04)).frequency
        off = 100 * (found / (UNIT * np.array(expected)) - 1)
        edge_rows.append(["-".join(edges), " ".join(f"{x:+.2f}" for x in off)])
    for mass, x, y in ((2.5, 0.2, 0.2), (5.0, 0.1, 0.16)):
        own = plate_modes(
            Plate(SIDE, SIDE, THICKNESS, STEEL, ("pinned",) * 4), StandingMass(mass, (x, y), 0.04), highest=1
        )
        f, phi = loaded_pinned_plate(mass, x, y, 0.04)
        off = 100 * (own.frequency[0] / f - 1), 100 * (own.amplitude[0] / phi - 1)
        mass_rows.append([f"{mass:g} kg at ({1e3 * x:g}, {1e3 * y:g}) mm", f"{off[0]:+.3f}", f"{off[1]:+.3f}"])
    return (
        "Steel, 400 x 400 x 4 mm, against Leissa 1973 (thin plates by Ritz's method: exact where all edges are pinned, "
        "upper bounds elsewhere, known to be up to 1.1 % high with free edges); with a mass against Kirchhoff's modes "
        "summed.",
        table(["edges", "modes 1-5 off by [%]"], edge_rows),
        table(["mass on the pinned plate (5 kg)", "f off by [%]", "phi off by [%]"], mass_rows),
    )


def known_section(empty):
    """What is lost by adding the particles in the space of a few modes."""
    exact = modes(load(ROOT / "configs" / "beam.yaml"), particles=0.0239985)
    rows = []
    for count in (5, 8, 12):
        added = empty.pick(np.arange(1, count + 1)[~empty.on_node[:count]]).with_mass(0.0239985)
        found = added.pick(exact.number)
        off = 100 * (found.frequency / exact.frequency - 1), 100 * (found.amplitude / exact.amplitude - 1)
        rows.append([f"1 to {count}", *(f"{f:+.2f}, {phi:+.2f}" for f, phi in zip(*off, strict=True))])
    return (
        "`particles_included: false` adds the particles' mass in the space of the modes given.  The paper's beam with "
        "its empty damper, 24 g of particles added to a set of modes, against the finite elements with them:",
        table(["modes in the set", *(f"mode {n}: f, phi off by [%]" for n in exact.number)], rows),
    )


def bracket(path):
    """An angle 60 x 100 x 40 mm of 5 mm plate: hexahedra of 5 x 10 x 5 mm, in millimetres."""
    from skfem import MeshHex

    grid = MeshHex.init_tensor(np.arange(0, 101, 5.0), np.arange(0, 41, 10.0), np.arange(0, 61, 5.0))
    outside = grid.elements_satisfying(lambda x: (x[0] > 5) & (x[2] < 55))
    mesh = grid.remove_elements(outside)
    mesh.save(path, file_format="gmsh22", binary=False)


def main():
    config = load(ROOT / "configs" / "beam.yaml")
    own, damper = beam(config)
    empty = beam_modes(own, damper, highest=12)
    few = np.linspace(0, LENGTH, 9)
    rows = [int(np.argmin(np.abs(empty.point[:, 0] - x))) for x in few]
    first = np.arange(8)
    write_csv(
        ROOT / "configs" / "beam_modes.csv",
        replace(
            empty,
            number=empty.number[first],
            frequency=empty.frequency[first],
            inherent_damping=np.full(8, 0.001),
            point=empty.point[rows],
            shape=empty.shape[first][:, rows],
        ),
    )
    bracket(ROOT / "configs" / "bracket.msh")
    cantilever = load(ROOT / "configs" / "cantilever.yaml")
    tube_beam, tube_damper = beam(cantilever)
    save(shapes(beam_modes(tube_beam, tube_damper, highest=3), cantilever.title), DOCS / "modes.png")

    write_document(
        "modes.md",
        head("Modes against closed forms", __file__) + ".",
        *("## Beams", *beam_section()),
        *("## Plates", *plate_section()),
        *("## Known modes", *known_section(empty)),
    )


if __name__ == "__main__":
    main()
