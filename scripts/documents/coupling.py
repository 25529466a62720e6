"""The prediction from prescribed motion against structures that answer; writes docs/coupling.md from docs/coupling.nc.

    python scripts/documents/coupling.py            # the document, from the committed runs and docs/beam.nc
    python scripts/documents/coupling.py simulate   # the runs anew: four minutes on two cores

Mode 1 of the paper's beam, alone, with the paper's damper: held near ten amplitudes by a harmonic force at resonance,
and released from the largest.  Both sides use the same three compacted beds.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np
import xarray as xr
from shared import DOCS, ROOT, head, panels, processes, table, write_document

from warpdamp import corrected, load
from warpdamp.analysis.results import write
from warpdamp.config.build import grains, scene
from warpdamp.coupled.identify import from_decay, from_response, host_of
from warpdamp.coupled.run import Run, advance
from warpdamp.damper.case import Request
from warpdamp.modal.from_config import modes
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene.host import Force
from warpdamp.scene.scene import STANDARD_GRAVITY, Drive

GAMMAS = (0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 7.0, 9.0, 11.0, 14.0)
INHERENT = 0.002
CYCLES, WINDOW, DECAY = 120, 10, 160
RECORDS = 64  # a cycle


def held(gamma: float, seed: int) -> dict:
    """A forced run near ``gamma``, started on the steady response that the prediction expects."""
    config = load(ROOT / "configs" / "beam.yaml")
    expected = corrected(xr.load_dataset(DOCS / "beam.nc")).sel(mode=1, gamma=gamma)
    frequency = float(expected["corrected_natural_frequency"])
    w = 2 * math.pi * frequency
    amplitude = gamma * STANDARD_GRAVITY / w**2
    mode = modes(config, particles=0.0).pick([1])
    phi = float(mode.amplitude[0])
    loss = (
        2 * (float(expected["corrected_damping_ratio"]) + INHERENT) / float(expected["corrected_mode_amplitude"]) ** 2
    )
    host = host_of(
        mode,
        [INHERENT],
        force=Force(loss * w**2 * amplitude, frequency),
        position=(-amplitude / phi,),
    )
    return _run(config, host, gamma, frequency, seed, CYCLES) | {"kind": "held"}


def released(gamma: float, seed: int) -> dict:
    """A ring-down from ``gamma``."""
    config = load(ROOT / "configs" / "beam.yaml")
    mode = modes(config, particles=0.0).pick([1])
    w = 2 * math.pi * float(mode.frequency[0])
    host = host_of(mode, [INHERENT], position=(gamma * STANDARD_GRAVITY / w**2 / float(mode.amplitude[0]),))
    return _run(config, host, gamma, float(mode.frequency[0]), seed, DECAY) | {"kind": "released"}


def _run(config, host, gamma, frequency, seed, cycles) -> dict:
    base, own = scene(config), grains(config)
    n = steps_per_cycle(base.driven(Drive(frequency, gamma * STANDARD_GRAVITY)), own)
    host = replace(host, record=n // RECORDS)
    done = advance(Run((Request(base, own, seed),), (base.on_host(host),), 1 / frequency / n, cycles * n))
    records = done["records"][0]
    found = from_response(records, host, WINDOW) if host.force else from_decay(records)
    return {
        "asked": gamma,
        "seed": seed,
        "found": np.array([[i.gamma, i.frequency, i.damping] for i in found]),
        "closure": done["closure"],
        "cpu_time": done["cpu_time"],
        "cycles": cycles,
    }


def simulate() -> None:
    """All runs, side by side."""
    jobs = [(held, gamma, seed) for gamma in GAMMAS for seed in (1, 2, 3)]
    jobs += [(released, GAMMAS[-1], seed) for seed in (1, 2, 3)]
    with processes() as executor:
        runs = [future.result() for future in [executor.submit(*job) for job in jobs]]
    longest = max(len(run["found"]) for run in runs)
    found = np.full((len(runs), longest, 3), np.nan)
    for k, run in enumerate(runs):
        found[k, : len(run["found"])] = run["found"]
    dataset = xr.Dataset(
        {
            "gamma": (("run", "window"), found[..., 0]),
            "natural_frequency": (("run", "window"), found[..., 1], {"units": "Hz"}),
            "damping_ratio": (("run", "window"), found[..., 2]),
            **{
                name: ("run", [run[name] for run in runs])
                for name in ("asked", "seed", "kind", "closure", "cpu_time", "cycles")
            },
        },
        attrs={"title": "Mode 1 of the paper's beam with its damper, coupled runs", "inherent_damping": INHERENT},
    )
    write(dataset, DOCS / "coupling.nc")


def predictions():
    """Interpolators of frequency and damping against Gamma, the paper's and the corrected, and their errors."""
    from scipy.interpolate import PchipInterpolator

    expected = corrected(xr.load_dataset(DOCS / "beam.nc")).sel(mode=1)
    names = {
        "frequency": "corrected_natural_frequency",
        "frequency_error": "corrected_natural_frequency_standard_error",
        "paper": "damping_ratio",
        "corrected": "corrected_damping_ratio",
        "error": "damping_ratio_standard_error",
    }
    at = {key: PchipInterpolator(expected["gamma"], expected[name]) for key, name in names.items()}
    return at, float(expected["natural_frequency"])


