"""Parameters, factors and constraints draw what they say."""

import numpy as np
import pytest
from scipy import stats

from billow.base.errors import InputError
from billow.case.schema import Case
from billow.study.definition import StudyDefinition
from billow.study.design import draw, maximin_hypercube
from billow.study.variables import StudyFactor, StudyParameter

HEAD = 'title = "T"\ncase = "case.toml"\nseed = 5\ntrain = 16\ntest = 4\nreference_length = 0.3\n'
AXIS = '[[parameters]]\nname = "{}"\nlabel = "L"\nunit = "m"\nlow = {}\nhigh = {}\nkeys = ["{}"]\n'
PAIR = AXIS.format("a", 1.0, 2.0, "x.a") + AXIS.format("b", 1.0, 3.0, "x.b")


def parameter(**given):
    table = {"name": "a", "label": "L", "unit": "m", "low": 1.0, "high": 3.0, "keys": ["x.a"]}
    return StudyParameter.model_validate(table | given)


def study(tmp_path, text):
    (tmp_path / "case.toml").write_text("")
    (tmp_path / "study.toml").write_text(text)
    return StudyDefinition.load(tmp_path / "study.toml")


def drawn(one, count=4000):
    return np.array([one.value((k + 0.5) / count) for k in range(count)])


@pytest.mark.parametrize(
    ("given", "law"),
    [
        ({}, stats.uniform(1.0, 2.0)),
        ({"scale": "log"}, stats.loguniform(1.0, 3.0)),
        ({"distribution": "triangular", "middle": 1.5}, stats.triang(0.25, 1.0, 2.0)),
        ({"distribution": "normal", "middle": 1.8, "deviation": 0.5}, stats.truncnorm(-1.6, 2.4, 1.8, 0.5)),
    ],
)
def test_values_follow_their_distribution(given, law):
    assert stats.kstest(drawn(parameter(**given)), law.cdf).statistic < 1e-3


def test_steps_come_equally_often():
    values, counts = np.unique(drawn(parameter(step=0.5)), return_counts=True)
    assert values.tolist() == [1.0, 1.5, 2.0, 2.5, 3.0]
    assert np.ptp(counts) == 0


def test_levels_set_their_entries_and_come_equally_often():
    levels = [
        {"name": "air", "entries": {"g.a": {"N2": 1.0}}},
        {"name": "argon", "entries": {"g.a": {"Ar": 1.0}, "g.b": 2}},
    ]
    factor = StudyFactor.model_validate({"name": "gas", "label": "Gas", "levels": levels})
    assert np.unique(drawn(factor), return_counts=True)[1].tolist() == [2000, 2000]
    assert factor.entries(1.0) == {"g.a": {"Ar": 1.0}, "g.b": 2}
    assert factor.axis.levels == ("air", "argon")


def test_every_design_fulfils_the_constraints(tmp_path):
    text = HEAD + PAIR + "[[constraints]]\nterms = {a = 2.0, b = -1.0}\nat_least = 0.0\nat_most = 1.5\n"
    rows = np.array(list(draw(study(tmp_path, text)).runs.values()))
    assert len(rows) == 20
    assert ((2 * rows[:, 0] - rows[:, 1] >= 0.0) & (2 * rows[:, 0] - rows[:, 1] <= 1.5)).all()


def test_constraints_that_leave_nothing_are_refused(tmp_path):
    text = HEAD + PAIR + "[[constraints]]\nterms = {a = 1.0}\nat_least = 5.0\n"
    with pytest.raises(InputError) as caught:
        draw(study(tmp_path, text))
    assert caught.value.code == "E-STU-041"


def test_a_sobol_study_grows_by_any_number(tmp_path):
    text = HEAD.replace("seed = 5", 'seed = 5\nsampling = "sobol"') + PAIR
    few, many = (
        list(draw(study(tmp_path, text.replace("train = 16", f"train = {n}"))).train.values()) for n in (13, 29)
    )
    assert many[:13] == few


def test_maximin_keeps_strata_and_points_apart():
    points = maximin_hypercube(20, 3, np.random.default_rng(1))
    assert np.array_equal(np.sort(np.floor(points * 20), axis=0), np.tile(np.arange(20.0)[:, None], 3))
    plain = [(np.argsort(np.random.default_rng(s).random((20, 3)), axis=0) + 0.5) / 20 for s in range(40)]
    least = [np.min(np.linalg.norm(p[:, None] - p, axis=2) + np.eye(20) * 9) for p in (points, *plain)]
    assert least[0] > max(least[1:])


def test_designs_that_a_study_may_have_lie_on_its_steps_and_fulfil_its_constraints(tmp_path):
    text = HEAD + PAIR + "step = 0.5\n[[constraints]]\nterms = {a = 1.0, b = 1.0}\nat_most = 3.0\n"
    rows = np.array([[1.2, 1.3], [1.2, 1.9], [1.9, 1.9]])
    definition = study(tmp_path, text)
    assert definition.drawable(rows).tolist() == [[1.2, 1.5]]
    assert rows[0].tolist() == [1.2, 1.3]
    assert definition.steps == {"b": 0.5}


@pytest.mark.parametrize(
    "wrong",
    [
        'distribution = "normal"\nmiddle = 4.0',
        "middle = 1.5",
        "step = 5.0",
        'distribution = "triangular"\ndeviation = 0.1',
        'scale = "log"\ndistribution = "normal"\ndeviation = 0.5',
    ],
)
def test_contradictions_are_refused(tmp_path, wrong):
    with pytest.raises(InputError) as caught:
        study(tmp_path, HEAD + AXIS.format("a", 1.0, 2.0, "x.a") + wrong)
    assert caught.value.code == "E-STU-004"


def test_entries_of_vectors_and_scales_reach_the_case():
    case = Case.from_dict({"obstacles": [{"shape": "super-ellipsoid", "name": "head", "locked": False}]})
    changes = {"obstacles.head.velocity.z": -5.0, "obstacles.head.offset.1": 0.02, "inflator.mass_flow.value.2": 3.0}
    varied = case.vary(changes)
    assert varied.obstacles[0].velocity == (0.0, 0.0, -5.0)
    assert varied.obstacles[0].offset == (0.02, 0.0)
    assert varied.inflator.mass_flow.value == (0.0, 3.0, 0.0)
    assert case.obstacles[0].velocity == (0.0, 0.0, 0.0)
    for wrong in ("obstacles.head.velocity.w", "obstacles.head.velocity.4", "obstacles.head.radii.x"):
        with pytest.raises(InputError) as caught:
            case.vary({wrong: 1.0})
        assert caught.value.code == "E-CASE-006"
