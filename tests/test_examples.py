"""The examples in the docstrings of the public names that are used most run, from the root of the repository."""

import doctest
import importlib
import pkgutil
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


def test_examples_of_what_is_not_public_hold(monkeypatch):
    """Docstrings of the modules below; those of the public names are above."""
    monkeypatch.chdir(Path(__file__).parents[1])
    public = {id(getattr(warpdamp, name)) for name in warpdamp.__all__}
    runner, finder = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS), doctest.DocTestFinder()
    for info in pkgutil.walk_packages(warpdamp.__path__, "warpdamp."):
        if ".kernels" in info.name or info.name == "warpdamp.__main__":
            continue
        module = importlib.import_module(info.name)
        for example in finder.find(module, info.name):
            if example.examples and id(getattr(module, example.name.rpartition(".")[2], None)) not in public:
                runner.run(example)
    assert runner.summarize(verbose=False).failed == 0
    assert runner.tries > 5
