"""Base motion, spectra and records in coupled runs of a configuration; and what of them is refused."""

import math

import numpy as np
import pytest

from warpdamp import ConfigError, load
from warpdamp.config.coupled import BaseRandomConfig, RandomConfig
from warpdamp.config.spectra import SPECTRA
from warpdamp.coupled import forces, noise
from warpdamp.coupled.response import highest, transform
from warpdamp.coupled.run import simulate
from warpdamp.execution.executors import InProcess
from warpdamp.scene.host import Force
from warpdamp.scene.scene import STANDARD_GRAVITY

LIGHT = """
structure:
  modes_given: [{frequency: 39.4 Hz, modal_mass: 0.362 kg, damping: 1 %, participation: 0.5 kg^0.5}]
  particles_included: false
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 1, radius: 1 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.86}
excitation: {gamma: [1, 2]}
preparation: loose
"""
"""One particle of 4 mg on 0.36 kg: a hundred-thousandth."""
NATURAL, MASS, DAMPING, PARTICIPATION = 39.4, 0.362, 0.01, 0.5


def receptance(frequency):
    """Displacement over modal force of the mode."""
    w, natural = 2 * np.pi * np.asarray(frequency), 2 * math.pi * NATURAL
    return 1 / (natural**2 - w**2 + 2j * DAMPING * natural * w)


def write_record(path, column, values, step):
    rows = "".join(f"{k * step:.7f},{value:.8g}\n" for k, value in enumerate(values))
    path.write_text(f"time_s,{column}\n{rows}")


@pytest.mark.parametrize("length", [5e-4, 1e-3, 4e-3])
def test_a_blow_of_any_length_gives_the_accelerance(write, tmp_path, length):
    """Within 1 % of -w^2 / m / (w0^2 - w^2 + 2 j zeta w w0) on every line, and lines up to the end of its power."""
    time = np.arange(4000) * 5e-5
    write_record(tmp_path / "hammer.csv", "force_N", 50 * np.sin(np.pi * time / length) * (time < length), 5e-5)
    runs = simulate(load(write(LIGHT + "coupled: {duration: 4 s, recorded: {file: hammer.csv}}\n")), InProcess())
    found = (runs["accelerance_real"] + 1j * runs["accelerance_imaginary"]).values
    frequency = runs["frequency"].values
    exact = -((2 * np.pi * frequency) ** 2) / MASS * receptance(frequency)
    assert np.abs(found / exact - 1).max() < 0.01
    assert frequency[0] == pytest.approx(0.25, rel=1e-3)
    assert 2 / length < frequency[-1] < 4 / length


def test_a_record_that_goes_on_is_read_in_pieces(write, tmp_path):
    """Noise to the end of the run, on a base: the transmissibility under Hann windows, off the resonance."""
    samples, step = noise.samples([(5.0, 1.0), (100.0, 1.0)], 3, 16.0)
    write_record(tmp_path / "base.csv", "acceleration_m_s2", samples[::4], 4 * step)
    text = "coupled: {duration: 16 s, base: {recorded: {file: base.csv}}}\n"
    runs = simulate(load(write(LIGHT.replace("damping: 1 %", "damping: 5 %") + text)), InProcess())
    found = (runs["transmissibility_real"] + 1j * runs["transmissibility_imaginary"]).sel(frequency=slice(8, 90))
    w, natural = 2 * np.pi * found["frequency"].values, 2 * math.pi * NATURAL
    exact = 1 + PARTICIPATION * MASS**-0.5 * w**2 / (natural**2 - w**2 + 0.1j * natural * w)
    np.testing.assert_allclose(
        found.values, exact, atol=0.03 * np.abs(exact).max()
    )  # windows of 3.5 s in a band of 4 Hz


def test_a_structure_that_still_moves_gives_no_accelerance(write, tmp_path):
    write_record(tmp_path / "hammer.csv", "force_N", [0, 10, 10, 0], 1e-3)
    runs = simulate(load(write(LIGHT + "coupled: {duration: 0.5 s, recorded: {file: hammer.csv}}\n")), InProcess())
    assert "accelerance_real" not in runs
    assert "still moves by" in runs.attrs["left_out"]
    assert "take a longer coupled.duration" in runs.attrs["left_out"]


