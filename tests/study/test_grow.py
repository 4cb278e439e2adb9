"""Nested designs, and studies that grow: what exists keeps its name, its values and its part of the split."""

import numpy as np
import pytest
from fake_solver import STUDY, simulate
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.base.errors import InputError
from billow.results.dataset_files import Parameter
from billow.study import study as study_module
from billow.study.definition import StudyDefinition
from billow.study.design import draw, latin_hypercube, refine
from billow.study.grow import read_added_designs
from billow.study.study import Study
from billow.study.variables import StudyConstraint

ROWS = "lift [m],slope [N/m]\n1.5,2000.0\n1.25,30000.0\n"


def is_latin_hypercube(points):
    strata = np.sort(np.floor(np.array(points) * len(points)).astype(int), axis=0)
    return np.array_equal(strata, np.tile(np.arange(len(points))[:, None], np.shape(points)[1]))


@given(st.integers(2, 12), st.lists(st.integers(2, 4), min_size=1, max_size=3), st.integers(1, 6), st.integers(0, 99))
@settings(max_examples=40)
def test_every_size_of_a_nested_design_is_a_latin_hypercube(first, factors, dimensions, seed):
    random = np.random.default_rng(seed)
    points = latin_hypercube(first, dimensions, random)
    for factor in factors:
        finer = np.vstack([points, refine(points, factor * len(points), random)])
        assert np.array_equal(finer[: len(points)], points)
        assert is_latin_hypercube(finer)
        points = finer


def fractions(values):
    lift, slope = np.array(list(values)).T
    return np.column_stack([lift - 1.0, np.log10(slope / 1e3) / 3.0])


def test_the_papers_sizes_are_nested(definition):
    loaded = StudyDefinition.load(definition)
    nested = draw(loaded.model_copy(update={"train": 400, "test": 50, "nested": (100, 200)}))
    points = fractions(nested.train.values())
    for size in (100, 200, 400):
        assert is_latin_hypercube(points[:size])
    alone = draw(loaded.model_copy(update={"train": 100, "test": 50}))
    assert list(alone.train.values()) == list(nested.train.values())[:100]
    assert list(alone.test.values()) == list(nested.test.values())
    assert not np.corrcoef(points[100:].T)[0, 1] ** 2 > 16 / 300  # new points fill both axes independently


@pytest.mark.parametrize(("sizes", "told"), [("[3]", "4 is not a multiple of 3"), ("[4]", "4 is not a multiple of 4")])
def test_sizes_that_do_not_nest_are_refused(definition, sizes, told):
    definition.write_text(STUDY.replace("train = 4", f"train = 4\nnested = {sizes}"))
    with pytest.raises(InputError, match="E-STU-004") as caught:
        StudyDefinition.load(definition)
    assert told in caught.value.why


def test_a_study_grows_and_keeps_what_it_has(study, definition):
    study.run(workers=1, runner=simulate)
    inodes = {run: (study.folder / "runs" / run).stat().st_ino for run in study.runs}
    definition.write_text(STUDY.replace("train = 4", "train = 8"))
    larger = Study.create(definition, study.folder)
    assert larger.test == study.test
    assert list(larger.train) == ["0000", "0001", "0002", "0003", "0006", "0007", "0008", "0009"]
    assert {run: larger.train[run] for run in study.train} == study.train
    assert is_latin_hypercube(fractions(larger.train.values()))
    assert list(study.dataset().missing.values()) == ["not run yet"] * 4  # valid before the new runs are made
    made = []
    larger.run(workers=1, runner=simulate, progress=lambda event: made.append(event.run))
    assert [run for run in made if run] == ["0006", "0007", "0008", "0009"]
    assert {run: (study.folder / "runs" / run).stat().st_ino for run in study.runs} == inodes
    dataset = larger.dataset()
    assert (len(dataset.train), len(dataset.test), dataset.missing) == (8, 2, {})
    # The same file again, and one that tells the sizes, are this study; the old one is not.
    assert Study.create(definition, study.folder).runs == larger.runs
    definition.write_text(STUDY.replace("train = 4", "train = 8\nnested = [4]"))
    assert Study.create(definition, study.folder).runs == larger.runs
    definition.write_text(STUDY)
    with pytest.raises(InputError, match=r"E-STU-008(.|\n)*8 training runs already"):
        Study.create(definition, study.folder)


