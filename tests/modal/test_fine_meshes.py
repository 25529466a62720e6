"""Sections and solids of fine meshes: what they cost, that nothing is lost by it, and what error they state."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_matrix, kron

from warpdamp import Material
from warpdamp.modal import beam as beams
from warpdamp.modal import eigenmodes, fem
from warpdamp.modal import solid as solids
from warpdamp.modal.beam import Beam, PointMass, beam_modes
from warpdamp.modal.section import MeshedSection, Rectangle
from warpdamp.modal.solid import Clamp, MeshedSolid, StandingMass, solid_modes
from warpdamp.modes import Modes
from warpdamp.report.tables import modes_table

pytest.importorskip("meshio")
STEEL = Material(7800, 210e9, 0.3)
WIDTH, THICKNESS = 0.02, 0.004
AT_ROOT = (Clamp(box=((0.0, 0.0), None, None)),)


def section_of(folder, cells, shape="Quad", keep=None, size=(WIDTH, THICKNESS)):
    """A mesh of a rectangle, or of what of it is kept."""
    import skfem

    sides = (np.linspace(-side / 2, side / 2, n + 1) for side, n in zip(size, cells, strict=True))
    mesh = getattr(skfem, f"Mesh{shape}").init_tensor(*sides)
    if keep is not None:
        mesh = mesh.restrict(mesh.elements_satisfying(keep))
    path = folder / f"{shape}{'-'.join(map(str, cells))}.msh"
    mesh.save(path)
    return MeshedSection(path)


def block_of(folder, cells, shape="Tet", size=(0.2, 0.12, 0.06)):
    import skfem

    sides = (np.linspace(0, side, n + 1) for side, n in zip(size, cells, strict=True))
    path = folder / f"{shape}{'-'.join(map(str, cells))}.vtk"
    getattr(skfem, f"Mesh{shape}").init_tensor(*sides).save(path)
    return MeshedSolid(path, STEEL, AT_ROOT)


@pytest.mark.parametrize(
    ("supports", "bends"), [(("clamped", "pinned"), "thickness"), (("free", "free"), "width")], ids=["held", "free"]
)
def test_a_few_functions_of_the_section_give_what_all_of_its_nodes_give(supports, bends, tmp_path):
    """A tee, off its beam's neutral plane, with masses and inertia: all 3 s displacements of every plane, to 1e-6."""
    tee = section_of(tmp_path, (6, 4), keep=lambda x: (x[1] > 0.001) | (abs(x[0]) < 0.0034))
    own = Beam(0.06, tee, STEEL, supports, bends, (PointMass(0.03, 0.02, 1e-6),))
    damper = PointMass(0.05, 0.04, 2e-6)
    found = beam_modes(own, damper, highest=3)

    section, masses, axis = tee.basis(), (damper, *own.masses), beams.BENDS[bends]
    solid, station = beams._supported(own, section, masses)
    carried = beams._carried(section, masses, station, axis, parts=1)
    planes = np.eye(len(station))
    rows = [kron(np.eye(3)[along], kron(planes, weights), format="csr") for along, weights, _ in carried]
    of_line = beams._line_mass(own, section, station)
    squares, vectors = beams._bending_modes(solid, rows, carried, of_line, axis, 3, 3)
    np.testing.assert_allclose(found.frequency, np.sqrt(squares) / (2 * math.pi), rtol=1e-6)
    np.testing.assert_allclose(
        np.abs(found.shape[:, :, axis]), np.abs(rows[axis] @ vectors).T, atol=1e-3 * np.abs(found.shape).max()
    )


