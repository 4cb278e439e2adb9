"""docs/dyna_results.md: its script and commands work, in their order, as they stand there; only smaller."""

from __future__ import annotations

import re
import runpy
import shlex
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from billow.cli.main import app
from billow.results.dataset import Dataset
from billow.results.result import Result
from billow.rom.surrogate.surrogate import Surrogate

PAGE = Path(__file__).parents[2] / "docs" / "dyna_results.md"
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
SMALLER = {"RUNS = 30": "RUNS = 5", '"end_time": 0.04, "frames": 20': '"end_time": 0.008, "frames": 4'}


def test_results_of_ls_dyna_become_a_surrogate(tmp_path, monkeypatch):
    """A few runs, hardly trained, so nothing is asked of the surrogate's answers; the frames that it learned are those
    of the runs that the d3plot files were written from, to single precision."""
    pytest.importorskip("dynars")
    monkeypatch.chdir(tmp_path)
    lines = []
    for language, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        if language == "python":
            for old, new in SMALLER.items():
                assert old in text
                text = text.replace(old, new)
            Path("stand_in.py").write_text(text)
        elif language != "text":
            lines += text.splitlines()
    assert [line.split()[1] for line in lines] == ["install", "stand_in.py", "import", "train", "evaluate", "explore"]
    runpy.run_path("stand_in.py", run_name="__main__")
    for line, more in zip(lines[2:4], ([], ["--epochs", "20", "--modes", "2"]), strict=True):
        done = CliRunner().invoke(app, [*shlex.split(line)[1:], *more])
        assert done.exception is None, f"{line}: {done.exception}"
    dataset, surrogate = Dataset.open("crash_study"), Surrogate.load("crash_study/surrogate.safetensors")
    assert [p.name for p in surrogate.parameters] == ["permeability", "temperature"]
    for run in ("0000", "0003"):
        native, read = Result.open(f"native/{run}"), dataset.result(run)
        assert read.times == pytest.approx(native.times)
        for mine, other in zip(native.fabric.each_points(), read.fabric.each_points(), strict=True):
            assert np.abs(mine - other).max() < 1e-7
