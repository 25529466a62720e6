"""FRFs of known modes out of every kind of file: the modes are found, or one line says what is wrong and where."""

import numpy as np
import pytest
from typer.testing import CliRunner

from frf_files import (
    FREQUENCY,
    IN,
    INCH,
    MM,
    MODES,
    POUND,
    SI,
    G,
    accelerance,
    binary58,
    dataset,
    frf58,
    integrated,
    table,
    uff,
)
from warpdamp.cli.app import app
from warpdamp.errors import ModalError
from warpdamp.formats.frf_file import read_frf
from warpdamp.modal.identify import fits

A, Y, H = accelerance(), integrated(1), integrated(2)


def parts(values):
    return values.real, values.imag


def polar(values, scale=1.0):
    return abs(values) / scale, np.degrees(np.angle(values))


def decibels(values, reference=1.0):
    return 20 * np.log10(abs(values) / reference), np.degrees(np.angle(values))


def check(path, rtol=1e-6, **options):
    """The accelerance, and modes: frequency and damping, which no factor changes, and the constant, which shows it."""
    frf = read_frf(path, **options)
    np.testing.assert_allclose(frf["frequency"], FREQUENCY, rtol=max(1e-9, 0.02 * rtol))
    np.testing.assert_allclose(frf["accelerance_real"] + 1j * frf["accelerance_imaginary"], A, rtol=rtol)
    return frf


def test_the_modes_of_a_file_are_found(tmp_path):
    """Least squares has the model that wrote the file: what is left are its digits."""
    path = tmp_path / "frf.csv"
    path.write_bytes(table((FREQUENCY, *parts(A)), "f,re,im"))
    found = fits(check(path)).sel(fit="least squares")
    for name, expected in zip(("frequency", "damping_ratio", "modal_constant"), zip(*MODES, strict=True), strict=True):
        np.testing.assert_allclose(found[f"fitted_{name}"], expected, rtol=1e-6)
    assert found["fitted_quality"].values == pytest.approx(1)


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        ("", (FREQUENCY, *parts(A))),
        ("Frequency [Hz],Magnitude [m/s2/N],Phase [deg]", (FREQUENCY, *polar(A))),
        ("Frequency [Hz],Magnitude [dB],Phase [deg]", (FREQUENCY, *decibels(A))),
        ("Frequency [Hz],Magnitude [dB re 1e-6 (m/s^2)/N],Phase [deg]", (FREQUENCY, *decibels(A, 1e-6))),
        ("Frequency (Hz),Accelerance (dB re 1 g/N),Phase (rad)", None),
        ("Frequenz [kHz],Realteil [g/N],Imaginärteil [g/N]", (FREQUENCY / 1e3, *parts(A / G))),
        ("omega [rad/s],Re(H) [mm/N],Im(H) [mm/N]", (2 * np.pi * FREQUENCY, *parts(1e3 * H))),
        ("omega,receptance_real,receptance_imag", (2 * np.pi * FREQUENCY, *parts(H))),
        ("frequency_Hz,mobility_re,mobility_im", (FREQUENCY, *parts(Y))),
        ("f / Hz,|Y| / (mm/s)/N,phase / deg", (FREQUENCY, *polar(1e3 * Y))),
        ("freq_Hz,mag_dB,phase_deg", (FREQUENCY, *decibels(A))),
        ("freq [rpm],inertance real [in/s^2/lbf],inertance imag", (60 * FREQUENCY, *parts(A * POUND / INCH))),
        ("Phase [rad],Amplitude [1/kg],Frequency [Hz]", (np.angle(A), abs(A), FREQUENCY)),
        ("Frequency [Hz],Real [G/LBF],Imaginary [g/lb]", (FREQUENCY, *parts(A * POUND / G))),
        ("fréquence [Hz],réel [µm/N],imaginaire [µm/N]", (FREQUENCY, *parts(1e6 * H))),
        ("Frequency,Real,Imaginary\nHz,(m/s)/N,(m/s)/N", (FREQUENCY, *parts(Y))),
        ("# omega [rad/s], re, im", (2 * np.pi * FREQUENCY, *parts(A))),
    ],
)  # fmt: skip
def test_columns_count_by_their_names_and_units(tmp_path, head, columns):
    """12 digits are written; 1e-6: what frequencies of 12 digits cost beside a resonance of 1 %."""
    if columns is None:
        columns = (FREQUENCY, 20 * np.log10(abs(A) / G), np.angle(A))
        head = head.replace("Accelerance", "Accelerance magnitude")
    path = tmp_path / "frf.csv"
    path.write_bytes(table(columns, head))
    check(path)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize(("mark", "decimal", "name"), [(",", ".", "FRF.CSV"), (";", ",", "frf.csv"), ("\t", ",", "frf.txt"), (" ", ".", "f.TSV")])  # fmt: skip
