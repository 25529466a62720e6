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
    nodes_2411,
    reals,
    systems_18,
    systems_2420,
    units,
    write,
)  # fmt: skip
from warpdamp.errors import ModalError
from warpdamp.modal.geometry_uff import UNITS
from warpdamp.modal.mode_uff import read_uff

FIVE_DIGITS = 2e-5
POINTS = [(0, 0, 0), (0.3, 0, 0)]
ALONG_Z = {1: (0, 0, 0), 2: (0, 0, 1)}
WRITERS = pytest.mark.parametrize("mode", [mode_55, mode_2414], ids=["55", "2414"])


@pytest.fixture
def read(tmp_path):
    def reader(*sets, given=None, **options):
        sets = sets if given else (units(), *sets)
        return read_uff(write(tmp_path / "modes.uff", *sets), units=given, **options)

    return reader


@pytest.fixture
def refused(read):
    def check(message, *sets, **options):
        with pytest.raises(ModalError, match=message) as caught:
            read(*sets, **options)
        assert "\n" not in str(caught.value)

    return check


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
    refused("damping ratio -0.004", nodes_15(POINTS), mode(1, ALONG_Z, **own | {"eigenvalue": 1 + 250j}))


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


# ---- nodes and coordinate systems


def turned(angle):
    """Axes turned about z by an angle, as rows."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


@WRITERS
def test_a_cartesian_system_of_either_dataset(read, mode):
    """Turned by 30 degrees about z, at (0.1, 0.2, 0): a node at 0.3 along its x moves along its x."""
    axes, origin = turned(np.pi / 6), np.array([0.1, 0.2, 0.0])
    shape = {1: (0, 0, 0), 2: (1, 0, 0)}
    for systems in (
        systems_2420((4, 0, axes, origin)),
        systems_18(4, 0, origin, origin + axes[0], origin + axes[0] + axes[2]),
    ):
        modes = read(systems, nodes_15([(0, 0, 0), (0.3, 0, 0)], 4), mode(1, shape)).at_label(2, axes[0])
        np.testing.assert_allclose(modes.point[1], origin + 0.3 * axes[0], rtol=FIVE_DIGITS)
        np.testing.assert_allclose(modes.modal_mass, [2.0], rtol=FIVE_DIGITS)
        assert modes.at_label(2, axes[1]).amplitude[0] < 1e-5


def test_displacements_in_cylindrical_and_spherical_systems(read):
    """At (0, 2, 0): r is y, theta is -x, z is z.  At (0, 0, 3): r is z, theta (from z) is x, phi is y."""
    for kind, point, expected in (
        (1, (0, 2, 0), [(0, 1, 0), (-1, 0, 0), (0, 0, 1)]),
        (2, (0, 0, 3), [(0, 0, 1), (1, 0, 0), (0, 1, 0)]),
    ):
        for component, direction in enumerate(expected):
            shape = {1: np.eye(3)[component], 2: (0, 0, 1)}
            modes = read(
                systems_2420((7, kind, np.eye(3), np.zeros(3))), nodes_2411([point, (5, 5, 5)], 0, 7), mode_55(1, shape)
            )
            np.testing.assert_allclose(
                modes.shape[0, 0] * np.sqrt(2) * np.sign(modes.shape[0, 0] @ direction), direction, atol=1e-12
            )


def test_positions_in_cylindrical_and_spherical_systems(read):
    """Angles in degrees: (2, 30, 0.5) on a cylinder; (2, 60, 90) on a sphere, 60 from z, 90 about it."""
    for kind, local, expected in ((1, (2, 30, 0.5), (np.sqrt(3), 1, 0.5)), (2, (2, 60, 90), (0, np.sqrt(3), 1))):
        modes = read(
            systems_2420((7, kind, np.eye(3), np.zeros(3))), nodes_15([local, (5, 5, 5)], 7, 0), mode_55(1, ALONG_Z)
        )
        np.testing.assert_allclose(modes.point[0], expected, atol=1e-5)


def test_a_system_may_refer_to_another(read):
    """The second is turned by 90 degrees in the first, which is turned by 90 degrees: x is -x."""
    points = ((0, 0, 0), (0, 1, 0), (0, 1, 1))
    systems = (systems_18(1, 0, *points), systems_18(2, 0, *points, reference=1))
    modes = read(*systems, nodes_15([(0, 0, 0), (0.3, 0, 0)], 2), mode_55(1, ALONG_Z))
    np.testing.assert_allclose(modes.point[1], [-0.3, 0, 0], atol=1e-12)


def test_coordinates_of_2411_are_the_parts(read):
    """The specification: its export system does not move them."""
    modes = read(systems_2420((4, 0, turned(1.0), np.ones(3))), nodes_2411(POINTS, 4, 0), mode_55(1, ALONG_Z))
    np.testing.assert_allclose(modes.point, POINTS)


@pytest.mark.parametrize(
    ("sets", "message"),
    [
        ([nodes_15(POINTS, 4)], r"modes.uff:\d+: dataset 15: node 1 uses coordinate system 4, which the file does not define"),
        ([nodes_2411(POINTS, 0, 4)], r"dataset 2411: node 1 uses coordinate system 4"),
        ([systems_2420((4, 3, np.eye(3), np.zeros(3)))], r"coordinate system 4 is of the unknown type 3"),
        ([systems_2420((4, 0, 2 * np.eye(3), np.zeros(3)))], r"coordinate system 4: its axes are no right-handed unit vectors"),
        ([systems_2420((4, 0, np.diag([1, 1, -1]), np.zeros(3)))], r"coordinate system 4: its axes are no right-handed"),
        ([systems_2420((4, 0, np.eye(3), np.zeros(3)), (4, 0, turned(1), np.zeros(3)))], r"coordinate system 4 is defined twice"),
        ([systems_18(4, 0, (0, 0, 0), (1, 0, 0), (2, 0, 0))], r"dataset 18: coordinate system 4: its three points lie on a line"),
        ([systems_18(4, 0, (0, 0, 0), (1, 0, 0), (0, 0, 1), reference=9)], r"coordinate system 4 refers to 9"),
        ([systems_18(4, 0, (0, 0, 0), (1, 0, 0), (0, 0, 1), method=2)], r"coordinate system 4 is defined by method 2"),
        ([nodes_15(POINTS), nodes_2411([(1, 1, 1)])], r"node 1 is at two places"),
        ([], r"modes.uff has no nodes"),
    ],
)  # fmt: skip
def test_geometry_that_cannot_be_applied(refused, sets, message):
    refused(message, *sets, mode_55(1, ALONG_Z))


def test_the_same_nodes_twice_are_one(read):
    assert list(read(nodes_15(POINTS), nodes_2411(POINTS), mode_55(1, ALONG_Z)).label) == [1, 2]


def test_a_node_that_was_not_measured(read, refused):
    """No entry is not 0, says the specification."""
    modes = read(nodes_15([*POINTS, (0.6, 0, 0)]), mode_55(1, ALONG_Z))
    assert list(modes.label) == [1, 2]
    with pytest.raises(
        ValueError, match="node 3 has no data in some of the modes, its motion is not known: choose from 1, 2"
    ):
        modes.at_label(3)
    with pytest.raises(ValueError, match="there is no node 9: choose from 1, 2"):
        modes.at_label(9)
    some = read(nodes_15(POINTS), mode_55(1, ALONG_Z), mode_55(2, {2: (0, 0, 1)}))
    assert list(some.label) == [2]
    refused(
        "no node has data in all of the modes", nodes_15(POINTS), mode_55(1, {1: (0, 0, 1)}), mode_55(2, {2: (0, 0, 1)})
    )
    refused("mode 1 moves node 9, which has no coordinates", nodes_15(POINTS), mode_55(1, {9: (0, 0, 1)}))
    refused("mode 1 moves no node", nodes_15(POINTS), mode_55(1, {}))
    refused("mode 1 moves no node", nodes_15(POINTS), mode_55(1, {1: (0, 0, 0)}))


def test_places_between_points_and_far_from_them(read):
    modes = read(nodes_15([*POINTS, (0.6, 0, 0)]), mode_55(1, {1: (0, 0, 1), 2: (0, 0, 2), 3: (0, 0, 1)}))
    assert modes.at((0.4, 0.05, 0)).damper == 1
    with pytest.raises(
        ValueError,
        match=r"\(2000 x 0 x 0\) mm is far from every point: the nearest, \(600 x 0 x 0\) mm, is 1400 mm away",
    ):
        modes.at((2.0, 0, 0))
    with pytest.raises(ValueError, match=r"the direction \[0.0, 0.0, 0.0\] has no length"):
        modes.at_label(2, (0, 0, 0))


# ---- units


@pytest.mark.parametrize("name", [name for name in UNITS if name != "MM-N"])
def test_units_of_dataset_164(tmp_path, name):
    """Written in other units: 0.3 m, and 2 kg as F s^2 / L."""
    length, force = UNITS[name]
    points = [tuple(length * x for x in point) for point in POINTS]
    path = write(
        tmp_path / "modes.uff", units([*UNITS].index(name) + 1, length, force), nodes_15(points),
        mode_55(1, ALONG_Z, mass=2 * force / length),
    )  # fmt: skip
    modes = read_uff(path).at_label(2)
    np.testing.assert_allclose(modes.point[1], POINTS[1], rtol=FIVE_DIGITS)
    np.testing.assert_allclose(modes.modal_mass, [2.0], rtol=FIVE_DIGITS)


def test_units_of_their_own_and_units_given(read, tmp_path):
    """Code 9: millimetres and newtons, hence tonnes; MM-N says the same."""
    points = [(0, 0, 0), (300, 0, 0)]
    sets = (nodes_15(points), mode_55(1, ALONG_Z, mass=0.002))
    one = read_uff(write(tmp_path / "own.uff", units(9, 1e3, 1.0), *sets)).at_label(2)
    for modes in (one, read(*sets, given="MM-N").at_label(2)):
        np.testing.assert_allclose(modes.modal_mass, [2.0])
        np.testing.assert_allclose(modes.point[1], POINTS[1])


@pytest.mark.parametrize(
    ("first", "message"),
    [
        ([units(1), units(5, 1e3, 1e3)], r"modes.uff:\d+: dataset 164: other units than on line 2: write a file for each"),
        ([units(1, 1e3, 1.0)], r"contradicts itself: units 1 \(SI\) have the factors 1 and 1, not 1000 and 1"),
        ([units(12)], r"unknown code of units 12"),
        ([units(9, 0.0, 1.0)], r"factors 0 and 1: must be above 0"),
        ([], r"does not say its units \(dataset 164\): give units, one of SI, BG, .*MM-N"),
    ],
)  # fmt: skip
def test_units_that_cannot_be_used(tmp_path, first, message):
    path = write(tmp_path / "modes.uff", *first, nodes_15(POINTS), mode_55(1, ALONG_Z))
    with pytest.raises(ModalError, match=message):
        read_uff(path)


def test_units_said_twice(read):
    with pytest.raises(ModalError, match=r"says its units .* leave units out"):
        read(units(), nodes_15(POINTS), mode_55(1, ALONG_Z), given="SI")


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
