"""Nodes, coordinate systems and units of universal files, as docs/universal-files.md says."""

import numpy as np
import pytest

from universal_files import mode_55, mode_2414, nodes_15, nodes_2411, systems_18, systems_2420, units, write
from warpdamp.errors import ModalError
from warpdamp.formats.mode_uff import read_uff
from warpdamp.formats.uff_geometry import UNITS

FIVE_DIGITS = 2e-5
POINTS = [(0, 0, 0), (0.3, 0, 0)]
ALONG_Z = {1: (0, 0, 0), 2: (0, 0, 1)}
WRITERS = pytest.mark.parametrize("mode", [mode_55, mode_2414], ids=["55", "2414"])


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
    np.testing.assert_allclose(read(nodes_2411(POINTS, 9, 0), mode_55(1, ALONG_Z)).point, POINTS)


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


def test_dataset_781_is_2411(read):
    nodes = nodes_2411(POINTS)
    modes = read([nodes[0], "   781", *nodes[2:]], mode_55(1, ALONG_Z))
    np.testing.assert_allclose(modes.point, POINTS)


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