def test_encodings_separators_and_decimal_marks(tmp_path, encoding, mark, decimal, name):
    path = tmp_path / name
    head = mark.join(["Frequenz[Hz]", "Re[(m/s²)/N]", "Im[(m/s²)/N]"])
    path.write_bytes(table((FREQUENCY, *parts(A)), head, mark=mark, decimal=decimal, encoding=encoding, end="\r\n"))
    check(path)


def test_what_a_table_does_not_say_is_an_option(tmp_path):
    path = tmp_path / "frf.csv"
    path.write_bytes(table((FREQUENCY, *parts(1e3 * Y)), "f,re,im"))
    frf = check(path, ordinate="mobility", units="mm/s/N")
    assert frf.attrs["read_as"] == "mobility in mm/s/N"


def test_lines_are_sorted_and_0_hz_is_left_out(tmp_path):
    path = tmp_path / "frf.csv"
    columns = [np.append(column, 0)[::-1] for column in (FREQUENCY, *parts(A))]
    path.write_bytes(table(columns, "f,re,im"))
    assert "0 Hz is left out" in check(path).attrs["read_as"]


LINE = "20,1,2\n21,3,4\n"


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("f,re,im\n" + LINE + "22,1\n", {}, r":4: 2 cells"),
        ("f,re,im\n", {}, "holds no rows of numbers"),
        ("f,re,im\n20,1,2\n21,x,2\n", {}, r":3: re: 'x' is no number"),
        ("f,re,im\n20,1,2\n21,nan,2\n", {}, r":3: .*not finite"),
        ("f,re,im\n20,1,2\n-21,1,2\n", {}, r":3: a frequency of -21 Hz is negative: leave such lines out: .* as it is$"),
        ("f,re,im\n20,1,2\n20,1,2\n", {}, r":3: 20 Hz was given before, at .*:2: keep one"),
        ("f,re,im\n0,1,2\n", {}, r":2: there is no value above 0 Hz"),
        ("20,1,2,3\n21,1,2,3\n", {}, r":1: 4 columns without names"),
        ("f,magnitude\n20,1\n21,2\n", {}, r":1: an FRF has .*there are frequency, magnitude"),
        ("f,re,im,coherence\n20,1,2,1\n21,1,2,1\n", {}, r":1: column 'coherence': is no part of an FRF: leave it out"),
        ("f,re,im,re\n20,1,2,1\n21,1,2,1\n", {}, r":1: column 're': is a second real part"),
        ("time [s],re,im\n" + LINE, {}, r":1: column 'time \[s\]': is no part"),
        ("f,x,y1\n" + LINE, {}, r":1: column 'x': is no part"),
        ("f [1/s],re,im\n" + LINE, {}, r"column 'f \[1/s\]': '1/s' is no unit of frequency: write Hz, kHz, rad/s"),
        ("omega [Hz],re,im\n" + LINE, {}, r"rad/s by its name and Hz by its unit"),
        ("f,mag,phase\n" + LINE, {}, r"column 'phase': say whether it is in deg or rad"),
        ("f,re [dB],im\n" + LINE, {}, "only a magnitude can be in dB"),
        ("f,re [N/m],im\n" + LINE, {}, "that of a dynamic stiffness: export response over force"),
        ("f,re [kg],im [kg]\n" + LINE, {}, "that of an apparent mass"),
        ("f,re [m/s^2],im\n" + LINE, {}, "is no response over force"),
        ("f,re [Mm/N],im\n" + LINE, {}, r"column 're \[Mm/N\]': cannot read the unit 'Mm/N'"),
        ("f,re [furlong/N],im\n" + LINE, {}, "cannot read the unit 'furlong/N'"),
        ("f,mobility re [m/N],im\n" + LINE, {}, "says mobility, but .* says receptance: mend one"),
        ("f,re [mm/N],im [g/N]\n" + LINE, {}, "says receptance, but .* says accelerance"),
        ("f,re [g/N],im\n" + LINE, {"units": "m/s^2/N"}, "says g/N, but the option units says m/s"),
        ("f,re [g/N],im\n" + LINE, {"ordinate": "mobility"}, "option ordinate says mobility, but .* says accelerance: mend one"),
        ("f,re,im\n" + LINE, {"ordinate": "inertia"}, "'inertia': is none of accelerance, mobility, receptance"),
        ("f,re,im\n" + LINE, {"units": "foo/N"}, "the option units: cannot read the unit"),
        ("f,re,im\n" + LINE, {"response": "1z"}, "in universal files only"),
        ("f,mag [dB],phase [deg]\n20,1e9,2\n21,1,2\n", {}, r":2: the value at 20 Hz is too large"),
        ("f,re,im\n1e200,1,2\n21,1,2\n", {}, r":2: a frequency of 1e\+200 Hz is no frequency"),
        ("Beam test 4\nf,re,im\n" + LINE, {}, r":1: 'Beam test 4' is neither names nor units"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_table_is_said_at_its_line(tmp_path, text, options, message):
    path = tmp_path / "frf.csv"
    path.write_text(text)
    with pytest.raises(ModalError, match=message) as caught:
        read_frf(path, **options)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value) or "option" in str(caught.value) or "ordinate" in str(caught.value)


