"""The reference of the variables of results, written from ``warpdamp/variables.py`` and ``warpdamp/status.py``."""

from __future__ import annotations

import ast
import inspect
import re

from warpdamp import variables
from warpdamp.status import Status

INTRODUCTION = """# Variables of the results

Written from `warpdamp/variables.py`. Results are netCDF files for `xarray.open_dataset`; every variable carries `units`
and `long_name`, and the file the resolved configuration, seeds and versions. Dimensions are `frequency`, `gamma` and
`seed`, one for every other scalar that is swept, `case` where scalars change together, `leg` where beds are carried,
`damper` where there are several, and `mode` of what concerns the structure. A file holds those variables that its
command computes. `*_loss` come once for contacts between particles and once for those with the walls.

"""


def page() -> str:
    """The page as Markdown."""
    lines = [INTRODUCTION]
    for title, names in groups():
        lines += [f"## {title}", "", "| variable | unit | meaning |", "|---|---|---|"]
        lines += [f"| `{name}` | {unit(name)} | {variables.VARIABLES[name][1]} |" for name in names]
        lines += [""]
    lines += ["## Values of `status`", "", "| value | name | meaning |", "|---|---|---|"]
    lines += [f"| {int(status)} | `{status.name.lower()}` | {status.meaning} |" for status in Status]
    return "\n".join(lines) + "\n"


def groups() -> list[tuple[str, list[str]]]:
    """Names of the variables, below the remarks between them in the source."""
    source = inspect.getsource(variables)
    table = next(
        node for node in ast.parse(source).body if isinstance(node, ast.Assign) and node.targets[0].id == "VARIABLES"
    )
    lines = source.splitlines()
    remarks = {k: line.strip() for k, line in enumerate(lines[: table.end_lineno], 1) if line.strip().startswith("# ")}
    found, title = {}, "Damper, cases and damping"
    by_line = {key.lineno: key.value for key in table.value.keys if isinstance(key, ast.Constant)}
    for k in range(table.lineno, table.end_lineno):
        if k in remarks:
            title = re.sub(r"\s*\(.*\)$", "", remarks[k].removeprefix("# ")).capitalize()
        found.setdefault(title, []).extend([by_line[k]] if k in by_line else [])
    known = {name for names in found.values() for name in names}
    losses = [name for name in variables.VARIABLES if name not in known]
    first = next(iter(found.values()))
    first[first.index("work_input") : first.index("work_input")] = losses
    return list(found.items())


def unit(name: str) -> str:
    """Unit of a variable, as it is read."""
    text = variables.VARIABLES[name][0]
    return "–" if text == "1" else re.sub(r"(?<=[a-zA-Z])(-?[\d.]+)", r"<sup>\1</sup>", text).replace(" ", "&nbsp;")
