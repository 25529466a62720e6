"""Imports only point down: the packages of warpdamp stand on levels, and no files import each other in a circle.

Imports inside functions count like any other; those under ``TYPE_CHECKING`` do not, for they are never run.  Inside a
function a module of the package is imported only where that hides a library that takes its time; the commands of the
command line import all that they run when they run, so that its help answers at once.
"""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

HEAVY = {
    "warp",
    "xarray",
    "scipy",
    "skfem",
    "sklearn",
    "matplotlib",
    "pint",
    "netCDF4",
    "rich",
    "meshio",
    "pyuff",
    "distributed",
}
"""Libraries that take a tenth of a second and more to import."""

LIGHT, NUMPY = "warpdamp.config", {"numpy"}
"""What reads a configuration hides NumPy, too: without a range, a distribution or spheroids no array is needed."""

SELDOM = ("warpdamp.formats", "warpdamp.modal")
"""Readers of other people's files, and what finds modes, take as long together; a configuration is read without them."""

LEVELS = (
    {"version", "errors", "status", "scene", "kernels"},
    {"files", "variables", "modes", "numerics"},
    {"config", "engine", "analysis"},
    {"formats"},
    {"damper", "modal"},
    {"sweep", "report"},
    {"execution", "coupled", "accessor"},
    {"study"},
    {"design"},
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
    """What a module imports: modules of the package, and other libraries; at its top, or anywhere."""

    def __init__(self, name: str, *, anywhere: bool):
        package = name if MODULES[name].stem == "__init__" else name.rpartition(".")[0]
        self.package, self.anywhere = package.split("."), anywhere
        self.inner, self.libraries = set(), set()
        self.visit(ast.parse(MODULES[name].read_text()))
        self.inner.discard(name)

    def visit_If(self, node):
        if "TYPE_CHECKING" not in ast.unparse(node.test):
            self.generic_visit(node)

    def visit_FunctionDef(self, node):
        if self.anywhere:
            self.generic_visit(node)

    def visit_Import(self, node):
        self.libraries |= {alias.name.partition(".")[0] for alias in node.names}

    def visit_ImportFrom(self, node):
        if not node.level:
            self.libraries.add(node.module.partition(".")[0])
            return
        base = self.package[: len(self.package) - node.level + 1]
        module = ".".join(base + ([node.module] if node.module else []))
        for alias in node.names:
            deeper = f"{module}.{alias.name}"
            self.inner.add(deeper if deeper in MODULES else module)


IMPORTS = {name: Imports(name, anywhere=True).inner for name in MODULES}
AT_TOP = {name: Imports(name, anywhere=False) for name in MODULES}


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


def is_heavy(name: str, heavy: set[str], seen: set[str]) -> bool:
    """Whether importing a module imports a library that takes its time."""
    seen.add(name)
    deeper = AT_TOP[name].inner - seen
    return (
        name.startswith(SELDOM)
        or bool(AT_TOP[name].libraries & heavy)
        or any(is_heavy(other, heavy, seen) for other in deeper)
    )


@pytest.mark.parametrize("name", [name for name in MODULES if not name.startswith("warpdamp.cli")])
def test_imports_inside_functions_hide_a_heavy_library(name):
    inside, heavy = IMPORTS[name] - AT_TOP[name].inner, HEAVY | (NUMPY if name.startswith(LIGHT) else set())
    assert not [other for other in inside if not is_heavy(other, heavy, set())], f"{name}: import these at the top"
