"""Files of modes and meshes with anything changed in them: read, or refused in one line; 10,000 by the script."""

import pytest
from fuzz_files import check

pytest.importorskip("meshio")
pytest.importorskip("pyuff")


def test_mutated_files_are_read_or_refused():
    counts = check(200)
    fates = [fate for (_, fate), count in counts.items() for _ in range(count)]
    assert len(fates) == 200
    assert set(fates) == {"read", "refused"}
