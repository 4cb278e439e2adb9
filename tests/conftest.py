"""What tests share: a driver case that runs in half a second, its result, and one hypothesis profile."""

from __future__ import annotations

import os
from pathlib import Path

# Two test processes on two cores: threads of BLAS would wait for each other (78 s for half a second of work).
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numba
import pytest
from hypothesis import settings

from billow.case.schema import Case
from billow.results.result import Result
from billow.run.interrupts import STOP_FILE, RunInterrupted
from billow.run.simulate import resume, simulate

# The same examples on every machine and every day: a test that fails, fails for everyone.
settings.register_profile("billow", deadline=None, derandomize=True, database=None, max_examples=100)
settings.load_profile("billow")


@pytest.fixture(autouse=True)
def one_thread():
    """Two processes use both cores already, and parallel compilations of kernels take longer than all they are used
    for. Tests of threads ask for `threads`."""
    numba.set_num_threads(1)


@pytest.fixture
def threads():
    """Sets the number of threads until the test ends; where there are not two, the test is skipped."""
    if numba.config.NUMBA_NUM_THREADS < 2:
        pytest.skip("one thread only")
    yield numba.set_num_threads
    numba.set_num_threads(1)


SMALL = {
    "title": "Small driver bag",
    "bag": {"element_size": 0.05},
    "fabric": {"permeability": 0.0275},
    "obstacles": [
        {"shape": "plate"},
        {
            "shape": "super-ellipsoid",
            "name": "impactor",
            "radii": 0.175,
            "degree": 3.0,
            "clearance": 0.05,
            "slope": 5e5,
            "locked": False,
        },
    ],
    "run": {"end_time": 0.015, "frames": 3, "histories_per_frame": 2},
}


@pytest.fixture(scope="session")
def small_case() -> Case:
    """612 triangles, 15 ms, plate and a free impactor that is hit at about 8 ms: every part of the solver works."""
    return Case.from_dict(SMALL)


def simulate_in_two(case: Case, folder: Path) -> Result:
    """Recover mode: the run is asked to stop half-way by a STOP file, and resumed from its checkpoint."""

    def stop_half_way(progress) -> None:
        if progress.time >= 0.5 * progress.end:
            (folder.with_name(folder.name + ".partial") / STOP_FILE).touch()

    with pytest.raises(RunInterrupted):
        simulate(case, folder, progress=stop_half_way)
    return resume(folder)


@pytest.fixture(scope="session")
def in_two():
    """`simulate_in_two`."""
    return simulate_in_two


@pytest.fixture(scope="session", params=[simulate, simulate_in_two], ids=["straight", "recovered"])
def deploy(request):
    """`simulate`, and the same stopped half-way and resumed: every scenario must pass both ways."""
    return request.param


@pytest.fixture(scope="session")
def small_run(deploy, small_case, tmp_path_factory) -> Result:
    """The result of the small case; read it, do not write to its folder."""
    return deploy(small_case, tmp_path_factory.mktemp("small") / "run")
