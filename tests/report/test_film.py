"""Films: the case chosen, its pictures, and files that the readers of other programs open."""

import dataclasses

import numpy as np
import pytest
import xarray as xr

from warpdamp.errors import SimulationError, UsageError
from warpdamp.report.film import Colour
from warpdamp.report.film_files import quaternions, write_extxyz, write_vtkhdf
from warpdamp.report.film_page import film_data, films_data, write_film_page
from warpdamp.report.film_pictures import pictures, write_gif, write_mp4
from warpdamp.status import Status
from warpdamp.study.again import again
from warpdamp.sweep.choice import Choice


def test_the_case_of_results_runs_to_the_same_bits(taken):
    assert taken.differing == {}
    assert taken.label.startswith("mode 1, ")
    assert "Γ 6" in taken.label


def test_the_case_of_a_study_is_that_of_its_results(study, taken):
    other = again(study, Choice(gamma=6, mode=1, seed=int(taken.label.rpartition(" ")[2])), frames=2, shown=1)
    assert other.differing == {}
    assert other.values["energy_dissipated"] == taken.values["energy_dissipated"]
    assert np.array_equal(other.trajectory.ledger.rows, taken.trajectory.ledger.rows)


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({"gamma": 5}, "no case with gamma 5: there is 2, 4, 6, 8"),
        ({"mode": 2}, "no case with mode 2: there is 1, 3"),
        (
            {"at": ["friction=0.5"]},
            "there is no friction to choose by: the cases differ in mode, frequency, gamma, seed",
        ),
        ({"at": ["friction"]}, "--at friction: write as friction=0.5"),
    ],
)
def test_a_case_that_is_not_there(results, choice, words):
    with pytest.raises(UsageError, match=words):
        again(results, Choice.of(**choice))


def test_a_study_has_to_be_told_which_case(study):
    with pytest.raises(UsageError, match="8 such cases: choose by gamma as well: 2, 4, 6, 8"):
        again(study, Choice(mode=1))


def altered(results, tmp_path, change):
    """Copy of the results, changed."""
    dataset = xr.load_dataset(results)
    change(dataset)
    path = tmp_path / "altered.nc"
    dataset.to_netcdf(path)
    return path


def test_a_case_that_had_failed(results, tmp_path):
    def change(dataset):
        dataset["status"][...] = int(Status.ESCAPED)

    with pytest.raises(SimulationError, match="had failed, there is nothing to film: a particle left the cavity"):
        again(altered(results, tmp_path, change), Choice(gamma=6, mode=1))


def test_results_of_another_machine_are_refused_and_said(results, tmp_path):
    def change(dataset):
        dataset["energy_dissipated"][...] *= 1 + 1e-15 * 4

    path = altered(results, tmp_path, change)
    with pytest.raises(UsageError, match="does not run to the same numbers here"):
        again(path, Choice(gamma=6, mode=1), frames=2)
    taken = again(path, Choice(gamma=6, mode=1), frames=2, anyway=True)
    assert set(taken.differing) == {"energy_dissipated"}
    assert "another version or on another machine" in taken.remark


def test_a_part_of_the_results(results, tmp_path):
    part = xr.load_dataset(results).drop_vars("cycles")
    part.to_netcdf(tmp_path / "part.nc")
    with pytest.raises(UsageError, match=r"part.nc: these are not the results of a whole run: there is no cycles"):
        again(tmp_path / "part.nc", Choice(gamma=6, mode=1))


def test_results_of_another_physics(results, tmp_path):
    def change(dataset):
        dataset.attrs["source"] = "warpdamp 0.0.1 (physics 1)"

    with pytest.raises(UsageError, match="made by version 1 of the physics"):
        again(altered(results, tmp_path, change), Choice(gamma=6, mode=1))


def test_pictures_change_from_frame_to_frame_and_with_the_colour(film):
    shots = list(pictures(film))
    assert len(shots) == 10
    assert shots[0].shape == (432, 720, 3)
    assert not np.array_equal(shots[0], shots[4])
    energy = next(pictures(dataclasses.replace(film, colour=Colour.ENERGY, forces=True)))
    assert not np.array_equal(shots[0], energy)


def test_dampers_stand_beside_each_other_in_one_scale(film, beside):
    shot = next(pictures(beside))
    assert shot.shape == (432, 1100, 3)
    every = films_data(beside)
    assert len(every) == 2
    assert len({data["strongest"] for data in every}) == 1
    assert every[0]["quantities"] == every[1]["quantities"]
    assert beside.strongest >= film.strongest


def test_a_gif_holds_every_frame(film, tmp_path):
    from PIL import Image

    write_gif(film, tmp_path / "film.gif")
    with Image.open(tmp_path / "film.gif") as gif:
        assert gif.n_frames == 10
        assert gif.size == (720, 432)


