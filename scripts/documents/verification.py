"""Run the verification suite at full resolution and write docs/verification.md with its plots.

python scripts/documents/verification.py
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


def main():
    pictures = DOCS / "verification"
    pictures.mkdir(parents=True, exist_ok=True)
    index, body, missed = [], [], 0
    for case in CASES:
        started = time.perf_counter()
        result = case.run(True)
        seconds = time.perf_counter() - started
        path = None
        if result.curves:
            path = pictures / f"{re.sub('[^a-z0-9]+', '-', case.title.lower()).strip('-')}.png"
            picture(case, result, path)
        held = sum(check.holds for check in result.checks)
        missed += len(result.checks) - held
        index.append([case.title, len(result.checks), held])
        body += section(case, result, seconds, path)
        print(f"{case.title}: {held} of {len(result.checks)}, {seconds:.1f} s", flush=True)
    introduction = head("Verification", __file__) + INTRODUCTION
    write_document("verification.md", introduction, table(["case", "figures", "held"], index), *body)
    return missed


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
