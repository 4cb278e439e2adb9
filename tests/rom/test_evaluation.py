"""Equation 5 by hand, errors that add up, and baselines that are what they say."""

from __future__ import annotations

import dataclasses
import json
import tracemalloc

import numpy as np
import pytest
from synthetic import SyntheticDataset

from billow.base.errors import InputError
from billow.results.dataset_files import Parameter
from billow.rom.judge.errors import Summary, accuracy, project, snapshot_rmse
from billow.rom.judge.evaluate import baselines, evaluate
from billow.rom.judge.report import metrics as metrics_of
from billow.rom.judge.timing import Inference, Timing
from billow.rom.learn.dataset import snapshot_bytes
from billow.rom.learn.simple_answers import BASELINES, radial_basis
from billow.rom.learn.train import Recipe, train


@pytest.fixture(scope="module")
def evaluation(dataset, surrogate):
    return evaluate(dataset, surrogate, sizes=(10,), modes=(1, 4, 8))


def test_equation_5_by_hand():
    # 2 runs, 1 time, 2 nodes. Run 0 errs in z by 3 and 4: sqrt((9 + 16) / 2); run 1 by 1 and 1: 1.
    truth = np.zeros((2, 1, 2, 3), np.float32)
    predicted = truth.copy()
    predicted[0, 0, :, 2], predicted[1, 0, :, 2] = (3, -4), (1, 1)
    rmse = snapshot_rmse(predicted, truth)
    assert rmse.shape == (2, 1, 3)
    assert rmse[:, 0, 2] == pytest.approx([12.5**0.5, 1.0])
    assert np.array_equal(rmse[:, :, :2], np.zeros((2, 1, 2)))
    summary = Summary.of(rmse[:, :, 2])
    assert summary.mean == pytest.approx((12.5**0.5 + 1.0) / 2)
    assert summary.maximum == pytest.approx(12.5**0.5)
    assert summary.p10 == pytest.approx(1.0 + 0.1 * (12.5**0.5 - 1.0))
    assert accuracy(0.0056, 0.28) == pytest.approx(0.98)


def test_truncation_and_regression_add_up_in_every_snapshot(evaluation):
    errors = evaluation.errors
    added = np.sqrt(np.square(errors["truncation"]) + np.square(errors["regression"]))
    assert np.allclose(errors["surrogate"], added, rtol=1e-4, atol=1e-8)
    assert (errors["truncation"] > 0).any()
    assert (errors["regression"] > errors["truncation"]).any()


def test_errors_are_those_of_the_answers(evaluation, dataset, surrogate):
    run = dataset.test[2]
    error = surrogate.predict(dataset.design([run])[0]) - dataset.snapshots("displacement", [run])[0]
    assert evaluation.errors["surrogate"][2, 11, 2] == pytest.approx(np.sqrt(np.mean(error[11, :, 2] ** 2)), rel=1e-5)


def test_surrogate_beats_every_baseline(evaluation):
    for component in range(3):
        own = evaluation.summary("surrogate", component).mean
        assert all(own < 0.9 * evaluation.summary(name, component).mean for name in BASELINES)


def test_cut_model_of_the_sweep_agrees_with_direct_evaluation(evaluation, dataset, surrogate):
    runs = dataset.train[:10]
    model = train(dataset, Recipe(modes=8, epochs=surrogate.training["epochs"], calibrate=False), runs=runs)
    for component, basis in enumerate(model.bases):
        rmse = []
        for run in dataset.test:
            learned = model.coefficients(dataset.design([run])[0])[:, component, :4]
            truth = dataset.snapshots("displacement", [run])[0, :, :, component]
            rmse.append(np.sqrt(np.square(learned @ basis.modes[:4] - truth).mean(axis=1)))
        summary = evaluation.sweep[0].errors.summary(component, 1)
        assert summary.mean == pytest.approx(np.mean(rmse), rel=1e-4)
        assert summary.maximum == pytest.approx(np.max(rmse), rel=1e-4)
    assert (np.diff(evaluation.sweep[0].errors.truncation[..., 2].mean(axis=(1, 2))) < 0).all()


def test_models_of_the_learning_curve_trained_side_by_side_are_those_trained_alone(dataset):
    recipe = Recipe(modes=4, epochs=2, calibrate=False, clock=False)
    found = evaluate(dataset, train(dataset, recipe), sizes=(10, 15, 20), modes=(4,)).sweep
    assert [model.runs for model in found] == [10, 15, 20]
    designs, truth = dataset.design(dataset.test), dataset.snapshots("displacement", dataset.test)
    for model in found:
        alone = train(dataset, recipe, runs=dataset.train[: model.runs])
        expected = project(truth, alone.bases).regression(alone.coefficients(designs), 4)
        assert np.array_equal(model.errors.regression[0], expected)