def test_an_mp4_holds_every_frame(film, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    write_mp4(film, tmp_path / "film.mp4")
    frames = ffmpeg.read_frames(str(tmp_path / "film.mp4"))
    assert next(frames)["size"] == (720, 432)
    assert sum(1 for _ in frames) == 10


def test_ase_reads_what_is_written_for_ovito(film, tmp_path):
    ase_io = pytest.importorskip("ase.io")
    write_extxyz(film, tmp_path / "film.xyz")
    frames = ase_io.read(tmp_path / "film.xyz", ":")
    assert len(frames) == 10
    for read, frame in zip(frames, film.frames, strict=True):
        assert read.positions == pytest.approx(frame.state.position, rel=1e-8)
        assert read.arrays["velo"] == pytest.approx(frame.state.velocity, rel=1e-8)
        assert read.arrays["energy_lost"] == pytest.approx(frame.lost, rel=1e-8)
        assert read.info["cycle"] == pytest.approx(frame.cycle, rel=1e-8)
    assert frames[0].cell.lengths() == pytest.approx([0.02, 0.02, 0.02])


def test_spheroids_go_to_ovito_with_axis_and_shape(spheroids, tmp_path):
    ase_io = pytest.importorskip("ase.io")
    write_extxyz(spheroids, tmp_path / "film.xyz")
    read = ase_io.read(tmp_path / "film.xyz", "4")
    x, y, z, w = read.arrays["orientation"].T
    turned = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x**2 + y**2)], axis=1)  # what z becomes
    assert turned == pytest.approx(spheroids.frames[4].state.axis, abs=1e-8)
    shape = read.arrays["aspherical_shape"]
    assert np.prod(shape, axis=1) == pytest.approx(0.003**3)  # the volume of the sphere
    assert shape[:, 2] == pytest.approx(2 * shape[:, 0])


def test_an_axis_may_point_straight_down():
    assert np.isfinite(quaternions(np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 2.0]]))).all()


def test_vtkhdf_says_where_every_moment_begins(film, tmp_path):
    h5py = pytest.importorskip("h5py")
    write_vtkhdf(film, tmp_path / "film.vtkhdf")
    with h5py.File(tmp_path / "film.vtkhdf") as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"PolyData"
        steps, n = root["Steps"], film.particles
        for k, frame in enumerate(film.frames):
            first = steps["PointOffsets"][k]
            moved = film.trajectory.displacement[k]
            assert root["Points"][first : first + n] == pytest.approx(frame.state.position + moved)
            line = steps["CellOffsets"][k][1]
            count = root["Lines"]["NumberOfCells"][k]
            force = root["CellData"]["force"][steps["CellDataOffsets"]["force"][k] :][: n + count]
            inner = frame.touching.pairs[:, 1] >= 0
            assert count == inner.sum()
            assert force[n:] == pytest.approx(np.linalg.norm(frame.touching.force[inner], axis=1))
            ids = root["Lines"]["Connectivity"][2 * line : 2 * (line + count)]
            assert np.array_equal(ids.reshape(-1, 2), frame.touching.pairs[inner])


def test_vtk_reads_what_is_written_for_paraview(spheroids, tmp_path):
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF", reason="VTK is not installed")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    write_vtkhdf(spheroids, tmp_path / "film.vtkhdf")
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(tmp_path / "film.vtkhdf"))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 10
    for k in (0, 7):
        reader.SetStep(k)
        reader.Update()
        data, frame = reader.GetOutput(), spheroids.frames[k]
        moved = spheroids.trajectory.displacement[k]
        assert vtk_to_numpy(data.GetPoints().GetData()) == pytest.approx(frame.state.position + moved)
        assert vtk_to_numpy(data.GetPointData().GetArray("axis")) == pytest.approx(frame.state.axis)
        assert data.GetNumberOfVerts() == spheroids.particles
        assert data.GetNumberOfLines() == (frame.touching.pairs[:, 1] >= 0).sum()


def test_a_page_names_no_outside_address_and_escapes_its_title(film, tmp_path):
    write_film_page(film, tmp_path / "film.html")
    text = (tmp_path / "film.html").read_text()
    assert "http" not in text
    assert "<b>" not in text
    assert "&lt;b&gt;" in text


def test_a_page_that_is_too_large_is_not_written(film, tmp_path, monkeypatch):
    monkeypatch.setattr("warpdamp.report.film_page.MOST_BYTES", 10_000)
    with pytest.raises(UsageError, match="take fewer frames"):
        write_film_page(film, tmp_path / "film.html")
    assert list(tmp_path.iterdir()) == []


def test_the_page_holds_positions_to_a_65535th_of_their_range(film):
    import base64
    import zlib

    data = film_data(film, film)
    kind, offset, length = data["packed"]["arrays"]["position"]
    assert kind == "u2"
    raw = zlib.decompress(base64.b64decode(data["packed"]["data"]))
    whole = np.frombuffer(raw, "<u2", length, offset).reshape(10, film.particles, 3)
    position = data["low"] + whole / 65535 * (data["high"] - data["low"])
    exact = np.array([frame.state.position for frame in film.frames])
    assert np.abs(position - exact).max() <= 0.51 / 65535 * (data["high"] - data["low"]).max()
