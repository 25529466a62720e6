"""Coupled runs from a configuration: forces, what is read off the records, and what is refused."""

import math
import re
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from scipy.signal import lsim
from typer.testing import CliRunner

from warpdamp import ConfigError, fits, load
from warpdamp.cli.app import app
from warpdamp.config.coupled import RandomConfig, SweptConfig
from warpdamp.coupled import forces
from warpdamp.coupled.response import averaged
from warpdamp.coupled.run import planned, simulate
from warpdamp.errors import ModalError
from warpdamp.execution.executors import InProcess
from warpdamp.report.coupled_verdicts import coupled_verdicts
from warpdamp.study.explain import explain

HEAVY = """
structure:
  modes_given: [{frequency: 40 Hz, modal_mass: 40 kg, damping: 1 %}]
  particles_included: false
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 8, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: 1}
preparation: loose
"""
"""8 particles of 1.6 g together on 40 kg: they shift the frequency by 2e-5 of itself and take about as much."""


def test_a_swept_sine_and_noise_are_what_they_say():
    sweep, step = forces.swept(SweptConfig(amplitude=2.0, from_=10.0, to=20.0), 3.0)
    time = np.arange(len(sweep)) * step
    np.testing.assert_allclose(sweep, 2 * np.sin(2 * np.pi * (10 * time + 10 / 3 * time**2 / 2)), atol=1e-9)
    assert time[-1] == pytest.approx(3.0)
    config = RandomConfig(rms=0.5, from_=10.0, to=20.0, seed=3)
    noise, step = forces.random(config, 3.0)
    assert np.sqrt(np.mean(noise**2)) == pytest.approx(0.5)
    power = np.abs(np.fft.rfft(noise)) ** 2
    lines = np.fft.rfftfreq(len(noise), step)
    assert power[(lines < 9.9) | (lines > 20.1)].sum() < 1e-12 * power.sum()
    assert (forces.random(config, 3.0)[0] == noise).all()
    with pytest.raises(ValueError, match="run it longer"):
        forces.random(RandomConfig(rms=0.5, from_=10.1, to=10.2), 0.1)


def test_the_accelerance_of_a_linear_oscillator():
    """Within 2 % of the closed form near its peak, from one sweep without a window and from noise in pieces of 20 s.

    The half-power band is 2 Hz wide: a window of 20 s resolves it to 5 %, whose bias on the peak is about 0.3 %.
    """
    w, zeta, phi = 2 * math.pi * 40, 0.025, 1.7
    step = 1 / (32 * 60)
    time = np.arange(round(160 / step)) * step
    system = ([[0, 1], [-(w**2), -2 * zeta * w]], [[0], [phi]], [[phi, 0]], [[0]])
    swept, own = forces.swept(SweptConfig(amplitude=1.0, from_=20.0, to=60.0), time[-1])
    noise, other = forces.random(RandomConfig(rms=1.0, from_=10.0, to=60.0), time[-1])
    blow = np.where(time < 0.008, np.sin(np.pi * time / 0.008), 0.0)
    for samples, sample_step, pieces in ((swept, own, 1), (noise, other, 15), (blow, step, 1)):
        force = np.interp(time, np.arange(len(samples)) * sample_step, samples)
        frequency, found = averaged([(force, lsim(system, force, time)[1])], step, pieces)
        near = (frequency > 38) & (frequency < 42)
        s = 2j * np.pi * frequency[near]
        exact = phi**2 * s**2 / (s**2 + 2 * zeta * w * s + w**2)
        np.testing.assert_allclose(found[near], exact, atol=0.02 * np.abs(exact).max())


@pytest.mark.parametrize("source", ["harmonic: {amplitude: 2 N, frequency: 40 Hz}", "release: {gamma: 0.3, mode: 1}"])
def test_a_structure_that_hardly_feels_its_damper_keeps_its_mode(write, source):
    """Frequency to 1e-4 and damping to 1 % of itself: 1.6 g on 40 kg, and a force that takes 2 s to settle."""
    config = load(write(HEAVY + f"coupled: {{duration: 4 s, {source}}}\n"))
    runs = simulate(config, InProcess())
    late = runs.isel(level=0, seed=0, window=slice(8, 60)).dropna("window")
    np.testing.assert_allclose(late["window_frequency"], 40.0, rtol=1e-4)
    np.testing.assert_allclose(late["window_damping_ratio"], 0.01, rtol=1e-2)
    assert float(runs["closure"].max()) < 5e-3


