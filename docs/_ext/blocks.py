"""Code blocks of the site's pages, and a page's commands as one script: python docs/_ext/blocks.py PAGE."""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path
from typing import NamedTuple

_FENCE = re.compile(r"^```(?P<language>sh|yaml|python)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    """A code block: its language, its text and its first line in the page."""

    language: str
    text: str
    line: int


def blocks(text: str) -> list[Block]:
    """Blocks of shell, YAML and Python of a page in Markdown, in their order."""
    return [Block(m["language"], m["text"], text[: m.start()].count("\n") + 2) for m in _FENCE.finditer(text)]


def script(text: str) -> str:
    """Everything that a reader of a page does, as one shell script.

    Shell is run as it stands, Python by the environment's interpreter, and YAML whose first line is ``# NAME`` is
    written to that file.
    """
    lines = ["set -euxo pipefail"]
    for block in blocks(text):
        if block.language == "sh":
            lines.append(block.text)
        elif block.language == "python":
            lines.append(f"python - <<'END'\n{block.text}END")
        elif named := re.match(r"# (\S+\.yaml)\n", block.text):
            lines.append(f"cat > {shlex.quote(named[1])} <<'END'\n{block.text}END")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(script(Path(sys.argv[1]).read_text(encoding="utf-8")), end="")
