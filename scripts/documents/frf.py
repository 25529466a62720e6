"""Frequency response of the paper's beam with its damper, from docs/beam.nc; writes docs/frf.md with its pictures.

python scripts/documents/frf.py
"""

import numpy as np
import xarray as xr
from shared import DOCS, head, table, write_document

from warpdamp.modal.apparent_mass import ComplexMass, complex_mass, corrected, per_mode
from warpdamp.modal.frf import ModalModel, accelerance, constant_force
from warpdamp.modal.identify import fits
from warpdamp.report.frf import against_gamma, families, force_curves
from warpdamp.scene.scene import STANDARD_GRAVITY

FORCES = {  # amplitudes [N] and band [Hz] for each mode
    1: ((0.02, 0.1, 0.3, 0.6, 1.0, 1.2), (35, 45)),
    3: ((0.005, 0.02, 0.1, 0.3, 0.6), (268, 296)),
    5: ((0.02, 0.1, 0.2, 0.4, 0.6), (710, 755)),
}
SHOWN = (0.5, 1, 2, 3, 4, 5, 6, 8, 10, 14)
FLUIDISED, TWO_SIDED = 3.0, 6.0  # where mode 1 has its shoulder and its optimum in docs/beam.nc
TEXT = """{head} from [beam.nc](beam.nc), the results of the main job. The structure is the sum of modes 1, 3
and 5, the damper the complex mass m′ − j m″ that its simulations found at each Γ, mean of three beds; the bare beam has
no damping of its own here. The force acts at the damper, as the shaker's does.

## Accelerance at controlled Γ

As in the paper's Figs 8a and b, 9 and 10: the lower amplitudes, then the higher.

![Accelerance for Gamma 0.5 to 4](frf-low.png)

![Accelerance for Gamma 4 to 14](frf-high.png)

## Natural frequency and damping against Γ

![Natural frequency and damping ratio of each mode against Gamma](frf-gamma.png)

Three ways to the same two numbers. *By energy*: eqs 6-11, the particles a rigid mass in the modes. *Corrected*: the
modes made anew with the mass m′ that the structure feels, which moves the frequency and the shape. *From FRFs*: the
curves above, fitted in their half-power bands as an experimenter does.

{table}

### What the paper's limitation iii costs

The paper expects its rigid mass to do little harm, because the particles are light. In mode 1 that holds: the corrected
damping differs by {mode1_low:+.1f} to {mode1_high:+.1f} %. In modes 3 and 5 it does not: there it is higher by
up to {mode3:.1f} and {mode5:.1f} %. The frequency hardly moves, but the shape does: {mass:.1f} g at the centre press
φ down from {phi3_empty:.3f} to {phi3:.3f} kg⁻½ in mode 3 and from {phi5_empty:.3f} to {phi5:.3f} in mode 5, and ζ goes
with φ². As Γ rises the structure feels ever less of the particles, and the mode becomes the empty beam's. Correcting
the frequency with the shape kept, ω²(1 + φ²(m′ − m)) = ω_r², gives {frozen3:.1f} and {frozen5:.1f} % at most.

### Fits beside energies

- Dobson, circle and least squares return the damping of the linearised structure within {fit_worst:.2f} % on these
  noise-free curves, the line fit within {line_worst:.1f} % (its bias on more heavily damped modes:
  [modal-fits.md](modal-fits.md)).
- The fitted damping lies below the corrected energy's by {harmonic_low:.1f} to {harmonic_high:.1f} % in the steady
  cases above Γ 1: by so much the first harmonic's work falls short of the energy dissipated. At Γ 0.5 and 1 in mode 1,
  where next to nothing is dissipated, it is {solid_low:.0f} and {solid_high:.0f} %.
- The fitted natural frequency lies below the corrected one by up to {complex_shift:.2f} %: 2ζ², as of complex modes.

## The paper's statement, checked

*"At low amplitudes the addition of particles decreases the natural frequency by an amount similar to the addition of an
equivalent mass block. As the amplitude approaches the fluidisation optimum, the natural frequency recovers around half
of the value lost. As the amplitude is increased further, through the two-sided collective collision optimum, the
natural frequency decreases again, dropping below the low-amplitude value."* For mode 1, by the apparent mass:

{statement}

- **The block: yes.** At Γ 0.5 the frequency is {low:.3f} Hz, {drop:.3f} Hz below the empty beam's {empty:.3f} Hz; a
  block of the particles' mass lowers it by {block:.3f} Hz.
- **About half: yes, rather more.** At Γ {fluidised:g} it has recovered {recovered:.0f} ± {recovered_error:.0f} % of
  what was lost, and half of it at Γ {half:.1f}. The largest recovery is {best:.0f} ± {best_error:.0f} % at
  Γ {best_gamma:g}; the error is the spread between beds.
- **Below the low-amplitude value: yes, but well past the optimum.** At the two-sided optimum, Γ {two_sided:g},
  {at_optimum:.0f} % of the loss is still recovered. The low-amplitude value is passed at Γ {crossing:.1f}, and at Γ 14
  the frequency is {below:.3f} ± {below_error:.3f} Hz lower: the structure then feels {felt:.1f} g, {more:.0f} % more
  than the particles weigh, as their body collides with both ends of the cavity.

Modes 3 and 5 recover and stay recovered, at Γ 14 by {rec3:.0f} and {rec5:.0f} %; in the paper they fall again, which it
ascribes to the rig. Mode 5 does not start at the block's frequency: at Γ 0.5 the structure feels {felt5:.1f} g, the bed
following its floor by two thirds; in mode 3 it feels {felt3:.1f} g, the bed moving a little more than its floor.

## Response at constant force

Harmonic balance with these describing functions, every branch, by continuation; drawn dashed where unstable, thin where
Γ is below the lowest simulated one (the bed there taken for linear).

![Gamma of the response at constant force](frf-force.png)

{forces}

In mode 1 the peak grows more slowly than the force, by far where particles begin to move; in modes 3 and 5, whose
damping falls with Γ, it grows faster than the force at the higher ones. Several states at one force and frequency exist
where the force that holds a level falls as the level rises. Such ranges of Γ, anywhere in the bands above:

{multivalued}

{known} Stability is that of the slow amplitude with a bed that adapts at once; a bed that remembers is beyond it.
"""
KNOWN = """Beyond Γ 1 a fall is at most {worst:.1f} of the standard error of the damping there: branches and folds there
are what the mean of these three beds gives, not what is known of the damper."""
NONE_BEYOND = "Beyond Γ 1 the force nowhere falls as the level rises."


