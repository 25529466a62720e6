"""The reference of the command line, written from the commands themselves."""

from __future__ import annotations

import re

import typer.main
from typer.cli import get_docs_for_click

from warpdamp.cli.app import app

TITLE = "The command line"
INTRODUCTION = """Written from the commands themselves; `warpdamp COMMAND --help` prints the same. An error is one line
and ends with exit status 2; a run that is stopped ends with 130 and goes on by the same command.
`warpdamp --install-completion` makes the shell complete commands and options.
"""


def page() -> str:
    """The page as Markdown."""
    group = typer.main.get_command(app)
    text = get_docs_for_click(obj=group, ctx=group.context_class(group, info_name="warpdamp"), name="warpdamp")
    body = text.partition("\n")[2]  # its title
    for name, command in group.commands.items():  # whole sentences, where the list of commands cuts them off
        first = " ".join(command.help.partition("\n\n")[0].split())
        body = re.sub(
            rf"^\* `{name}`: .*$", f"* [`{name}`](#warpdamp-{name}): {first}", body, count=1, flags=re.MULTILINE
        )
    return f"# {TITLE}\n\n{INTRODUCTION}\n{body}"
