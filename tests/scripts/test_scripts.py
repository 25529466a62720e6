"""Every script can be started: all that it imports is there, and nothing is run before it is asked to."""

import runpy
import sys

import pytest

from conftest import ROOT

SCRIPTS = [
    *sorted((ROOT / "scripts").glob("*.py")),
    *sorted((ROOT / "scripts" / "documents").glob("*.py")),
    ROOT / "scripts" / "benchmarks" / "benchmark.py",
    ROOT / "scripts" / "benchmarks" / "limit" / "measure.py",
]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_every_script_imports_without_running(path, monkeypatch, capsys):
    monkeypatch.syspath_prepend(path.parent)
    monkeypatch.delitem(sys.modules, "shared", raising=False)  # it puts tests/ on the path that has just been changed
    runpy.run_path(str(path), run_name="imported")
    assert capsys.readouterr().out == ""