def three_ways(energy, fitted):
    best, zeta = fitted.sel(fit="least squares"), 100 * fitted["fitted_damping_ratio"]
    columns = {
        "m′ [g]": (1e3 * energy["apparent_mass"], ".1f"),
        "f, corrected [Hz]": (energy["corrected_natural_frequency"], ".2f"),
        "f, fitted [Hz]": (best["fitted_frequency"], ".2f"),
        "ζ by energy [%]": (100 * energy["damping_ratio"], ".4g"),
        "corrected": (100 * energy["corrected_damping_ratio"], ".4g"),
        **{name: (zeta.sel(fit=name), ".4g") for name in ("least squares", "dobson", "line")},
    }
    rows = [
        [
            f"{mode}",
            f"{gamma:g}",
            *(f"{values.sel(mode=mode, gamma=gamma):{form}}" for values, form in columns.values()),
        ]
        for mode in energy["mode"].values
        for gamma in SHOWN
    ]
    return table(["mode", "Γ", *columns], rows)


def recovered(energy, mode):
    """Part of the frequency lost to a block of the particles' mass that is recovered [%], and its standard error."""
    own = energy.sel(mode=mode)
    lost = own["empty_natural_frequency"] - own["natural_frequency"]
    part = 100 * (own["corrected_natural_frequency"] - own["natural_frequency"]) / lost
    return part, 100 * own["corrected_natural_frequency_standard_error"] / lost


def crossing(gamma, values, level, *, falling):
    """First Gamma at which a curve falls (or rises) through a level, by linear interpolation."""
    below = values < level
    k = int(np.flatnonzero((~below[:-1] & below[1:]) if falling else (below[:-1] & ~below[1:]))[0])
    return gamma[k] + (level - values[k]) / (values[k + 1] - values[k]) * (gamma[k + 1] - gamma[k])


