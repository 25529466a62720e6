"""What the reader of modes makes of every record that docs/universal-files.md names: used, transformed or refused."""

import numpy as np
import pytest

from universal_files import (
    binary_58b,
    dataset,
    integers,
    mode_55,
    mode_2414,
    nodes_15,
    reals,
    units,
)  # fmt: skip
from warpdamp.errors import ModalError
from warpdamp.formats.mode_uff import read_uff

FIVE_DIGITS = 2e-5
POINTS = [(0, 0, 0), (0.3, 0, 0)]
ALONG_Z = {1: (0, 0, 0), 2: (0, 0, 1)}
WRITERS = pytest.mark.parametrize("mode", [mode_55, mode_2414], ids=["55", "2414"])


# ---- complex shapes


@WRITERS
@pytest.mark.parametrize("storage", [5, 6])
def test_a_real_shape_stored_as_complex_numbers(read, mode, storage):
    """Node 2 moves along y only: 2 kg along y, still along z."""
    modes = read(nodes_15(POINTS), mode(1, {1: (0, 0, 0), 2: (0, 1, 0)}, storage=storage))
    np.testing.assert_allclose(modes.at_label(2, (0, 1, 0)).modal_mass, [2.0])
    assert modes.at_label(2, (0, 0, 1)).on_node.all()


@WRITERS
@pytest.mark.parametrize("phase", [0.3, np.pi / 2, 2.5, -1.0])
def test_a_shape_with_one_phase_is_turned(read, mode, phase):
    """The modal mass is that of the shape whatever its phase; the points keep their signs to each other."""
    shape = {1: np.exp(1j * phase) * np.array([0, 0, 1.0]), 2: np.exp(1j * phase) * np.array([0, 0, -0.5])}
    modes = read(nodes_15(POINTS), mode(1, shape, storage=5))
    np.testing.assert_allclose(modes.shape[0, :, 2] * np.sqrt(2), [1, -0.5], rtol=FIVE_DIGITS)


@WRITERS
def test_a_shape_of_many_phases_is_refused_with_its_collinearity(refused, mode):
    """Two points of equal size a quarter of a turn apart: |1 + i^2|^2 / 2^2 = 0; an eighth: |1 + i|^2 / 4 = 1/2."""
    for lag, said in ((np.pi / 4, r"collinearity is 0.5"), (np.pi / 8, r"collinearity is 0.854")):
        shape = {1: (0, 0, 1), 2: (0, 0, np.exp(1j * lag))}
        refused(
            rf"modes.uff:\d+: dataset \d+: mode 1 is complex: its modal phase {said}.*export real modes",
            nodes_15(POINTS),
            mode(1, shape, storage=5),
        )


@WRITERS
@pytest.mark.parametrize("conjugate", [False, True])
def test_complex_modes_of_a_proportionally_damped_structure(read, mode, conjugate):
    """lambda = w0 (-zeta + i sqrt(1 - zeta^2)); modal A = 2 i Im(lambda) m e^(2 i alpha) of a shape turned by alpha."""
    w0, zeta, mass, alpha = 2 * np.pi * 40, 0.02, 3.0, 0.7
    eigenvalue = w0 * (-zeta + 1j * np.sqrt(1 - zeta**2))
    modal_a = 2j * eigenvalue.imag * mass * np.exp(2j * alpha)
    shape = {1: np.exp(1j * alpha) * np.array([0, 0, 0.5]), 2: np.exp(1j * alpha) * np.array([0, 0, 1.0])}
    if conjugate:
        eigenvalue, modal_a = eigenvalue.conjugate(), modal_a.conjugate()
        shape = {node: np.conj(values) for node, values in shape.items()}
    own = {"storage": 5, "analysis": 3, "eigenvalue": eigenvalue, "modal_a": modal_a}
    modes = read(nodes_15(POINTS), mode(1, shape, **own)).at_label(2)
    np.testing.assert_allclose(modes.frequency, [40.0], rtol=FIVE_DIGITS)
    np.testing.assert_allclose(modes.inherent_damping, [zeta], rtol=1e-3)
    np.testing.assert_allclose(modes.modal_mass, [mass], rtol=1e-4)


