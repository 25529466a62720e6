"""Modes from Nastran's .f06 and .pch, against the exact modes of a lumped model, and what is refused."""

import numpy as np
import pytest

from nastran_files import MASS, POINTS, dmig, exact, f06, grid, lumped, pch
from warpdamp.errors import ModalError
from warpdamp.formats.mode_nastran import UNCHECKED, read_nastran
from warpdamp.formats.nastran_bulk import cards, geometry, real

SIX_DIGITS = 5e-6
CONSISTENT = MASS + 0.0002 * (np.eye(3, k=1) + np.eye(3, k=-1))


def six(vectors, axis=2):
    """(m, n, 6) shapes that move along one axis."""
    shapes = np.zeros((vectors.shape[1], len(vectors), 6))
    shapes[:, :, axis] = vectors.T
    return shapes


@pytest.fixture
def written(tmp_path):
    def write(text, name="run.f06", **beside):
        (tmp_path / name).write_text(text)
        for suffix, lines in beside.items():
            (tmp_path / f"run.{suffix}").write_text("\n".join(lines) + "\n")
        return tmp_path / name

    return write


def assert_exact(modes, mass=MASS, scale=1.0):
    """40 Hz or so; tonnes to kilograms is a factor of 1000, in phi of its root."""
    values, vectors = exact(mass)
    np.testing.assert_allclose(modes.frequency, np.sqrt(values) / (2 * np.pi), rtol=SIX_DIGITS)
    np.testing.assert_allclose(np.abs(modes.shape[:, :, 2]) * np.sqrt(1e3), np.abs(vectors.T), rtol=1e-5)
    np.testing.assert_allclose(modes.point, np.array([*POINTS.values()]) / 1e3)
    assert list(modes.label) == [*POINTS]


@pytest.mark.parametrize("scale", [1.0, 3.0], ids=["by mass", "by something else"])
def test_an_f06_with_its_echo(written, scale):
    """Generalised masses as they are printed; 1 where shapes are normalised by mass."""
    values, vectors = exact()
    text = f06(six(scale * vectors), values, [scale**2] * 3, echo=[*grid(), *lumped()])
    modes = read_nastran(written(text), units="MM-N")
    assert_exact(modes)
    assert modes.remark == ""


def test_the_table_after_augmentation_counts(written):
    """With residual vectors the table is printed twice, first without them."""
    values, vectors = exact()
    text = f06(six(vectors), values, [1.0] * 3, echo=[*grid(), *lumped()])
    title = " " * 46 + "R E A L   E I G E N V A L U E S"
    start, end = text.index(title), text.index("1\n      EIGENVALUE")
    table = text[start:end]
    before = table.replace(title, title + "\n" + " " * 40 + "(BEFORE AUGMENTATION OF RESIDUAL VECTORS)")
    assert_exact(read_nastran(written(text[:start] + before + "1\n" + text[start:]), units="MM-N"))


def test_an_f06_with_its_input_beside(written):
    values, vectors = exact()
    deck = ["SOL 103", "CEND", "METHOD = 1", "BEGIN BULK", *grid(), *lumped(), "ENDDATA"]
    assert_exact(read_nastran(written(f06(six(vectors), values, [1.0] * 3), bdf=deck), units="MM-N"))


def test_a_pch_with_a_mass_matrix(written):
    """Off its diagonal, too: consistent masses."""
    values, vectors = exact(CONSISTENT)
    text = pch(six(vectors), values, extra=dmig(CONSISTENT))
    modes = read_nastran(written(text, "run.pch", dat=grid()), units="MM-N", modal_mass=1000.0)  # of 1 t
    assert_exact(modes, CONSISTENT)


