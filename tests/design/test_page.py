"""The first round of docs/design.md: its study is accepted, and its commands run, on made-up values of responses."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from billow.case.schema import Case
from billow.cli.main import app
from billow.design import surfaces, table
from billow.study.corners import check_values, meshed_once
from billow.study.definition import StudyDefinition
from billow.study.design import draw

PAGE = (Path(__file__).parents[2] / "docs" / "design.md").read_text(encoding="utf-8")
TOML = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
(PYTHON,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
COMMANDS = re.search(r"```\n(billow study.*?)```", PAGE, re.DOTALL)[1].splitlines()
NAMES = ("study.toml", "case.toml", "goals.toml", "scatter.toml")


@pytest.fixture
def definition(tmp_path, monkeypatch):
    """The page's study, in the folder of the test."""
    monkeypatch.chdir(tmp_path)
    for name, text in zip(NAMES, TOML, strict=True):
        Path(name).write_text(text)
    return StudyDefinition.load("study.toml")


def made_up(definition: StudyDefinition) -> table.ResponseTable:
    """A table of the page's study, its responses smooth functions of the designs."""
    designs = np.array(list(draw(definition).runs.values()))
    vent, speed, scale = ((column - column.mean()) / np.ptp(column) for column in designs.T)
    values = np.column_stack(
        [600.0 - 700.0 * speed - 200.0 * vent + 300.0 * scale**2, 50.0 - 20.0 * vent + 30.0 * scale]
    )
    runs = tuple(f"{k:04d}" for k in range(len(designs)))
    return table.ResponseTable(definition.title, definition.axes, definition.responses, ("-", "kPa"), runs,
                               definition.test, designs, values, {})  # fmt: skip


def test_the_study_of_the_page_is_accepted(definition):
    case = meshed_once(Case.load("case.toml"), definition)
    check_values(Path("study.toml"), definition, case)
    assert case.bag.mesh_of.vent_diameter == case.bag.vents.diameter


def test_the_python_of_the_page(definition, monkeypatch):
    monkeypatch.setattr(surfaces, "respond", lambda folder, responses: made_up(definition))
    session: dict = {}
    exec(PYTHON, session)
    assert session["best"].design["speed"] == pytest.approx(-5.0)
    assert session["surfaces"].verdict("hic15").word == "usable"


@pytest.mark.parametrize(("given", "missing"), [("--scatter", "--optimum or --design"), ("--design", "--scatter")])
def test_a_report_of_robustness_needs_a_design_and_its_scatter(given, missing):
    """It was written without a word of robustness."""
    done = CliRunner().invoke(app, ["design", "report", "none.safetensors", given, "x.toml", "--out", "x.html"])
    assert done.exception.code == "E-DES-040"
    assert missing in done.exception.remedy


def test_commands_of_the_page(definition, monkeypatch):
    monkeypatch.setattr(table, "respond", lambda folder: made_up(definition))
    assert COMMANDS[0].startswith("billow study")
    for command in COMMANDS[1:]:
        words = shlex.split(command.replace("--verify 3", ""))[1:]
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, f"{command}\n{done.output}\n{done.exception}"
    assert len(Path("responses.csv").read_text().splitlines()) == 21
    record = json.loads(Path("best/optimum.json").read_text())
    assert record["rounds"][0]["design"]["speed"] == pytest.approx(-5.0)
    assert record["rounds"][0]["predicted"]["peak_pressure"][2] <= 60.0
    page = Path("design.html").read_text()
    assert page.count("data:image/svg") >= 9
    assert "Not run in the solver yet" in page