@WRITERS
def test_complex_modes_without_a_mass(read, refused, mode):
    own = {"storage": 5, "analysis": 7, "eigenvalue": -1 + 250j, "modal_a": 5 + 3j}
    refused("mode 1 without modal mass", nodes_15(POINTS), mode(1, ALONG_Z, **own))
    np.testing.assert_allclose(
        read(nodes_15(POINTS), mode(1, ALONG_Z, **own), modal_mass=2.0).at_label(2).modal_mass, [2.0]
    )
    refused(
        "modal A gives the modal mass .* which is not real", nodes_15(POINTS), mode(1, ALONG_Z, **own | {"analysis": 3})
    )
    refused("eigenvalue -3, which is no vibration", nodes_15(POINTS), mode(1, ALONG_Z, **own | {"eigenvalue": -3 + 0j}))
    refused("damping ratio -0.0039", nodes_15(POINTS), mode(1, ALONG_Z, **own | {"eigenvalue": 1 + 250j}))


# ---- values a node, data types, analyses


@WRITERS
def test_rotations_are_left_aside(read, mode):
    shape = {1: (0, 0, 0, 9, 9, 9), 2: (0, 0, 1, 9, 9, 9)}
    modes = read(nodes_15(POINTS), mode(1, shape, characteristic=3, values=6))
    np.testing.assert_allclose(modes.at_label(2).modal_mass, [2.0])
    turned = read(nodes_15(POINTS), mode(1, shape, characteristic=3, values=6, storage=5))  # twelve numbers, two lines
    np.testing.assert_allclose(turned.at_label(2).modal_mass, [2.0])


@WRITERS
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"characteristic": 1, "values": 1}, r"mode 1 is a scalar a node: export displacements along x, y and z"),
        ({"characteristic": 2, "values": 1}, r"mode 1 has 1 values a node, and the data characteristic 2: expected 3"),
        ({"characteristic": 2, "values": 6}, r"mode 1 has 6 values a node, and the data characteristic 2: expected 3"),
        ({"characteristic": 0, "values": 2}, r"expected 3 or 6"),
        ({"characteristic": 4, "values": 6}, r"mode 1 is a symmetric tensor a node"),
        ({"characteristic": 77}, r"mode 1 is of the unknown characteristic 77 a node"),
        ({"storage": 3}, r"mode 1 is stored as the unknown data type 3"),
        ({"content": 11}, r"mode 1 is not a displacement \(data type 11\)"),
        ({"content": 12}, r"mode 1 is not a displacement \(data type 12\)"),
        ({"analysis": 1}, r"holds no modes .* only .*\(static\)"),
        ({"analysis": 5}, r"holds no modes .* only .*\(frequency responses\)"),
        ({"analysis": 6}, r"holds no modes .* only .*\(buckling\)"),
        ({"frequency": -40.0}, r"mode 1 has the frequency -40 Hz"),
        ({"viscous": -0.01}, r"mode 1 has the damping ratio -0.01"),
        ({"viscous": 1.2}, r"mode 1 has the damping ratio 1.2"),
        ({"viscous": 0.01, "hysteretic": 0.05}, r"viscous damping 0.01 and hysteretic damping 0.05, which is another"),
        ({"mass": -1.0}, r"mode 1 without modal mass"),
        ({"mass": 0.0}, r"mode 1 without modal mass: export"),
    ],
)  # fmt: skip
def test_what_is_no_mode_is_refused(refused, mode, change, message):
    refused(message, nodes_15(POINTS), mode(1, ALONG_Z, **change))


