"""What is shipped, and what scripts and configurations promise."""

import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from warpdamp import load

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Path of the wheel."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "-q", "-w", folder, ROOT]
    subprocess.run(command, check=True, capture_output=True)
    (found,) = folder.glob("*.whl")
    return found


def test_the_wheel_holds_every_module_and_no_other(wheel):
    """A sub-package missing from pyproject's list would be missing from the wheel without a word."""
    names = zipfile.ZipFile(wheel).namelist()
    shipped = {name for name in names if name.endswith(".py")}
    own = {p.relative_to(ROOT).as_posix() for p in (ROOT / "warpdamp").rglob("*.py")}
    own = {path for path in own if not path.startswith("warpdamp/kernels/")}
    own |= {f"warpdamp/{p.relative_to(ROOT).as_posix()}" for p in (ROOT / "kernels").glob("*.py")}
    assert shipped == own
    assert {"warpdamp/py.typed"} < set(names)
    pages = {p.relative_to(ROOT).as_posix() for p in (ROOT / "warpdamp" / "report" / "page").iterdir()}
    assert pages == {name for name in names if name.startswith("warpdamp/report/page/")} != set()


def test_the_wheel_runs_a_study_away_from_the_checkout(wheel, tmp_path):
    """The libraries are those of this environment, warpdamp itself the wheel's alone."""
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "site")}

    def python(*arguments):
        line = [sys.executable, "-P", *arguments]
        return subprocess.run(line, capture_output=True, text=True, check=True, cwd=tmp_path, env=environment).stdout

    assert Path(python("-c", "import warpdamp; print(warpdamp.__file__)").strip()).is_relative_to(tmp_path / "site")
    text = (ROOT / "configs" / "modes_given.yaml").read_text()
    (tmp_path / "short.yaml").write_text(text.replace("[1, 2, 3, 4, 6, 8, 10]", "[2, 6]"))
    python("-m", "warpdamp", "run", "short.yaml", "--quick", "--workers", "1")
    assert (tmp_path / "results" / "short-quick.png").read_bytes()[:4] == b"\x89PNG"


def test_kernels_do_not_defer_annotations():
    """Warp reads the annotation objects; ``from __future__ import annotations`` would make them text."""
    for path in (ROOT / "kernels").glob("*.py"):
        assert not any(line.startswith("from __future__") for line in path.read_text().splitlines()), path


def test_every_public_name_can_be_had():
    import warpdamp

    for name in warpdamp.__all__:
        assert getattr(warpdamp, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = warpdamp.nonsense


@pytest.mark.parametrize(
    "action", ["import warpdamp.cli.app", f"import warpdamp; warpdamp.load({str(ROOT / 'configs' / 'beam.yaml')!r})"]
)
def test_the_command_line_starts_and_configurations_are_read_without_the_heavy_libraries(action):
    heavy = ("numpy", "scipy", "warp", "xarray", "skfem", "matplotlib", "pint")
    code = f"{action}; import sys; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("path", sorted((ROOT / "configs").rglob("*.yaml")), ids=lambda p: p.name)
def test_every_configuration_is_valid(path):
    load(path)


def test_the_version_is_in_the_changelog():
    import warpdamp

    assert f"## {warpdamp.__version__}" in (ROOT / "CHANGELOG.md").read_text()
    assert f"version: {warpdamp.__version__}\n" in (ROOT / "CITATION.cff").read_text()
    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["name"] == "warpdamp"
