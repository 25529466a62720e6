"""The examples in the docstrings of the public names that are used most run, from the root of the repository."""

import doctest
from pathlib import Path

import pytest

import warpdamp

NAMES = (
    "load", "run", "open_results", "Material", "Surface", "Cylinder", "Drive", "Scene", "State", "Simulation", "Request",
    "prepare", "peaks", "accelerance", "corrected", "fits",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_the_example_of_a_public_name_runs(name, monkeypatch):
    monkeypatch.chdir(Path(__file__).parents[1])  # examples name configs/... and docs/beam.nc
    [example] = doctest.DocTestFinder(recurse=False).find(getattr(warpdamp, name), name, globs={})
    report = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    failed, attempted = runner.run(example, out=report.append)
    assert attempted, f"{name} has no example"
    assert not failed, "".join(report)
