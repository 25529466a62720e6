"""The list of the documents that scripts have written, with date, command and cost of each."""

from __future__ import annotations

import json
import re
from pathlib import Path

from warpdamp.version import PHYSICS_VERSION

DOCS = Path(__file__).parents[1]
OF_THE_REFERENCE = ("frf-files", "mode-files", "universal-files")
"""Documents of this folder that say what is read from files of others: they belong to the reference."""

INTRODUCTION = """# Evidence

What is claimed is measured, by scripts that are part of the repository. Each of these documents is written by the
command beside it and not touched by hand. The date, the processor time and the version of the physics are noted by the
script when it writes; simulations that a document reads again (`simulate` makes them anew) are noted apart. Where
nothing is noted the document is older than the notes.

The simulations behind the documents are of these versions of the physics (`warpdamp info` names the present one):

{versions}

`coverage.py`, `price.py` and `presets.py` beside the scripts measure for [accuracy](/accuracy.md) whether claimed
intervals hold, what a tolerance saves, and by what presets err.

"""
SHOWS = {
    "acceptance": "the main job, figure by figure",
    "accuracy": "error against core-seconds for every numerical choice, error budget, cheapest settings",
    "appendix-a": "real against complex modes, the paper's Fig. A.1",
    "bed-states": "what compaction reaches, cavity by cavity, packing fractions, what is left of `memory_error`",
    "benchmark": "speed beside LAMMPS, LIGGGHTS and YADE, scaling, memory, starting times",
    "card": "a damper as a part; with it the beam by FRF, harmonic solution and substructuring",
    "coupling": "the prediction against structures that answer the particles, and the price of each",
    "design": "the emulator on cases that it has not seen, recovery of friction and restitution, design problems",
    "dip": "how deep the dip between the two optima of mode 1 is, and what it goes with",
    "effects": "what each effect costs, on and off, and against kernels that never had it",
    "films-and-reports": "what films and reports cost, and how large they are",
    "first-time": "the tutorial's commands and minutes in an empty environment",
    "frequency_map": "the paper's damper over 27 frequencies and 24 amplitudes: optima, fits, regimes",
    "frf": "natural frequency and damping by energy and by fitted FRFs; constant force",
    "gamma_c": "the optimum of collision over frequency beside the paper's line and a block; the motion",
    "modal-fits": "line fit, Dobson, circle, least squares on known modes: biases and spreads",
    "modes": "beams, plates and added masses against closed forms",
    "parameters": "the paper's Table 1 and its statements of section 4, checked by paired studies",
    "performance": "what was tried for speed, kept or not, and the plain-C limit",
    "sphericity": "spheroids of six aspects beside spheres: optima, clearances, the paper's section 4.1",
    "stability": "hard cases: each runs, is refused, or is flagged; what the guards cost; damaged files",
    "steps": "what fewer steps a contact do to energies, the ledger and a bed's stability",
    "sweeps": "10,000 cases: overhead, memory, kills, partitions, a plan for a million",
    "two_optima": "eight packings over Gamma: optima, spread, what the clearance explains of it",
    "verification": "impacts, friction, rolling, energy, dampers against closed forms and independent integrations",
}


def documents() -> list[Path]:
    """Documents of the evidence: every page of docs/ itself but the front page and those of the reference."""
    return [path for path in sorted(DOCS.glob("*.md")) if path.stem not in ("index", *OF_THE_REFERENCE)]


def page() -> str:
    """The page as Markdown."""
    lines = [
        INTRODUCTION.format(versions=versions()),
        "| document | what it shows | command | written | simulated |",
        "|---|---|---|---|---|",
    ]
    for path in documents():
        notes = record(path.stem)
        command = notes.get("written", {}).get("command") or command_of(path.read_text(encoding="utf-8"))
        cells = (
            f"[{path.stem}](/{path.name})",
            SHOWS.get(path.stem, title_of(path)),
            f"`{command}`" if command else "by hand",
            said(notes.get("written")),
            said(notes.get("simulated")),
        )
        lines.append(f"| {' | '.join(cells)} |")
    tree = ["", "```{toctree}", ":hidden:", "", *(f"/{path.stem}" for path in documents()), "```", ""]
    return "\n".join(lines + tree)


def record(name: str) -> dict:
    """What the script noted of a document."""
    path = DOCS / "evidence" / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def versions() -> str:
    """Which documents are of which version of the physics, as a list."""
    of: dict[str, list[str]] = {}
    for path in documents():
        of.setdefault(physics_of(path), []).append(f"[{path.stem}](/{path.name})")
    own, unknown = of.pop(str(PHYSICS_VERSION), []), of.pop("", [])
    groups = [(f"{PHYSICS_VERSION}, the present one", own), *sorted(of.items(), reverse=True), ("not noted", unknown)]
    return "\n".join(f"- {version}: {', '.join(names)}" for version, names in groups if names)


def physics_of(path: Path) -> str:
    """Version of the physics of the simulations behind a document; empty where nobody noted it.

    That of its last simulation; what is known of its data by hand; what the data that it names say; that of its writing
    where it names none.
    """
    notes = record(path.stem)
    if "simulated" in notes:
        return str(notes["simulated"]["physics_version"])
    if "data" in notes:
        return notes["data"]
    named = re.findall(r"docs/([\w*/]+\.nc)", path.read_text(encoding="utf-8"))
    files = [file for pattern in named for file in sorted(DOCS.glob(pattern))]
    if not files:
        return str(notes["written"]["physics_version"]) if notes else ""
    found = sorted({version for file in files if (version := version_in(file))}, reverse=True)
    return " and ".join(found)


def version_in(file: Path) -> str:
    """Version of the physics that a netCDF file says it is of; empty if it says none.

    Its attributes stand in it as they are: nothing needs to be opened that others may hold open.
    """
    found = re.search(rb"\(physics (\d+)\)", file.read_bytes())
    return found[1].decode() if found else ""


def command_of(text: str) -> str:
    """The command that a document names as its author's."""
    found = re.search(r"Written\s+by\s+`(.*?)`", text)
    return found[1] if found else ""


def title_of(path: Path) -> str:
    """The document's first heading."""
    return path.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")


def said(entry: dict | None) -> str:
    """A note in words: date, cost, version of the physics."""
    if not entry:
        return "–"
    spent = entry["processor_time"]
    cost = f"{spent:.0f} s" if spent < 600 else f"{spent / 60:.0f} min" if spent < 36000 else f"{spent / 3600:.0f} h"
    return f"{entry['date']}, {cost} of processor time, physics {entry['physics_version']}"
