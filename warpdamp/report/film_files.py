"""Frames of a film for other programs: extended XYZ for OVITO, VTKHDF for ParaView."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import MissingLibrary
from ..files import whole_file
from .film import Film, turned

EXTXYZ = {
    "pos": 3,
    "velo": 3,
    "spin": 3,
    "radius": 1,
    "energy_lost": 1,
    "orientation": 4,
    "aspherical_shape": 3,
}
"""Columns of an extended XYZ file, and how many numbers each has; OVITO knows them by these names."""

SYMBOLS = ("H", "He", "Li", "Be", "B", "C", "N", "O", "F", "Ne")
"""Names of the particles' species in such a file: its readers ask for symbols of elements."""


def write_extxyz(film: Film, path: Path) -> None:
    """Write the frames as extended XYZ, in SI units: a text file that OVITO and ASE read.

    Positions are in the frame of the cavity, which stands at the origin; ``enclosure`` says how far it has moved.
    Particles that are no spheres have an ``orientation`` (quaternion x, y, z, w) and an ``aspherical_shape``
    (semi-axes, the axis last).
    """
    cavity = film.trajectory.scene.enclosure
    box = np.diag([cavity.diameter, cavity.diameter, cavity.height])
    origin = [-cavity.diameter / 2, -cavity.diameter / 2, 0.0]
    with whole_file(path) as part, open(part, "w", encoding="utf-8") as file:
        for frame, moved in zip(film.frames, film.trajectory.displacement, strict=True):
            columns = _columns(frame)
            properties = ":".join(f"{name}:R:{EXTXYZ[name]}" for name in columns)
            time = frame.cycle / film.trajectory.scene.drive.frequency
            file.write(f"{film.particles}\n")
            moment = f'Time={time:.9g} cycle={frame.cycle:.9g} enclosure="{_numbers(moved)}"'
            cell = f'Lattice="{_numbers(box.ravel())}" Origin="{_numbers(origin)}" pbc="F F F"'
            file.write(f"{cell} Properties=species:S:1:{properties} {moment}\n")
            table = np.concatenate([column.reshape(film.particles, -1) for column in columns.values()], axis=1)
            for species, row in zip(frame.state.species, table, strict=True):
                file.write(f"{SYMBOLS[species % len(SYMBOLS)]} {_numbers(row)}\n")


def _columns(frame) -> dict[str, np.ndarray]:
    """Columns of a frame, in the order of ``EXTXYZ``."""
    state = frame.state
    columns = {"pos": state.position, "velo": state.velocity, "spin": state.spin, "radius": state.radius}
    columns |= {"energy_lost": frame.lost}
    if bodies := turned(frame):
        sides = np.stack([bodies.across, bodies.across, bodies.along], axis=1)
        columns |= {"orientation": quaternions(bodies.axis), "aspherical_shape": sides}
    return columns


def quaternions(axis: np.ndarray) -> np.ndarray:
    """Rotations that take z to each axis (n, 3), as quaternions (x, y, z, w), (n, 4)."""
    x, y, z = (axis / np.linalg.norm(axis, axis=1)[:, None]).T
    q = np.stack([-y, x, 0 * z, 1 + z], axis=1)
    q[z < -1 + 1e-12] = [1.0, 0.0, 0.0, 0.0]
    return q / np.linalg.norm(q, axis=1)[:, None]


def _numbers(values) -> str:
    return " ".join(f"{value:.9g}" for value in values)


CELLS = ("Vertices", "Lines", "Polygons", "Strips")
"""Kinds of cells of VTK's polygonal data, in their order."""


def write_vtkhdf(film: Film, path: Path) -> None:
    """Write the frames as VTKHDF: points with their properties, and lines with the forces between particles.

    Positions are those in the laboratory [m]; times are seconds since the case began.

    Raises
    ------
    MissingLibrary
        If h5py is not installed.

    References
    ----------
    VTK file formats, VTKHDF 2.0, temporal PolyData.
    """
    try:
        import h5py
    except ImportError:
        raise MissingLibrary("films for ParaView need h5py: pip install 'warpdamp[film]'", name="h5py") from None
    n, frequency = film.particles, film.trajectory.scene.drive.frequency
    chains = [_between_particles(frame) for frame in film.frames]
    counts = np.array([len(force) for _, force in chains])
    points = [
        frame.state.position + moved for frame, moved in zip(film.frames, film.trajectory.displacement, strict=True)
    ]
    with whole_file(path) as part, h5py.File(part, "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], np.int64)
        root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", 8))
        root["NumberOfPoints"] = np.full(len(points), n, np.int64)
        root["Points"] = np.concatenate(points)
        vertices = [np.arange(n)] * len(points)
        _cells(root, "Vertices", vertices, [np.arange(n + 1)] * len(points))
        lines = [pairs.ravel() for pairs, _ in chains]
        _cells(root, "Lines", lines, [2 * np.arange(count + 1) for count in counts])
        for kind in CELLS[2:]:
            _cells(root, kind, [np.zeros(0)] * len(points), [np.zeros(1)] * len(points))
        _point_data(root, film)
        force = [np.concatenate([np.zeros(n), force]) for _, force in chains]
        root.create_group("CellData")["force"] = np.concatenate(force)
        _steps(root, [frame.cycle / frequency for frame in film.frames], n, counts)


def _between_particles(frame) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of particles that press on each other, and their forces [N]."""
    inner = frame.touching.pairs[:, 1] >= 0
    return frame.touching.pairs[inner], np.linalg.norm(frame.touching.force[inner], axis=1)


def _cells(root, kind: str, connectivity: list[np.ndarray], offsets: list[np.ndarray]) -> None:
    group = root.create_group(kind)
    group["NumberOfConnectivityIds"] = np.array([len(part) for part in connectivity], np.int64)
    group["NumberOfCells"] = np.array([len(part) - 1 for part in offsets], np.int64)
    group["Connectivity"] = np.concatenate(connectivity).astype(np.int64)
    group["Offsets"] = np.concatenate(offsets).astype(np.int64)


def _point_data(root, film: Film) -> None:
    data = root.create_group("PointData")
    states = [frame.state for frame in film.frames]
    values = {name: [getattr(state, name) for state in states] for name in ("velocity", "spin", "radius", "species")}
    values["energy_lost"] = [frame.lost for frame in film.frames]
    if turned(film.frames[0]):
        values |= {name: [getattr(state, name) for state in states] for name in ("axis", "aspect")}
    for name, parts in values.items():
        data[name] = np.concatenate(parts)


def _steps(root, times: list[float], n: int, lines: np.ndarray) -> None:
    """Where each moment's part of the arrays begins."""
    count = len(times)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = count
    steps["Values"] = np.array(times)
    steps["PartOffsets"] = np.arange(count, dtype=np.int64)
    steps["NumberOfParts"] = np.ones(count, np.int64)
    before = np.concatenate([[0], np.cumsum(lines)[:-1]])
    steps["PointOffsets"] = n * np.arange(count, dtype=np.int64)
    none = np.zeros(count, np.int64)
    steps["CellOffsets"] = np.stack([n * np.arange(count), before, none, none], axis=1).astype(np.int64)
    steps["ConnectivityIdOffsets"] = np.stack([n * np.arange(count), 2 * before, none, none], axis=1).astype(np.int64)
    offsets = steps.create_group("PointDataOffsets")
    for name in root["PointData"]:
        offsets[name] = n * np.arange(count, dtype=np.int64)
    steps.create_group("CellDataOffsets")["force"] = (n * np.arange(count) + before).astype(np.int64)