def answers(energy, particles):
    """Figures for the paper's statement."""
    gamma = energy["gamma"].values
    one = energy.sel(mode=1)
    f, error = one["corrected_natural_frequency"], one["corrected_natural_frequency_standard_error"]
    low, empty, block = float(f[0]), float(one["empty_natural_frequency"]), float(one["natural_frequency"])
    part, part_error = recovered(energy, 1)
    best = int(part.argmax("gamma"))
    later = gamma > FLUIDISED
    mass, mass_error = 1e3 * one["apparent_mass"], 1e3 * one["apparent_mass_standard_error"]
    columns = (a.values for a in (mass, mass_error, f, error, part))
    rows = [
        [f"{g:g}", f"{m:.1f} ± {m_error:.1g}", f"{x:.3f} ± {x_error:.1g}", f"{int(np.rint(p))}"]
        for g, m, m_error, x, x_error, p in zip(gamma, *columns, strict=True)
    ]
    felt = 1e3 * energy["apparent_mass"]
    return {
        "statement": table(["Γ", "m′ [g]", "natural frequency [Hz]", "recovered [%]"], rows),
        "low": low, "empty": empty, "drop": empty - low, "block": empty - block,
        "fluidised": FLUIDISED, "two_sided": TWO_SIDED,
        "recovered": float(part.sel(gamma=FLUIDISED)), "recovered_error": float(part_error.sel(gamma=FLUIDISED)),
        "half": crossing(gamma, part.values, 50, falling=False),
        "best": float(part[best]), "best_error": float(part_error[best]), "best_gamma": gamma[best],
        "at_optimum": float(part.sel(gamma=TWO_SIDED)),
        "crossing": crossing(gamma[later], f.values[later], low, falling=True),
        "below": low - float(f[-1]), "below_error": float(error[-1]),
        "felt": float(felt.sel(mode=1, gamma=14)), "more": 100 * (float(felt.sel(mode=1, gamma=14)) / particles - 1),
        "rec3": float(recovered(energy, 3)[0][-1]), "rec5": float(recovered(energy, 5)[0][-1]),
        "felt3": float(felt.sel(mode=3, gamma=0.5)), "felt5": float(felt.sel(mode=5, gamma=0.5)),
    }  # fmt: skip


def costs(dataset, energy, mass):
    """What a rigid mass in the modes costs [%], by mode, and what a correction of the frequency alone makes of it."""
    change = 100 * (energy["corrected_damping_ratio"] / energy["damping_ratio"] - 1)
    loading = dataset["mode_amplitude"] ** 2 * (energy["apparent_mass"] - mass / 1e3)
    frozen = 100 * (1 / (1 + loading) - 1)
    shape = energy["corrected_mode_amplitude"].sel(gamma=14)
    return {
        "mass": mass,
        "mode1_low": float(change.sel(mode=1).min()), "mode1_high": float(change.sel(mode=1).max()),
        "mode3": float(change.sel(mode=3).max()), "mode5": float(change.sel(mode=5).max()),
        "frozen3": float(frozen.sel(mode=3).max()), "frozen5": float(frozen.sel(mode=5).max()),
        "phi3": float(dataset["mode_amplitude"].sel(mode=3)), "phi3_empty": float(shape.sel(mode=3)),
        "phi5": float(dataset["mode_amplitude"].sel(mode=5)), "phi5_empty": float(shape.sel(mode=5)),
    }  # fmt: skip


def fits_against(dataset, energy, frf, fitted):
    """How far fits, linearised structure and energies lie from each other [%]."""
    zeta = np.abs(100 * (fitted["fitted_damping_ratio"] / frf["resonance_damping_ratio"] - 1))
    best = fitted.sel(fit="least squares")
    lower = 100 * (1 - best["fitted_damping_ratio"] / energy["corrected_damping_ratio"])
    steady = per_mode(dataset, (dataset["status"] == 0).all("seed")) & (dataset["gamma"] > 1)
    shift = 100 * (1 - best["fitted_frequency"] / energy["corrected_natural_frequency"])
    return {
        "fit_worst": float(zeta.sel(fit=["dobson", "circle", "least squares"]).max()),
        "line_worst": float(zeta.sel(fit="line").max()),
        "harmonic_low": float(lower.where(steady).min()), "harmonic_high": float(lower.where(steady).max()),
        "solid_low": float(lower.sel(mode=1, gamma=0.5)), "solid_high": float(lower.sel(mode=1, gamma=1)),
        "complex_shift": float(shift.max()),
    }  # fmt: skip


