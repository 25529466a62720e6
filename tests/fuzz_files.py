"""Valid files of every kind that other people's programs write, and what must hold when they are damaged.

``damage(number)`` makes the numbered case of an endless series, and ``is_read(case, folder)`` tries it.
"""

from __future__ import annotations

import contextlib
import faulthandler
import functools
import importlib.util
import io
import os
import pickle
import shutil
import signal
import tempfile
import warnings
from collections.abc import Callable
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import numpy as np

import nastran_files as nastran
import universal_files as universal
from conftest import ROOT
from frf_files import FREQUENCY, IN, MM, SI, accelerance, binary58, frf58, integrated, table, uff
from fuzz_damage import PIECES, damaged
from warpdamp import ConfigError, load, open_results
from warpdamp.coupled import recorded
from warpdamp.errors import ModalError, WarpdampError
from warpdamp.formats import mode_rst
from warpdamp.formats.apart import seconds_for
from warpdamp.formats.frf_file import read_frf
from warpdamp.formats.mesh_file import load_named
from warpdamp.formats.mode_csv import read_csv, write_csv
from warpdamp.formats.mode_nastran import read_nastran
from warpdamp.formats.mode_uff import read_uff, write_uff
from warpdamp.modal.card import MEASURED, card, read_card, write_card
from warpdamp.modal.identify import fits
from warpdamp.modes import Modes

LONGEST = 10
"""Seconds that a file may take."""
STUDY = """damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 16, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 3 300 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 86 %}
excitation: {gamma: [1, 2], frequency: [46 Hz, 0.1 kHz], gravity: 9.81 m/s^2}
seeds: [1]
"""


class TooLong(BaseException):
    """Time over, which no reader may take for an error of the file."""


@dataclass(frozen=True)
class Case:
    """A file that was valid, and the options that it is read with."""

    kind: str
    name: str
    content: bytes
    options: dict


def damage(number: int) -> Case:
    """The numbered case: a valid file with one to four damages, and options that mostly fit it."""
    rng = np.random.default_rng(number)
    valid = valid_files()
    kind, name = list(valid)[int(rng.integers(len(valid)))]
    content = damaged(valid[kind, name], rng)
    options = _frf_options(kind, rng) if kind.startswith("FRFs") else {}
    return Case(kind, name, content, options)


def is_read(case: Case, folder: Path) -> bool:
    """Whether a case is read; an error that is none of the package's, or of more than a line, comes through."""
    path = folder / case.name
    path.write_bytes(case.content)
    try:
        with _in_time(), warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            KINDS[case.kind](path, **case.options)
    except WarpdampError as error:
        _one_line_each(error, path)
        return False
    return True


def _one_line_each(error: Exception, path: Path) -> None:
    """A configuration may have several errors, each on a line with its place."""
    lines = str(error).split("\n")
    assert all(lines), error
    if isinstance(error, ConfigError):
        assert all(line.startswith(str(path.parent)) for line in lines), error
    else:
        assert len(lines) == 1, error


@contextmanager
def _in_time():
    """Ends what takes too long, where the system can."""

    def over(*_):
        raise TooLong(f"took more than {LONGEST} s")

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


# Readers, and what must hold of all that they let pass.


def _modes(reader, path: Path, **options) -> None:
    modes = reader(path, **options)
    assert np.isfinite(modes.shape).all()
    assert np.isfinite(modes.frequency).all()
    assert len(modes.number) == len(set(modes.number.tolist()))
    picked = modes.pick(modes.dampable).with_mass(0.01)
    assert np.isfinite(picked.inherent_damping).all()
    assert np.isfinite(picked.modal_mass).all()


def _nastran_modes(path: Path) -> None:
    _modes(read_nastran, path, units="MM-N", modal_mass=1000.0 if path.suffix == ".pch" else None)


def _mesh(path: Path) -> None:
    assert np.isfinite(load_named(path).mesh.p).all()


def _frf(path: Path, **options) -> None:
    found = fits(read_frf(path, **options))
    kept = found["fitted_frequency"].notnull()
    inside = (found["fitted_frequency"] >= found["band_start"]) & (found["fitted_frequency"] <= found["band_end"])
    assert (inside | ~kept).all()
    assert ((found["fitted_damping_ratio"] > 0) | ~kept).all()


def _card(path: Path) -> None:
    part = read_card(path)
    for name in MEASURED:
        assert np.isfinite(part[name]).all()
        assert (part[f"{name}_interval"] >= 0).all()


