"""Modes from Ansys's result files, by the files that the reader's package brings: 321 nodes, six modes, no units."""

import shutil

import numpy as np
import pytest
from scipy.sparse import csr_matrix, triu

from warpdamp.errors import MissingLibrary, ModalError
from warpdamp.formats.mode_rst import UNCHECKED, read_rst

READER = "ansys.mapdl.reader"


@pytest.fixture
def result(tmp_path):
    pytest.importorskip(READER)
    from ansys.mapdl.reader import examples

    shutil.copy(examples.rstfile, tmp_path / "run.rst")
    return tmp_path / "run.rst"


@pytest.fixture
def mass_matrix(result, monkeypatch):
    """Puts a .full file beside, with the mass matrix M = V (V^T V)^-2 V^T, for which the shapes V are orthonormal."""
    from warpdamp.formats import mode_rst as rst

    label, _, _, shape = rst.results(result)
    freedom = np.array([(node, axis) for node in label for axis in range(3)])
    vectors = shape.reshape(len(shape), -1).T
    matrix = vectors @ np.linalg.matrix_power(np.linalg.inv(vectors.T @ vectors), 2) @ vectors.T
    monkeypatch.setattr(rst, "mass_matrix", lambda file: (freedom, triu(csr_matrix(matrix)).tocsr()))
    monkeypatch.setattr(rst, "apart", lambda function, file, library: function(file))
    result.with_suffix(".full").touch()


def test_modes_with_their_mass_matrix(result, mass_matrix):
    """Shapes normalised by mass, here in tonnes: modal masses of 1000 kg; the first frequency is the package's own."""
    modes = read_rst(result, units="MM-N")
    np.testing.assert_allclose(modes.frequency[0], 7366.49503969, rtol=1e-9)
    np.testing.assert_allclose(np.abs(modes.shape[0]).max(), 28.99190327125468 / np.sqrt(1e3), rtol=1e-6)
    assert modes.shape.shape == (6, 321, 3)
    assert modes.remark == ""


def test_damaged_shapes_are_caught(result, mass_matrix, monkeypatch):
    from warpdamp.formats import mode_rst as rst

    right = rst.results

    def damaged(file):
        label, point, frequency, shape = right(file)
        shape[2, :50] *= -1
        return label, point, frequency, shape

    monkeypatch.setattr(rst, "results", damaged)
    with pytest.raises(
        ModalError, match=r"run.rst: modes \d and \d have the modal mass phi\^T M phi = .* where 0 is right"
    ):
        read_rst(result, units="SI")


def test_a_mass_matrix_of_another_run_is_caught(result):
    """The package's .full file is that of a clamped beam, its .rst that of a free one."""
    from ansys.mapdl.reader import examples

    shutil.copy(examples.fullfile, result.with_suffix(".full"))
    with pytest.raises(ModalError, match=r"run.rst: modes \d and \d have the modal mass"):
        read_rst(result, units="SI")


def test_without_a_mass_matrix_the_modal_mass_must_be_given(result):
    with pytest.raises(
        ModalError, match=r"modes 1, 2, 3, 4, 5, 6 without modal mass: put the .full file of the run beside"
    ):
        read_rst(result, units="SI")
    assert read_rst(result, units="SI", modal_mass=1.0).remark == UNCHECKED
    with pytest.raises(ModalError, match="does not say its units: give units"):
        read_rst(result, modal_mass=1.0)


def test_what_is_no_result_file(tmp_path):
    pytest.importorskip(READER)
    with pytest.raises(ModalError, match="there is no file"):
        read_rst(tmp_path / "none.rst", units="SI")
    (tmp_path / "text.rst").write_text("A heading\n=========\n")
    with pytest.raises(ModalError, match=r"text.rst (is no file of Ansys that can be read|is damaged)"):
        read_rst(tmp_path / "text.rst", units="SI")


def test_a_reader_that_crashes_is_a_damaged_file(tmp_path, monkeypatch):
    """Its process ends; what it finds or raises otherwise comes back."""
    from warpdamp.formats.apart import apart

    functions = (
        "import os\n"
        "from warpdamp.errors import ModalError\n"
        "def crash(file): os.abort()\n"
        "def size(file): return file.stat().st_size\n"
        "def refuse(file): raise ModalError(f'{file.name} is nothing')\n"
    )
    (tmp_path / "some_reader.py").write_text(functions)
    monkeypatch.syspath_prepend(tmp_path)
    import some_reader

    file = tmp_path / "run.rst"
    file.write_text("123")
    assert apart(some_reader.size, file, "json") == 3
    with pytest.raises(
        ModalError, match=r"run.rst is damaged: its reader crashed or came to no end \(-6\): write it again"
    ):
        apart(some_reader.crash, file, "json")
    with pytest.raises(ModalError, match=r"run.rst is nothing"):
        apart(some_reader.refuse, file, "json")


def test_a_missing_reader_is_named_with_its_remedy(tmp_path, monkeypatch):
    import importlib.util

    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(
        MissingLibrary, match=r"result files of Ansys need ansys.mapdl.reader: pip install 'warpdamp\[ansys\]'"
    ):
        read_rst(tmp_path / "file.rst", units="SI")
