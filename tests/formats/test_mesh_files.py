"""Meshes of every kind of cells: nothing is dropped, nothing is named in vain, and what cannot be used is refused."""

import itertools

import numpy as np
import pytest

from plate_theory import STEEL
from warpdamp.errors import ModalError
from warpdamp.formats.mesh_cells import EDGES, FACES, bent, tetrahedra, triangles
from warpdamp.formats.mesh_file import load_mesh, load_named
from warpdamp.modal.beam import Beam, PointMass, beam_modes
from warpdamp.modal.clamp import Clamp
from warpdamp.modal.section import MeshedSection, moments
from warpdamp.modal.solid import MeshedSolid, StandingMass, solid_modes

meshio = pytest.importorskip("meshio")
ROUNDING = 1e-12


def strip(counts=(4, 2, 1), size=(200.0, 20.0, 10.0)):
    """Points and hexahedra of a box, in meshio's order of nodes."""
    axes = [np.linspace(0, side, n + 1) for side, n in zip(size, counts, strict=True)]
    points = np.array(list(itertools.product(*axes)))
    number = np.arange(len(points)).reshape([n + 1 for n in counts])
    corner = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
    cells = [
        [number[tuple(np.add(at, step))] for step in corner] for at in itertools.product(*(range(n) for n in counts))
    ]
    return points, np.array(cells)


def wedges(cells):
    """Two wedges of every hexahedron."""
    return np.concatenate([cells[:, [0, 1, 2, 4, 5, 6]], cells[:, [0, 2, 3, 4, 6, 7]]])


def second_order(points, cells, kind):
    """Nodes in the middles of the edges, each once."""
    number, made, rows = {}, [], []
    for cell in cells:
        row = list(cell)
        for a, b in EDGES[kind]:
            key = tuple(sorted((cell[a], cell[b])))
            if key not in number:
                number[key] = len(points) + len(made)
                made.append((points[cell[a]] + points[cell[b]]) / 2)
            row.append(number[key])
        rows.append(row)
    return np.concatenate([points, made]), np.array(rows)


@pytest.fixture
def written(tmp_path):
    def write(points, cells, name="mesh.vtk", **options):
        kind = {"file_format": "gmsh22"} if name.endswith(".msh") else {}
        meshio.Mesh(points, cells, **options).write(tmp_path / name, **kind)
        return tmp_path / name

    return write


def volume(mesh):
    from skfem import Basis

    return Basis(mesh, mesh.elem(), intorder=4).dx.sum()


# ---- cutting


def volumes(points, cells):
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    return np.abs(np.linalg.det(edges)) / 6


@pytest.mark.parametrize(
    ("count", "whole"), [(8, 1.0), (6, 0.5), (5, 1 / 3), (4, 1 / 6)], ids=["hexahedron", "wedge", "pyramid", "tetrahedron"]
)  # fmt: skip
def test_a_cell_is_cut_into_tetrahedra_that_fill_it(count, whole):
    """Whatever the numbers of its nodes."""
    cube = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], float)
    own = {8: range(8), 6: (0, 1, 2, 4, 5, 6), 5: range(5), 4: (0, 1, 2, 5)}[count]
    for seed in range(20):
        number = np.random.default_rng(seed).permutation(8)
        points = cube[np.argsort(number)]
        pieces = tetrahedra(number[[*own]][None])
        assert volumes(points, pieces).sum() == pytest.approx(whole, rel=ROUNDING)
        assert volumes(points, pieces).min() > 0.1


def test_neighbours_of_all_kinds_agree_on_their_faces():
    """A strip of hexahedra and wedges with shuffled numbers: every face has two neighbours or lies on the surface."""
    points, cells = strip((3, 2, 1), (3, 2, 1))
    number = np.random.default_rng(4).permutation(len(points))
    cells = number[cells]
    pieces = np.concatenate([tetrahedra(cells[::2]), tetrahedra(wedges(cells[1::2]))])
    faces = np.sort(np.concatenate([pieces[:, face] for face in FACES[4]]), axis=1)
    assert volumes(points[np.argsort(number)], pieces).sum() == pytest.approx(6, rel=ROUNDING)
    outside = 2 * 2 * (3 * 2 + 2 * 1 + 3 * 1)  # two triangles of every square
    assert np.sum(np.unique(faces, axis=0, return_counts=True)[1] == 1) == outside


