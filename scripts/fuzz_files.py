"""Modes and meshes with anything changed in their files: read or refused in one line, never a traceback, never a hang.

    python scripts/fuzz_files.py [10000]

mutates valid files, reads each, and prints how many were read and refused; ``check`` is what the tests call with fewer.
"""

from __future__ import annotations

import io
import signal
import sys
import tempfile
from collections import Counter
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

import nastran_files as nastran  # noqa: E402
import universal_files as universal  # noqa: E402
from warpdamp.errors import MissingLibrary, ModalError  # noqa: E402
from warpdamp.modal.mesh_file import load_named  # noqa: E402
from warpdamp.modal.mode_csv import read_csv, write_csv  # noqa: E402
from warpdamp.modal.mode_nastran import read_nastran  # noqa: E402
from warpdamp.modal.mode_uff import read_uff, write_uff  # noqa: E402
from warpdamp.modal.modes import Modes  # noqa: E402
from warpdamp.text_file import TableError  # noqa: E402

LONGEST = 10
"""Seconds that a file may take."""


def valid_files(folder: Path) -> list[Path]:
    """Files of every kind, each of which can be read."""
    random = np.random.default_rng(1)
    modes = Modes(
        number=np.array([1, 2]),
        frequency=np.array([40.0, 55.5]),
        point=random.normal(size=(3, 3)),
        shape=random.normal(size=(2, 3, 3)),
        inherent_damping=np.array([0.001, 0.0]),
    )
    write_uff(folder / "modes.uff", modes)
    write_csv(folder / "modes.csv", modes)
    _local_systems(folder / "local.uff")
    _nastran(folder)
    table = (folder / "modes.csv").read_text()
    (folder / "german.csv").write_bytes(table.replace(",", ";").replace(".", ",").encode("utf-16"))
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):  # meshio says what it makes up
        _meshes(folder)
    return sorted(folder.iterdir())


def _local_systems(file: Path) -> None:
    """Complex storage, nodes in systems of both datasets, a binary function between them."""
    axes = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    geometry = universal.systems_2420((4, 0, axes, (0.1, 0, 0)), (5, 1, np.eye(3), (0, 0, 0)))
    systems = universal.systems_18(6, 0, (0, 0, 0), (1, 0, 0), (1, 0, 1))
    nodes = universal.nodes_15([(0, 0, 0), (0.3, 0, 0)], 4, 5)
    mode = universal.mode_2414(1, {1: (0, 0, 0.5), 2: (0, 0, 1)}, storage=5)
    universal.write(file, universal.units(), geometry, systems, nodes)
    text = "\n".join(
        universal.mode_55(2, {1: (0, 0, 1), 2: (0, 0, -1)}, analysis=3, eigenvalue=-2 + 300j, modal_a=1200j) + mode
    )
    file.write_bytes(file.read_bytes() + universal.binary_58b() + text.encode() + b"\n")


def _nastran(folder: Path) -> None:
    values, vectors = nastran.exact()
    shapes = np.zeros((3, 3, 6))
    shapes[:, :, 2] = vectors.T
    bulk = [*nastran.grid(7), *nastran.lumped(), "CORD2R,7,,0.,0.,0.,0.,0.,1.", ",1.,0.,0."]
    (folder / "run.f06").write_text(nastran.f06(shapes, values, [1.0] * 3, echo=bulk))
    (folder / "run.pch").write_text(nastran.pch(shapes, values, extra=[*bulk, *nastran.dmig(nastran.MASS)]))


def _meshes(folder: Path) -> None:
    import meshio
    from skfem import MeshHex, MeshTet

    steps = (np.linspace(0, 2, 3), np.linspace(0, 1, 2), np.linspace(0, 1, 2))
    for name, kind in (("hexahedra.vtk", MeshHex), ("tetrahedra.msh", MeshTet)):
        kind.init_tensor(*steps).save(folder / name, **({"file_format": "gmsh22"} if name.endswith("msh") else {}))
    solid = meshio.read(folder / "hexahedra.vtk")
    cells = solid.cells_dict["hexahedron"]
    mixed = [
        ("hexahedron", cells[:1]),
        ("wedge", np.concatenate([cells[1:, [0, 1, 2, 4, 5, 6]], cells[1:, [0, 2, 3, 4, 6, 7]]])),
    ]
    root = np.flatnonzero(solid.points[:, 0] == 0)
    meshio.Mesh(solid.points, mixed, point_sets={"ROOT": root}).write(folder / "mixed.inp")
    square = solid.points * [1, 1, 0]
    meshio.Mesh(square, [("quad", cells[:, :4]), ("line", cells[:, :2])]).write(folder / "section.vtk", binary=False)