def test_growing_twice_equals_drawing_at_once(study, definition, tmp_path):
    for train in (8, 24):
        definition.write_text(STUDY.replace("train = 4", f"train = {train}"))
        grown = Study.create(definition, study.folder)
    definition.write_text(STUDY.replace("train = 4", "train = 24\nnested = [4, 8]"))
    at_once = Study.create(definition, tmp_path / "other")
    assert list(at_once.train.values()) == list(grown.train.values())
    assert list(at_once.test.values()) == list(grown.test.values())


def test_a_study_grows_to_multiples_only(study, definition):
    definition.write_text(STUDY.replace("train = 4", "train = 6"))
    with pytest.raises(InputError, match="E-STU-025"):
        Study.create(definition, study.folder)
    assert Study.open(study.folder).runs == study.runs


@pytest.mark.parametrize("change", [("test = 2", "test = 3"), ("seed = 3", "seed = 4"), ("low = 1.0", "low = 0.9")])
def test_nothing_else_may_change_while_it_grows(study, definition, change):
    definition.write_text(STUDY.replace("train = 4", "train = 8").replace(*change))
    with pytest.raises(InputError, match="E-STU-008"):
        Study.create(definition, study.folder)


def test_added_designs_become_training_runs(study, definition, tmp_path):
    study.run(workers=1, runner=simulate)
    (tmp_path / "next.csv").write_text(ROWS)
    with_rows = STUDY.replace("train = 4", 'train = 4\nadded_designs = "next.csv"')
    definition.write_text(with_rows)
    grown = Study.create(definition, study.folder)
    assert grown.train == {**study.train, "0006": (1.5, 2000.0), "0007": (1.25, 30000.0)}
    assert grown.test == study.test
    assert grown.run(workers=1, runner=simulate).completed == tuple(grown.runs)
    # More of both later: rows and hypercube points go on numbering where they are.
    (tmp_path / "next.csv").write_text(ROWS + "1.125,40000.0\n")
    definition.write_text(with_rows.replace("train = 4", "train = 8"))
    more = Study.create(definition, study.folder)
    assert list(more.train)[:6] == list(grown.train)
    assert len(more.train) == 8 + 3
    assert Study.open(study.folder).definition.nested == (4,)
    definition.write_text(STUDY.replace("train = 4", "train = 8"))
    assert Study.create(definition, study.folder).train == more.train  # what was added once stays


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ("lift [m]\n1.5\n", "its columns are"),
        (ROWS + "1.5,2000.0\n", "twice"),
        (ROWS + "2.5,2000.0\n", "line 4: lift = 2.5 is not between 1 and 2"),
        (ROWS + "1.5\n", "line 4 has 1 value, the header"),
        (ROWS + "1.5,soft\n", "soft"),
        (ROWS + "nan,2000.0\n", "line 4: the value of 'lift [m]' is 'nan'"),
    ],
)
def test_rows_that_cannot_be_added_are_refused(definition, tmp_path, rows, told):
    (tmp_path / "next.csv").write_text(rows)
    definition.write_text(STUDY.replace("train = 4", 'train = 4\nadded_designs = "next.csv"'))
    with pytest.raises(InputError, match="E-STU-024") as caught:
        Study.create(definition, tmp_path / "study2")
    assert told in caught.value.why
    assert not (tmp_path / "study2").exists()


