"""Runs that nothing was learned from are told, with what they have in common."""

from __future__ import annotations

import dataclasses

import pytest
from synthetic import SyntheticDataset

from billow.rom.judge.evaluate import evaluate
from billow.rom.judge.findings import weaknesses
from billow.rom.learn.left_out import LeftOut, left_out
from billow.rom.learn.train import Recipe, train


def without(dataset, lost, reason="failed"):
    """The dataset with training runs left out."""
    dataset.left_out = dict.fromkeys(lost, reason)
    dataset.trusted = tuple(run for run in dataset.train if run not in lost)
    return dataset


def by_jet(dataset):
    """Training runs, those with the largest third parameter first."""
    return sorted(dataset.train, key=lambda run: -dataset.design([run])[0][2])


@pytest.mark.parametrize(("side", "part"), [("high", slice(0, 8)), ("low", slice(-8, None))])
def test_runs_that_fail_at_one_end_of_a_range_are_found_to_lean(side, part):
    dataset = SyntheticDataset(train=40)
    lost = left_out(without(dataset, by_jet(dataset)[part]), dataset.trusted)
    assert lost.leaning == {dataset.parameters[2].label: side}
    assert lost.biased
    assert lost.part == 8 / 40


def test_runs_that_fail_anywhere_do_not_lean():
    dataset = SyntheticDataset(train=40)
    lost = left_out(without(dataset, by_jet(dataset)[::5]), dataset.trusted)
    assert lost.leaning == {}
    assert lost.biased  # 8 of 40 are many all the same


def test_one_in_a_hundred_is_no_bias_unless_they_lean():
    dataset = SyntheticDataset(train=200)
    assert not left_out(without(dataset, by_jet(dataset)[:2]), dataset.trusted).biased  # two have nothing in common
    assert not left_out(without(dataset, by_jet(dataset)[20:200:70]), dataset.trusted).biased
    assert left_out(without(dataset, by_jet(dataset)[:3]), dataset.trusted).biased


def test_runs_used_all_the_same_are_not_left_out():
    dataset = without(SyntheticDataset(train=40), ["0003", "0004"])
    assert set(left_out(dataset, dataset.train[:4]).why) == {"0004"}


def test_reasons_are_counted_without_their_particulars():
    why = {"1": "E-NUM-005: torn; element 3", "2": "E-NUM-005: torn; element 9", "3": "REVIEW: shooting nodes"}
    assert LeftOut(why, 0.1, {}).reasons() == "E-NUM-005: torn (2), REVIEW: shooting nodes (1)"
    many = {str(k): f"reason {k}" for k in range(5)}
    assert LeftOut(many, 0.1, {}).reasons().endswith(", ...")


def test_the_report_declares_the_bias():
    dataset = SyntheticDataset(train=12, test=2, times=5, nodes=60)
    surrogate = train(dataset, Recipe(modes=2, epochs=2))
    evaluation = evaluate(dataset, surrogate, sizes=(), modes=(1, 2))
    assert not any("learned from" in sentence for sentence in weaknesses(evaluation))
    lost = LeftOut({f"{run:04d}": "failed" for run in range(4)}, 0.25, {"Jet direction": "high"})
    told = [text for text in weaknesses(dataclasses.replace(evaluation, left_out=lost)) if "learned from" in text]
    assert "4 training runs, 25.0 % of the design, because failed (4)" in told[0]
    assert "where Jet direction is high: the surrogate is biased" in told[0]
    few = LeftOut({"0001": "failed"}, 0.01, {})
    told = [text for text in weaknesses(dataclasses.replace(evaluation, left_out=few)) if "learned from" in text]
    assert told[0].endswith("failed (1).")