def force_table(responses):
    rows = []
    for mode, response in responses.items():
        for force in np.unique(response["force"]):
            one = response.isel(point=response["force"].values == force)
            top = one.isel(point=int(np.argmax(one["response_gamma"].values)))
            moved = np.diff(one["excitation_frequency"]) * (np.diff(one["branch"]) == 0)
            rows.append(
                [
                    f"{mode}",
                    f"{force:g}",
                    f"{float(top['response_gamma']):.3g}",
                    f"{float(top['excitation_frequency']):.2f}",
                    f"{len(np.unique(one['branch']))}",
                    f"{int(np.sum(moved[1:] * moved[:-1] < 0))}",
                    f"{int((~one['stable'].astype(bool)).sum())} of {one.sizes['point']}",
                ]
            )
    return table(["mode", "F [N]", "largest Γ", "at [Hz]", "branches", "turning points", "unstable points"], rows)


def several_states(dataset):
    """Ranges of Gamma in which, at some frequency, the force that holds a level falls as the level rises."""
    structure, mass = ModalModel.of(dataset), ComplexMass.of(dataset)
    felt = per_mode(dataset, complex_mass(dataset))
    error = 100 * felt["quadrature_mass_standard_error"] / felt["quadrature_mass"]
    gamma = np.linspace(mass.gamma[0], mass.gamma[-1], 1351)
    rows = []
    for mode, (_, band) in FORCES.items():
        f = np.linspace(*band, 2001)[:, None]
        force = gamma * STANDARD_GRAVITY * np.abs(structure.dynamic_mass(f) + mass(f, gamma))
        falling = np.diff(force, axis=1) < 0
        column = np.flatnonzero(falling.any(axis=0))
        for group in np.split(column, np.flatnonzero(np.diff(column) > 1) + 1) if column.size else ():
            first, last = group[0], group[-1] + 1
            k = np.flatnonzero(falling[:, group].any(axis=1))
            fall = 100 * np.max(1 - force[k, last] / force[k, first])
            own = float(error.sel(mode=mode).interp(gamma=(gamma[first] + gamma[last]) / 2))
            span = force[k, first : last + 1]
            rows.append(
                [
                    f"{mode}",
                    f"{gamma[first]:.2f}-{gamma[last]:.2f}",
                    f"{span.min():.3g}-{span.max():.3g}",
                    f"{f[k[0], 0]:.2f}-{f[k[-1], 0]:.2f}",
                    f"{fall:.2g}",
                    f"{own:.2g}",
                ]
            )
    heading = ["mode", "Γ", "force [N]", "frequency [Hz]", "the force falls by at most [%]", "s.e. of the damping [%]"]
    beyond = [float(row[4]) / float(row[5]) for row in rows if float(row[1].split("-")[0]) > 1]
    return {"multivalued": table(heading, rows), "known": KNOWN.format(worst=max(beyond)) if beyond else NONE_BEYOND}


def main():
    dataset = xr.load_dataset(DOCS / "beam.nc")
    mass = 1e3 * float(dataset["particle_mass"])
    energy, frf = corrected(dataset), accelerance(dataset)
    fitted = fits(frf)
    responses = {mode: constant_force(dataset, *given) for mode, given in FORCES.items()}

    families(frf.sel(gamma=slice(None, 4))).savefig(DOCS / "frf-low.png")
    families(frf.sel(gamma=slice(4, None))).savefig(DOCS / "frf-high.png")
    against_gamma(energy, fitted).savefig(DOCS / "frf-gamma.png")
    force_curves(*responses.values()).savefig(DOCS / "frf-force.png")
    text = TEXT.format(
        head=head("Frequency response of the beam with its damper", __file__),
        table=three_ways(energy, fitted),
        forces=force_table(responses),
        **several_states(dataset),
        **costs(dataset, energy, mass),
        **fits_against(dataset, energy, frf, fitted),
        **answers(energy, mass),
    )
    write_document("frf.md", text)


if __name__ == "__main__":
    main()