@pytest.mark.parametrize(
    ("sets", "options"),
    [
        ([frf58(A)], {}),
        ([frf58(Y, numerator=(11, "m/s"))], {}),
        ([frf58(H, numerator=(8, "m"))], {}),
        ([frf58(A / G, numerator=(12, "g"))], {}),
        ([frf58(A * POUND / G, numerator=(12, "g"), denominator=(13, "lbf"))], {}),
        ([frf58(1e3 * H, numerator=(8, "mm/N"), denominator=(13, ""))], {}),
        ([frf58(A, numerator=(12, ""), denominator=(13, ""))], {}),
        ([SI, frf58(A, numerator=(12, ""), denominator=(13, ""))], {}),
        ([MM, frf58(A, numerator=(12, ""), denominator=(13, ""))], {}),
        ([MM, frf58(A, numerator=(12, "mm/s^2"), denominator=(13, "mN"))], {}),
        ([IN, frf58(A * POUND / INCH, numerator=(12, ""), denominator=(13, ""))], {}),
        ([IN, frf58(Y * POUND / INCH, numerator=(11, "in/s"), denominator=(13, ""))], {}),
        ([frf58(A, numerator=(1, "m/s^2"))], {}),
        ([frf58(A, numerator=(1, ""), denominator=(1, ""), exponents=((1, 0, 0), (0, 1, 0)))], {"ordinate": "accelerance"}),
        ([frf58(1e3 * Y, numerator=(1, ""), denominator=(0, ""))], {"units": "mm/s/N"}),
        ([SI, frf58(A / G, numerator=(12, "g"))], {"units": "g/N"}),
        ([frf58(A, kind=0)], {"ordinate": "accelerance"}),
        ([frf58(A, abscissa=(18, ""))], {}),
        ([frf58(A, FREQUENCY * 2 * np.pi, abscissa=(18, "rad/s"), even=False)], {}),
        ([frf58(A, FREQUENCY * 60, abscissa=(19, ""), even=False)], {}),
        ([frf58(A, even=False)], {}),
        ([frf58(A, data_type=6)], {}),
        ([frf58(A, data_type=6, even=False)], {}),
        ([frf58(A), frf58(np.ones(len(A)), kind=6, data_type=2), frf58(A, kind=9)], {}),
        ([frf58(A, response=(2, -3)), frf58(7 * A, response=(12, 3)), frf58(7 * A, response=(2, 3), reference=(3, 3))], {"response": "2-z"}),
        ([frf58(A), frf58(7 * A, response=(12, 3)), frf58(7 * A, reference=(3, 3))], {"response": 2, "reference": "1z"}),
        ([frf58(7 * A), frf58(A), frf58(7 * A)], {"number": 2}),
    ],
)  # fmt: skip
def test_universal_files(tmp_path, sets, options):
    """1e-4: E13.5 keeps six digits, of the abscissa too, and a resonance of 1 % magnifies them fiftyfold."""
    path = tmp_path / "frf.UNV"
    path.write_bytes(uff(*sets))
    check(path, rtol=4e-4, **options)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize(("data_type", "even"), [(5, True), (5, False), (6, True), (6, False)])