def test_a_section_of_240_quadrilaterals_moves_in_a_few_dozen_ways(tmp_path, monkeypatch):
    """3,075 displacements to a plane; the band matrix of fewer than 160 functions takes less than 0.45 GB.

    Frequencies to 2e-4: the rectangle's two quadratic elements across half of it are that good.
    """
    steps = []
    monkeypatch.setattr(beams, "converged", lambda *given: steps.append(converged(*given)) or steps[-1])
    fine, coarse = (
        beam_modes(Beam(0.58, section, STEEL), PointMass(0.2, 0.29), highest=1)
        for section in (section_of(tmp_path, (20, 12)), Rectangle(WIDTH, THICKNESS))
    )
    assert steps[0].reduced.extrusion.place.shape == (2, 1025)
    assert steps[0].reduced.r < 160
    assert steps[0].reduced.memory < 4.5e8
    assert steps[0].rest < 4e-7
    assert fine.frequency[0] == pytest.approx(coarse.frequency[0], rel=2e-4)
    assert fine.amplitude[0] == pytest.approx(coarse.amplitude[0], rel=2e-4)


converged = beams.converged


def test_the_same_section_gives_the_same_bits(tmp_path):
    own = Beam(0.08, section_of(tmp_path, (4, 2)), STEEL)
    one, other = (beam_modes(own, PointMass(0.2, 0.03), highest=2) for _ in range(2))
    np.testing.assert_array_equal(one.frequency, other.frequency)
    np.testing.assert_array_equal(one.shape, other.shape)


@pytest.mark.parametrize(
    ("cells", "entries"),
    [((10, 6, 3), 2.8e6), pytest.param((20, 12, 6), 4.3e7, marks=pytest.mark.slow)],
    ids=["1,080", "8,640"],
)
def test_a_solid_is_factorised_once_for_all_masses(cells, entries, tmp_path, monkeypatch):
    """Entries of the factors, 8 bytes each: a tenth above what nested dissection leaves.  Masses change no bit."""
    fill = []
    splu = eigenmodes.splu
    monkeypatch.setattr(eigenmodes, "splu", lambda *given, **how: fill.append(splu(*given, **how)) or fill[-1])
    block, damper = block_of(tmp_path, cells), StandingMass(0.05, (0.15, 0.06, 0.06), 0.04)
    empty, filled = (solid_modes(block, damper.loaded(mass), highest=3) for mass in (0.0, 1.0))
    assert [factors.nnz < entries for factors in fill] == [True]
    solids._body.cache_clear()
    again = solid_modes(block, damper.loaded(1.0), highest=3)
    np.testing.assert_array_equal(again.frequency, filled.frequency)
    np.testing.assert_array_equal(again.shape, filled.shape)
    assert np.all(filled.frequency < empty.frequency)


def test_a_mesh_file_that_changes_is_read_again(tmp_path):
    damper = StandingMass(0.05, (0.15, 0.06, 0.06), 0.06)
    coarse = solid_modes(block_of(tmp_path, (4, 2, 1)), damper, highest=1)
    block = block_of(tmp_path, (4, 2, 2))
    block.file.replace(tmp_path / "Tet4-2-1.vtk")
    finer = solid_modes(MeshedSolid(tmp_path / "Tet4-2-1.vtk", STEEL, AT_ROOT), damper, highest=1)
    assert finer.frequency[0] < coarse.frequency[0]


def test_a_free_solid_carries_masses_as_if_they_were_its_own(tmp_path):
    """Woodbury's formula against the factors of the whole: squares of angular frequencies to 1e-8."""
    from skfem import Basis, ElementTetP2, MeshTet

    basis = Basis(
        MeshTet.init_tensor(*(np.linspace(0, side, 3) for side in (0.2, 0.03, 0.01))), ElementTetP2(), intorder=4
    )
    free = fem.meshed(basis, STEEL)
    rows = csr_matrix((np.ones(3), (range(3), [5, 5 + basis.N, 5 + 2 * basis.N])), (3, 3 * basis.N))
    carried = eigenmodes.Attached(rows, np.full(3, 0.4))
    whole = replace(free, mass=(free.mass + carried.mass).tocsr())
    nothing = eigenmodes.Attached(rows, np.zeros(3))
    assert free.shift < 0
    one, other = (
        eigenmodes.elastic_modes(solid, attached, lambda squares, vectors: squares[:4], count=12)
        for solid, attached in ((free, carried), (whole, nothing))
    )
    np.testing.assert_allclose(one, other, rtol=1e-8)


