"""What a user asks first: which version, which device, where are the caches, what is missing."""

import importlib.metadata
import os
import subprocess
import sys

import pytest

import warpdamp
from warpdamp.report import installation


def command(*arguments, **environment):
    line = [sys.executable, "-m", "warpdamp", *arguments]
    return subprocess.run(line, capture_output=True, text=True, check=False, env=os.environ | environment)


def test_version():
    done = command("--version")
    assert done.stdout == f"warpdamp {warpdamp.__version__}, physics version {warpdamp.PHYSICS_VERSION}\n"


def test_info_names_versions_devices_caches_and_extras(tmp_path):
    done = command("info", WARPDAMP_CACHE=str(tmp_path), WARP_CACHE_PATH=str(tmp_path / "kernels"))
    assert done.returncode == 0, done.stderr
    lines = {line.split()[0]: line for line in done.stdout.splitlines()}
    assert f"{warpdamp.__version__} (physics {warpdamp.PHYSICS_VERSION}" in lines["warpdamp"]
    assert f"{os.cpu_count()} cores" in lines["cpu"]
    assert f"{tmp_path / 'beds'}: 0 files, 0.0 MB" in lines["beds"]
    assert str(tmp_path / "kernels") in lines["kernels"]


def test_what_is_in_a_cache_is_counted(tmp_path, monkeypatch):
    monkeypatch.setenv("WARPDAMP_CACHE", str(tmp_path))
    (tmp_path / "beds" / "deep").mkdir(parents=True)
    (tmp_path / "beds" / "deep" / "bed").write_bytes(bytes(1_500_000))
    assert installation.caches()["beds"] == f"{tmp_path / 'beds'}: 1 files, 1.5 MB"


def test_a_missing_extra_is_named_with_the_line_that_installs_it(monkeypatch):
    monkeypatch.setattr(
        importlib.metadata, "requires", lambda _: ["numpy>=2", "numpy; extra == 'there'", "nowhere>=1; extra == 'lost'"]
    )
    assert installation.extras() == {"there": "installed", "lost": "nowhere missing: pip install 'warpdamp[lost]'"}


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_complete_commands(shell):
    words = {"COMP_WORDS": "warpdamp sta", "COMP_CWORD": "1"}  # bash
    words |= {"_TYPER_COMPLETE_ARGS": "warpdamp sta", "_TYPER_COMPLETE_FISH_ACTION": "get-args"}  # zsh and fish
    done = command(_WARPDAMP_COMPLETE=f"complete_{shell}", **words)
    assert "status" in done.stdout
    assert "collect" not in done.stdout