def test_binary_universal_files(tmp_path, order, data_type, even):
    path = tmp_path / "frf.uf"
    path.write_bytes(uff(SI) + binary58(A, order=order, data_type=data_type, even=even))
    check(path, rtol=4e-4)


@pytest.mark.parametrize("change", [("e+", "D+"), ("e-", "D-"), ("\n", "\r\n")])
def test_universal_files_of_old_programs(tmp_path, change):
    path = tmp_path / "frf.uff"
    path.write_bytes(uff(frf58(A)).decode().replace(*change).encode())
    check(path, rtol=4e-4)


def test_zeros_that_fill_the_last_line_are_no_values(tmp_path):
    lines = frf58(A[:-1], FREQUENCY[:-1])
    lines[-2] += f"{0:13.5e}{0:13.5e}"
    path = tmp_path / "frf.uff"
    path.write_bytes(uff(lines))
    np.testing.assert_allclose(read_frf(path)["frequency"], FREQUENCY[:-1], rtol=1e-6)


def test_every_frf_of_a_file(tmp_path):
    path = tmp_path / "frf.uff"
    path.write_bytes(uff(frf58(A), frf58(2 * A, response=(3, 3)), frf58(3 * A, response=(3, 3))))
    frf = read_frf(path, every=True)
    assert frf["frf"].values.tolist() == ["2z/1z", "3z/1z #2", "3z/1z #3"]
    found = fits(frf).sel(fit="least squares")
    np.testing.assert_allclose(found["fitted_modal_constant"], np.outer([2.5, 1], [1, 2, 3]), rtol=1e-4)
    assert read_frf(path, response="3", every=True).sizes["frf"] == 2


FEW = FREQUENCY[:6]


def few(**options):
    return frf58(A[:6], FEW, **options)