def test_quadrilaterals_are_cut_and_collapsed_ones_are_triangles():
    assert len(triangles(np.array([[3, 1, 2, 0], [5, 5, 6, 4]]))) == 3


# ---- kinds of cells


def test_a_mixed_mesh_has_the_modes_of_its_solid(written):
    """Half of it wedges; 1 % for tetrahedra in place of hexahedra, where half the strip missing is a factor of four."""
    points, cells = strip((8, 2, 1))
    found = []
    for kinds in ([("hexahedron", cells)], [("hexahedron", cells[:8]), ("wedge", wedges(cells[8:]))]):
        solid = MeshedSolid(written(points, kinds), STEEL, (Clamp(box=((0.0, 0.0), None, None)),), 1e-3)
        found.append(solid_modes(solid, StandingMass(0.1, (0.15, 0.01, 0.01), 0.01), highest=1))
    np.testing.assert_allclose(found[1].frequency, found[0].frequency, rtol=1e-2)
    np.testing.assert_allclose(found[1].amplitude, found[0].amplitude, rtol=2e-2)


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron20"])
def test_second_order_cells_have_the_modes_of_first_order_ones(written, kind):
    """Both are computed by quadratic elements; straight ones are the same solid to the last digits."""
    points, cells = strip((4, 1, 1))
    cells = tetrahedra(cells) if kind == "tetra10" else cells
    found = []
    for name, own, rows in ((kind.rstrip("0123456789"), points, cells), (kind, *second_order(points, cells, kind))):
        solid = MeshedSolid(written(own, [(name, rows)]), STEEL, (Clamp(box=((0.0, 0.0), None, None)),), 1e-3)
        found.append(solid_modes(solid, StandingMass(0.1, (0.15, 0.01, 0.01), 0.01), highest=1))
    np.testing.assert_allclose(found[1].frequency, found[0].frequency, rtol=1e-8)
    np.testing.assert_allclose(found[1].amplitude, found[0].amplitude, rtol=1e-6)


def test_second_order_cells_that_are_mixed_are_cut_where_they_are_straight(written):
    points, cells = strip()
    own, rows = second_order(points, cells, "hexahedron20")
    kinds = [("hexahedron20", rows[:4]), ("wedge", wedges(cells[4:]))]
    assert volume(load_mesh(written(own, kinds))) == pytest.approx(200 * 20 * 10, rel=ROUNDING)
    own[rows[0, 8], 1] += 1.0
    assert bent("hexahedron20", rows, own)
    with pytest.raises(ModalError, match="holds 4 hexahedron20, 8 wedge, the hexahedron20 with curved edges"):
        load_mesh(written(own, kinds))


@pytest.mark.parametrize("name", ["mesh.vtk", "mesh.msh", "mesh.inp"])
def test_hexahedra_of_20_nodes_keep_their_geometry(written, name):
    """Their functions hold every polynomial of second degree: nodes in the middles of faces and cells lie on it, too."""

    def bend(x):
        return x + np.stack(
            [0.1 * x[:, 1] ** 2 + 0.05 * x[:, 0] * x[:, 2], 0.2 * x[:, 0] ** 2, 0.1 * x[:, 0] * x[:, 1]], axis=1
        )

    points, rows = second_order(*strip((2, 2, 1), (1.0, 1.0, 0.5)), "hexahedron20")
    straight, bent_one = (load_mesh(written(p, [("hexahedron20", rows)], name)) for p in (points, bend(points)))
    assert straight.doflocs.shape[1] == 5 * 5 * 3
    np.testing.assert_allclose(bent_one.doflocs.T, bend(straight.doflocs.T), atol=1e-12)
    assert volume(straight) == pytest.approx(0.5, rel=ROUNDING)


