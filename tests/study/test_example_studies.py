"""The studies in examples/: their cases accept every design, and they are what the ROM paper says."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from billow.study.definition import StudyDefinition
from billow.study.study import Study

EXAMPLES = Path(__file__).parents[2] / "examples" / "studies"
TABLE_1 = {
    "permeability": (0.02, 0.035),
    "inflator_temperature": (500.0, 800.0),
    "jet_direction": (30.0, 60.0),
    "impactor_radius": (0.1, 0.25),
    "impactor_degree": (2.0, 4.5),
}
SIXTH = {"locked": ("contact_slope", (1e3, 1e6)), "free": ("impactor_angle", (0.0, 45.0))}


@pytest.mark.parametrize("kind", ["locked", "free"])
def test_a_study_has_the_papers_size_and_ranges(kind):
    study = StudyDefinition.load(EXAMPLES / f"study_{kind}.toml")
    assert (study.train, study.test, study.nested) == (400, 50, (100, 200))
    name, ranges = SIXTH[kind]
    assert {p.name: (p.low, p.high) for p in study.parameters} == {**TABLE_1, name: ranges}
    small = StudyDefinition.load(EXAMPLES / f"study_{kind}_small.toml")
    assert small.parameters == study.parameters


@pytest.mark.parametrize("kind", ["locked", "free"])
def test_the_small_study_is_made_and_its_cases_are_the_papers(kind, tmp_path):
    study = Study.create(EXAMPLES / f"study_{kind}_small.toml", tmp_path / "study")
    assert (len(study.train), len(study.test)) == (48, 12)
    impactor = {run: study.case(run).obstacles[-1] for run in list(study.runs)[:3]}
    for run, obstacle in impactor.items():
        values = dict(zip((p.name for p in study.definition.parameters), study.runs[run], strict=True))
        assert obstacle.locked == (kind == "locked")
        assert obstacle.slope == (values["contact_slope"] if kind == "locked" else 2e6)
        assert obstacle.degree == values["impactor_degree"]
        assert np.all(np.array(obstacle.radii) == values["impactor_radius"])
        if kind == "free":
            assert obstacle.angle_about_x == values["impactor_angle"]
    assert study.case("0000").run.frames == 50


def test_the_design_example_is_made_and_its_companions_fit_it(tmp_path):
    """Goals, design and scatter name parameters and responses of the study."""
    folder = EXAMPLES.parent / "design"
    study = Study.create(folder / "study.toml", tmp_path / "study")
    parameters = {p.name: p for p in study.definition.parameters}
    responses = {r.name for r in study.definition.responses}
    assert len(parameters) == 6
    assert study.case("0000").obstacles[-1].velocity[2] < 0.0
    design, scatter, goals = (tomllib.loads((folder / f"{n}.toml").read_text()) for n in ("design", "scatter", "goals"))
    assert set(design) == set(scatter) == set(parameters)
    assert all(parameters[name].low < value < parameters[name].high for name, value in design.items())
    assert {goals["minimise"], *goals["below"], *goals["above"]} <= responses
    assert set(goals["fixed"]) <= set(parameters)
