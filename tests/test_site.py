"""The code of the site's pages and of the README is that of the present version: options, keys and names exist.

The commands of the tutorial are run from first to last by ``.ci/run``, which also builds the site.
"""

import ast
import json
import os
import re
import shlex
import sys

import pytest
import typer.main
import xarray as xr
from pydantic import ValidationError
from ruamel.yaml import YAML

import warpdamp
from conftest import ROOT
from warpdamp.cli.app import app
from warpdamp.config.study import Config

sys.path.insert(0, str(ROOT / "docs" / "_ext"))

import evidence_page
import variables_page
import yaml_page
from blocks import blocks, script

PAGES = [
    ROOT / "README.md",
    *sorted(path for folder in ("tutorial", "howto", "theory") for path in (ROOT / "docs" / folder).glob("*.md")),
]
BLOCKS = [(page, block) for page in PAGES for block in blocks(page.read_text(encoding="utf-8"))]


def of(language):
    return [
        pytest.param(page, block, id=f"{page.stem}:{block.line}")
        for page, block in BLOCKS
        if block.language == language
    ]


def commands(text):
    """Every call of warpdamp in a block of shell, as lists of words."""
    for line in text.splitlines():
        for part in line.split("&&"):
            words = shlex.split(part.partition(">")[0], comments=True)
            if words and os.path.basename(words[0]) == "warpdamp":
                yield words[1:]


@pytest.mark.parametrize(("page", "block"), of("sh"))
def test_commands_and_their_options_exist(page, block):
    group = typer.main.get_command(app)
    for words in commands(block.text):
        context = group.make_context("warpdamp", list(words), resilient_parsing=True)
        name, command, rest = group.resolve_command(context, words[:])
        assert command is not None, f"{page}:{block.line}: there is no command {name}"
        command.make_context(name, rest, parent=context)  # raises where an option or an argument is wrong


@pytest.mark.parametrize(("page", "block"), of("yaml"))
def test_yaml_is_valid_within_a_study(page, block):
    """A fragment takes the place of the same sections of the paper's study."""
    load = YAML(typ="safe").load
    fragment = load(block.text)
    whole = load((ROOT / "configs" / "beam.yaml").read_text())
    study = fragment if {"damper", "materials"} <= set(fragment) else whole | fragment
    used = set(re.findall(r"material: (\w+)", str(study).replace("'", "")))
    study["materials"] = {name: material for name, material in study["materials"].items() if name in used}
    try:
        Config.model_validate(study)
    except ValidationError as error:
        pytest.fail(f"{page}:{block.line}: {error}")


@pytest.mark.parametrize(("page", "block"), of("python"))
def test_names_of_python_blocks_exist(page, block):
    """Blocks that read data of the repository run; of those that simulate, or read what a run would write, the names are."""
    for node in ast.walk(ast.parse(block.text)):
        if isinstance(node, ast.ImportFrom) and node.module.startswith("warpdamp"):
            module = __import__(node.module, fromlist=[alias.name for alias in node.names])
            assert all(hasattr(module, alias.name) for alias in node.names), f"{page}:{block.line}"
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "warpdamp":
            assert hasattr(warpdamp, node.attr), f"{page}:{block.line}: warpdamp.{node.attr}"
    if "docs/" in block.text or "beam_modes" in block.text:
        exec(compile(block.text, f"{page}:{block.line}", "exec"), {})


def test_links_to_files_of_the_repository_lead_somewhere():
    """Links of the README; those of the site's pages are checked when it is built."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    targets = [target for target in re.findall(r"\]\(([^)#]+)", text) if "://" not in target]
    assert targets
    assert not [target for target in targets if not (ROOT / target).exists()]


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_bytes()) <= 8192


def test_the_readmes_design_is_the_one_that_was_run():
    """The answer in the README is that in docs/design-example.txt, which `scripts/documents/design.py` writes."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    answer = text.partition("<!-- answer of the design example -->\n```\n")[2].partition("```")[0]
    assert answer.startswith("the target of 2 % is met with P = ")
    assert (ROOT / "docs" / "design-example.txt").read_text().startswith(answer)


def test_the_tutorial_is_one_script_that_begins_with_the_installation():
    lines = script((ROOT / "docs" / "tutorial" / "index.md").read_text(encoding="utf-8")).splitlines()
    assert lines[1:3] == ["python3 -m venv .venv", '.venv/bin/pip install ".[report]"']
    assert "cat > own.yaml <<'END'" in lines
    assert "warpdamp run own.yaml -o results --quick" in lines


def test_every_key_of_the_schema_is_in_the_reference():
    text = yaml_page.page()
    for model in Config.model_json_schema()["$defs"].values():
        for key in model["properties"]:
            assert f"`{key}`" in text


def test_every_variable_is_in_the_reference_once():
    names = [name for _, names in variables_page.groups() for name in names]
    assert sorted(names) == sorted(variables_page.variables.VARIABLES)


def test_commands_of_the_evidence_can_be_run():
    """Every document is listed, and the script that it names as its author exists."""
    text = evidence_page.page()
    for document in evidence_page.documents():
        assert f"(/{document.name})" in text
        written = evidence_page.command_of(document.read_text(encoding="utf-8"))
        for word in (evidence_page.record(document.stem).get("written", {}).get("command") or written).split():
            assert not word.endswith(".py") or (ROOT / word).exists(), f"{document.name}: {word}"


def test_the_versions_of_the_evidence_follow_from_notes_and_data(monkeypatch, tmp_path):
    """Last simulation before what was written down by hand, that before the data named, that before the writing."""
    monkeypatch.setattr(evidence_page, "DOCS", tmp_path)
    (tmp_path / "evidence").mkdir()
    xr.Dataset(attrs={"source": "warpdamp 0.1.0 (physics 4), python 3"}).to_netcdf(tmp_path / "old.nc")
    document = tmp_path / "some.md"
    document.write_text("# Some\n\nfrom docs/old.nc")
    written = {"written": {"physics_version": 6}}

    def of(notes):
        (tmp_path / "evidence" / "some.json").write_text(json.dumps(notes))
        return evidence_page.physics_of(document)

    assert of(written | {"simulated": {"physics_version": 7}, "data": "2"}) == "7"
    assert of(written | {"data": "2, a part 3"}) == "2, a part 3"
    assert of(written) == "4"
    document.write_text("# Some")
    assert of(written) == "6"
    assert of({}) == ""
    assert "- not noted: [some](/some.md)" in evidence_page.page()


def test_no_variable_page_depends_on_where_it_is_built(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert "Values of `status`" in variables_page.page()