def test_the_transform_of_straight_lines_is_exact():
    """Against a fine quadrature, of a record that begins with a jump; and where it has its content."""
    samples = np.append(np.cos(np.pi * np.arange(100) / 200), 0.0)
    signal = Force(samples=samples, sample_step=1e-5)
    time = np.linspace(0, 1e-3, 100_001)
    value = np.interp(time, np.arange(101) * 1e-5, samples)
    exact = [np.trapezoid(value * np.exp(-2j * np.pi * 700 * k * time), time) for k in range(5)]
    np.testing.assert_allclose(transform(signal, 5, 700.0), exact, rtol=1e-8)
    half_sine = Force(samples=np.sin(np.pi * np.linspace(0, 1, 51)), sample_step=2e-5)
    assert highest(half_sine) == pytest.approx(3200, rel=0.05)  # |cos(pi f T) / (1 - (2 f T)^2)| last passes 2 %


@pytest.mark.parametrize("frequency", [20.0, 39.4, 60.0])
def test_a_mode_on_a_base_that_moves(write, frequency):
    """Steady: the mode that was given, and the absolute acceleration by its transmissibility; energies close."""
    text = f"coupled: {{duration: 4.5 s, base: {{harmonic: {{gamma: 0.05, frequency: {frequency} Hz}}}}}}\n"
    runs = simulate(load(write(LIGHT + text)), InProcess()).isel(level=0, seed=0)
    late = runs.isel(window=slice(-3, None))
    w = 2 * math.pi * frequency
    exact = abs(1 + PARTICIPATION * MASS**-0.5 * w**2 * receptance(frequency))
    np.testing.assert_allclose(late["window_gamma"], 0.05 * exact, rtol=2e-3)
    np.testing.assert_allclose(late["window_frequency"], NATURAL, rtol=1e-3)
    np.testing.assert_allclose(late["window_damping_ratio"], DAMPING, rtol=1e-2)
    assert float(runs["closure"]) < 2e-3
    assert float(runs["base_work"]) == pytest.approx(float(runs["structure_loss"]), rel=0.1)


def test_a_sweep_of_the_base_gives_the_transmissibility(write):
    """Within 2 % of its peak, from one sweep through the mode and back out of the band, without a window."""
    text = LIGHT.replace("damping: 1 %", "damping: 5 %")
    text += "coupled: {duration: 20 s, base: {swept: {gamma: 0.05, from: 20 Hz, to: 60 Hz}}}\n"
    runs = simulate(load(write(text)), InProcess())
    found = (runs["transmissibility_real"] + 1j * runs["transmissibility_imaginary"]).sel(frequency=slice(30, 50))
    w, natural = 2 * np.pi * found["frequency"].values, 2 * math.pi * NATURAL
    exact = 1 + PARTICIPATION * MASS**-0.5 * w**2 / (natural**2 - w**2 + 0.1j * natural * w)
    np.testing.assert_allclose(found.values, exact, atol=0.02 * np.abs(exact).max())


def test_energies_close_on_a_base_with_particles_that_matter(write):
    """A third of the structure's mass in particles, thrown about: work of the base against all losses."""
    text = LIGHT.replace("count: 1, radius: 1 mm", "count: 30, radius: 1.5 mm").replace("0.362 kg", "2 g")
    text = text.replace("0.5 kg^0.5", "0.04 kg^0.5")
    runs = simulate(
        load(write(text + "coupled: {duration: 0.6 s, base: {harmonic: {gamma: 0.7, frequency: 39.4 Hz}}}\n")),
        InProcess(),
    )
    assert runs["particle_loss"].item() > runs["structure_loss"].item()
    assert float(runs["closure"].max()) < 5e-3


