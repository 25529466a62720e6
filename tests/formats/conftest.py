"""Reading of universal files, whole and refused, for the tests of what they hold."""

import pytest

from universal_files import units, write
from warpdamp.errors import ModalError
from warpdamp.formats.mode_uff import read_uff


@pytest.fixture
def read(tmp_path):
    def reader(*sets, given=None, **options):
        sets = sets if given else (units(), *sets)
        return read_uff(write(tmp_path / "modes.uff", *sets), units=given, **options)

    return reader


@pytest.fixture
def refused(read):
    def check(message, *sets, **options):
        with pytest.raises(ModalError, match=message) as caught:
            read(*sets, **options)
        assert "\n" not in str(caught.value)

    return check
