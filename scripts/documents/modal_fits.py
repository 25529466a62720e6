"""Modal fits on a synthetic accelerance of three known modes, without and with noise; writes docs/modal-fits.md.

python scripts/documents/modal_fits.py
"""

import numpy as np
from shared import DOCS, head, panels, table, write_document

from warpdamp.modal.fit import Fit, circle_fit, dobson, half_power_band, line_fit
from warpdamp.modal.fit_together import least_squares

OWN = np.array([39.5, 280.0, 731.0])
ZETA = np.array([0.03, 0.008, 0.004])
PHI = np.array([1.6627, 0.7692, 0.5458])  # the paper's beam with its particles [kg^-0.5]
CONSTANT = PHI**2
POINTS, DRAWS, NOISE = 41, 200, 0.01
READINGS = (
    "between the 3 dB points",
    "ζ f to both sides of the peak",
    "ζ f to both sides of the natural frequency",
    "between the 3 dB points, imaginary part as a constant",
)
TEXT = """{head}. A synthetic point accelerance with three modes of the paper's beam: 39.5, 280 and
731 Hz, damping ratios 3, 0.8 and 0.4 %, modal constants {constants} kg⁻¹ (the squares of the mode
shapes at the mass). Damping is viscous, the fits suppose it hysteretic: none is fed its own model. Each mode is fitted
in its half-power band, {points} points in equal steps; least squares takes the three bands together.

![The accelerance, the lines of the line fit, and its bias](modal-fits.png)

## Without noise

{clean}

## Why the line fit is biased

The line fit takes 1/H of a mode for two straight lines over ω². The other modes leave a residual B in H, nearly real
and nearly constant across the band, and it bends both lines (middle picture). How much that costs depends on the band:

{reading}

To first order in B the imaginary line tilts and the real one bends, both symmetrically about the resonance, and nothing
is biased: the bias is of second order, nothing for the lowest mode, which towers over its neighbours, and growing with
the square of what they leave (right-hand picture). Twice over, in fact. B itself acts in second order, in any band. And
B makes the peak lopsided, so that a band about the peak, or between the 3 dB points even more so, does not lie
symmetrically about the resonance; over a lopsided band a symmetric bend becomes a slope. The last row has one mode and
a constant in the neighbours' place: they do nothing else. Dobson's differences, the circle's free centre and the
residuals of least squares take B out; what remains is its change across the band and the difference between viscous
and hysteretic damping.

## With {noise} % noise

{draws} draws; complex Gaussian noise, its rms {noise} % of each point's size. Mean error and spread (one standard
deviation) of ζ, spread of f, and the mean of the standard errors that the methods state themselves (least squares: of
the fit; the others: of a jackknife, every tenth of the points left out in turn).

{noisy}

The line fit scatters least, about the wrong value: it has the fewest unknowns. The other three pay for the residual
with about twice its scatter. Dobson's fit divides by differences of neighbouring points; each difference is weighed by
what its noise allows.
"""
METHODS = {"line fit": line_fit, "Dobson": dobson, "circle fit": circle_fit}


def accelerance(frequency, modes=slice(None)):
    """Sum of viscously damped modes [m s^-2 N^-1]: not the hysteretic ones that the fits take for granted."""
    w, own = 2 * np.pi * np.asarray(frequency)[:, None], 2 * np.pi * OWN[modes]
    return np.sum(-(w**2) * CONSTANT[modes] / (own**2 - w**2 + 2j * ZETA[modes] * own * w), axis=1)


def band(mode):
    """POINTS frequencies in equal steps across a mode's half-power band."""
    wide = OWN[mode] * (1 + 4 * ZETA[mode] * np.linspace(-1, 1, 4001))
    inside = wide[half_power_band(wide, accelerance(wide), OWN[mode])]
    return np.linspace(inside[0], inside[-1], POINTS)


def every_method(frequencies, curves) -> dict[str, list[Fit]]:
    found = {name: [fit(f, a) for f, a in zip(frequencies, curves, strict=True)] for name, fit in METHODS.items()}
    together = np.concatenate(frequencies), np.concatenate(curves)
    return found | {"least squares": least_squares(*together, found["Dobson"])}


def neighbours(mode):
    """What the other modes leave in the receptance at a mode's resonance, over the mode's own peak."""
    others = [k for k in range(3) if k != mode]
    w = 2 * np.pi * OWN[mode]
    rest = complex(-accelerance([OWN[mode]], others)[0] / w**2)
    return rest.real / (CONSTANT[mode] / (2 * ZETA[mode] * w**2))


def line_fit_bias(mode, share):
    """Bias of zeta by a line fit of a mode with a constant real ``share`` of its peak added to the receptance."""
    f = OWN[mode] * (1 + 6 * ZETA[mode] * np.linspace(-1, 1, 20_001))
    x = (f / OWN[mode]) ** 2
    a = -x * (1 / (1 - x + 2j * ZETA[mode]) + share / (2 * ZETA[mode]))
    inside = half_power_band(f, a, OWN[mode])
    return line_fit(f[inside], a[inside]).damping_ratio / ZETA[mode] - 1


def about(centre, mode):
    """POINTS frequencies within zeta f of a centre."""
    return centre * (1 + ZETA[mode] * np.linspace(-1, 1, POINTS))


def mean_reading(frequency, curve):
    """zeta by a line fit that reads the imaginary part as a constant, its mean over the band."""
    x = (frequency / np.mean(frequency)) ** 2
    inverse = -x / curve
    _, offset = np.polyfit(x, inverse.real, 1)  # w_r^2 / C
    return inverse.imag.mean() / offset / 2


