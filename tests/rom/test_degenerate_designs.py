"""Runs of one design, that hardly differ, lie on a line, or are too few: learned from as what they are, or refused."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from free_synthetic import FreeDataset
from synthetic import SyntheticDataset

from billow.base.errors import InputError
from billow.rom.coupled.impactor import ImpactorOfDesign
from billow.rom.judge.evaluate import evaluate
from billow.rom.judge.findings import verdict, weaknesses
from billow.rom.judge.report import page
from billow.rom.learn.simple_answers import radial_basis
from billow.rom.learn.suggest import suggest
from billow.rom.learn.train import Recipe, of_one_design, train
from billow.rom.surrogate.design_space import distinct, standing


@pytest.fixture(autouse=True)
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def designed(change, train=6, test=1):
    """A small dataset whose designs are changed: change(rows) of the training runs, (runs, parameters), in place."""
    dataset = SyntheticDataset(train=train, test=test, times=4, nodes=60)
    rows = dataset.design(dataset.train)
    change(rows)
    dataset._design |= dict(zip(dataset.train, rows, strict=True))
    return dataset


def copied(rows):
    rows[1] = rows[0]


def nearly_copied(rows):
    rows[1] = rows[0] * (1.0 + 1e-12)


def close(rows):
    rows[1] = rows[0] * (1.0 + 1e-5)


def on_a_line(rows):
    rows[:] = rows[0] + np.linspace(0.0, 1.0, len(rows))[:, None] * (rows[1] - rows[0])


@pytest.mark.parametrize("change", [copied, nearly_copied, close, on_a_line])
def test_designs_that_hardly_differ_are_learned_from_and_judged(change):
    dataset = designed(change, train=9)
    surrogate = train(dataset, Recipe(modes=2, epochs=1))
    found = evaluate(dataset, surrogate)
    assert np.isfinite(found.errors["radial basis functions"]).all()
    stands = surrogate.standing(dataset.design(dataset.test)[0])
    assert 0.0 < stands.usual <= stands.largest
    weaknesses(found)
    verdict(found)
    page(found, {})
    suggest(surrogate, 2, dataset.design(dataset.train))


def test_copies_are_named():
    dataset = designed(copied)
    assert of_one_design(dataset, dataset.train)[0] == ("0000", "0001")
    known, twice = dataset.design(dataset.train[1:]), dataset.design(dataset.train)
    asked = dataset.design(dataset.test)[0]
    assert standing(asked, twice, dataset.parameters) == standing(asked, known, dataset.parameters)
    assert distinct(twice, dataset.parameters) == [[0, 1], [2], [3], [4], [5]]


def test_copies_count_as_their_mean():
    dataset = designed(copied)
    rows = dataset.design(dataset.train)
    values = np.arange(6.0)[:, None, None, None] * np.ones((1, 1, 3, 1))
    assert radial_basis(rows, values, dataset.parameters)(rows[0]) == pytest.approx(0.5, abs=1e-9)


def fixed(rows):
    rows[:, 2] = 45.0


@pytest.mark.parametrize(
    ("change", "runs", "message"),
    [
        (fixed, 6, r"E-ROM-010(?s:.*)jet(?s:.*)one value"),
        (lambda rows: None, 1, r"E-ROM-007(?s:.*)one design"),
        (lambda rows: rows.__setitem__(slice(None), rows[0]), 6, r"E-ROM-007(?s:.*)one design"),
    ],
)
def test_what_shows_nothing_of_a_parameter_is_refused(change, runs, message):
    dataset = designed(change)
    with pytest.raises(InputError, match=message):
        train(dataset, Recipe(modes=1, epochs=1), runs=dataset.train[:runs])


def test_two_runs_are_enough_to_learn_from_and_say_that_nobody_judged():
    dataset = designed(lambda rows: None, train=2)
    surrogate = train(dataset, Recipe(modes=1, epochs=1))
    assert surrogate.judgement is None
    found = evaluate(dataset, surrogate)
    assert any("So few runs do not show" in s or "are few" in s for s in weaknesses(found))


def test_a_study_whose_runs_are_all_in_doubt_is_told_that_reason():
    dataset = SyntheticDataset(train=4, test=1, times=4, nodes=60)
    dataset.trusted, dataset.left_out = (), dict.fromkeys(dataset.train, "REVIEW: mass of gas")
    with pytest.raises(
        InputError, match=r"E-ROM-007(?s:.*)REVIEW: mass of gas \(4\)(?s:.*)runs/0000/run\.json"
    ) as told:
        train(dataset)
    assert "finish the study" not in str(told.value)


def test_an_obstacle_is_not_learned_from_copies_and_says_why():
    class Copies:
        def __getattr__(self, name):
            return getattr(free, name)

        def design(self, runs):
            return np.repeat(free.design(runs[:2]), 6, axis=0)[: len(runs)]

    free = FreeDataset(train=8, test=0, nodes=40)
    copies = Copies()
    copies.result = lambda run: free.result(free.train[int(run) // 6])
    with pytest.raises(InputError, match=r"E-CPL-004(?s:.*)copies of few"):
        ImpactorOfDesign.learn(copies, free.train)


@pytest.mark.parametrize(
    "recipe",
    [
        Recipe(modes=0),
        Recipe(modes=10**9),
        Recipe(epochs=0),
        Recipe(epochs=10**9),
        Recipe(epochs=1.5),
        Recipe(seed=-1),
        Recipe(seed=2**70),
        Recipe(force_modes=-1),
        Recipe(memory=0),
        Recipe(memory=float("nan")),
    ],
    ids=repr,
)
def test_a_recipe_out_of_bounds_is_refused_before_any_work(dataset, recipe):
    with pytest.raises(InputError, match="E-ROM-026"):
        train(dataset, recipe)
