"""The answer to a design problem as a Dataset, and what was left out of its tolerances."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from design_formula import STUDY, by_formula, simulated
from warpdamp import load
from warpdamp.analysis.results import read, write
from warpdamp.design import tolerances
from warpdamp.design.dataset import CHOSEN, FRONT, RUNNER_UP, to_dataset
from warpdamp.design.run import design
from warpdamp.design.tolerances import sensitivity
from warpdamp.errors import UsageError
from warpdamp.report.design import lines


@pytest.fixture(scope="module")
def answer(tmp_path_factory):
    folder = tmp_path_factory.mktemp("design")
    (folder / "study.yaml").write_text(STUDY)
    with by_formula():
        return design(load(folder / "study.yaml"), folder / "store")


def test_a_dataset_holds_the_answer_and_survives_its_file(answer, tmp_path):
    path = tmp_path / "design.nc"
    write(to_dataset(answer), path)
    found = read(path, design=True)
    verified, chosen = answer.verified, answer.design
    assert found["particle_mass"][0].item() == chosen.mass
    assert [found[name][0].item() for name in ("height", "count")] == list(chosen.values.values())
    np.testing.assert_array_equal(found["damping_ratio"].sel(mode=1), verified.damping)
    np.testing.assert_array_equal(found["damping_ratio_mean"].sel(mode=1), verified.mean)
    assert found["target_probability"].item() == verified.probability
    assert found["height"].attrs["units"] == "m"
    roles = [(name, len(list(group))) for name, group in itertools.groupby(found["role"].values)]
    assert roles == [(CHOSEN, 1), (FRONT, len(answer.front)), (RUNNER_UP, 3)]
    assert dict(zip(found["tolerance"].values, found["tolerance_unit"].values, strict=True)) == {
        "contact.friction": "1",
        "contact.restitution": "1",
        "damper.enclosure.height": "m",
        "damper.enclosure.diameter": "m",
    }
    assert all(variable.attrs.get("long_name") for variable in found.variables.values())


def test_the_configuration_in_it_is_that_of_the_damper(answer, tmp_path):
    path = tmp_path / "chosen.yaml"
    path.write_text(to_dataset(answer).attrs["configuration"])
    assert load(path).damper == answer.design.config.damper


def test_it_is_no_results_file(answer, tmp_path):
    path = tmp_path / "design.nc"
    write(to_dataset(answer), path)
    with pytest.raises(UsageError, match="holds the answer of a design: `warpdamp report` makes a page of it"):
        read(path)
    assert xr.load_dataset(path).attrs["history"].endswith("warpdamp design")


class Again:
    """A search of the problem, as the tolerances take it."""

    def __init__(self, answer, store, run):
        from warpdamp.design.search import Search

        self._search = Search(answer.problem, store, 1, lambda *_: None, lambda _: None)
        self._run = run
        self.rows = []

    def __getattr__(self, name):
        return getattr(self._search, name)

    def run_apart(self, orders):
        return self._run(self.problem, orders, None, workers=1, report=None)


def test_designs_that_cannot_be_and_cases_without_a_result_are_counted(answer, monkeypatch, tmp_path):
    """Friction of every second design drawn is made negative, and every third case of the others fails."""
    varied, calls, nan = tolerances._varied, itertools.count(), np.nan

    def refused(design, spans, part):
        return varied(design, spans, part if next(calls) % 2 else np.full(len(part), -1e3))

    def failing(problem, orders, store, **options):
        rows = simulated(problem, orders, store, **options)
        return [type(r)(r.order, r.frequency, nan, nan, nan, nan) if k % 3 == 0 else r for k, r in enumerate(rows)]

    monkeypatch.setattr(tolerances, "_varied", refused)
    found = sensitivity(Again(answer, tmp_path, failing), answer.verified)
    assert (found.samples, found.impossible, found.cases, found.failed) == (8, 4, 12, 4)
    said = "\n".join(lines(replace(answer, sensitivity=found)))
    assert "4 of 8 designs drawn from these ranges cannot be, and were left out" in said
    assert "4 of 12 cases simulated there gave no result: left out" in said