def test_noise_of_a_spectrum_moves_the_base(write):
    """gRMS in by its table to 1e-3, out by Miles within two standard errors, 1 / (2 sqrt(pi zeta f T)) each."""
    table = "[[5 Hz, 0.001 g^2/Hz], [200 Hz, 0.001 g^2/Hz]]"
    text = f"coupled: {{duration: 20 s, base: {{random: {{spectrum: {table}}}}}, levels: [1, 2]}}\n"
    text = LIGHT.replace("damping: 1 %", "damping: 5 %").replace("0.5 kg^0.5", f"{MASS**0.5} kg^0.5") + text
    runs = simulate(load(write(text)), InProcess()).isel(seed=0)
    np.testing.assert_allclose(runs["base_grms_asked"], math.sqrt(0.195) * np.array([1, 2]), rtol=1e-9)
    np.testing.assert_allclose(runs["base_grms"], runs["base_grms_asked"], rtol=1e-3)
    miles = math.sqrt(math.pi / 2 * NATURAL * 10 * 0.001 * 1.01)
    error = 1 / (2 * math.sqrt(math.pi * 0.05 * NATURAL * 10))
    np.testing.assert_allclose(runs["response_grms"], miles * np.array([1, 2]), rtol=2 * error)


def test_spectra_by_name_and_by_table():
    """A name is its breakpoints; a slope of -3 dB an octave has a logarithm in its area; bare numbers are SI."""
    named = BaseRandomConfig(spectrum="NAVMAT P-9492").spectrum
    assert named[0] == (20.0, pytest.approx(0.01 * STANDARD_GRAVITY**2))
    for name, spectrum in SPECTRA.items():
        assert noise.rms(list(spectrum.breakpoints)) == pytest.approx(spectrum.rms, rel=0.01), name
    assert noise.rms([(10.0, 1.0), (100.0, 0.1)]) == pytest.approx(math.sqrt(10 * math.log(10)))
    assert noise.rms([(10.0, 1.0), (20.0, 4.0)]) == pytest.approx(math.sqrt(7000 / 300))  # int (f / 10)^2
    assert BaseRandomConfig(spectrum=[[1, 2.0], [2, "3 m^2/s^3"]]).spectrum == [(1.0, 2.0), (2.0, 3.0)]
    assert RandomConfig(spectrum=[[1, "4 N^2/Hz"], [2, 1]]).spectrum == [(1.0, 4.0), (2.0, 1.0)]


def test_noise_is_deterministic_and_has_its_density():
    table = [(10.0, 2.0), (40.0, 0.5)]
    first, step = noise.samples(table, 7, 4.0)
    assert (noise.samples(table, 7, 4.0)[0] == first).all()
    assert not (noise.samples(table, 8, 4.0)[0] == first).all()
    lines = np.abs(np.fft.rfft(first[:-1])) / (len(first) - 1)
    frequency = np.fft.rfftfreq(len(first) - 1, step)
    passed = lines * np.sinc(frequency * step) ** 2  # what straight lines leave of each
    np.testing.assert_allclose(2 * passed**2 * 4.0, noise.density(table, frequency), atol=1e-12)
    assert forces.root_mean_square(first) == pytest.approx(noise.rms(table), rel=0.01)


def test_the_general_minimum_integrity_exposure_has_the_area_that_its_standard_prints():
    """0.04 (1000 - 20) + 0.04 1000^2 (1/1000 - 1/2000) = 39.2 + 20 g^2: 7.69, printed 7.7; 6 dB an octave is 1 / f^2.

    A knee at 900 or 1100 Hz, or 3 dB an octave, would give 7.4, 7.9 and 8.2.
    """
    spectrum = SPECTRA["MIL-STD-810H general minimum integrity"]
    assert noise.rms(list(spectrum.breakpoints)) == pytest.approx(math.sqrt(59.2), rel=1e-3)  # -6 dB is 0.251
    assert round(math.sqrt(59.2), 1) == spectrum.rms == 7.7