def readings():
    """Bias of zeta by the line fit, by what is taken for the band and how the lines are read."""
    rows = {name: [] for name in READINGS}
    for mode in range(3):
        found = band(mode)
        peak = found[np.argmax(np.abs(accelerance(found)))]
        for name, f in zip(READINGS, (found, about(peak, mode), about(OWN[mode], mode)), strict=False):
            rows[name].append(line_fit(f, accelerance(f)).damping_ratio / ZETA[mode] - 1)
        rows[READINGS[-1]].append(mean_reading(found, accelerance(found)) / ZETA[mode] - 1)
    return rows


def noisy_draws(frequencies, curves):
    """Fits of DRAWS copies with complex Gaussian noise, its rms NOISE of each point's size."""
    random = np.random.default_rng(20)
    draws = []
    for _ in range(DRAWS):
        scatter = [random.normal(size=(2, len(a))) * NOISE / np.sqrt(2) for a in curves]
        draws.append(
            every_method(frequencies, [a * (1 + e[0] + 1j * e[1]) for a, e in zip(curves, scatter, strict=True)])
        )
    return draws


def picture(path, frequencies, curves, shares):
    figure, (whole, lines, bias) = panels(3, (11, 3.6))
    f = np.unique(np.concatenate([np.geomspace(20, 1000, 4000), *frequencies]))
    whole.loglog(f, np.abs(accelerance(f)), lw=1)
    for one, a in zip(frequencies, curves, strict=True):
        whole.loglog(one, np.abs(a), "C3", lw=2.5)
    whole.set_title("accelerance; bands that are fitted", fontsize=10)
    whole.set_xlabel("frequency [Hz]")
    whole.set_ylabel("accelerance [m s$^{-2}$ N$^{-1}$]")

    f, a = frequencies[2], curves[2]
    alone = accelerance(f, [2])
    x = (f / OWN[2]) ** 2
    for values, style, label in ((a, "-", "with its neighbours"), (alone, "--", "alone")):
        inverse = -x / values * CONSTANT[2]
        lines.plot(f, inverse.real, f"C0{style}", label=f"real, {label}")
        lines.plot(f, inverse.imag, f"C1{style}", label=f"imaginary, {label}")
    lines.set_title("mode at 731 Hz: C / H, to be fitted by lines", fontsize=10)
    lines.set_xlabel("frequency [Hz]")
    lines.legend(fontsize=7)

    b = np.linspace(0, 0.12, 25)
    bias.plot(100 * b, [100 * line_fit_bias(2, -s) for s in b], lw=1, label="one mode and a constant")
    for mode, share in enumerate(shares):
        found = line_fit(frequencies[mode], curves[mode]).damping_ratio / ZETA[mode] - 1
        bias.plot(100 * abs(share), 100 * found, "C3o", label=None if mode else "the three modes")
    bias.set_title("bias of ζ by the line fit", fontsize=10)
    bias.set_xlabel("neighbours at resonance, % of the peak")
    bias.set_ylabel("bias [%]")
    bias.legend(fontsize=7)
    figure.savefig(path)


def percent(values):
    return [f"{100 * value:+.2f}" for value in values]


def main():
    frequencies = [band(mode) for mode in range(3)]
    curves = [accelerance(f) for f in frequencies]
    shares = [neighbours(mode) for mode in range(3)]
    exact = every_method(frequencies, curves)
    draws = noisy_draws(frequencies, curves)
    picture(DOCS / "modal-fits.png", frequencies, curves, shares)

    def errors(values, names=("damping_ratio", "frequency")):
        return [
            f"{100 * (getattr(fit, name) / true[mode] - 1):+.3f}"
            for name, true in zip(names, (ZETA, OWN), strict=True)
            for mode, fit in enumerate(values)
        ]

    modes = [f"{f:g} Hz" for f in OWN]
    heading = ["error [%]", *(f"ζ, {m}" for m in modes), *(f"f, {m}" for m in modes)]
    clean = table(heading, [[name, *errors(values)] for name, values in exact.items()])

    rows = []
    for name in exact:
        zeta = np.array([[fit.damping_ratio for fit in draw[name]] for draw in draws]) / ZETA - 1
        f = np.array([[fit.frequency for fit in draw[name]] for draw in draws]) / OWN - 1
        stated = np.array([[fit.damping_ratio_error for fit in draw[name]] for draw in draws]).mean(0) / ZETA
        cells = [f"{100 * m:+.2f} ± {100 * s:.2f}" for m, s in zip(zeta.mean(0), zeta.std(0, ddof=1), strict=True)]
        cells += [f"{100 * s:.4f}" for s in f.std(0, ddof=1)]
        cells += [f"{100 * s:.2f}" for s in stated]
        rows.append([name, *cells])
    heading = ["[%]", *(f"{what}, {m}" for what in ("ζ", "spread of f", "s.e. of ζ") for m in modes)]
    noisy = table(heading, rows)

    rows = [["neighbours at resonance, % of the peak", *percent(shares)]]
    rows += [[f"bias of ζ, {name}", *percent(values)] for name, values in readings().items()]
    constant = percent(line_fit_bias(mode, share) for mode, share in enumerate(shares))
    rows += [["one mode and a constant that large, between the 3 dB points", *constant]]
    text = TEXT.format(
        head=head("Modal fits and their biases", __file__),
        constants=", ".join(f"{c:.4f}" for c in CONSTANT),
        points=POINTS,
        draws=DRAWS,
        noise=f"{100 * NOISE:g}",
        clean=clean,
        reading=table(["[%]", *modes], rows),
        noisy=noisy,
    )
    write_document("modal-fits.md", text)


if __name__ == "__main__":
    main()
