"""The paper's beam with a complex mass at its middle, solved in two ways that share nothing with the package.

Both are Euler-Bernoulli beams, clamped at both ends, with the empty damper as a point mass: ``direct`` by Hermite elements
of scikit-fem, one solution a frequency; ``substructured`` by coupling the receptance of the bare beam, from its modes
in closed form, with that of the damper.  The beam of the package is a solid, whose clamps stop Poisson's contraction:
its frequencies are 0.2 to 0.3 % higher.
"""

import numpy as np
from scipy.optimize import brentq

from warpdamp.modal.apparent_mass import ComplexMass
from warpdamp.modal.frf import ModalModel, accelerance, complex_accelerance
from warpdamp.modal.identify import fits
from warpdamp.scene.scene import Material

LENGTH, WIDTH, THICKNESS, EMPTY_DAMPER = 0.58, 0.02, 0.004, 0.2  # configs/beam.yaml [m], [kg]
STEEL = Material(density=7800.0, youngs_modulus=210e9, poissons_ratio=0.3)
STIFFNESS = STEEL.youngs_modulus * WIDTH * THICKNESS**3 / 12  # E I [N m^2]
LINE_MASS = STEEL.density * WIDTH * THICKNESS  # [kg/m]
ELEMENTS = 32
"""Even, for a node at the middle; mode 5 then errs by 3e-5."""
MODES = range(1, 41)
"""Of the bare beam in its receptance, symmetric; the rest adds 1e-6 of the static flexibility."""

WIDE, CLOSE, LINES = 0.1, 0.006, 600
"""Of an FRF: half the lines from so far below a mode to so far above it, as far as the card reaches, half of them so
close to it that the narrowest half-power band holds ten."""
FRF, DIRECT, COUPLED = "warpdamp frf", "direct", "substructured"


def direct(frequency, mass):
    """Accelerance [m s^-2 N^-1] at the damper: (K - w^2 (M + m b b^T)) u = b, A = -w^2 b^T u, by finite elements.

    Parameters
    ----------
    frequency : (n,) array [Hz]
    mass : (n,) complex array [kg], of what is in the damper
    """
    from skfem import Basis, BilinearForm, ElementLineHermite, MeshLine
    from skfem.helpers import dd, ddot

    basis = Basis(MeshLine(np.linspace(0, LENGTH, ELEMENTS + 1)), ElementLineHermite())
    stiffness = BilinearForm(lambda u, v, _: STIFFNESS * ddot(dd(u), dd(v))).assemble(basis)
    inertia = BilinearForm(lambda u, v, _: LINE_MASS * u * v).assemble(basis)
    free = basis.complement_dofs(basis.get_dofs())
    at_damper = (free == basis.nodal_dofs[0, np.argmin(np.abs(basis.mesh.p[0] - LENGTH / 2))]).astype(float)
    stiffness, inertia = (matrix.toarray()[np.ix_(free, free)] for matrix in (stiffness, inertia))
    square = (2 * np.pi * np.asarray(frequency))[:, None, None] ** 2
    attached = (EMPTY_DAMPER + np.asarray(mass))[:, None, None] * np.outer(at_damper, at_damper)
    dynamic = stiffness - square * (inertia + attached)
    moved = np.linalg.solve(dynamic, np.broadcast_to(at_damper[:, None], (len(square), len(free), 1)))
    return -square[:, 0, 0] * (at_damper @ moved)[:, 0]


def substructured(frequency, mass):
    """The same by H = H_s - H_s (H_s + 1 / Z)^-1 H_s, Z = -w^2 m of the damper and what is in it.

    de Klerk, Rixen, Voormeeren 2008, doi:10.2514/1.33274.
    """
    w = 2 * np.pi * np.asarray(frequency)
    natural, shape = _bare_modes()
    bare = np.sum(shape**2 / (natural**2 - w[:, None] ** 2), axis=1)
    damper = -(w**2) * (EMPTY_DAMPER + np.asarray(mass))
    return -(w**2) * (bare - bare / (bare + 1 / damper) * bare)


def _bare_modes():
    """Symmetric modes of the bare beam: natural frequencies [rad/s], mass-normalised shapes at the middle [kg^-0.5].

    W(x) = cos(2 h x / L) / cos h - cosh(2 h x / L) / cosh h from the middle, tan h + tanh h = 0; the mean of W^2 is
    (1 / cos^2 h + 1 / cosh^2 h) / 2.  The antisymmetric ones do not move the damper.
    """
    h = np.array([brentq(lambda h: np.sin(h) + np.cos(h) * np.tanh(h), (n - 0.5) * np.pi, n * np.pi) for n in MODES])
    shape = (1 / np.cos(h) - 1 / np.cosh(h)) / np.sqrt((1 / np.cos(h) ** 2 + 1 / np.cosh(h) ** 2) / 2)
    return (2 * h / LENGTH) ** 2 * np.sqrt(STIFFNESS / LINE_MASS), shape / np.sqrt(LINE_MASS * LENGTH)


def compared(part, modes, mode: int, gamma: float):
    """Natural frequency [Hz] and damping ratio [-] of one mode at one Gamma with the damper of a card, in three ways.

    Each from the accelerance by the same fit of least squares in the half-power band.

    Parameters
    ----------
    part : card
    modes : those of the package's beam, with the particles of the damper
    mode, gamma : of them one

    Returns
    -------
    dict of (float, float), by the way
    """
    import xarray as xr

    felt = ComplexMass.of(part)
    structure = ModalModel.of_modes(modes, modes.inherent_damping, float(part["particle_mass"]))
    natural = structure.resonances(felt, gamma)[0][list(modes.number).index(mode)]
    frequency = np.unique([np.linspace(natural * (1 - span), natural * (1 + span), LINES) for span in (WIDE, CLOSE)])
    frequency = frequency[(frequency >= felt.band[0]) & (frequency <= felt.band[1])]
    mass = felt(frequency, gamma)
    package = complex_accelerance(accelerance(part, gamma, frequency, structure=structure)).values[0]
    ways = {FRF: package, DIRECT: direct(frequency, mass), COUPLED: substructured(frequency, mass)}
    found = {}
    for way, curve in ways.items():
        parts = {"accelerance_real": ("frequency", curve.real), "accelerance_imaginary": ("frequency", curve.imag)}
        frf = xr.Dataset(parts, {"frequency": frequency})
        fit = fits(frf, [frequency[np.argmax(np.abs(curve))]]).sel(fit="least squares").isel(mode=0)
        found[way] = float(fit["fitted_frequency"]), float(fit["fitted_damping_ratio"])
    return found