@pytest.mark.parametrize("name", ["section", "solid"])
def test_points_from_which_a_geometry_was_built_do_no_harm(name, tmp_path):
    """A node that belongs to no cell, first and last: the same modes to the bit."""
    import meshio
    from skfem import MeshTet, MeshTri

    if name == "section":
        mesh = MeshTri.init_tensor(np.linspace(-10, 10, 4), np.linspace(-2, 2, 3))
        points, kind, loose = np.pad(mesh.p.T, ((0, 0), (0, 1))), "triangle", (0.0, 0.1, 0.0)
    else:
        mesh = MeshTet.init_tensor(np.linspace(0, 40, 3), np.linspace(0, 20, 3), np.linspace(0, 10, 2))
        points, kind, loose = mesh.p.T, "tetra", (0.0, 0.1, 0.0)

    def modes(points, cells):
        file = tmp_path / f"{len(points)}.msh"
        meshio.write_points_cells(file, points, [(kind, cells)], file_format="gmsh22", binary=False)
        if name == "section":
            return beam_modes(Beam(0.1, MeshedSection(file, 1e-3), STEEL), PointMass(0.01, 0.05), highest=1)
        return solid_modes(
            MeshedSolid(file, STEEL, AT_ROOT, 1e-3), StandingMass(0.01, (0.03, 0.01, 0.01), 0.01), highest=1
        )

    clean = modes(points, mesh.t.T)
    dirty = modes(np.vstack([loose, points, loose]), mesh.t.T + 1)
    np.testing.assert_array_equal(dirty.frequency, clean.frequency)
    np.testing.assert_array_equal(dirty.shape, clean.shape)


@pytest.mark.parametrize("shape", ["Tet", "Hex"])
def test_the_error_stated_of_a_solid_is_that_of_its_mesh(shape, tmp_path):
    """Against elements of a third: what those still lack is a seventh or so, so that 0.7 to 2.5 times is agreement."""
    damper = StandingMass(0.05, (0.15, 0.06, 0.06), 0.06)
    coarse, fine = (
        solid_modes(block_of(tmp_path, cells, shape), damper, highest=3) for cells in ((4, 2, 1), (12, 6, 3))
    )
    ratio = coarse.mesh_error / (coarse.frequency / fine.frequency - 1)
    assert np.all((ratio > 0.7) & (ratio < 2.5))
    assert np.all(fine.mesh_error < 0.5 * coarse.mesh_error)


def test_the_error_stated_of_a_beam_is_that_of_its_meshes(tmp_path, monkeypatch):
    """A stubby strip of triangles, against a mesh and stations of a half: which lack a quarter to a half of the error themselves.

    One to two times the error is 1 to 3 times the difference.
    """
    own = [Beam(0.06, section_of(tmp_path, cells, "Tri", size=(0.02, 0.01)), STEEL) for cells in ((4, 2), (8, 4))]
    coarse = beam_modes(own[0], PointMass(0.2, 0.03), highest=2)
    monkeypatch.setattr(beams, "FINEST", beams.FINEST / 2)
    monkeypatch.setattr(beams, "COARSEST", beams.COARSEST / 2)
    fine = beam_modes(own[1], PointMass(0.2, 0.03), highest=2)
    ratio = coarse.mesh_error / (coarse.frequency / fine.frequency - 1)
    assert np.all((ratio > 1) & (ratio < 3))


def test_the_error_stated_is_shown():
    modes = Modes(np.array([1]), np.array([40.0]), np.zeros((1, 3)), np.ones((1, 1, 3)), np.zeros(1))
    assert [column.header for column in modes_table(modes).columns][-1] == r"modal mass \[kg]"
    meshed = modes_table(replace(modes, mesh_error=np.array([1.234e-3])))
    assert meshed.columns[-1].header == "f high by"
    assert list(meshed.columns[-1].cells) == ["0.12 %"]
