"""Run the verification suite at full resolution and write docs/verification.md with its plots.

    python scripts/documents/verification.py several dampers

runs those cases alone whose titles hold the words, and leaves the other sections as they are.
"""

import re
import sys
import time

from shared import DOCS, head, panels, table, write_document

from verification import dampers, impacts, invariances, motion, predictions, spheroid_collision, spheroids, structures  # noqa: F401
from verification.suite import CASES

INTRODUCTION = """, which runs every case of `tests/verification/` at full resolution; the test suite
runs the same cases shortened. A miss is reported as a miss."""


def picture(case, result, path):
    """The case's curves."""
    figure, (ax,) = panels(1, (6, 3.6))
    for curve in result.curves:
        ax.plot(curve.x, curve.y, curve.style, label=curve.label, ms=4, lw=1)
    for axis, label in zip(("x", "y"), result.axes, strict=True):
        if "(log)" in label:
            getattr(ax, f"set_{axis}scale")("log")
        getattr(ax, f"set_{axis}label")(label.replace(" (log)", ""))
    ax.legend(fontsize=7)
    figure.savefig(path)


def section(case, result, seconds, picture_path):
    """Text of one case."""
    held = sum(check.holds for check in result.checks)
    verdict = "holds" if held == len(result.checks) else f"MISSES {len(result.checks) - held} of {len(result.checks)}"
    blocks = [f"## {case.title}", f"**{verdict}** ({held} of {len(result.checks)} figures, {seconds:.1f} s)"]
    blocks += [f"- Setup: {case.setup}\n- Reference: {case.reference}\n- Tolerance: {case.tolerance}"]
    if picture_path:
        blocks += [f"![{case.title}]({picture_path.relative_to(DOCS)})"]
    rows = [
        [check.name, f"{check.expected:.6g}", f"{check.found:.6g}"]
        + [f"{check.error:.2g}{'' if check.holds else ' **miss**'}", f"{check.tolerance:.2g}"]
        for check in sorted(result.checks, key=lambda c: c.holds)
    ]
    return [*blocks, table(["figure", "expected", "found", "error", "tolerance"], rows)]


def main(words: str) -> int:
    """Run the cases whose titles hold some words, write their sections anew, and return how many figures missed."""
    pictures = DOCS / "verification"
    pictures.mkdir(parents=True, exist_ok=True)
    rows, sections = ({}, {}) if not words else kept()
    missed = 0
    for case in CASES:
        if words not in case.title.lower():
            continue
        started = time.perf_counter()
        result = case.run(True)
        seconds = time.perf_counter() - started
        path = None
        if result.curves:
            path = pictures / f"{re.sub('[^a-z0-9]+', '-', case.title.lower()).strip('-')}.png"
            picture(case, result, path)
        held = sum(check.holds for check in result.checks)
        missed += len(result.checks) - held
        rows[case.title] = [case.title, len(result.checks), held]
        sections[case.title] = "\n\n".join(section(case, result, seconds, path))
        print(f"{case.title}: {held} of {len(result.checks)}, {seconds:.1f} s", flush=True)
    there = [case.title for case in CASES if case.title in rows]
    introduction = head("Verification", __file__) + INTRODUCTION
    index = table(["case", "figures", "held"], [rows[title] for title in there])
    write_document("verification.md", introduction, index, *(sections[title] for title in there))
    return missed


def kept() -> tuple[dict[str, list[str]], dict[str, str]]:
    """Rows of the index and sections of the document as it is, by the titles of their cases."""
    first, *parts = (DOCS / "verification.md").read_text(encoding="utf-8").split("\n## ")
    rows = [line.strip("| ").split(" | ") for line in first.splitlines() if line.startswith("| ")]
    sections = {part.partition("\n")[0]: f"## {part.rstrip()}" for part in parts}
    return {row[0]: row for row in rows[1:]}, sections


if __name__ == "__main__":
    sys.exit(1 if main(" ".join(sys.argv[1:]).lower()) else 0)
