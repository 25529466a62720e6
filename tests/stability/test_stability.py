"""Every hard case, shortened.  Whole: ``scripts/documents/stability.py``, docs/stability.md."""

import pytest

from stability import shapes  # noqa: F401  its cases are among them
from stability.cases import CASES


@pytest.mark.parametrize("case", CASES, ids=[case.title for case in CASES])
def test_hard_case(case):
    outcome = case.run(False)
    how = "refused" if not outcome.ran else "flagged" if outcome.flagged else "runs"
    assert how == case.expected, outcome
    assert "UNSEEN" not in outcome.flagged
    if how == "refused":
        assert len(outcome.message) > 30  # says what to change