@pytest.mark.parametrize(
    ("content", "options", "message"),
    [
        (uff(few(), few(response=(3, 3))), {}, r"2 FRFs \(response/reference\) are meant: 2z/1z; 3z/1z: choose one by response"),
        (uff(few()), {"response": "3z"}, r"none of its FRFs is the one asked for; there are 1: FRF 2z/1z"),
        (uff(few()), {"response": "north"}, "response 'north': write a node and its direction, as 2z"),
        (uff(few()), {"number": 2}, "none of its FRFs is the one asked for"),
        (uff(SI, few(kind=6), few(kind=9)), {}, r"holds no FRF .*only 1 x coherence, 1 x power spectral density, 1 x dataset 164"),
        (uff(few(kind=0)), {}, "only 1 x general or unknown function"),
        (uff(few(numerator=(13, "N"), denominator=(12, "m/s^2"))), {}, r":2: function 1: FRF 2z/1z: is force over acceleration: export"),
        (uff(few(denominator=(12, "m/s^2"))), {}, "is acceleration over acceleration"),
        (uff(few(numerator=(15, "Pa"))), {}, "is pressure over force"),
        (uff(few(numerator=(77, ""))), {}, "is a quantity of type 77 over force"),
        (uff(few(numerator=(12, "m/s"))), {}, "its data type says accelerance, but its unit m/s / N says mobility"),
        (uff(few(numerator=(12, "smoots"))), {}, "cannot read the unit"),
        (uff(few(denominator=(13, "m"))), {}, "'m' is no unit of force"),
        (uff(few(numerator=(1, ""))), {}, "does not say what its response is: give the option ordinate"),
        (uff(few(numerator=(12, ""), denominator=(0, ""))), {}, "does not say what its response is divided by"),
        (uff(few(numerator=(1, ""), exponents=((0, 1, 0), (0, 0, 0)))), {"ordinate": "accelerance"}, r"exponents \(0, 1, 0\)"),
        (uff(few()), {"ordinate": "mobility"}, "says accelerance, but the option ordinate says mobility"),
        (uff(few()), {"units": "g/N"}, "the file says its units, m/s.*, and the option says g/N"),
        (uff(IN, few()), {}, "its units are m/s.2 / N, but dataset 164 has others: give the option units"),
        (uff(few(abscissa=(17, "s"))), {}, "is over time, not over frequency"),
        (uff(few(abscissa=(18, "orders"))), {}, "'orders' is no unit of frequency"),
        (uff(few(response=(2, 5))), {}, "a rotation: only translations are read"),
        (uff(few(data_type=2)), {}, "its values are real"),
        (uff(few(data_type=5)[:-2] + ["    -1"]), {}, "has 3 values where it says 6|has 4 values where it says 6"),
        (uff([*few()[:-2], "  1.0 abc", "    -1"]), {}, r":\d+: dataset 58: expected numbers, got '1.0 abc'"),
        (uff([line.replace("         5         6         1", "         7         6         1") for line in few()]), {}, "there is no such form"),
        (uff(few()[:-1]), {}, "does not end"),
        (binary58(A[:6], FEW)[:-20], {}, "does not end after its 48 bytes"),
        (binary58(A[:6], FEW).replace(b"b     1     2", b"b     1     3"), {}, "format 3: expected"),
        (uff(frf58(A[:6], FEW, even=False))[:0] + uff(frf58(A[:3], np.array([20, 20, 21.0]), even=False)), {}, "20 Hz was given before, at .*value 1"),
        (uff(dataset(2411, "         1         1         1         1")), {}, "only 1 x dataset 2411"),
        (b"nothing", {}, "is no universal file"),
        (b"", {}, "is no universal file"),
    ],
)  # fmt: skip
def test_what_a_universal_file_says_is_applied_or_refused(tmp_path, content, options, message):
    path = tmp_path / "frf.uff"
    path.write_bytes(content)
    with pytest.raises(ModalError, match=message) as caught:
        read_frf(path, **options)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "message"),
    [("frf.nc", "is no netCDF file"), ("frf.xlsx", r"ends in \.csv, .*\.nc"), ("none.csv", "no such file")],
)
def test_other_files(tmp_path, name, message):
    (tmp_path / "frf.nc").write_text("nothing")
    (tmp_path / "frf.xlsx").write_text("nothing")
    with pytest.raises(ModalError, match=message):
        read_frf(tmp_path / name)


def test_a_netcdf_file_in_other_units_is_refused(tmp_path):
    path = tmp_path / "frf.csv"
    path.write_bytes(table((FREQUENCY, *parts(A)), "f,re,im"))
    frf = read_frf(path)
    frf["frequency"].attrs["units"] = "rad/s"
    frf.to_netcdf(tmp_path / "frf.nc")
    with pytest.raises(ModalError, match="frequency is in rad/s: expected Hz"):
        read_frf(tmp_path / "frf.nc")


@pytest.mark.parametrize(
    ("options", "status", "words"),
    [
        ((), 2, "2 FRFs (response/reference) are meant: 2z/1z; 3z/1z"),
        (("--response", "3z"), 0, "accelerance in m/s^2 / N"),
        (("--response", "3z"), 0, "mode 1 39.15 to 39.9 Hz, 16 lines"),
        (("--number", "2", "--damping", "viscous"), 0, "viscous damping ratio"),
        (("--all",), 0, "3z/1z"),
        (("--all", "--damping", "dry"), 2, "damping 'dry': is none of structural, viscous"),
        (("--number", "1", "--ordinate", "mobility"), 2, "but the option ordinate says mobility"),
        (("--number", "1", "--units", "g/N"), 2, "and the option says g/N"),
        (("--number", "1", "--near", "-3"), 2, "near: expected frequencies above 0 Hz"),
    ],
)
def test_the_command(tmp_path, options, status, words):
    path = tmp_path / "frf.uff"
    path.write_bytes(uff(frf58(A), frf58(A, response=(3, 3))))
    done = CliRunner().invoke(app, ["fit", str(path), *options], env={"COLUMNS": "120"})
    assert done.exit_code == status, done.output
    assert words in " ".join(done.output.split()), done.output