def test_a_row_that_breaks_a_constraint_is_refused(definition, tmp_path):
    (tmp_path / "next.csv").write_text(ROWS)
    limit = "[[constraints]]\nterms = {slope = 1e-4, lift = -2.0}\nat_most = LIMIT\n[[parameters]]"
    text = STUDY.replace("train = 4", 'train = 4\nadded_designs = "next.csv"').replace("[[parameters]]", limit, 1)
    definition.write_text(text.replace("LIMIT", "0.4"))
    with pytest.raises(InputError, match="E-STU-024") as caught:
        Study.create(definition, tmp_path / "study2")
    assert "line 3 breaks number 1 of [[constraints]]" in caught.value.why
    definition.write_text(text.replace("LIMIT", "0.5"))
    assert len(Study.create(definition, tmp_path / "study2").train) == 6


def test_a_row_on_a_constraint_fulfils_it_whatever_rounding_does():
    assert 0.1 + 0.2 > 0.3
    on = StudyConstraint(terms={"a": 1.0, "b": 1.0}, at_most=0.3)
    assert on.holds(np.array([[0.1, 0.2], [0.1, 0.2 + 1e-9]]), ["a", "b"]).tolist() == [True, False]


def test_a_row_between_two_levels_is_refused(tmp_path):
    """Its run would be that of the nearest level, and what is learned from it would not say so."""
    gas = Parameter("gas", "Gas", "-", 0.0, 1.0, ("air", "argon"))
    (tmp_path / "next.csv").write_text("gas [-]\n1\n")
    assert read_added_designs(tmp_path / "next.csv", (gas,)) == [(1.0,)]
    (tmp_path / "next.csv").write_text("gas [-]\n1\n0.4\n")
    with pytest.raises(InputError, match="E-STU-024") as caught:
        read_added_designs(tmp_path / "next.csv", (gas,))
    assert "line 3: gas = 0.4 is the number of no level" in caught.value.why


def test_a_design_that_is_a_test_run_is_not_learned_from(study, definition, tmp_path):
    lift, slope = next(iter(study.test.values()))
    (tmp_path / "next.csv").write_text(f"lift [m],slope [N/m]\n{lift!r},{slope!r}\n")
    definition.write_text(STUDY.replace("train = 4", 'train = 4\nadded_designs = "next.csv"'))
    with pytest.raises(InputError, match=r"E-STU-008(.|\n)*one of its test runs"):
        Study.create(definition, study.folder)


@pytest.mark.parametrize("file", ["design.csv", "split.toml", "study.toml"])
def test_a_crash_while_it_grows_leaves_a_study_that_goes_on(study, definition, monkeypatch, file):
    study.run(workers=1, runner=simulate)
    definition.write_text(STUDY.replace("train = 4", "train = 8"))

    def crashing(name):
        if name == file:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        for module, function in ((study_module, "write_design"), (study_module, "write_split")):
            real, name = (
                getattr(module, function),
                {"write_design": "design.csv", "write_split": "split.toml"}[function],
            )
            patch.setattr(module, function, lambda *a, real=real, name=name: (crashing(name), real(*a)))
        real_write = study_module.write_atomically
        patch.setattr(
            study_module, "write_atomically", lambda path, text: (crashing(path.name), real_write(path, text))
        )
        with pytest.raises(KeyboardInterrupt):
            Study.create(definition, study.folder)
    assert set(study.dataset().test) == set(study.test)
    grown = Study.create(definition, study.folder)
    assert grown.run(workers=1, runner=simulate).completed == tuple(grown.runs)
    assert list(grown.train)[4:] == ["0006", "0007", "0008", "0009"]


def test_a_run_that_was_added_stays_when_the_study_is_asked_for_again(definition, tmp_path):
    study = Study.create(definition, tmp_path / "study")
    grown, run = study.with_run((1.5, 1e4))
    assert grown.train[run] == (1.5, 1e4)
    assert grown.with_run((1.5, 1e4))[1] == run
    again = Study.create(definition, tmp_path / "study")
    assert (again.train, again.test) == (grown.train, study.test)
