"""The page of a design: its words and numbers, without a browser."""

import re

import xarray as xr
from typer.testing import CliRunner

from warpdamp.analysis.results import write
from warpdamp.cli.app import app
from warpdamp.report.design_page import write_design_report


def text_of(dataset, tmp_path):
    write_design_report(dataset, tmp_path / "d.html")
    return (tmp_path / "d.html").read_text()


def test_the_page_names_the_damper_its_probability_and_where_it_is_from(answer, tmp_path):
    text = text_of(answer, tmp_path)
    damps = "Which damper damps mode 1 over Γ 2 to 8 by at least 2 %, with the least mass?"
    assert damps in text
    assert f"P = {float(answer['target_probability']):.3f} (" in text
    assert f"height {1e3 * float(answer['height'][0]):.4g} mm, count {int(answer['count'][0])}" in text
    assert text.count('<th scope="row">runner-up</th>') == 3
    assert "damper.enclosure.diameter" in text
    assert "warpdamp design" in text
    assert "confidence: 0.95" in text  # the problem, beside the damper
    assert not re.search(r"""(src|href)=["'](?!#|data:)""", text)


def test_without_a_claim_the_page_says_so(answer, tmp_path):
    refused = answer.drop_dims("tolerance").assign(claimed=0)
    text = text_of(refused, tmp_path)
    assert "No claim: the best damper found meets the target with P = " in text
    assert "0.95 was asked for" in text
    assert "Tolerances" not in text


def test_without_a_target_the_page_asks_for_the_most_damping(answer, tmp_path):
    names = [name for name in answer if name.startswith("target_")]
    free = answer.drop_dims("tolerance").drop_vars(names).assign_attrs(goal="the most damping")
    text = text_of(free, tmp_path)
    assert "Which damper has the most damping in mode 1 over Γ 2 to 8?" in text
    assert "P = " not in text


def test_modes_with_gammas_of_their_own(answer, tmp_path):
    """As over a range of force, which leads to other Gammas in each mode."""
    second = answer.assign_coords(mode=[3]).assign(gamma=2 * answer["gamma"])
    both = xr.concat([answer, second], "mode", data_vars="minimal", coords="minimal", compat="override")
    both = both.assign_attrs(target_over="force", target_range=[0.1, 0.4])
    text = text_of(both, tmp_path)
    assert "Which damper damps modes 1, 3 over a force at the damper of 0.1 to 0.4 N by at least 2 %" in text
    assert text.count(" % at Γ ") == 2 * answer.sizes["point"]
    assert '<th scope="col">mode 3</th>' in text


def test_what_was_left_out_of_the_tolerances_is_said(answer, tmp_path):
    assert "4 of 8 designs" in text_of(answer.assign_attrs(left_out="4 of 8 designs cannot be"), tmp_path)


def test_the_command_takes_the_file_that_a_design_writes(answer, tmp_path):
    write(answer, tmp_path / "small-design.nc")
    done = CliRunner().invoke(app, ["report", str(tmp_path / "small-design.nc")])
    assert done.exit_code == 0, done.stderr
    assert "Which damper" in (tmp_path / "small-design.html").read_text()