def test_quadrilaterals_of_8_nodes_make_a_section(written):
    points, cells = strip((2, 2, 1), (20.0, 4.0, 1.0))
    flat = points[cells[:, :4]].reshape(-1, 3)
    flat, numbers = np.unique(flat, axis=0, return_inverse=True)
    own, rows = second_order(flat, numbers.reshape(-1, 4), "quad8")
    of = moments(MeshedSection(written(own, [("quad8", rows)])).basis())
    assert of.area == pytest.approx(80, rel=ROUNDING)
    assert of.across == pytest.approx(4 * 20**3 / 12, rel=ROUNDING)


def test_a_section_of_triangles_and_quadrilaterals_is_whole(written):
    points = np.array([(x, y, 0.0) for x in (-1, 0, 1) for y in (-1, 1)])
    file = written(points, [("quad", np.array([[0, 2, 3, 1]])), ("triangle", np.array([[2, 4, 5], [2, 5, 3]]))])
    assert moments(MeshedSection(file).basis()).area == pytest.approx(4, rel=ROUNDING)


def test_collapsed_hexahedra_are_wedges(written):
    points, cells = strip((1, 1, 1), (1.0, 1.0, 1.0))
    cell = cells[:, [0, 1, 2, 2, 4, 5, 6, 6]]
    assert volume(load_mesh(written(points, [("hexahedron", cell)]))) == pytest.approx(0.5, rel=ROUNDING)


def test_inverted_cells_and_unused_points_do_no_harm(written):
    points, cells = strip()
    points = np.concatenate([[[7.0, 7.0, 77.0]], points])
    for kinds in (
        [("hexahedron", cells[:, [4, 5, 6, 7, 0, 1, 2, 3]] + 1)],
        [("tetra", tetrahedra(cells)[:, [1, 0, 2, 3]] + 1)],
    ):
        mesh = load_mesh(written(points, kinds))
        assert volume(mesh) == pytest.approx(40000, rel=ROUNDING)
        assert mesh.p.shape[1] == len(points) - 1


@pytest.mark.parametrize("mixed", [False, True])
def test_cells_of_two_groups_are_there_once(written, mixed):
    """Gmsh 2.2 writes them once for each group: half of the strip twice would weigh half as much again."""
    points, cells = strip()
    body = (
        [("hexahedron", cells[:4]), ("wedge", np.concatenate([wedges(cells[4:])] * 2))]
        if mixed
        else [("hexahedron", np.concatenate([cells, cells[:4]]))]
    )
    assert volume(load_mesh(written(points, body))) == pytest.approx(40000, rel=ROUNDING)


# ---- names


def held_as_the_box(file, name):
    """What a name holds is what the plane x = 0 holds."""
    from skfem import Basis, ElementHex2, ElementTetP2, MeshHex1

    named = load_named(file)
    basis = Basis(named.mesh, ElementHex2() if isinstance(named.mesh, MeshHex1) else ElementTetP2(), intorder=2)
    by_name, by_box = Clamp(name).nodes(basis, named.nodes), Clamp(box=((0.0, 0.0), None, None)).nodes(basis)
    assert by_box.any()
    np.testing.assert_array_equal(by_name, by_box)


def cells_of(kind):
    """The strip in cells of a kind, and the nodes of those of its surface at x = 0."""
    points, cells = strip()
    if kind.startswith("tetra"):
        cells = tetrahedra(cells)
    if kind in EDGES:
        points, cells = second_order(points, cells, kind)
    return points, cells, np.flatnonzero(points[:, 0] == 0)


@pytest.mark.parametrize("kind", ["tetra", "tetra10", "hexahedron", "hexahedron20"])
def test_node_sets_of_abaqus(written, kind):
    points, cells, root = cells_of(kind)
    held_as_the_box(written(points, [(kind, cells)], "mesh.inp", point_sets={"ROOT": root}), "ROOT")


SIDES = {"tetra": "triangle", "tetra10": "triangle6", "hexahedron": "quad", "hexahedron20": "quad8"}


def sides_of(kind, cells, root):
    """Cells on the faces at x = 0 of cells of a kind."""
    corners = 4 if kind.startswith("tetra") else 8
    sides = np.concatenate([cells[:, face] for face in FACES[corners]])
    sides = sides[np.isin(sides, root).all(axis=1)]
    if kind not in EDGES:
        return sides
    middle = {frozenset((c[a], c[b])): c[k] for c in cells for k, (a, b) in enumerate(EDGES[kind], corners)}
    return np.array([[*s, *(middle[frozenset((s[a], s[b]))] for a, b in EDGES[SIDES[kind]])] for s in sides])


