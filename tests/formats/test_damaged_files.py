"""Damaged files of every kind are read or refused in one line; scripts/documents/fuzz.py tries 10,000."""

import pytest

from fuzz_files import KINDS, damage, is_read, read_valid_files, valid_files

pytest.importorskip("meshio")
pytest.importorskip("pyuff")


def test_the_files_are_valid_before_they_are_damaged(tmp_path):
    assert {kind for kind, _ in valid_files()} == set(KINDS)
    read_valid_files(tmp_path)


@pytest.mark.parametrize("first", [0, 200])
def test_damaged_files_are_read_or_refused(tmp_path, first):
    fates = {}
    for number in range(first, first + 200):
        try:
            fates[number] = is_read(damage(number), tmp_path)
        except Exception as error:
            error.add_note(f"case {number}")
            raise
    assert set(fates.values()) == {True, False}


def test_a_number_gives_the_same_case_again():
    assert damage(7) == damage(7)
    assert damage(7) != damage(8)
