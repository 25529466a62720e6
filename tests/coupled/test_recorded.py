"""Records of forces and accelerations in tables of every form: the same samples, or one line that names the place."""

import numpy as np
import pytest

from warpdamp.coupled import recorded
from warpdamp.errors import UsageError

POUND, G = 4.4482216152605, 9.80665


@pytest.fixture
def read(tmp_path):
    def reader(text, quantity="force", encoding="utf-8"):
        (tmp_path / "record.csv").write_bytes(text.encode(encoding))
        return recorded.samples(tmp_path / "record.csv", quantity)

    return reader


def test_a_record_is_read_to_the_bit_and_followed_by_zero(read):
    samples, step = read("time_s, force_N\n0, 1.1\n0.1, 2\n0.2, -1\n")
    assert samples.tolist() == [1.1, 2, -1, 0]
    assert step == 0.1


@pytest.mark.parametrize(
    ("text", "quantity", "factor"),
    [
        ("time_s,force_N\n0,1\n0.1,2\n0.2,-1\n", "force", 1),
        ("force_N,time_s\n1,0\n2,0.1\n-1,0.2\n", "force", 1),
        ("time [s];force [N]\n0;1\n0,1;2\n0,2;-1\n", "force", 1),
        ("Time (ms)\tForce (lbf)\n0\t1\n100\t2\n200\t-1\n", "force", POUND),
        ("# hammer\ntime_ms,force_kN\n0,1\n100,2\n200,-1\n", "force", 1000),
        ("time,force\n[s],[N]\n0,1\n0.1,2\n0.2,-1\n", "force", 1),
        ("time_s,acceleration_m_s2\n0,1\n0.1,2\n0.2,-1\n", "acceleration", 1),
        ("time_s,acceleration_g\n0,1\n0.1,2\n0.2,-1\n", "acceleration", G),
        ("time_s,acceleration_mm_s2\n0,1\n0.1,2\n0.2,-1\n", "acceleration", 1e-3),
        ("time [s],acceleration [in/s^2]\n0,1\n0.1,2\n0.2,-1\n", "acceleration", 0.0254),
        ("time [s],acceleration [m s^-2]\n0,1\n0.1,2\n0.2,-1\n", "acceleration", 1),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32"])
def test_separators_decimal_commas_units_and_encodings(read, text, quantity, factor, encoding):
    samples, step = read(text, quantity, encoding)
    np.testing.assert_allclose(samples, factor * np.array([1, 2, -1, 0]), rtol=1e-14)
    assert step == pytest.approx(0.1, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t, f\n0, 1\n", r"record.csv:1: the columns must be time_s and force_N, got t, f$"),
        ("0, 1\n0.1, 2\n", r"record.csv:1: the columns must be time_s and force_N, got no names$"),
        ("time_s, force_N, mass_kg\n0, 1, 2\n", "got time_s, force_N, mass_kg"),
        ("time_s, acceleration_g\n0, 1\n", "got time_s, acceleration_g"),
        ("time_s, force_N\n0, 1\n0.1, x\n", r"record.csv:3: force_N: 'x' is no number: correct the cell"),
        ("time_s, force_N\n0, 1\n0.1, nan\n", r"record.csv:3: force_N: 'nan' is not finite"),
        ("time_s, force_N\n0, 1\n0.1\n", r"record.csv:3: 1 cells where the rows above have 2"),
        ("time_s, force_N\n0, 1\n0.1, 1\n0.3, 1\n", "evenly spaced: resample"),
        ("time_s, force_N\n0.1, 1\n0.2, 1\n", "must start at 0"),
        ("time_s, force_N\n0, 1\n", "at least two rows"),
        ("time_s, force_N\n0, 0\n1, 0\n", "the force is zero throughout"),
        ("time_s, force_N\n0, 1\n1, 1e200\n", r"has a number above 1e\+100: correct it"),
        ("time_s, force\n0, 1\n1, 1\n", "column force has no unit: write force_N, or its unit in brackets"),
        ("time_s, force [mm]\n0, 1\n1, 1\n", r"record.csv:1: column force \[mm\]: 'mm' is no unit of force"),
        ("time_min, force_N\n0, 1\n1, 1\n", r"record.csv:1: column time_min: 'min' is no unit of time"),
        ("time_s, force_N [kN]\n0, 1\n1, 1\n", r"column force_N \[kN\] says its unit twice"),
        (
            "Run 7, March, hit\ntime_s, force_N\n0, 1\n1, 1\n",
            "record.csv:1: 'Run 7, March, hit' is neither names nor units",
        ),
        ("", "holds no rows of numbers"),
    ],
)
def test_what_is_no_record_is_refused_in_one_line(read, text, message):
    with pytest.raises(UsageError, match=message) as caught:
        read(text)
    assert "\n" not in str(caught.value)


def test_a_unit_that_is_no_acceleration(read):
    with pytest.raises(UsageError, match="'m/s' is no unit of acceleration: write m/s\\^2 or g"):
        read("time_s, acceleration [m/s]\n0, 1\n1, 1\n", "acceleration")


def test_no_file(tmp_path):
    with pytest.raises(UsageError, match=r"there is no file .*none.csv"):
        recorded.samples(tmp_path / "none.csv", "force")


def test_a_unit_of_acceleration_that_is_none_has_the_remedy_of_records(read):
    with pytest.raises(
        UsageError, match=r"acceleration \[Gal\]: cannot read the unit 'Gal': write acceleration_m_s2 or"
    ):
        read("time_s,acceleration [Gal]\n0,1\n0.1,2\n", "acceleration", "utf-8")