def read(file: Path) -> None:
    """Read a file as the package does; what comes out is finite."""
    if file.suffix == ".uff":
        _check_modes(read_uff(file))
    elif file.suffix == ".csv":
        _check_modes(read_csv(file))
    elif file.suffix in (".f06", ".pch"):
        _check_modes(read_nastran(file, units="MM-N", modal_mass=1000.0 if file.suffix == ".pch" else None))
    else:
        named = load_named(file)
        assert np.isfinite(named.mesh.p).all()


def _check_modes(modes: Modes) -> None:
    assert np.isfinite(modes.shape).all()
    assert np.isfinite(modes.frequency).all()
    assert len(modes.number) == len(set(modes.number.tolist()))
    picked = modes.pick(modes.dampable).with_mass(0.01)
    assert np.isfinite(picked.inherent_damping).all()
    assert np.isfinite(picked.modal_mass).all()


TOKENS = [
    *(
        b"",
        b"-1",
        b"    -1\n",
        b"nan",
        b"1e999",
        b"1e-320",
        b"-",
        b",",
        b";",
        b"\t",
        b"\n",
        b"\r",
        b"\0",
        b"\xff",
        b"0",
    ),
    *(b"1.5", b"99999999999999999999", b"*", b"$", b'"', b"#", b"    55\n", b"    58b     1     2    11    9\n"),
]


@st.composite
def mutated(draw, content: bytes) -> bytes:
    """Bytes with one to four things changed: a stretch taken out, doubled, moved, or written over."""
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(content)))
        stop = min(len(content), start + draw(st.sampled_from([0, 1, 2, 10, 13, 81, 400, 100000])))
        how = draw(st.sampled_from(["cut", "double", "move", "write", "random", "digit"]))
        part = content[start:stop]
        if how == "cut":
            content = content[:start] + content[stop:]
        elif how == "double":
            content = content[:stop] + part[:400] + content[stop:]
        elif how == "move":
            to = draw(st.integers(0, start))
            content = content[:to] + part + content[to:start] + content[stop:]
        elif how == "write":
            token = draw(st.sampled_from(TOKENS))
            content = content[:start] + token + content[start + len(token) :]
        elif how == "digit":
            content = content[:start] + draw(st.sampled_from([b"0", b"1", b"7", b"-", b" "])) + content[start + 1 :]
        else:
            content = content[:start] + draw(st.binary(max_size=8)) + content[start:]
    return content


@contextmanager
def _in_time():
    """Ends what takes too long, where the system can."""

    def over(*_):
        raise TimeoutError(f"took more than {LONGEST} s")

    if not hasattr(signal, "SIGALRM"):
        yield
        return
    before = signal.signal(signal.SIGALRM, over)
    signal.alarm(LONGEST)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def check(examples: int, *, derandomize: bool = True) -> Counter:
    """Read so many mutated files; how many of each were "read" and "refused".

    Raises
    ------
    Exception
        What a reader let through, with the file's name and content as hypothesis found them.
    """
    counts: Counter = Counter()
    with tempfile.TemporaryDirectory() as folder:
        valid = {file.name: file.read_bytes() for file in valid_files(Path(folder))}
        for name in valid:
            read(Path(folder) / name)

        @settings(
            max_examples=examples, deadline=None, derandomize=derandomize, database=None,
            suppress_health_check=list(HealthCheck), phases=[Phase.generate],
        )  # fmt: skip
        @given(data=st.data())
        def one(data):
            name = data.draw(st.sampled_from(sorted(valid)))
            file = Path(folder) / f"mutated-{name}"
            file.write_bytes(data.draw(mutated(valid[name])))
            try:
                with _in_time():
                    read(file)
            except (ModalError, TableError, MissingLibrary) as error:
                said = str(error)
                assert "\n" not in said, said
                counts[name, "refused"] += 1
            else:
                counts[name, "read"] += 1

        one()
    return counts


if __name__ == "__main__":
    found = check(int(sys.argv[1]) if len(sys.argv) > 1 else 10000, derandomize=False)
    for (name, fate), count in sorted(found.items()):
        print(f"{name:16} {fate:8} {count}")
    print(f"{'all':25} {sum(found.values())}")