@pytest.mark.parametrize("reader", ["f06", "pch"])
@pytest.mark.parametrize("damage", ["value", "sign", "swapped"])
def test_damaged_shapes_are_caught(written, reader, damage):
    """One value 1 % too large, one sign turned, two modes mixed up."""
    values, vectors = exact(CONSISTENT)
    shapes = six(vectors)
    if damage == "value":
        shapes[1, 2, 2] *= 1.01
    elif damage == "sign":
        shapes[1, 2, 2] *= -1
    else:
        shapes[:, [0, 1]] = shapes[:, [1, 0]]
    if reader == "f06":
        file, own = written(f06(shapes, values, [1.0] * 3, echo=[*grid(), *dmig(CONSISTENT)])), {}
    else:
        file, own = written(pch(shapes, values, extra=dmig(CONSISTENT)), "run.pch", bdf=grid()), {"modal_mass": 1000.0}
    with pytest.raises(
        ModalError,
        match=r"run\.\w+: modes? .* the modal mass phi\^T M phi = .* is right: the shapes or the masses are damaged",
    ):
        read_nastran(file, units="MM-N", **own)


def test_masses_of_a_part_bound_the_whole(written):
    """With elements that may weigh something, lumped masses may find less than the generalised mass, never more."""
    values, vectors = exact()
    more = [*grid(), *lumped(), "CBAR           1       1      11      12     0.0     0.0     1.0"]
    assert_exact(read_nastran(written(f06(six(vectors), values, [1.0] * 3, echo=more)), units="MM-N"))
    shapes = six(vectors)
    shapes[1] *= 1.1
    with pytest.raises(ModalError, match=r"mode 2 has the modal mass phi\^T M phi = 1.21 where 1 is right"):
        read_nastran(written(f06(shapes, values, [1.0] * 3, echo=more)), units="MM-N")


def test_without_a_mass_matrix_it_is_said(written):
    values, vectors = exact()
    modes = read_nastran(written(f06(six(vectors), values, [1.0] * 3, echo=grid())), units="MM-N")
    assert modes.remark == UNCHECKED
    assert modes.pick([1]).remark == UNCHECKED


@pytest.mark.parametrize(
    ("card", "axis", "expected"),
    [
        (
            "CORD2R         7       0     0.0     0.0     0.0     1.0     0.0     0.0\n+            0.0     0.0     1.0",
            0,
            (0, 0, 2),
        ),
        ("CORD2C,7,0,0.,0.,-9.,0.,0.,1.,+\n+,1.,0.,-9.", 1, (0, 1, 1)),
        ("CORD2S  ,7,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.", 0, (1, 0, 0)),
    ],
    ids=["z along x", "cylinder", "sphere"],
)
def test_displacements_in_local_systems(written, card, axis, expected):
    """A system whose z is the global x; theta on a cylinder is y at points on x; r on a sphere is x there."""
    values, vectors = exact()
    shapes = six(vectors, {"CORD2R": 2, "CORD2C": 1, "CORD2S": 0}[card[:6]])
    points = {11: (100.0, 0, 0), 12: (300.0, 0, 0), 20: (600.0, 0, 0)}
    echo = [*grid(7, points=points), *lumped(), *card.split("\n")]
    modes = read_nastran(written(f06(shapes, values, [1.0] * 3, echo=echo)), units="MM-N")
    direction = {"CORD2R": 0, "CORD2C": 1, "CORD2S": 0}[card[:6]]
    np.testing.assert_allclose(np.abs(modes.shape[:, :, direction]) * np.sqrt(1e3), np.abs(vectors.T), rtol=1e-5)
    others = np.delete(modes.shape, direction, axis=2)
    assert np.abs(others).max() < 1e-9


def test_places_in_local_systems_and_fields_of_every_kind():
    """Small, large and free fields; a cylinder's point at r = 2, theta = 90 degrees is (0, 2, 0)."""
    lines = ["GRID*                  1               5            2.+0           9.D+1", "*                    0.0               0",
             "GRID,2,,1.5-1,0.,.5", "$ a comment", "CORD2C         5             0.0     0.0     0.0     0.0     0.0     1.0", "             1.0     0.0     0.0"]  # fmt: skip
    bulk = geometry("run.bdf", cards("run.bdf", list(enumerate(lines, 1))))
    np.testing.assert_allclose(bulk.point, [[0, 2, 0], [0.15, 0, 0.5]], atol=1e-12)
    assert [real(text) for text in ("1.5+3", "-1.5D-3", ".5", "7.")] == [1500.0, -0.0015, 0.5, 7.0]


