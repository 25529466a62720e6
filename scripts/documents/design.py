"""Evidence on emulator, calibration and design; writes docs/design.md, and the worked example in the README.

    python scripts/documents/design.py [emulator] [example] [problems [K ...]] [checks [K ...]] [--workers N]

Without a word nothing is simulated, and the document is written from what lies in docs.  ``emulator`` runs the
five-dimensional sweep and two sets of held-out cases (about seven core-minutes), ``example`` the worked example,
``problems`` the random design problems, all twenty or those named, with 64 fresh packings of every damper claimed
(about five core-minutes each), ``checks`` a brute force of 2,000 cases and a second optimiser on three of them.  All
may be stopped and started again: results/design keeps what is done, whole parts are kept in docs.
"""

from __future__ import annotations

import argparse
import time

from design_checks import COMPARED, checks_section, simulate_checks
from design_emulator import emulator_section, recovery_section, simulate_emulator
from design_problems import COUNT, KEPT, problems_section, simulate_problems
from shared import DOCS, ROOT, head, machine, write_document

from warpdamp.analysis.results import write
from warpdamp.design.dataset import to_dataset
from warpdamp.design.run import design
from warpdamp.files import whole_file
from warpdamp.report.design import lines, picture
from warpdamp.report.figures import save


def simulate_example(workers: int | None) -> None:
    """The worked example: its answer, picture and data; the minutes only where all of it was run."""
    started, whole = time.perf_counter(), not (KEPT / "example").exists()
    answer = design(ROOT / "configs" / "design.yaml", KEPT / "example", workers=workers, say=print)
    said = lines(answer) + [f"in {(time.perf_counter() - started) / 60:.0f} minutes of this run"] * whole
    write(to_dataset(answer), DOCS / "design-example.nc")
    with whole_file(DOCS / "design-example.txt") as part:
        part.write_text("\n".join(said) + "\n")
    save(picture(answer), DOCS / "design-example.png")


PROBLEMS = (
    "Beams, plates and modes in numbers, 20-2000 Hz, Γ 0.5-20, limits of mass; a quarter ask for more than an ideal "
    "damper of the allowed mass gives. `python scripts/documents/design.py problems` solves all, `problems 3 7` those "
    "named."
)


def document() -> None:
    """Write the document from what is there."""
    blocks = [
        f"{head('Design, emulator, calibration', __file__)} from docs/emulator_*.nc, docs/design-example.txt, "
        f"docs/design-problems.json and docs/design-checks.json; how to use them is in "
        f"[howto/design-a-damper.md](howto/design-a-damper.md).",
        f"Written on: {machine()}.",
        "## Emulator on cases that it has not seen",
        emulator_section(),
        "## Recovery of friction and restitution",
        recovery_section(),
        "## The worked example",
        example_section(),
        "## Problems drawn at random",
        PROBLEMS,
        problems_section(),
        "## Beside a brute force, and another optimiser",
        checks_section(),
    ]
    write_document("design.md", *blocks)


def example_section() -> str:
    """The worked example as it was run."""
    said = DOCS / "design-example.txt"
    asked = (
        "`warpdamp design configs/design.yaml`: 2 % in mode 1 of the paper's beam over Γ 2 to 8 with the least mass.  "
        "It is the last of several runs while the search was written. In an earlier one the damper found missed the "
        "target when it was simulated again, no claim was made, and the search was changed after it; in another a "
        "damper of 26.0 g kept its claim (P 0.966); in a third the budget ended among the lightest designs, and the "
        "search was changed again. Within 120 cases it does not always find the lightest."
    )
    if not said.exists():
        return f"{asked} Not run yet."
    return (
        f"{asked}\n\n```\n{said.read_text().rstrip()}\n```\n\n![The damper chosen, and the front](design-example.png)"
    )


ANSWER = "<!-- answer of the design example -->\n```\n", "```\n<!-- end of the answer -->"


def write_in_readme() -> None:
    """Put the answer of the worked example, without tolerances and runners-up, into the README."""
    said = (DOCS / "design-example.txt").read_text()
    readme = ROOT / "README.md"
    before, _, rest = readme.read_text().partition(ANSWER[0])
    with whole_file(readme) as part:
        part.write_text(
            f"{before}{ANSWER[0]}{said.partition('with all of these')[0]}{ANSWER[1]}{rest.partition(ANSWER[1])[2]}"
        )


PARTS = ("emulator", "example", "problems", "checks")


def main() -> None:
    """Simulate what is named, then write the document."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", help=f"{', '.join(PARTS)}, and numbers of problems")
    parser.add_argument("--workers", type=int)
    options = parser.parse_args()
    numbers = [int(part) for part in options.parts if part.isdecimal()]
    unknown = [part for part in options.parts if not part.isdecimal() and part not in PARTS]
    if unknown:
        parser.error(f"unknown part {unknown[0]}")
    if "emulator" in options.parts:
        simulate_emulator(options.workers)
    if "example" in options.parts:
        simulate_example(options.workers)
    if "problems" in options.parts:
        simulate_problems(numbers or list(range(1, COUNT + 1)), options.workers)
    if "checks" in options.parts:
        simulate_checks(numbers or COMPARED, options.workers)
    document()
    write_in_readme()


if __name__ == "__main__":
    main()
