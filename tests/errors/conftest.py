"""Sound files to be damaged, made once for all tests of errors."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))  # trust/ stands beside the package, not in it


@pytest.fixture(scope="session")
def bench(tmp_path_factory):
    """`trust.fuzz_inputs.Bench`: a study of four tiny runs, an interrupted run, a surrogate; leave them as they are."""
    from trust.fuzz_inputs import Bench

    return Bench(tmp_path_factory.mktemp("bench"))
