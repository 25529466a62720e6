"""Run the verification suite at full resolution and write docs/verification.md with its plots.

python scripts/documents/verification.py
"""

import re
import sys
import time
from pathlib import Path

from matplotlib.figure import Figure

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from verification import dampers, impacts, invariances, motion  # noqa: E402, F401
from verification.suite import CASES  # noqa: E402

HEAD = """# Verification

Written by `scripts/documents/verification.py`, which runs every case of `tests/verification/` at full resolution; the test suite
runs the same cases shortened. A miss is reported as a miss.

"""


def picture(case, result, path):
    """The case's curves."""
    figure = Figure(figsize=(6, 3.6), layout="constrained", dpi=110)
    ax = figure.subplots()
    for curve in result.curves:
        ax.plot(curve.x, curve.y, curve.style, label=curve.label, ms=4, lw=1)
    for axis, label in zip(("x", "y"), result.axes, strict=True):
        if "(log)" in label:
            getattr(ax, f"set_{axis}scale")("log")
        getattr(ax, f"set_{axis}label")(label.replace(" (log)", ""))
    ax.grid(alpha=0.3)
    ax.legend(fontsize=7)
    figure.savefig(path)


def section(case, result, seconds, picture_path):
    """Text of one case."""
    held = sum(check.holds for check in result.checks)
    verdict = "holds" if held == len(result.checks) else f"MISSES {len(result.checks) - held} of {len(result.checks)}"
    lines = [f"## {case.title}", "", f"**{verdict}** ({held} of {len(result.checks)} figures, {seconds:.1f} s)", ""]
    lines += [f"- Setup: {case.setup}", f"- Reference: {case.reference}", f"- Tolerance: {case.tolerance}", ""]
    if picture_path:
        lines += [f"![{case.title}]({picture_path.relative_to(ROOT / 'docs')})", ""]
    lines += ["| figure | expected | found | error | tolerance |", "|---|---|---|---|---|"]
    for check in sorted(result.checks, key=lambda c: c.holds):
        mark = "" if check.holds else " **miss**"
        lines.append(
            f"| {check.name} | {check.expected:.6g} | {check.found:.6g} | {check.error:.2g}{mark} "
            f"| {check.tolerance:.2g} |"
        )
    return [*lines, ""]


def main():
    pictures = ROOT / "docs" / "verification"
    pictures.mkdir(parents=True, exist_ok=True)
    index, body, missed = ["| case | figures | held |", "|---|---|---|"], [], 0
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
        index.append(f"| {case.title} | {len(result.checks)} | {held} |")
        body += section(case, result, seconds, path)
        print(f"{case.title}: {held} of {len(result.checks)}, {seconds:.1f} s", flush=True)
    (ROOT / "docs" / "verification.md").write_text(HEAD + "\n".join([*index, "", *body]).rstrip() + "\n")
    return missed


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
