"""What is shipped, and what scripts and configurations promise."""

import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from warpdamp import load

ROOT = Path(__file__).parents[1]


def test_the_wheel_holds_every_module_and_no_other(tmp_path):
    """A sub-package missing from pyproject's list would be missing from the wheel without a word."""
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "-q", "-w", tmp_path, ROOT]
    subprocess.run(command, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    shipped = {name for name in zipfile.ZipFile(wheel).namelist() if name.endswith(".py")}
    own = {p.relative_to(ROOT).as_posix() for p in (ROOT / "warpdamp").rglob("*.py")}
    own = {path for path in own if not path.startswith("warpdamp/kernels/")}
    own |= {f"warpdamp/{p.relative_to(ROOT).as_posix()}" for p in (ROOT / "kernels").glob("*.py")}
    assert shipped == own


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


def test_the_command_line_starts_without_the_heavy_libraries():
    code = "import sys, warpdamp.cli; print([m for m in ('warp', 'xarray', 'skfem', 'matplotlib', 'pint') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("path", sorted((ROOT / "configs").rglob("*.yaml")), ids=lambda p: p.name)
def test_every_configuration_is_valid(path):
    load(path)


def test_the_version_is_in_the_changelog():
    import warpdamp

    assert f"## {warpdamp.__version__}" in (ROOT / "CHANGELOG.md").read_text()
    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["name"] == "warpdamp"