def _forked(function: Callable, file: Path, _library: str):
    """The same as ``formats.apart``, by a fork: libraries are imported once, not for each of a thousand files."""
    result = file.with_name("result-of-a-process")
    result.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        import resource  # not on Windows, where there is no fork either

        signal.alarm(0)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        faulthandler.dump_traceback_later(seconds_for(file), exit=True)
        try:
            found = function(file)
        except Exception as error:  # which the parent raises again
            found = error
        with contextlib.suppress(Exception):
            result.write_bytes(pickle.dumps(found))
        os._exit(0)
    end = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if not result.is_file():
        raise ModalError(f"{file} is damaged: its reader crashed or came to no end ({end}): write it again")
    found = pickle.loads(result.read_bytes())
    if isinstance(found, Exception):
        raise found
    return found


def _ansys_modes(path: Path) -> None:
    with mock.patch.object(mode_rst, "apart", _forked):
        _modes(mode_rst.read_rst, path, units="MM-N", modal_mass=1000.0)


def _record(path: Path) -> None:
    samples, step = recorded.samples(path, "force" if path.stem.startswith("force") else "acceleration")
    assert np.isfinite(samples).all()
    assert step > 0


def _sweep(path: Path) -> None:
    study = path.with_name("study-of-a-sweep.yaml")
    study.write_text(STUDY + f"sweep: {{csv: {path.name}}}\n")
    load(study)


KINDS: dict[str, Callable] = {
    "modes, CSV": functools.partial(_modes, read_csv),
    "modes, universal file": functools.partial(_modes, read_uff),
    "modes, Nastran": _nastran_modes,
    **({"modes, Ansys": _ansys_modes} if importlib.util.find_spec("ansys") and hasattr(os, "fork") else {}),
    "meshes": _mesh,
    "FRFs, table": _frf,
    "FRFs, universal file": _frf,
    "records of forces and bases": _record,
    "cards, table": _card,
    "cards, netCDF": _card,
    "cases of a sweep, CSV": _sweep,
    "configurations, YAML": load,
}


def read_valid_files(folder: Path) -> None:
    """Read every file before it is damaged; an error comes through."""
    for (kind, name), content in valid_files().items():
        (folder / name).write_bytes(content)
        KINDS[kind](folder / name, **({"number": 1} if kind == "FRFs, universal file" else {}))


def _frf_options(kind: str, rng) -> dict:
    """A choice among a universal file's functions, and now and then an ordinate or a unit."""
    options = {}
    if kind == "FRFs, universal file":
        one = rng.random() < 0.7
        options = {"response": None, "number": 1, "every": False} if one else {"response": "2z", "every": True}
    if rng.random() < 0.1:
        options |= {"ordinate": str(rng.choice(["accelerance", "mobility", "receptance"]))}
    if rng.random() < 0.1:
        options |= {"units": str(rng.choice(["g/N", "mm/s/N", "m/N", "kg", *PIECES]))}
    return options


# The valid files.


@functools.cache
def valid_files() -> dict[tuple[str, str], bytes]:
    """Content of valid files, by their kind and name."""
    files = {}
    with tempfile.TemporaryDirectory() as name:
        for write in (_write_modes, _write_nastran, _write_ansys, _write_meshes, _write_cards):
            folder = Path(name) / write.__name__
            folder.mkdir()
            for kind in write(folder):
                files |= {(kind[0], file.name): file.read_bytes() for file in sorted(folder.glob(kind[1]))}
    return files | _tables()


