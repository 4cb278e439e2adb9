"""The first round of docs/design.md: its files are read and its commands run, on a shorter and smaller study."""

import json
import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from billow.cli.main import app

PAGE = (Path(__file__).parents[2] / "docs" / "design.md").read_text(encoding="utf-8")
TOML = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
COMMANDS = re.search(r"```\n(billow study.*?)```", PAGE, re.DOTALL)[1].splitlines()
SHORTER = {"train = 16": "train = 13", "test = 4": "test = 1", "speed = 0.1": "speed = 0.05",
           "clearance = 0.30": "clearance = 0.05", "end_time = 0.060": "end_time = 0.016", "frames = 20": "frames = 8",
           "histories_per_frame = 30": "histories_per_frame = 20", "peak_pressure = 60.0": "peak_pressure = 500.0",
           "--verify 3": "--verify 1", "[run]": "[inflator.mass_flow]\ntime = [0.0, 0.002, 0.008]\nvalue = [0.0, 3.0, 0.0]\n[run]"}  # fmt: skip


def shorter(text):
    for one, other in SHORTER.items():
        text = text.replace(one, other)
    return text


@pytest.mark.slow
def test_commands_of_the_page(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in zip(("study.toml", "case.toml", "goals.toml", "scatter.toml"), TOML, strict=True):
        Path(name).write_text(shorter(text))
    for command in COMMANDS:
        words = shlex.split(shorter(command))[1:]
        if words[0] == "study":
            words += ["--workers", "1"]
        done = CliRunner().invoke(app, words)
        may_not_hold = 1 if "--verify" in words else 0  # runs as short and coarse as these need not keep the limits
        assert done.exit_code in (0, may_not_hold), f"{command}\n{done.output}\n{done.exception}"
    assert len(Path("responses.csv").read_text().splitlines()) >= 13
    record = json.loads(Path("best/optimum.json").read_text())
    assert record["rounds"][0]["run"] == "0014"
    page = Path("design.html").read_text()
    assert page.count("data:image/svg") >= 9
    assert "hic15" in page
