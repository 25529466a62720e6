"""One table in every dress that programs give it; what cannot be read is refused at its line."""

import re

import numpy as np
import pytest

from warpdamp.formats.text_table import Column, TableError, column, read_rows, read_table

COLUMNS = (Column("Frequenz", "Hz"), Column("Re", "(m/s²)/N"), Column("Im"))
VALUES = [[0.5, 2.0, -3.25], [1.5, 1e-3, 4.0]]
TEXT = "Frequenz [Hz],Re [(m/s²)/N],Im\n0.5,2,-3.25\n1.5,1e-3,4\n"


@pytest.fixture
def read(tmp_path):
    def reader(content, encoding="utf-8"):
        file = tmp_path / "table.csv"
        file.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        return read_table(file)

    return reader


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16", "utf-16-le", "utf-16-be", "utf-32"]
)  # fmt: skip
def test_encodings(read, encoding):
    table = read(TEXT, encoding)
    assert table.columns == COLUMNS
    assert table.values.tolist() == VALUES
    assert list(table.lines) == [2, 3]


@pytest.mark.parametrize(
    "text",
    [
        TEXT.replace(",", ";"),
        TEXT.replace(".", "|").replace(",", ";").replace("|", ","),
        TEXT.replace(",", "\t"),
        TEXT.replace(".", "|").replace(",", "\t").replace("|", ","),
        TEXT.replace(",", ", "),
        TEXT.replace("\n", "\r\n"),
        TEXT.replace("\n", "\r"),
        TEXT.replace("\n", ",\n"),
        TEXT.replace("1e-3", "1D-03"),
        TEXT.replace("-3.25", "\u22123.25\u00a0"),
        TEXT.replace("0.5,2,-3.25", '"0.5","2","-3.25"'),
        "sep=;\n" + TEXT.replace(",", ";"),
        "# of the beam\n\n" + TEXT,
        "# " + TEXT,
        "# Point;one two\n" + TEXT.replace(",", ";"),
        "Frequenz;Re;Im\nHz;(m/s²)/N;\n0.5;2;-3.25\n1.5;1e-3;4\n",
    ],
)
def test_separators_marks_and_headers(read, text):
    table = read(text)
    assert table.columns == COLUMNS
    assert table.values.tolist() == VALUES


def test_blanks_and_no_header(read):
    """Blanks around a decimal comma separate; a file may have no names, which its reader must then judge."""
    table = read("  0,5   2    -3,25\n 1,5 1e-3 4\n")
    assert table.columns == ()
    assert table.values.tolist() == VALUES


def test_what_is_neither_names_nor_units_is_refused(read):
    with pytest.raises(TableError, match=r":1: 'Export of Monday' is neither names nor units: begin remarks with #"):
        read("Export;of Monday\nSamples;2\n" + TEXT.replace(",", ";"))
    assert read("# Export;of Monday\n" + TEXT.replace(",", ";")).header_line == 2


@pytest.mark.parametrize(
    ("cell", "remedy"),
    [
        ("3,000.00", "has its thousands apart: write 3000.00"),
        ("3.000,00", "has its thousands apart: write 3000,00"),
        ("-1'234'567.8", "has its thousands apart: write -1234567.8"),
        ("1.0+2.0j", "is a complex number: write its real and its imaginary part into two columns"),
        ("(1e-3 - 2.5i)", "is a complex number"),
        ("12 N", "is no number: correct the cell"),
    ],
)
def test_cells_that_are_no_numbers_name_their_remedy(read, cell, remedy):
    with pytest.raises(TableError, match=f":3: im: .* {re.escape(remedy)}"):
        read(f"f;re;im\n1;2;3\n4;5;{cell}\n")


@pytest.mark.parametrize(
    ("head", "name", "unit"),
    [
        ("Frequency [Hz]", "Frequency", "Hz"), ("Frequency(Hz)", "Frequency", "Hz"), ("Frequency / Hz", "Frequency", "Hz"),
        ("H(f) [dB]", "H(f)", "dB"), ("A ((m/s²)/N)", "A", "(m/s²)/N"), ("Mass in kg", "Mass", "kg"), ("x_m", "x_m", ""),
    ],
)  # fmt: skip
def test_heads_of_columns(head, name, unit):
    assert column(head) == Column(name, unit)


def test_cells_with_text(tmp_path):
    """Tables of quantities: split at the separator that gives rows of one length."""
    (tmp_path / "sweep.csv").write_text('radius;contact\n3 mm;0,5\n"4 mm";0,6\n')
    rows = read_rows(tmp_path / "sweep.csv")
    assert [(row.line, row.cells) for row in rows] == [
        (1, ("radius", "contact")),
        (2, ("3 mm", "0,5")),
        (3, ("4 mm", "0,6")),
    ]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("f,re\n1,x\n", r"table.csv:2: re: 'x' is no number"),
        ("f,re\nx,1\n", r"table.csv:2: f: 'x' is no number"),
        ("f,re\n1,nan\n", r"table.csv:2: re: 'nan' is not finite"),
        ("f,re\n1,1_0\n", r"table.csv:2: re: '1_0' is no number"),
        ("f,re\n1,2\n1,2,3\n", r"table.csv:3: 3 cells where the rows above have 2"),
        ("f,re\n39,5,1,0\n", r"table.csv:1: 2 names for 4 columns: if the commas are decimal marks"),
        ("f;re\n1.5;2,5\n", r"table.csv:2: has decimal points and decimal commas"),
        ("f,re\n", r"table.csv: holds no rows of numbers"),
        ("", r"table.csv: holds no rows of numbers"),
        (b"f,re\n1,\x81\n", r"table.csv:2: is neither UTF-8, UTF-16 nor Windows-1252 text: save the file as UTF-8"),
        (b"CDF\x01\0\0\0\0", r"table.csv:1: is neither UTF-8, UTF-16 nor Windows-1252 text"),
    ],
)  # fmt: skip
def test_what_is_no_table(read, content, message):
    with pytest.raises(TableError, match=message):
        read(content)


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(TableError, match=r"there is no file .*none.csv"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(TableError, match=r"cannot be read: Is a directory"):
        read_table(tmp_path)


def test_values_are_finite_floats(read):
    assert read(TEXT).values.dtype == np.float64
