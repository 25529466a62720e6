"""Commands of design: materials."""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import UsageError
from .common import one_line_errors

app = typer.Typer()


@app.command()
def materials(
    name: Annotated[str | None, typer.Argument(help="Material (default: all).", metavar="[NAME]")] = None,
) -> None:
    """Show the library of materials: values, ranges and sources."""
    from rich.console import Console

    with one_line_errors():
        from ..config.messages import suggestion
        from ..report.materials import material_lines, materials_table, sources_lines
        from ..scene.materials import LIBRARY

        if name is not None and name not in LIBRARY:
            raise UsageError(f"there is no material '{name}'{suggestion(name, LIBRARY)}")
    console = Console()
    if name is None:
        console.print(materials_table())
    for line in sources_lines() if name is None else material_lines(name):
        console.print(line, highlight=False, markup=False, soft_wrap=True)
