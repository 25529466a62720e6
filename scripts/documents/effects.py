"""What each effect costs, and that one which is off costs nothing: writes docs/effects.md and its chart.

    python scripts/documents/effects.py

Three measurements, each of processor time, alternating, medians of the rounds:

- on one frozen set of contacts (the paper's bed pressed against the floor): the same contacts for every set of effects;
- in the paper's scene at Gamma 6, where every set of effects moves its bed in its own way;
- against a build that never had the effect: the kernels' source with every branch and field of the effect deleted,
  in a process of its own.
"""

from __future__ import annotations

import ast
import json
import pickle
import statistics
import subprocess
import sys
import tempfile
import textwrap
from dataclasses import asdict
from pathlib import Path

from shared import DOCS, ROOT, head, machine, panels, table, write_document

from warpdamp.scene.effects import Effects
from warpdamp.study.cost import SIMPLEST, frozen, jammed_bed, moving
from warpdamp.study.speeds import TOGGLES, remember, within, without

FULL = Effects()
EXTRAS = tuple(name for name in TOGGLES if not getattr(FULL, name))
LIMIT = 0.40


class Deleted(ast.NodeTransformer):
    """Resolves every test that asks for effects, and deletes the branch not taken."""

    def __init__(self, effects: Effects):
        self.effects = effects

    def visit_If(self, node):
        """Keep the branch taken."""
        self.generic_visit(node)
        test = node.test
        if isinstance(test, ast.Call) and ast.unparse(test.func) == "wp.static":
            test = test.args[0]
        names = {n.id for n in ast.walk(test) if isinstance(n, ast.Name)}
        if names != {"effects"}:
            return node
        taken = eval(compile(ast.Expression(test), "", "eval"), {"effects": self.effects})  # our own source
        return (node.body if taken else node.orelse) or ast.Pass()


def deleted_build(effects: Effects, folder: Path) -> Path:
    """A copy of the package whose kernels never heard of what ``effects`` leaves out."""
    package = folder / "warpdamp"
    for path in sorted((ROOT / "warpdamp").rglob("*.py")) + sorted((ROOT / "kernels").glob("*.py")):
        inside = path.relative_to(ROOT)
        if "kernels" in inside.parts:
            inside = Path("warpdamp/kernels") / path.name
        text = path.read_text()
        if path.parent == ROOT / "kernels":
            text = ast.unparse(ast.fix_missing_locations(Deleted(effects).visit(ast.parse(text)))) + "\n"
        (folder / inside).parent.mkdir(parents=True, exist_ok=True)
        (folder / inside).write_text(text)
    return package


CHILD = """
import json, pickle, sys
sys.path.insert(0, sys.argv[1])
import warpdamp
from warpdamp.scene.effects import Effects
from warpdamp.study.cost import frozen
assert warpdamp.__file__.startswith(sys.argv[1]), warpdamp.__file__
if __name__ == "__main__":
    effects = Effects(**json.loads(sys.argv[2]))
    bed = pickle.load(open(sys.argv[3], "rb"))
    print(json.dumps(frozen([effects], bed=bed, rounds=5)[effects]))
"""


def against_deleted(effects: Effects, rounds: int = 3) -> list[float]:
    """Ratios of the time with an effect off to that of a build without it, the two in turn, a process each."""
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        deleted_build(effects, Path(folder))
        (Path(folder) / "run.py").write_text(textwrap.dedent(CHILD))
        (Path(folder) / "bed").write_bytes(pickle.dumps(jammed_bed()))
        for _ in range(rounds):
            times = [_timed(Path(folder) / "run.py", where, effects) for where in (ROOT, Path(folder))]
            ratios.append(times[0] / times[1])
    return ratios


def _timed(script: Path, where: Path, effects: Effects) -> float:
    done = subprocess.run(
        [sys.executable, str(script), str(where), json.dumps(asdict(effects)), str(script.parent / "bed")],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return min(json.loads(done.stdout))


def main() -> None:
    """Measure and write."""
    names = [name for name in TOGGLES if name not in EXTRAS]
    sets = {name: without(FULL, name) for name in names} | {name: within(FULL, name) for name in EXTRAS}
    every = [FULL, SIMPLEST, *sets.values()]
    still, shaken = frozen(every), moving(every)
    remember("frozen", still)
    remember("moving", shaken)
    bare = {
        name: against_deleted(without(FULL, name)) for name in ("friction", "rotation", "dashpots", "rolling", "lid")
    }
    rows = []
    for name, other in sets.items():
        off, on = (FULL, other) if name in EXTRAS else (other, FULL)
        rows.append((name, _median(still[off]), _median(still[on]), _median(shaken[off]), _median(shaken[on])))
    share = statistics.median(a / b for a, b in zip(still[SIMPLEST], still[FULL], strict=True))
    _write(rows, bare, share, _median(still[FULL]), _median(shaken[FULL]), _median(still[SIMPLEST]))


def _median(times):
    return statistics.median(times)


def _write(rows, bare, share, full, full_moving, simplest):
    costs = [[n, f"{a:.1f}", f"{b:.1f}", f"{b - a:+.1f}", f"{c:.1f}", f"{d:.1f}"] for n, a, b, c, d in rows]
    ratios = [[n, f"{_median(r):.3f}", f"{min(r):.3f} .. {max(r):.3f}"] for n, r in bare.items()]
    write_document(
        "effects.md",
        head("What each effect costs", __file__) + f" on {machine()}; nanoseconds of processor time per particle-step, "
        f"medians; float64 unless said otherwise.  All effects of the paper's scene together: **{full:.0f} ns** on the "
        f"frozen contacts, {full_moving:.0f} ns in the paper's scene at Gamma 6.  The simplest law (no friction, no "
        f"dashpots, no gravity, losses in total) takes {simplest:.0f} ns, **{100 * share:.0f} %** of the full one on "
        f"the same contacts (asked for: at most {100 * LIMIT:.0f} %).",
        "![bars](effects.png)",
        "Frozen: the same contacts in both columns, so their difference is what the effect costs.  Scene: the bed "
        "moves as the effects let it, so that the number of contacts changes, too.  `precision` off is float32; "
        "friction off takes rotation along, as in a scene without friction.",
        table(["effect", "frozen, off", "frozen, on", "costs", "scene, off", "scene, on"], costs),
        "## Off against a build that never had it",
        "The kernels' source with every branch and field of the effect deleted, timed in turn with the real one: ratio "
        "of times (off / deleted), median and range of three pairs of processes.",
        table(["effect", "off / deleted", "range"], ratios),
    )
    _chart(rows)


def _chart(rows):
    figure, (axes,) = panels(1, (8, 4.5))
    for k, (_, off, on, _, _) in enumerate(rows):
        axes.barh(k - 0.2, on, 0.38, color="tab:blue", label="on" if k == 0 else None)
        axes.barh(k + 0.2, off, 0.38, color="tab:gray", label="off" if k == 0 else None)
    axes.set_yticks(range(len(rows)), [row[0] for row in rows])
    axes.invert_yaxis()
    axes.set_xlabel("ns per particle-step, frozen contacts")
    axes.legend()
    figure.savefig(DOCS / "effects.png")


if __name__ == "__main__":
    main()
