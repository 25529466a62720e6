"""Imports only point down: the packages of warpdamp stand on levels, and no files import each other in a circle.

Imports inside functions count like any other; those under ``TYPE_CHECKING`` do not, for they are never run.
"""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

LEVELS = (
    {"version", "errors", "status", "scene", "kernels"},
    {"files", "variables", "numerics"},
    {"config", "engine", "analysis"},
    {"damper", "modal"},
    {"sweep", "report"},
    {"execution", "coupled", "accessor"},
    {"study"},
    {"cli", "", "__main__"},
)
"""What stands on each level, from the ground up; ``""`` is ``warpdamp/__init__.py``, the public face."""


def modules() -> dict[str, Path]:
    """Every module of the package by its dotted name."""
    found = {}
    for folder, prefix in ((ROOT / "warpdamp", "warpdamp"), (ROOT / "kernels", "warpdamp.kernels")):
        for path in folder.rglob("*.py"):
            parts = path.relative_to(folder).with_suffix("").parts
            found[".".join((prefix, *parts)).removesuffix(".__init__")] = path
    return found


MODULES = modules()


class Imports(ast.NodeVisitor):
    """The modules of the package that a module imports, wherever the import stands."""

    def __init__(self, name: str):
        package = name if MODULES[name].stem == "__init__" else name.rpartition(".")[0]
        self.package, self.found = package.split("."), set()
        self.visit(ast.parse(MODULES[name].read_text()))
        self.found.discard(name)

    def visit_If(self, node):
        if "TYPE_CHECKING" not in ast.unparse(node.test):
            self.generic_visit(node)

    def visit_Import(self, node):
        self.found |= {alias.name for alias in node.names if alias.name in MODULES}

    def visit_ImportFrom(self, node):
        base = self.package[: len(self.package) - node.level + 1] if node.level else []
        module = ".".join(base + ([node.module] if node.module else []))
        for alias in node.names:
            inner = f"{module}.{alias.name}"
            self.found |= {name for name in (inner if inner in MODULES else module,) if name in MODULES}


IMPORTS = {name: Imports(name).found for name in MODULES}


def level(name: str) -> int:
    place = (name.split(".") + [""])[1]
    return next(k for k, members in enumerate(LEVELS) if place in members)


@pytest.mark.parametrize("name", MODULES)
def test_imports_only_point_down(name):
    up = sorted(other for other in IMPORTS[name] if level(other) > level(name))
    assert not up, f"{name} (level {level(name)}) imports from above"


def test_no_files_import_each_other_in_a_circle():
    try:
        TopologicalSorter(IMPORTS).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))