def test_a_force_far_above_the_mode_and_what_is_read_while_it_settles(write):
    """Transient windows have no equivalent mode or another one: they are there, and said not to be steady."""
    config = load(write(HEAVY + "coupled: {duration: 3 s, harmonic: {amplitude: 2 N, frequency: 120 Hz}}\n"))
    runs = simulate(config, InProcess()).isel(level=0, seed=0)
    assert runs.sizes["window"] == 36  # of 10 cycles each, the last included
    steady = runs["window_steady"] == 1
    assert not steady[0]
    assert steady[-5:].all()
    np.testing.assert_allclose(runs["window_frequency"][-5:], 40.0, rtol=5e-3)


def test_the_direction_is_the_excitations(write):
    """Across the axis of the damper, whatever the structure calls its own direction."""
    text = HEAVY.replace("excitation: {gamma: 1}", "excitation: {gamma: 1, direction: lateral}")
    runs, _ = planned(load(write(text + "coupled: {duration: 1 s, release: {gamma: 1, mode: 1}}\n")))
    assert runs[0, 0].host.direction == (1.0, 0.0, 0.0)


def test_a_recorded_blow_is_heard_in_the_frf(write, tmp_path):
    """A half sine of 8 ms: the peak of the accelerance within 1 % of phi^2 / (2 zeta), at 40 Hz."""
    time = np.arange(0, 4.0, 5e-4)
    rows = "".join(f"{t:.4f},{80 * max(0.0, math.sin(math.pi * t / 8e-3)) * (t < 8e-3):.5f}\n" for t in time)
    (tmp_path / "blow.csv").write_text("time_s,force_N\n" + rows)
    runs = simulate(load(write(HEAVY + "coupled: {duration: 8 s, recorded: {file: blow.csv}}\n")), InProcess())
    size = np.hypot(runs["accelerance_real"], runs["accelerance_imaginary"])
    assert float(size.idxmax()) == pytest.approx(40, abs=0.13)
    assert float(size.max()) == pytest.approx(1 / 40 / 0.02, rel=0.01)
    found = fits(runs, [40.0])
    assert float(found["fitted_damping_ratio"].sel(fit="dobson").isel(mode=0)) == pytest.approx(0.01, rel=0.05)


def test_levels_and_seeds_and_an_frf_to_fit(write, tmp_path):
    """Twice the force on a structure that stays linear: twice the motion, and the same FRF."""
    text = (
        HEAVY + "seeds: [1, 2]\ncoupled: {duration: 40 s, random: {rms: 1 N, from: 20 Hz, to: 60 Hz}, levels: [1, 2]}\n"
    )
    runs = simulate(load(write(text)), InProcess())
    assert dict(runs["reaction"].sizes) == {"level": 2, "seed": 2, "time": runs.sizes["time"]}
    first, second = (runs["structure_displacement"].isel(level=k, seed=0).values for k in (0, 1))
    np.testing.assert_allclose(second, 2 * first, atol=2e-3 * np.abs(second).max())
    assert (runs["applied_force"].isel(level=1) == 2 * runs["applied_force"].isel(level=0)).all()
    curves = runs["accelerance_real"] + 1j * runs["accelerance_imaginary"]
    np.testing.assert_allclose(curves.isel(level=1), curves.isel(level=0), atol=0.01 * float(np.abs(curves).max()))
    with pytest.raises(ModalError, match="several FRFs along level: choose one, as --at level=1"):
        fits(runs)
    assert np.isfinite(fits(runs.sel(level=2), [40.0])["fitted_frequency"]).any()