def document() -> None:
    """Write docs/coupling.md and its picture."""
    runs = xr.load_dataset(DOCS / "coupling.nc")
    price = xr.load_dataset(DOCS / "beam.nc")["cpu_time"].isel(frequency=0)
    at, rigid = predictions()
    inherent = runs.attrs["inherent_damping"]
    forced = runs.where(runs["kind"] == "held", drop=True)
    low, high = float(at["paper"].x[0]), float(at["paper"].x[-1])
    rows, off, gone = [], {"paper": [], "corrected": [], "frequency": [], "rigid": []}, []
    alone = 0
    for gamma in GAMMAS:
        own = forced.where(forced["asked"] == gamma, drop=True)
        per_bed = own.isel(window=slice(CYCLES // WINDOW // 2, None)).mean("window")
        there = (per_bed["gamma"] <= high).values
        gone += [f"{float(g):.0f}" for g in per_bed["gamma"].values[~there]]
        if there.sum() < 2:
            alone += int(there.sum())
            continue
        per_bed = per_bed.isel(run=there)
        g = np.clip(per_bed["gamma"].values, low, high)  # the lowest come out at 0.498
        zeta, f = per_bed["damping_ratio"].values - inherent, per_bed["natural_frequency"].values
        misses = {key: _mean(zeta - at[key](g)) for key in ("paper", "corrected")}
        error = float(at["error"](g.mean()))
        for key, (miss, own_error) in misses.items():
            off[key].append(miss / math.hypot(own_error, error))
        shift, shift_error = _mean(f - at["frequency"](g))
        shift_total = math.hypot(shift_error, float(at["frequency_error"](g.mean())))
        off["frequency"].append(shift)
        off["rigid"].append(float(np.mean(f)) - rigid)
        rows.append(
            [f"{g.min():.2f} - {g.max():.2f}", len(g)]
            + [f"{100 * float(x.mean()):.3f}" for x in (zeta, at["paper"](g), at["corrected"](g))]
            + [f"{100 * misses['corrected'][0]:+.3f} ± {100 * math.hypot(misses['corrected'][1], error):.3f}"]
            + [f"{float(x.mean()):.3f}" for x in (f, at["frequency"](g))]
            + [f"{shift:+.3f} ± {shift_total:.3f}"]
        )
    inside = {key: sum(abs(x) <= 2 for x in off[key]) for key in ("paper", "corrected")}
    coupled = float((forced["cpu_time"] / forced["cycles"]).mean())
    heading = ["Gamma", "beds", "damping, coupled [%]", "the paper's", "corrected", "coupled - corrected"]
    heading += ["frequency, coupled [Hz]", "corrected", "coupled - corrected"]
    write_document(
        "coupling.md",
        head("Structures that answer", __file__) + " from docs/coupling.nc and docs/beam.nc.  The modal oscillator and "
        "the particles advance together, driven by a harmonic force near resonance; natural frequency and damping are "
        f"read from the steady response (windows of {WINDOW} cycles, the second half of {CYCLES}), the inherent "
        f"damping of {100 * inherent:g} % taken off.  Beside it the prediction from prescribed motion at the same "
        "Gamma: the paper's (particles as a rigid mass) and with the mass that the structure feels, each bed's at its "
        "own amplitude.  ± are standard errors: of the beds, and of the prediction.",
        table(heading, rows),
        f"Damping: {inside['corrected']} of {len(rows)} amplitudes agree within two standard errors with the corrected "
        f"prediction, {inside['paper']} with the paper's.  Frequency: the prediction is off by "
        f"{1e3 * np.sqrt(np.mean(np.square(off['frequency']))):.0f} mHz (root mean square), the rigid mass's "
        f"{rigid:.3f} Hz by {1e3 * np.sqrt(np.mean(np.square(off['rigid']))):.0f} mHz.",
        f"{len(gone) + alone} of {forced.sizes['run']} runs are not in the table.  {len(gone)} went to Gamma "
        f"{', '.join(gone)}, beyond what was predicted: past the optimum damping falls with the amplitude, so that the "
        "same force has a second, larger response.  Where prescribed motion holds Gamma, a force does not: "
        "`warpdamp frf --constant-force` follows such branches as far as the results reach."
        + (f"  {alone} is left alone at its force, without another bed to compare with." if alone else ""),
        "At the lowest amplitude both dampings are small: the difference is a tenth of the inherent one.  There beds "
        "age for as long as one waits; the prediction's have run for up to 1,000 cycles, these for 120.",
        "![damping and frequency](coupling.png)",
        "## Energy",
        f"Work of the force, less all losses and gains of structure and particles in the laboratory: at most "
        f"{100 * float(runs['closure'].max()):.2f} % of what was lost (asked for: 0.5 %), median "
        f"{100 * float(runs['closure'].median()):.2f} %.",
        "## Price",
        f"A coupled cycle takes {coupled:.3f} core-seconds, a point (one amplitude, three beds, {CYCLES} cycles) "
        f"{3 * CYCLES * coupled:.0f}; a point of the prediction took {float(price.sum('seed').mean()):.0f} at its 2 % "
        "per case.  But the prediction serves every structure, and a coupled run one amplitude of one structure, "
        "found by choosing its force.  A single release gives damping and frequency at all amplitudes on the way down "
        f"({float(runs['cpu_time'].where(runs['kind'] == 'released').mean()):.0f} core-seconds), of a bed that does "
        "not have the time to become steady at any of them: the dots in the picture.",
    )
    _picture(runs, forced, at, inherent)


def _mean(values) -> tuple[float, float]:
    return float(values.mean()), float(values.std(ddof=1)) / math.sqrt(values.size)


def _picture(runs, forced, at, inherent) -> None:
    figure, (left, right) = panels(2, (10, 4))
    grid = np.linspace(at["paper"].x[0], at["paper"].x[-1], 300)
    curves = (
        (left, "corrected", "damping ratio [-]", "error"),
        (right, "frequency", "natural frequency [Hz]", "frequency_error"),
    )
    for ax, key, name, error in curves:
        middle, width = at[key](grid), at[error](grid)
        ax.fill_between(grid, middle - width, middle + width, alpha=0.25)
        ax.plot(grid, middle, label="prescribed motion, mass as felt")
        ax.set(xlabel="Γ", ylabel=name)
    left.plot(grid, at["paper"](grid), "--", label="the paper's")
    released_runs = runs.where(runs["kind"] == "released", drop=True)
    windows = forced.isel(window=slice(CYCLES // WINDOW // 2, None)).mean("window")
    for ax, name, less in ((left, "damping_ratio", inherent), (right, "natural_frequency", 0.0)):
        ax.plot(
            released_runs["gamma"].values.ravel(),
            released_runs[name].values.ravel() - less,
            ".",
            ms=2,
            alpha=0.5,
            label="released",
        )
        ax.plot(windows["gamma"], windows[name] - less, "ko", ms=4, mfc="none", label="held by a force")
    for ax in (left, right):
        ax.set_xlim(0, 1.1 * at["paper"].x[-1])
    left.set_ylim(0, 0.035)
    right.set_ylim(39.0, 41.0)
    left.legend(fontsize=8)
    figure.savefig(DOCS / "coupling.png")


if __name__ == "__main__":
    if "simulate" in sys.argv[1:]:
        simulate()
    document()