@pytest.mark.parametrize(
    "written", ["0.04 g^2/Hz", "0.04 g2/Hz", "0.04 G²/Hz", "4e-2g**2 / Hz", "3.849444 (m/s^2)^2/Hz"]
)
def test_spellings_of_a_density(write, written):
    text = f"coupled: {{duration: 1 s, base: {{random: {{spectrum: [[20 Hz, {written}], [30 Hz, {written}]]}}}}}}\n"
    table = load(write(LIGHT + text)).coupled.base.random.spectrum
    assert [density for _, density in table] == pytest.approx([0.04 * STANDARD_GRAVITY**2] * 2, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "base: {harmonic: {gamma: 1, frequency: 40 Hz}, random: {spectrum: NAVMAT P-9492}}",
            "exactly one of harmonic",
        ),
        ("base: {}", "base: give exactly one of harmonic, swept, random and recorded; got none"),
        ("base: {random: {spectrum: NAVMAT P-9429}}", "no spectrum 'NAVMAT P-9429'; did you mean 'NAVMAT P-9492'"),
        (
            "base: {random: {spectrum: MIL-STD-810H}}",
            r"'MIL-STD-810H': .* 'MIL-STD-810H general minimum integrity' \(Category 24\) is held here: take it, or copy ano",
        ),
        ("base: {random: {spectrum: NAVMAT}}", r"no spectrum 'NAVMAT'; .* or give its breakpoints"),
        ("base: {random: {spectrum: [[20 Hz, 1 N^2/Hz], [30 Hz, 1 g^2/Hz]]}}", "has the wrong unit.* or in g\\^2/Hz$"),
        (
            "base: {random: {spectrum: [[20 Hz, 0.01], [80, '0.04']]}}",
            "0.01 without a unit is 0.01 m.2/s.3: write its unit, as '0.01 g.2/Hz', or '0.01 m.2/s.3' if that is meant",
        ),
        ("base: {random: {spectrum: [[30 Hz, 1 g^2/Hz], [20 Hz, 1 g^2/Hz]]}}", "in the order of their frequencies"),
        ("base: {random: {spectrum: [[30.01 Hz, 1 g^2/Hz], [30.02 Hz, 1 g^2/Hz]]}}", "run it longer"),
        (
            "base: {recorded: {file: force.csv}}",
            "columns must be time_s and acceleration_m_s2 or acceleration_g, got time_s, force_N",
        ),
        ("random: {spectrum: NAVMAT P-9492}", "is of no force"),
        ("random: {spectrum: [[20 Hz, 1], [30 Hz, 1]], rms: 1 N}", "spectrum: says all that rms would"),
        ("random: {rms: 1 N, from: 10 Hz}", "give rms, from and to, or a spectrum"),
        ("recorded: {file: force.csv}", "the record ends before the run does, at 50 % of its largest value"),
    ],
)
def test_what_is_refused(write, tmp_path, text, message):
    (tmp_path / "force.csv").write_text("time_s,force_N\n0,0\n0.1,2\n0.2,1\n")
    with pytest.raises(ConfigError, match=message):
        simulate(load(write(LIGHT + f"coupled: {{duration: 1 s, {text}}}\n")), InProcess())


def test_a_base_needs_participation(write):
    coupled = "coupled: {duration: 1 s, base: {harmonic: {gamma: 1, frequency: 40 Hz}}}\n"
    without = LIGHT.replace(", participation: 0.5 kg^0.5", "")
    with pytest.raises(ConfigError, match=r"coupled.base: structure.modes_given gives no participation .*, add|: add"):
        simulate(load(write(without + coupled)), InProcess())
    with pytest.raises(ConfigError, match="moves none of these modes"):
        simulate(load(write(LIGHT.replace("0.5 kg^0.5", "0 kg^0.5") + coupled)), InProcess())
    two = LIGHT.replace("modes_given: [", "modes_given: [{frequency: 10 Hz, modal_mass: 1 kg}, ")
    with pytest.raises(ConfigError, match="mode 1 has no participation, and others have one"):
        simulate(load(write(two + coupled)), InProcess())
