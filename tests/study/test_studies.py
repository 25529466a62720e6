"""The studies of section 4 run, each with few particles, soft, for eight cycles, and differ in what they vary."""

import re

import numpy as np
import pytest

import warpdamp
from conftest import ROOT
from warpdamp.status import FIRST_UNFINISHED, Status

STUDIES = sorted((ROOT / "configs" / "studies").glob("*.yaml"))

OF_THESE = r"gamma: \[?(?:[\d., ]* )?(?:1\.4|6)[,\]}]"
"""Exclusions of the amplitudes that are left; others leave nothing out, which is refused."""

SMALL = (
    (r"^seeds: \[.*?\]", "seeds: [1]"),
    (r"fewest_cycles: \d+, most_cycles: \d+", "fewest_cycles: 8, most_cycles: 8"),
    (r"\[32, 96, 96\]", "[8, 8, 8]"),
    (r"\[32, 96\]", "[8, 8]"),
    (r"^  gamma: \[.*\]", "  gamma: [1.4, 6]"),
    (r"^    - \{.*gamma: .*\}.*\n", lambda found: found[0] * bool(re.search(OF_THESE, found[0]))),
    (r"^  exclude:.*\n(?!    - )", ""),
    (r"count: 120", "count: 12"),
    (r"\[60, 120, (\d+)0\]", r"[6, 12, \1]"),
    (r"diameter: 40 mm, height: 40 mm", "diameter: 20 mm, height: 25 mm"),
    (r"height: \[21.8 mm, 40 mm, 58 mm\]", "height: [20 mm, 25 mm, 30 mm]"),
    (r"height: \[41.7 mm, 40 mm, 38.5 mm\]", "height: [26 mm, 25 mm, 24 mm]"),
    (r"height: \[40 mm, 41 mm, 42 mm, 44 mm\]", "height: [25 mm, 26 mm, 27 mm, 29 mm]"),
    (r"n: 1024", "n: 4"),
    (r"seed: \[1, 4\]", "seed: [1, 2]"),
    (r"([\d.]+) ([GM])Pa", lambda found: f"{float(found[1]) * {'G': 1e9, 'M': 1e6}[found[2]] / 10:g} Pa"),
)


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_a_study_runs(path, write):
    text = path.read_text()
    for old, new in SMALL:
        text = re.sub(old, new, text, flags=re.MULTILINE)
    results = warpdamp.run(write(text), executor="in-process")
    ran = results["status"] != Status.EXCLUDED
    assert ran.any()
    assert (results["status"].where(ran, 0) < FIRST_UNFINISHED).all(), set(map(str, results["message"].values.ravel()))
    values = results["effectiveness"].where(ran).values
    values = values[np.isfinite(values) & (values > 1e-6)]
    assert len(np.unique(values)) == len(values)  # no two cases are one