@WRITERS
@pytest.mark.parametrize("storage", [2, 5])
def test_fewer_values_than_are_said(refused, mode, storage):
    """Three reals a node where six, or twelve, are announced: the next nodes' numbers are not taken for values."""
    points = [(0.1 * n, 0, 0) for n in range(4)]
    lines = mode(1, {n: (0, 0, n) for n in range(1, 5)})
    said = [line.replace(integers(2, 8, 2, 3), integers(3, 8, storage, 6)) for line in lines]
    assert said != lines
    refused(r"modes.uff:\d+: dataset \d+: expected \d+ numbers, got '2'", nodes_15(points), said)


def test_data_on_elements_are_none_of_nodes(refused):
    refused(
        r"only .*dataset 2414 \(normal modes, data on elements\)", nodes_15(POINTS), mode_2414(1, ALONG_Z, location=2)
    )


@WRITERS
def test_stresses_beside_the_displacements_are_left_aside(read, mode):
    stress = mode(1, {1: (5,) * 6, 2: (5,) * 6}, characteristic=4, content=2, values=6)
    np.testing.assert_allclose(read(nodes_15(POINTS), stress, mode(1, ALONG_Z)).at_label(2).modal_mass, [2.0])


@WRITERS
def test_hysteretic_damping_is_twice_the_ratio(read, mode):
    modes = read(nodes_15(POINTS), mode(1, ALONG_Z, viscous=0.0, hysteretic=0.03))
    np.testing.assert_allclose(modes.inherent_damping, [0.015])
    both = read(nodes_15(POINTS), mode(1, ALONG_Z, viscous=0.015, hysteretic=0.03))  # the same, said twice
    np.testing.assert_allclose(both.inherent_damping, [0.015])


def test_the_eigenvalue_stands_in_for_a_frequency_of_0(read):
    modes = read(nodes_15(POINTS), mode_2414(1, ALONG_Z, frequency=0.0, squared=(2 * np.pi * 40) ** 2))
    np.testing.assert_allclose(modes.frequency, [40.0], rtol=FIVE_DIGITS)


@WRITERS
def test_numbers_of_modes(read, refused, mode):
    """Repeated ones are refused; where none is said, modes are counted."""
    refused(
        r"modes.uff:\d+: mode 2 is there already, from line \d+ on",
        nodes_15(POINTS),
        mode(2, ALONG_Z),
        mode(2, ALONG_Z),
    )
    refused(r"mode number -1: number the modes from 1 on", nodes_15(POINTS), mode(-1, ALONG_Z))
    assert list(read(nodes_15(POINTS), mode(0, ALONG_Z), mode(0, ALONG_Z, frequency=50.0)).number) == [1, 2]


@WRITERS
def test_rigid_bodies_are_kept_until_a_damper_picks(read, mode):
    modes = read(
        nodes_15(POINTS), mode(1, ALONG_Z, frequency=0.0), mode(2, ALONG_Z, frequency=1e-4), mode(3, ALONG_Z)
    ).at_label(2)
    assert list(modes.dampable) == [3]
    picked = modes.pick(modes.dampable)
    assert picked.remark == "left out: rigid-body motions, modes 1, 2 (up to 0.0001 Hz, below 0.1 Hz)"
    with pytest.raises(ValueError, match=r"mode 1 is a rigid-body motion \(0 Hz, below 0.1 Hz\)"):
        modes.pick([1])
    with pytest.raises(ValueError, match="only rigid-body motions"):
        _ = read(nodes_15(POINTS), mode(1, ALONG_Z, frequency=0.0)).dampable


