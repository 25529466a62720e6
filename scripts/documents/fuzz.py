"""Damage valid files of every kind, try to read each, and write the counts to docs/fuzz.json and docs/stability.md.

    python scripts/documents/fuzz.py [10000]

tries so many, and rewrites the section of docs/stability.md that is about them alone; with ``again`` instead of a
number those that failed are tried once more, after what was wrong has been mended.
"""

import json
import sys
import tempfile
import time
from pathlib import Path

from shared import DOCS, machine, table, write_document

from fuzz_files import KINDS, LONGEST, TooLong, damage, is_read, read_valid_files

COUNTS = DOCS / "fuzz.json"
TITLE = "## Files of other people, damaged"
INTRODUCTION = f""". Valid files are damaged in one to four places: parts cut out, doubled, moved or
written over, digits changed, lines exchanged, pieces of other formats put in. A file is read, with finite numbers in
the result, or refused in one line. One that ends in any other error, in a warning of numpy's or after more than
{LONGEST} s has failed. Each case follows from its number."""


def main(files: int) -> int:
    counts = {kind: {"read": 0, "refused": 0, "failed": 0, "longest_s": 0.0} for kind in KINDS}
    failed = tried(range(files), counts)
    _keep({"files": files, "machine": machine(), "kinds": counts, "failures": failed, "mended": []})
    return len(failed)


def again() -> int:
    """Try those that failed once more, and count them as they end now."""
    kept = json.loads(COUNTS.read_text())
    for number in kept["failures"]:
        kept["kinds"][damage(number).kind]["failed"] -= 1
    still = tried(kept["failures"], kept["kinds"])
    kept["mended"] += [number for number in kept["failures"] if number not in still]
    _keep(kept | {"failures": still})
    return len(still)


def _keep(counts: dict) -> None:
    COUNTS.write_text(json.dumps(counts, indent=2) + "\n")
    rewrite_section()


def tried(numbers, counts: dict[str, dict]) -> list[int]:
    """Count for each kind how many files were read, refused and failed, and the longest time [s]; those that failed."""
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        read_valid_files(Path(folder))  # which imports what takes its time
        for number in numbers:
            case = damage(number)
            started = time.perf_counter()
            count = counts[case.kind]
            fate = _fate(number, case, Path(folder))
            count[fate] += 1
            failed += [number] if fate == "failed" else []
            count["longest_s"] = max(count["longest_s"], round(time.perf_counter() - started, 3))
    return failed


def _fate(number: int, case, folder: Path) -> str:
    try:
        return "read" if is_read(case, folder) else "refused"
    except (Exception, TooLong) as error:  # what this script looks for
        print(f"case {number}, {case.name}: {type(error).__name__}: {error}", flush=True)
        return "failed"


def rewrite_section() -> None:
    """Write the section into docs/stability.md and leave the rest as it is."""
    before = (DOCS / "stability.md").read_text(encoding="utf-8").partition(TITLE)[0]
    write_document("stability.md", before.rstrip(), section())


def section() -> str:
    """The section of docs/stability.md, from the counts that were kept."""
    kept = json.loads(COUNTS.read_text())
    kinds = kept["kinds"]
    names = ("read", "refused", "failed", "longest_s")
    rows = [[kind, *(counts[name] for name in names)] for kind, counts in kinds.items()]
    total = [sum(counts[name] for counts in kinds.values()) for name in names[:3]]
    rows.append(["all", *total, max(counts["longest_s"] for counts in kinds.values())])
    script = f"Written by `python scripts/documents/fuzz.py {kept['files']}`"
    counted = table(["kind", "read", "refused", "failed", "longest [s]"], rows)
    numbers = ", ".join(map(str, kept["mended"]))
    notes = (
        [f"Failed at first, and tried again when what was wrong had been mended: cases {numbers}."] if numbers else []
    )
    return "\n\n".join((TITLE, script + INTRODUCTION, counted, *notes, f"({kept['machine']})"))


if __name__ == "__main__":
    asked = sys.argv[1] if len(sys.argv) > 1 else "10000"
    sys.exit(1 if (again() if asked == "again" else main(int(asked))) else 0)
