"""Every verification case, shortened.  At full resolution: ``scripts/documents/verification.py``, docs/verification.md."""

import pytest

from verification import dampers, impacts, invariances, motion, predictions, spheroid_collision, spheroids, structures
from verification.suite import CASES

assert dampers
assert impacts
assert invariances
assert motion
assert predictions
assert spheroid_collision
assert spheroids
assert structures


@pytest.mark.parametrize("case", CASES, ids=[case.title for case in CASES])
def test_case(case):
    result = case.run(False)
    assert result.checks
    missed = [
        f"{c.name}: expected {c.expected:.6g} ± {c.tolerance:.2g}, found {c.found:.6g}"
        for c in result.checks
        if not c.holds
    ]
    assert not missed, "\n".join(missed)