def test_the_command(write, tmp_path):
    config = write(HEAVY + "coupled: {duration: 3 s, swept: {amplitude: 1 N, from: 50 Hz, to: 30 Hz}}\n")
    done = subprocess.run(
        [sys.executable, "-m", "warpdamp", "coupled", str(config), "-o", str(tmp_path), "--workers", "1"],
        capture_output=True, text=True, timeout=200, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "closes to" in done.stdout
    path = tmp_path / f"{config.stem}-coupled.nc"
    assert path.with_suffix(".png").read_bytes()[:4] == b"\x89PNG"
    with xr.open_dataset(path) as runs:
        assert runs["accelerance_real"].dims == ("frequency",)
        assert "configuration" in runs.attrs


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("", "", r"coupled: missing: it says what moves"),
        ("", "coupled: {duration: 1 s}", r"give exactly one of harmonic, .* got none of them"),
        (
            "",
            "coupled: {duration: 1 s, release: {gamma: 1, mode: 1}, harmonic: {amplitude: 1 N, frequency: 40 Hz}}",
            "got harmonic and release",
        ),
        ("", "coupled: {duration: 1 s, release: {gamma: 1, mode: 3}}", "release.mode: there is no mode 3"),
        ("", "coupled: {duration: 1 s, recorded: {file: no.csv}}", "coupled.recorded: .*no.csv"),
        ("included: false", "included: true", "adds the particles itself"),
        ("friction: 0.5", "friction: [0.4, 0.5]", "run one combination at a time"),
        ("preparation: loose", "preparation: loose\naccuracy: fast", "accuracy: is for `warpdamp run`"),
        ("count: 8", "count: 30", "too many particles"),
        (
            "",
            "coupled: {duration: 0.1 s, harmonic: {amplitude: 1 N, frequency: 40 Hz}}",
            "at least 20 cycles of it",
        ),
        ("", "coupled: {duration: 1 s, swept: {amplitude: 1 N, form: 1 Hz, to: 2 Hz}}", "did you mean 'from'"),
    ],
)
def test_what_cannot_be_run_is_refused(write, old, new, message):
    text = HEAVY + (f"{new}\n" if not old else "coupled: {duration: 1 s, release: {gamma: 1, mode: 1}}\n")
    with pytest.raises(ConfigError, match=message):
        simulate(load(write(text.replace(old, new) if old else text)), InProcess())


def test_it_is_explained_or_said_why_not(write):
    text = explain(load(write(HEAVY + "coupled: {duration: 1 s, release: {gamma: 1, mode: 1}, levels: [1, 2]}\n")))
    assert "Coupled runs (warpdamp coupled)\n  runs: 2 (levels 2, seeds 1) of 1 s by release" in text
    assert "particle-steps; beds are extra" in text.splitlines()[-1]
    text = explain(load(write(HEAVY + "coupled: {duration: 1 s, recorded: {file: no.csv}}\n")))
    assert re.search(r"are refused: .*coupled.recorded: there is no file .*no.csv", text)
    base = "coupled: {duration: 1 s, base: {harmonic: {gamma: 1, frequency: 40 Hz}}}\n"
    assert "gives no participation" in explain(load(write(HEAVY + base)))
    assert "Coupled" not in explain(load(write(HEAVY)))


def test_what_went_in_and_came_out_is_said(write):
    """Of noise on a base: gRMS of both and the peak of the transmissibility; of a force in a band the accelerance's."""
    text = HEAVY.replace("damping: 1 %", "damping: 5 %, participation: 6 kg^0.5")
    noise = "coupled: {duration: 4 s, base: {random: {spectrum: [[20 Hz, 1e-4 g^2/Hz], [80 Hz, 1e-4 g^2/Hz]]}}}\n"
    runs = simulate(load(write(text + noise)), InProcess())
    first, last = coupled_verdicts(runs)
    assert first.startswith(f"level 1: {float(runs['base_grms'][0]):.3g} g rms in, ")
    assert re.search(r" g rms out; transmissibility at most \d+(\.\d+)?, at \d+(\.\d+)? Hz$", first)
    assert last.startswith("particles took ")
    force = "coupled: {duration: 4 s, random: {rms: 2 N, from: 20 Hz, to: 80 Hz}}\n"
    first, _ = coupled_verdicts(simulate(load(write(text + force)), InProcess()))
    assert re.match(r"level 1: 2 N rms in, .* g rms out; accelerance at most .* m s\^-2 N\^-1, at ", first)


def test_other_commands_say_what_the_file_is(write, tmp_path):
    runs = simulate(load(write(HEAVY + "coupled: {duration: 0.1 s, release: {gamma: 1, mode: 1}}\n")), InProcess())
    runs.to_netcdf(tmp_path / "coupled.nc")
    drawn = CliRunner().invoke(app, ["plot", str(tmp_path / "coupled.nc")])
    assert drawn.exit_code == 0, drawn.output
    assert (tmp_path / "coupled.png").read_bytes()[:4] == b"\x89PNG"
    for command, more in (("card", []), ("frf", []), ("compare", ["measured.csv"])):
        done = CliRunner().invoke(app, [command, str(tmp_path / "coupled.nc"), *more])
        assert done.exit_code == 2
        assert "coupled.nc: holds coupled runs, no study of prescribed motion: warpdamp plot draws them" in done.output
