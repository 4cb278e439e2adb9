"""A start loads what its command needs, and nothing of what others need; that kernels are compiled is said."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from billow.base.compiled import COMPILING

LIST = """
import atexit, gc, json, sys
@atexit.register
def told():
    gc.unfreeze()
    modules, numba = sorted(sys.modules), sys.modules.get("numba.core.dispatcher")
    found = [o for o in gc.get_objects() if numba and isinstance(o, numba.Dispatcher) and o.overloads]
    kernels = sorted(f"{d.py_func.__module__}.{d.py_func.__name__}" for d in found)
    print(json.dumps({"modules": modules, "kernels": kernels}), file=sys.stderr)
from billow.cli.main import main
main()
"""
"""The command; at its end, which modules and kernels it has loaded, as the last line of standard error."""

CASE = """
[bag]
element_size = 0.05
[run]
end_time = "0.1 ms"
frames = 1
histories_per_frame = 1
"""

HEAVY = {"numpy", "numba", "llvmlite", "scipy", "h5py", "pydantic", "matplotlib", "torch", "distributed", "dask"}


def command(*arguments, **environment: str) -> tuple[list[str], dict]:
    """Lines that a command prints, and what it has loaded."""
    done = subprocess.run(
        [sys.executable, "-c", LIST, *map(str, arguments)],
        env={**os.environ, **environment}, capture_output=True, text=True, check=True, timeout=300,
    )  # fmt: skip
    return done.stdout.splitlines(), json.loads(done.stderr.splitlines()[-1])


def packages(modules: list[str]) -> set[str]:
    return {name.partition(".")[0] for name in modules}


def test_help_loads_no_library_that_computes():
    lines, loaded = command("--help")
    assert any("Simulate airbag deployment" in line for line in lines)
    assert not packages(loaded["modules"]) & HEAVY


@pytest.fixture(scope="module")
def case(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("start") / "case.toml"
    path.write_text(CASE)
    return path


def test_a_run_by_uniform_pressure_loads_its_own_kernels_only(case):
    command("run", case, "--out", case.with_name("first"), "--threads", 1)
    lines, loaded = command("run", case, "--out", case.with_name("second"), "--threads", 1)
    assert COMPILING not in lines
    assert COMPILING not in (case.with_name("second") / "solver.log").read_text()
    modules = set(loaded["modules"])
    assert not {name for name in modules if name.startswith("billow.parts.gas.corpuscular")}
    assert not packages(modules) & {"matplotlib", "torch", "distributed", "dask", "rich", "jinja2"}
    assert not modules & {"scipy.spatial", "scipy.sparse", "scipy.linalg", "numba.np.linalg"}
    kernels = set(loaded["kernels"])
    assert "billow.parts.gas.uniform.chamber_step.advance_chambers" in kernels
    others = ("corpuscular", "self_contact", "layers", "curve_fabric", "_parallel", "meeting")
    assert not {name for name in kernels if any(other in name for other in others)}


@pytest.mark.slow
def test_a_run_says_that_its_kernels_are_compiled_when_they_are(case, tmp_path):
    """Once, before anything else. The second run has them."""
    still = tmp_path / "still.toml"
    still.write_text(CASE + '[gas]\nmodel = "none"\n')
    said = []
    for folder in (tmp_path / "cold", tmp_path / "warm"):
        lines, _ = command("run", still, "--out", folder, "--threads", 1, BILLOW_CACHE=str(tmp_path / "cache"))
        log = (folder / "solver.log").read_text().splitlines()
        assert lines[: len(log)] == log  # peaks follow
        said.append([k for k, line in enumerate(log) if line == COMPILING])
    assert said == [[0], []]
