"""The paper's appendix A: what real modes cost against complex ones; writes docs/appendix-a.md with its Fig. A.1.

python scripts/documents/appendix_a.py
"""

import math

import numpy as np
from scipy.optimize import brentq
from shared import DOCS, head, panels, table, write_document

from warpdamp.modal.appendix_a import complex_mode, energy_damping, pole_damping, real_mode, rigid_damping

LARGEST = 0.32
STIFFNESS = (1.0, 1.41, 2.0, 5.0, 20.0, 1e6)
# mode shapes of the paper's beam at the mass, without particles, by beam theory [kg^-0.5]
BEAM = {1: 1.7201, 3: 0.8300, 5: 0.5963}
PARTICLES = 0.0239985
TEXT = """{head}. A damper, effectiveness ε, gives its point of the structure the complex mass
m (1 − j 4ε/π). The paper's two-mass model carries it on a spring: a host mode (m_h, k_h), a damper of mass r_m m_h on a
spring r_k k_h; of the two modes the even one, eqs 26 and 27, at ε = 1.

- **Real modes**: those of the undamped model, damped by energy (eq. 6): ζ = m″φ²/2 = (2/π) ε r_m φ².
- **Complex modes**: the eigenvalue ω²(1 + jη) of the damped model. Its damping ratio has two readings that agree only
  to first order: half the loss factor, η/2, which is what eq. 6 counts, and the decay of the pole,
  −Re s/|s| = sin(atan(η)/2).
- **The error**: (ζ of the real modes − ζ of the complex mode) / ζ of the complex mode.

![Errors against the mass ratio, and damping against the stiffness ratio](appendix-a.png)

At the paper's largest mass ratio, {largest:g}:

{table}

What the paper says of its largest case is a damping ratio of 0.2 at a mass ratio of 0.32, without the stiffness ratio:

- Real modes give 0.200 at r_k = {found:.3f}. There the complex mode has η/2 = {found_energy:.4f} and a pole damping of
  {found_pole:.4f}.
- With a rigid spring ζ is (2/π) r_m / (1 + r_m) = {rigid:.4f}: the damper's mass lowers the frequency, and so its own
  effect.
- (2/π) r_m = {plain:.4f} leaves the added mass out. It is near 0.2 by chance, and so near the pole damping at
  r_k = 1.41 that the two are easily taken for one another.

So the 0.2 belongs to a soft spring, and the answer depends on r_k and on the reading. Against the pole the real modes
err by {pole_soft:+.1f} % at r_k = 1.41 and by {pole_rigid:+.1f} % with a rigid spring: "very small" holds. Against
the loss factor, which compares like with like, they err by {energy_soft:+.1f} % at r_k = 1.41 and not at all with a
rigid spring, where shape and mass are given. Both errors go with the square of the damping, and the paper's beam is
far from this case (rigid attachment, ε = 1):

{beam}

There a granular damper's real error lies elsewhere: the mass that moves with the structure is not the whole mass of
the particles, see [frf.md](frf.md).
"""


def errors(mass_ratio, stiffness_ratio):
    """Errors of the real mode's damping [%], against the loss factor and against the pole."""
    square = complex_mode(mass_ratio, stiffness_ratio)
    real = real_mode(mass_ratio, stiffness_ratio)[1]
    return 100 * (real / energy_damping(square) - 1), 100 * (real / pole_damping(square) - 1)


def label(stiffness_ratio):
    return "rigid" if stiffness_ratio >= 1e6 else f"{stiffness_ratio:g}"


def picture(path):
    figure, (against_energy, against_pole, damping) = panels(3, (11, 3.6))
    masses = np.linspace(0.002, LARGEST, 80)
    for k in STIFFNESS:
        rows = np.array([errors(m, k) for m in masses])
        against_energy.plot(masses, rows[:, 0], lw=1, label=f"r_k {label(k)}")
        against_pole.plot(masses, rows[:, 1], lw=1, label=f"r_k {label(k)}")
    for ax, name in ((against_energy, "half the loss factor"), (against_pole, "the pole's decay")):
        ax.set_title(f"error of real modes against {name}", fontsize=10)
        ax.set_xlabel("mass ratio r_m [-]")
        ax.set_ylabel("error [%]")
        ax.legend(fontsize=7)
    stiffness = np.geomspace(0.5, 100, 120)
    squares = [complex_mode(LARGEST, k) for k in stiffness]
    damping.semilogx(stiffness, [real_mode(LARGEST, k)[1] for k in stiffness], label="real modes")
    damping.semilogx(stiffness, [energy_damping(s) for s in squares], "--", label="complex, η/2")
    damping.semilogx(stiffness, [pole_damping(s) for s in squares], ":", label="complex, pole")
    for level, name in ((rigid_damping(LARGEST), "rigid"), (2 / math.pi * LARGEST, "(2/π) r_m")):
        damping.axhline(level, color="0.5", lw=0.7)
        damping.text(30, level + 0.002, name, fontsize=7, color="0.4")
    damping.set_title(f"damping ratio at r_m = {LARGEST:g}", fontsize=10)
    damping.set_xlabel("stiffness ratio r_k [-]")
    damping.set_ylabel("ζ [-]")
    damping.legend(fontsize=7)
    figure.savefig(path)


def main():
    picture(DOCS / "appendix-a.png")
    rows = []
    for k in STIFFNESS:
        square = complex_mode(LARGEST, k)
        values = (real_mode(LARGEST, k)[1], energy_damping(square), pole_damping(square))
        rows.append([label(k), *(f"{v:.4f}" for v in values), *(f"{e:+.2f}" for e in errors(LARGEST, k))])
    heading = ["r_k", "ζ, real", "η/2, complex", "pole, complex", "error against η/2 [%]", "error against the pole [%]"]
    largest = table(heading, rows)

    rows = []
    for mode, phi in BEAM.items():
        ratio = PARTICLES * phi**2
        energy, pole = errors(ratio, 1e6)
        rows.append([f"{mode}", f"{ratio:.4f}", f"{rigid_damping(ratio):.5f}", f"{energy:+.4f}", f"{pole:+.4f}"])
    heading = ["mode of the beam", "r_m = m φ²", "ζ at ε = 1", "error against η/2 [%]", "error against the pole [%]"]
    found = brentq(lambda k: real_mode(LARGEST, k)[1] - 0.2, 0.5, 10)
    text = TEXT.format(
        head=head("Appendix A: real against complex modes", __file__),
        largest=LARGEST,
        table=largest,
        found=found,
        found_energy=energy_damping(complex_mode(LARGEST, found)),
        found_pole=pole_damping(complex_mode(LARGEST, found)),
        rigid=rigid_damping(LARGEST),
        plain=2 / math.pi * LARGEST,
        energy_soft=errors(LARGEST, 1.41)[0],
        pole_soft=errors(LARGEST, 1.41)[1],
        pole_rigid=errors(LARGEST, 1e6)[1],
        beam=table(heading, rows),
    )
    write_document("appendix-a.md", text)


if __name__ == "__main__":
    main()