def test_a_free_mass_is_added_to_rigid_bodies_too(read):
    """A dumbbell 1 kg - k - 1 kg; 0.5 kg more on one end: w^2 = k (1/1 + 1/1.5), whose modes are exact in two."""
    k = (2 * np.pi * 40) ** 2 / 2  # w^2 = k (1 + 1)
    rigid, elastic = {1: (1, 0, 0), 2: (1, 0, 0)}, {1: (1, 0, 0), 2: (-1, 0, 0)}
    modes = read(nodes_15(POINTS), mode_55(1, rigid, frequency=0.0), mode_55(2, elastic)).at_label(2, (1, 0, 0))
    loaded = modes.with_mass(0.5)
    np.testing.assert_allclose(loaded.frequency[1], np.sqrt(k * (1 + 1 / 1.5)) / (2 * np.pi), rtol=1e-9)
    assert loaded.rigid[0]
    assert np.isfinite(loaded.inherent_damping).all()


# ---- other datasets, and damaged files


def test_what_is_not_about_modes_is_left_aside(read):
    """Header, elements, trace lines, functions in text; what no list knows."""
    header = dataset(151, *["NONE"] * 7)
    elements = dataset(2412, integers(1, 94, 1, 1, 7, 4), integers(1, 2, 1, 2))
    lines = dataset(82, integers(1, 2, 1), "line", integers(1, 2))
    function = dataset(58, *["NONE"] * 5, "    4", reals(1, 2, 3))
    modes = read(header, nodes_15(POINTS), elements, lines, function, dataset(9999, "?"), mode_55(1, ALONG_Z))
    np.testing.assert_allclose(modes.at_label(2).modal_mass, [2.0])


def test_binary_functions_are_stepped_over(tmp_path):
    """Whatever their bytes look like."""
    text = ["\n".join(part).encode() + b"\n" for part in (units(), nodes_15(POINTS), mode_55(1, ALONG_Z))]
    (tmp_path / "modes.uff").write_bytes(text[0] + binary_58b() + text[1] + binary_58b(b"\n    -1\n") + text[2])
    np.testing.assert_allclose(read_uff(tmp_path / "modes.uff").at_label(2).modal_mass, [2.0])


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "cp1252"])
def test_other_encodings_and_line_ends(tmp_path, encoding):
    text = "\r\n".join(line for part in (units(), nodes_15(POINTS), mode_55(1, ALONG_Z)) for line in part)
    (tmp_path / "MODES.UNV").write_bytes(text.replace("NONE", "Träger", 1).encode(encoding))
    assert list(read_uff(tmp_path / "MODES.UNV").number) == [1]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("1.00000e+00", "        nan", r"modes.uff:\d+: dataset 55: expected 3 numbers, got '0.00000e\+00  0.00000e\+00          nan'"),
        ("1.00000e+00", "1.00000e999", r"a number is too large"),
        ("1.00000e+00", "1.00000e+00  1.0", r"expected 3 numbers, got 4"),
        ("         2\n", "         2   1.5\n", r"modes.uff:\d+: dataset 55: expected 1 integers, got '2   1.5'"),
        ("4.00000e+01", "        nan", r"expected 4 numbers, got"),
        ("\n    -1\n", "\n", r"dataset 55 does not end"),
    ],
)  # fmt: skip
def test_damaged_records_are_named_with_their_line(tmp_path, old, new, message):
    """The last place where the text stands."""
    text = "\n".join(line for part in (units(), nodes_15(POINTS), mode_55(1, ALONG_Z)) for line in part) + "\n"
    head, _, tail = text.rpartition(old)
    (tmp_path / "modes.uff").write_text(head + new + tail)
    with pytest.raises(ModalError, match=message):
        read_uff(tmp_path / "modes.uff")


def test_a_file_cut_short_anywhere_is_never_read_wrongly(tmp_path):
    """Every prefix of a file is refused, or read as the whole."""
    text = "\n".join(line for part in (units(), nodes_15(POINTS), mode_55(1, ALONG_Z)) for line in part) + "\n"
    for length in range(0, len(text), 7):
        (tmp_path / "modes.uff").write_text(text[:length])
        try:
            modes = read_uff(tmp_path / "modes.uff")
        except ModalError:
            continue
        np.testing.assert_allclose(modes.at_label(2).modal_mass, [2.0])