def test_baselines_reproduce_what_they_know(dataset, surrogate):
    low, high = (np.array([getattr(p, side) for p in dataset.parameters]) for side in ("low", "high"))
    designs, truth = dataset.design(dataset.train), dataset.snapshots("displacement", dataset.train)
    mean, nearest, radial = baselines(dataset, dataset.train, surrogate.bases).values()
    assert np.allclose(mean(designs[0]), truth.mean(axis=0, dtype=float), atol=1e-7)
    nudged = designs[4] + 1e-3 * (high - low)
    assert np.array_equal(nearest(nudged), truth[4])
    projected = (truth[4, :, :, 2] @ surrogate.bases[2].modes.T) @ surrogate.bases[2].modes
    assert np.allclose(radial(designs[4])[:, :, 2], projected, atol=1e-4)  # [m]: through the training runs


def ranges(low, high):
    return tuple(Parameter(f"p{k}", "", "-", *ends) for k, ends in enumerate(zip(low, high, strict=True)))


@pytest.mark.parametrize("runs", [2, 12])
def test_radial_basis_functions_know_ranges_and_straight_lines(runs):
    """Units of a parameter do not matter; what is linear in the design is met everywhere once there are enough runs."""
    random = np.random.default_rng(4)
    low, high = np.array([0.0, 100.0, -1.0]), np.array([1.0, 900.0, 1.0])
    designs, asked = (low + random.uniform(size=(n, 3)) * (high - low) for n in (runs, 1))
    slope = random.normal(size=(3, 2 * 3 * 1)) / (high - low)[:, None]
    units = np.array([1.0, 1e-3, 1e6])
    one, other = (
        radial_basis(designs * unit, (designs @ slope).reshape(runs, 2, 3, 1), ranges(low * unit, high * unit))
        for unit in (1.0, units)
    )
    answer = one(asked[0])
    np.testing.assert_allclose(other(asked[0] * units), answer, atol=1e-6 * np.abs(answer).max())
    known = (asked @ slope if runs > 3 else designs[:1] @ slope).reshape(2, 3)
    met = answer if runs > 3 else one(designs[0])
    np.testing.assert_allclose(met[:, :, 0], known, rtol=1e-5)


def test_memory_stays_bounded_however_many_runs_there_are():
    dataset = SyntheticDataset(train=150, test=10, times=30, nodes=1000)
    surrogate = train(dataset, Recipe(modes=6, epochs=2))
    one, all_runs = (snapshot_bytes(dataset, dataset.train[:n]) for n in (1, 150))
    memory = all_runs // 6
    tracemalloc.start()
    try:
        evaluate(dataset, surrogate, sizes=(150,), modes=(4, 6), memory=memory)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # Beside the blocks: a run, its errors in float64 and the fields of the ensemble's members, 16 runs in all.
    assert peak < memory + 16 * one
    assert memory + 16 * one < 0.3 * all_runs  # a test that holding all snapshots would not pass


def test_break_even_counts_generation_and_training():
    timing = Timing(
        simulation=4.0,
        generation=120.0,
        training=5.0,
        inference=Inference(0.005, (0.001,) * 3, 0.01, 0.1, 0.002),
    )
    assert timing.speed_up == 400.0
    # 120 + 5 + 0.01 n <= 4 n from n = 31.33 on; without training it would be 31
    assert timing.break_even == 32
    assert dataclasses.replace(timing, simulation=0.01).break_even is None


def test_timing_of_a_surrogate(evaluation):
    assert evaluation.timing.generation == 4.0 * 30
    assert evaluation.timing.simulation == 4.0
    assert 0 < evaluation.timing.inference.copy < evaluation.timing.inference.whole < evaluation.timing.training


def test_metrics_file_holds_the_same_numbers(evaluation):
    metrics = json.loads(json.dumps(metrics_of(evaluation), allow_nan=False))
    assert metrics["rmse_m"]["surrogate"]["z"]["mean"] == evaluation.errors["surrogate"][:, :, 2].mean()
    assert np.allclose(metrics["snapshots_rmse_m"]["nearest run"], evaluation.errors["nearest run"], rtol=1e-5)
    assert [(row["runs"], row["modes"]) for row in metrics["sweep"]] == [(10, 1), (10, 4), (10, 8)]


def test_strangers_are_refused(surrogate, dataset, monkeypatch):
    with pytest.raises(InputError, match=r"E-ROM-012(?s:.*)meshes differ"):
        evaluate(SyntheticDataset(nodes=500), surrogate)
    with pytest.raises(InputError, match=r"E-ROM-012(?s:.*)training runs"):
        evaluate(SyntheticDataset(train=29), surrogate)
    monkeypatch.setattr(dataset, "test", ())
    with pytest.raises(InputError, match="E-ROM-015"):
        evaluate(dataset, surrogate)