@pytest.mark.parametrize("kind", SIDES)
def test_named_boundaries_of_gmsh_2(written, kind):
    """The faces' tag is that of the volume, too: tags count in each dimension by themselves."""
    points, cells, root = cells_of(kind)
    sides = sides_of(kind, cells, root)
    tags = [np.full(len(cells), 1), np.full(len(sides), 1)]
    names = {"body": np.array([1, 3]), "root": np.array([1, 2])}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    file = written(points, [(kind, cells), (SIDES[kind], sides)], "mesh.msh", cell_data=data, field_data=names)
    held_as_the_box(file, "root")


@pytest.mark.parametrize(("kind", "codes"), [("tetra", (4, 2)), ("hexahedron", (5, 3))])
def test_named_boundaries_of_gmsh_4(tmp_path, kind, codes):
    points, cells, root = cells_of(kind)
    sides = sides_of(kind, cells, root)
    blocks = [
        f"{dim} 1 {code} {len(rows)}\n"
        + "".join(f"{first + k} {' '.join(map(str, row + 1))}\n" for k, row in enumerate(rows))
        for dim, code, rows, first in ((3, codes[0], cells, 1), (2, codes[1], sides, 1 + len(cells)))
    ]
    total, box = len(cells) + len(sides), "0 0 0 200 20 10"
    (tmp_path / "mesh.msh").write_text(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
        '$PhysicalNames\n2\n3 1 "body"\n2 1 "root"\n$EndPhysicalNames\n'
        f"$Entities\n0 0 1 1\n1 {box} 1 1 0\n1 {box} 1 1 0\n$EndEntities\n"
        f"$Nodes\n1 {len(points)} 1 {len(points)}\n3 1 0 {len(points)}\n"
        + "".join(f"{k}\n" for k in range(1, len(points) + 1)) + "".join("{} {} {}\n".format(*p) for p in points)
        + f"$EndNodes\n$Elements\n2 {total} 1 {total}\n{''.join(blocks)}$EndElements\n"
    )  # fmt: skip
    held_as_the_box(tmp_path / "mesh.msh", "root")


def test_a_named_edge_is_held(tmp_path):
    points, cells, root = cells_of("hexahedron")
    line = root[points[root, 2] == 0]
    lines = np.column_stack([line[:-1], line[1:]])
    tags = [np.full(len(cells), 1), np.full(len(lines), 2)]
    mesh = meshio.Mesh(
        points, [("hexahedron", cells), ("line", lines)], cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={"hinge": np.array([2, 1])},
    )  # fmt: skip
    mesh.write(tmp_path / "mesh.msh", file_format="gmsh22")
    named = load_named(tmp_path / "mesh.msh")
    np.testing.assert_allclose(np.sort(named.nodes["hinge"][1]), np.sort(points[line, 1]))


# ---- refusals


@pytest.mark.parametrize(
    ("kinds", "message"),
    [
        ([("hexahedron", None), ("triangle", [[0, 1, 5]])], r"mesh.vtk holds 1 triangle cells that are no faces of its other cells"),
        ([("hexahedron", None), ("quad", [[0, 1, 25, 20]])], r"holds 1 quad cells that are no faces"),
        ([("hexahedron", None), ("line", [[0, 25]])], r"holds lines that are no edges of its solid: beams are not modelled"),
        ([("hexahedron", None), ("wedge18", [list(range(18))])], r"holds 1 wedge18: no such cells can be computed with"),
        ([("hexahedron", None), ("wedge", [[0, 6, 8, 27, 28, 29]])], r"holds 8 hexahedron, 1 wedge, triangular faces of some against quadrilateral"),
        ([("line", [[0, 1], [1, 2]])], r"holds 2 line: neither a plane mesh nor a solid"),
        ([("triangle", [[0, 1, 5], [1, 7, 23]])], r"lies in a plane z = constant, and its points reach over 10"),
    ],
)  # fmt: skip
def test_cells_that_cannot_be_used_are_named_and_counted(written, kinds, message):
    points, cells = strip()
    file = written(points, [(kind, np.array(cells if rows is None else rows)) for kind, rows in kinds])
    with pytest.raises(ModalError, match=message):
        load_mesh(file)


