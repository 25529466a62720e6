"""Any YAML is read or refused with a clear line; never a traceback."""

import io

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from conftest import ROOT
from warpdamp import ConfigError, load

BASE = YAML(typ="safe").load(ROOT / "configs" / "beam.yaml")
SCALARS = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=12), st.just("auto"), st.just("modes"),
    st.builds(lambda number, unit: f"{number} {unit}", st.floats(), st.sampled_from(["mm", "GPa", "Hz", "%", "kg", "foo"])),
)  # fmt: skip
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=4,
)


def paths(node, path=()):
    yield path
    if isinstance(node, dict):
        for key, value in node.items():
            yield from paths(value, (*path, key))


def outcome(folder, text):
    path = folder / "study.yaml"
    path.write_text(text, encoding="utf-8")
    try:
        load(path)
    except ConfigError as error:
        for line in str(error).splitlines():
            assert line.startswith(str(path)), line
            assert len(line) > len(str(path)) + 8


@settings(
    max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], derandomize=True
)
@given(data=st.data())
def test_a_study_with_one_thing_changed(tmp_path, data):
    import copy

    study = copy.deepcopy(BASE)
    path = data.draw(st.sampled_from([p for p in paths(BASE) if p]))
    node = study
    for key in path[:-1]:
        node = node[key]
    what = data.draw(st.sampled_from(["replace", "remove", "add"]))
    if what == "replace":
        node[path[-1]] = data.draw(VALUES)
    elif what == "remove":
        del node[path[-1]]
    else:
        node[data.draw(st.text(min_size=1, max_size=8))] = data.draw(VALUES)
    text = io.StringIO()
    YAML(typ="safe").dump(study, text)
    outcome(tmp_path, text.getvalue())


@settings(
    max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], derandomize=True
)
@given(text=st.text(alphabet=st.characters(exclude_categories=("Cs",)), max_size=80))
def test_any_text(tmp_path, text):
    outcome(tmp_path, text)
