"""Damaged FRF files and configurations are read or refused in one line; scripts/documents/fuzz.py tries many more."""

import warnings

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzz_doors import VALID, Case, check, mutated

QUIET = {"deadline": None, "suppress_health_check": [HealthCheck.function_scoped_fixture], "derandomize": True}


def test_the_files_are_valid_before_they_are_damaged(tmp_path):
    for name, content in VALID.items():
        options = {} if name.endswith(("csv", "txt", "yaml")) else {"number": 1}
        assert name == "study.yaml" or check(Case(name, content, options), tmp_path), name


@settings(max_examples=200, **QUIET)
@given(number=st.integers(0, 2**32 - 1))
def test_damaged_files(tmp_path, number):
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        check(mutated(np.random.default_rng(number)), tmp_path)