GOOD = exact()


def good(**change):
    own = {"shapes": six(GOOD[1]), "eigenvalues": GOOD[0], "masses": [1.0] * 3, "echo": [*grid(), *lumped()]} | change
    return f06(own["shapes"], own["eigenvalues"], own["masses"], echo=own["echo"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (good(echo=()), r"run.f06 holds no coordinates: ask for ECHO = SORT in an .f06, or put the input file beside it as run.bdf"),
        (good(masses=[1.0, 0.0, 1.0]), r"run.f06: mode 2 without modal mass: give modal_mass"),
        (good(echo=grid()[:2]), r"run.f06: mode 1 moves grid point 20, which has no coordinates"),
        (good(echo=grid(7)), r"run.f06:4: GRID: grid point 11 uses coordinate system 7, which no CORD2R"),
        (good(echo=["INCLUDE 'mesh.bdf'", *grid()]), r"run.f06:4: INCLUDE is not read: write the bulk data out flat"),
        (good(echo=["GRDSET,,5", *grid()]), r"GRDSET is not read"),
        (good(echo=[*grid(), "GRID,99,,abc,0.,0."]), r"run.f06:7: GRID: field 4: 'abc' is no number"),
        (good(echo=[*grid(), "CORD2R,7,7,0.,0.,0.,0.,0.,1.", ",1.,0.,0."]), r"CORD2R: refers to coordinate system 7, which is not defined, or to itself"),
        (good().replace("R E A L   E I G E N V E C T O R", "C O M P L E X   E I G E N V E C T O R"), r"run.f06:\d+: complex eigenvectors: export real modes"),
        (good().replace("R E A L   E I G E N V A L U E S", "nothing"), r"eigenvector 1 is not in the table of real eigenvalues"),
        (good() + "0*** USER FATAL MESSAGE 9050 (SEKRRS)\n", r"run.f06:\d+: the run ended in an error: '0\*\*\* USER FATAL MESSAGE"),
        (good().replace("1.000000E+00", "1.000000E+01", 1), r"run.f06:\d+: mode 1: eigenvalue .* contradict each other"),
        ("hello\n", r"run.f06 holds no real eigenvectors: ask for DISPLACEMENT"),
    ],
)  # fmt: skip
def test_an_f06_that_cannot_be_used(written, text, message):
    with pytest.raises(ModalError, match=message) as caught:
        read_nastran(written(text), units="MM-N")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"output": "REAL-IMAGINARY OUTPUT"}, r"run.pch:5: complex eigenvectors"),
        ({"output": "MAGNITUDE-PHASE OUTPUT"}, r"run.pch:5: complex eigenvectors"),
        ({"output": "POINT ID =        11"}, r"run.pch:5: eigenvectors in SORT2: ask for SORT1"),
    ],
)
def test_a_pch_that_cannot_be_used(written, change, message):
    with pytest.raises(ModalError, match=message):
        read_nastran(
            written(pch(six(GOOD[1]), GOOD[0], **change), "run.pch", bdf=grid()), units="MM-N", modal_mass=1000.0
        )


def test_what_must_be_given(written):
    file = written(pch(six(GOOD[1]), GOOD[0]), "run.pch", bdf=[*grid(), *lumped()])
    with pytest.raises(ModalError, match="does not say its units, as no file of Nastran does: give units, one of SI"):
        read_nastran(file)
    with pytest.raises(ModalError, match="modes 1, 2, 3 without modal mass: give modal_mass"):
        read_nastran(file, units="MM-N")
    assert_exact(read_nastran(file, units="MM-N", modal_mass=1000.0))
    with pytest.raises(ModalError, match="modal_mass says them again"):
        read_nastran(written(good()), units="MM-N", modal_mass=1000.0)
