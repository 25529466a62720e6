"""The tutorial as a first-time user takes it, timed: a fresh checkout, an empty environment, empty caches.

python scripts/documents/tutorial.py
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from shared import DOCS, ROOT, head, machine, table, write_document

sys.path.insert(0, str(DOCS / "_ext"))
from blocks import blocks

NAMED = "# "
"""Begins the first line of a YAML block that is written to a file."""


def steps(text: str):
    """What a reader does, as (what is shown of it, script of the shell or of Python, its interpreter)."""
    for block in blocks(text):
        if block.language == "sh":
            yield from ((line, line, "bash") for line in block.text.splitlines())
        elif block.language == "python":
            yield "the script in Python", block.text, "python"


def environment(checkout: Path) -> dict[str, str]:
    """Environment of the commands: the checkout's own Python, caches that are empty."""
    own = {
        "PATH": f"{checkout / '.venv' / 'bin'}{os.pathsep}{os.environ['PATH']}",
        "WARPDAMP_CACHE": str(checkout / "cache"),
    }
    return {name: value for name, value in os.environ.items() if name != "WARP_CACHE_PATH"} | own


def timed(checkout: Path, script: str, interpreter: str) -> tuple[float, float]:
    """Seconds on the wall, and of processor time, that a step takes."""
    before, started = sum(os.times()[2:4]), time.perf_counter()
    line = [interpreter, "-c", script]
    subprocess.run(line, cwd=checkout, env=environment(checkout), check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - started, sum(os.times()[2:4]) - before


def main():
    text = (DOCS / "tutorial" / "index.md").read_text(encoding="utf-8")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        checkout = Path(folder) / "warpdamp"
        subprocess.run(["git", "clone", "-q", ROOT, checkout], check=True)
        for block in blocks(text):
            name = block.text.partition("\n")[0].removeprefix(NAMED)
            if block.language == "yaml" and name.endswith(".yaml"):
                (checkout / name).write_text(block.text, encoding="utf-8")
        load = os.getloadavg()[0]
        for shown, script, interpreter in steps(text):
            print("+", shown, flush=True)
            rows.append((shown, *timed(checkout, script, interpreter)))
    wall, spent = (sum(row[k] for row in rows) / 60 for k in (1, 2))
    write_document(
        "first-time.md",
        f"{head('The path of a first-time user', __file__)}, which takes the [tutorial](tutorial/index.md) from a "
        "fresh checkout, in an empty environment with empty caches: nothing compiled, no bed made. On "
        f"{machine()}; load {load:.1f} before the first command. Where the wall's time is far above the processor's, "
        "others used the machine.",
        table(
            ["command", "wall [s]", "processor [s]"],
            [(f"`{shown}`", f"{waited:.0f}", f"{used:.0f}") for shown, waited, used in rows],
        ),
        f"Together {wall:.1f} minutes, {spent:.1f} of processor time.",
    )


if __name__ == "__main__":
    main()