def _tables() -> dict[tuple[str, str], bytes]:
    lines = slice(370, 430)  # round the peak at 39.5 Hz
    f, a, y = FREQUENCY[lines], accelerance()[lines], integrated(1)[lines]
    time = np.arange(40) * 1e-3
    blow = np.where(time < 8e-3, 50 * np.sin(np.pi * time / 8e-3), 0.0)
    decibels = (f, 20 * np.log10(abs(a)), np.angle(a))
    text, universal_file, record = "FRFs, table", "FRFs, universal file", "records of forces and bases"
    return {
        (text, "real.csv"): table((f, a.real, a.imag), "f [Hz],Re [(m/s^2)/N],Im [(m/s^2)/N]"),
        (text, "polar.csv"): table(
            (f, abs(y), np.degrees(np.angle(y))), "Frequency;|Y| [mm/s/N];Phase [deg]", mark=";", decimal=","
        ),
        (text, "decibel.txt"): table(decibels, "omega [rad/s]\tmag [dB re 1 g/N]\tphase [rad]", mark="\t"),
        (text, "wide.csv"): table((f, a.real, a.imag), "Frequenz [Hz],Re,Im", encoding="utf-16"),
        (universal_file, "text.uff"): uff(SI, frf58(a, f), frf58(y, f, numerator=(11, "m/s"), response=(3, 1))),
        (universal_file, "uneven.unv"): uff(
            MM, frf58(a, f, numerator=(12, ""), denominator=(13, ""), data_type=6, even=False)
        ),
        (universal_file, "binary.uf"): uff(IN) + binary58(a, f, numerator=(12, ""), denominator=(13, "")),
        (record, "force.csv"): table((time, blow), "time_s,force_N"),
        (record, "force-german.csv"): table((1e3 * time, blow), "time [ms];force [kN]", mark=";", decimal=","),
        (record, "base.csv"): table((time, blow / 50), "time_s\tacceleration_g", mark="\t", encoding="utf-16"),
        ("cases of a sweep, CSV", "cases.csv"): table(
            ((0.3, 0.5, 0.8), (4.0, 8.0, 12.0)), "contact.friction,damper.particles.count"
        ),
        ("configurations, YAML", "study.yaml"): STUDY.encode(),
    }


def _write_modes(folder: Path):
    """Modes as this package writes them, a table of another country, and universal files with systems and complex data."""
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
    text = (folder / "modes.csv").read_text()
    (folder / "german.csv").write_bytes(text.replace(",", ";").replace(".", ",").encode("utf-16"))
    _write_local_systems(folder / "local.uff")
    return ("modes, CSV", "*.csv"), ("modes, universal file", "*.uff")


def _write_local_systems(file: Path) -> None:
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


def _write_nastran(folder: Path):
    values, vectors = nastran.exact()
    shapes = np.zeros((3, 3, 6))
    shapes[:, :, 2] = vectors.T
    bulk = [*nastran.grid(7), *nastran.lumped(), "CORD2R,7,,0.,0.,0.,0.,0.,1.", ",1.,0.,0."]
    (folder / "run.f06").write_text(nastran.f06(shapes, values, [1.0] * 3, echo=bulk))
    (folder / "run.pch").write_text(nastran.pch(shapes, values, extra=[*bulk, *nastran.dmig(nastran.MASS)]))
    return (("modes, Nastran", "run.*"),)


def _write_ansys(folder: Path):
    """The example of the reader's package, where it is installed: six modes of 321 nodes."""
    if "modes, Ansys" not in KINDS:
        return ()
    from ansys.mapdl.reader import examples

    shutil.copy(examples.rstfile, folder / "run.rst")
    return (("modes, Ansys", "run.rst"),)


def _write_cards(folder: Path):
    """The card of the paper's damper, at some Gammas."""
    part = card(open_results(ROOT / "docs" / "beam.nc").sel(gamma=[2.0, 4.0, 6.0]))
    write_card(part, folder / "damper.csv")
    write_card(part, folder / "damper.nc")
    return ("cards, table", "*.csv"), ("cards, netCDF", "*.nc")


def _write_meshes(folder: Path):
    import meshio
    from skfem import MeshHex, MeshTet

    steps = (np.linspace(0, 2, 3), np.linspace(0, 1, 2), np.linspace(0, 1, 2))
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):  # meshio says what it makes up
        MeshHex.init_tensor(*steps).save(folder / "hexahedra.vtk")
        MeshTet.init_tensor(*steps).save(folder / "tetrahedra.msh", file_format="gmsh22")
        solid = meshio.read(folder / "hexahedra.vtk")
        cells = solid.cells_dict["hexahedron"]
        wedges = np.concatenate([cells[1:, [0, 1, 2, 4, 5, 6]], cells[1:, [0, 2, 3, 4, 6, 7]]])
        root = {"ROOT": np.flatnonzero(solid.points[:, 0] == 0)}
        mixed = [("hexahedron", cells[:1]), ("wedge", wedges)]
        meshio.Mesh(solid.points, mixed, point_sets=root).write(folder / "mixed.inp")
        square = solid.points * [1, 1, 0]
        meshio.Mesh(square, [("quad", cells[:, :4]), ("line", cells[:, :2])]).write(
            folder / "section.vtk", binary=False
        )
    return (("meshes", "*"),)