def test_folded_and_flat_cells_are_refused(written):
    points, cells = strip()
    mass = StandingMass(0.0, (0.1, 0.0, 0.0), 0.01)
    crossed = cells.copy()
    crossed[0, [0, 1]] = crossed[0, [1, 0]]
    with pytest.raises(ValueError, match="holds 0 cells without volume and 1 that are folded"):
        solid_modes(MeshedSolid(written(points, [("hexahedron", crossed)]), STEEL), mass)
    flat = np.concatenate([tetrahedra(cells), [[0, 1, 2, 3]]])  # four points of the face x = 0
    with pytest.raises(ValueError, match="holds 1 cells without volume"):
        solid_modes(MeshedSolid(written(points, [("tetra", flat)]), STEEL), mass)


def test_nodes_in_the_middles_of_edges_in_another_order_are_refused(written):
    """Two of them exchanged, as programs order them differently: some cells have no volume at a point."""
    points, cells = strip()
    nodes, rows = second_order(points, tetrahedra(cells), "tetra10")
    exchanged = rows[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]
    mass = StandingMass(0.0, (0.1, 0.0, 0.0), 0.01)
    with pytest.raises(ModalError, match=r"holds .*cells.* folded"):
        solid_modes(MeshedSolid(written(nodes, [("tetra10", exchanged)]), STEEL), mass)


def test_folded_cells_of_a_section_and_one_of_another_unit_are_refused(written):
    points = np.array([(x, y, 0.0) for x in (-10.0, 0.0, 10.0) for y in (-2.0, 2.0)])
    quads = np.array([[0, 2, 3, 1], [2, 4, 5, 3]])
    crossed = np.array([[0, 2, 3, 1], [2, 4, 3, 5]])
    with pytest.raises(ModalError, match="holds 0 cells without volume and 1 that are folded: mesh it again"):
        MeshedSection(written(points, [("quad", crossed)]), 1e-3).basis()
    damper = PointMass(0.0, 0.29)
    beam = Beam(0.58, MeshedSection(written(points, [("quad", quads)])), STEEL)
    with pytest.raises(ModalError, match=r"a section of 2e\+04 x 4000 mm on a beam 580 mm long: is its unit right\?"):
        beam_modes(beam, damper)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("*INSTANCE, NAME=one, PART=part", r"mesh.inp:1: '\*INSTANCE, NAME=one, PART=part' makes or moves nodes"),
        ("*Include, input=nodes.inp", r"mesh.inp:1: '\*Include, input=nodes.inp' makes or moves"),
        ("*NODE, SYSTEM=C", r"mesh.inp:1: '\*NODE, SYSTEM=C' makes or moves"),
        ("hello", r"mesh.inp holds"),
    ],
)
def test_abaqus_files_that_meshio_would_read_wrongly(tmp_path, line, message):
    (tmp_path / "mesh.inp").write_text(f"{line}\n*NODE\n1, 0, 0, 0\n")
    with pytest.raises(ModalError, match=message):
        load_mesh(tmp_path / "mesh.inp")


def test_a_block_of_cells_without_cells_beside_one_with_them(tmp_path):
    nodes = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n"
    (tmp_path / "mesh.inp").write_text(f"{nodes}*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n*ELEMENT, TYPE=C3D4\n")
    with pytest.raises(ModalError, match=r"mesh.inp: of two blocks of a kind of cell, one is empty"):
        load_mesh(tmp_path / "mesh.inp")


def test_a_set_of_nodes_that_are_none_of_the_solid(written):
    points, cells = strip()
    points = np.concatenate([points, [[0.0, 0.0, 50.0]]])
    file = written(points, [("hexahedron", cells)], "mesh.inp", point_sets={"PILOT": np.array([len(points) - 1])})
    solid = MeshedSolid(file, STEEL, (Clamp("PILOT"),), 1e-3)
    with pytest.raises(ModalError, match="the set 'PILOT' holds 1 nodes that are none of the solid's"):
        solid_modes(solid, StandingMass(0.0, (0.1, 0.0, 0.0), 0.01))
