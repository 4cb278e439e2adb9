"""What a surrogate promises: reproducible training, split by run, honest ranges, consistent answers."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import SyntheticDataset

from billow.base.errors import InputError
from billow.rom.learn.network import MEMBERS
from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate.regression import OutputScaling


@pytest.fixture(scope="module")
def middle(surrogate):
    return {p.name: 0.5 * (p.low + p.high) for p in surrogate.parameters}


def test_same_seed_same_bits_and_another_seed_others(dataset):
    def learn(seed):
        return train(dataset, Recipe(modes=3, seed=seed, epochs=3, calibrate=False), runs=dataset.train[:8])

    def answer(surrogate):
        return surrogate.predict(dataset.design(dataset.test)).tobytes()

    one, same, other = learn(1), learn(1), learn(2)
    assert answer(one) == answer(same)
    assert not np.allclose(one.regression.weights[0], other.regression.weights[0], atol=1e-3)


def test_training_reads_no_unseen_run():
    dataset = SyntheticDataset(train=6, test=4, times=5, nodes=60)
    surrogate = train(dataset, Recipe(modes=2, epochs=1))
    assert set(dataset.read) == set(dataset.train) == set(surrogate.training["runs"])


def test_one_design_or_many_by_name_or_by_order(surrogate, dataset, middle):
    row = np.array([middle[p.name] for p in surrogate.parameters])
    one = surrogate.predict(middle)
    assert one.shape == (20, 800, 3)
    assert one.dtype == np.float32
    many = surrogate.predict(np.stack([dataset.design(dataset.test)[0], row]))
    assert many.shape == (2, 20, 800, 3)
    assert np.allclose(many[1], one, atol=1e-6)
    assert np.array_equal(surrogate.predict(row), one)


def test_designs_one_after_the_other_in_one_memory(surrogate, dataset):
    designs = dataset.design(dataset.train)
    many = surrogate.predict(designs)
    places = set()
    for answer, expected in zip(surrogate.predict_each(designs), many, strict=True):
        np.testing.assert_allclose(answer, expected, atol=1e-6)
        places.add(answer.__array_interface__["data"][0])
    assert len(places) == 1


def test_prediction_is_coefficients_times_modes(surrogate, middle):
    coefficients = surrogate.coefficients(middle)
    for component, basis in enumerate(surrogate.bases):
        expected = coefficients[:, component].astype(float) @ basis.modes.astype(float)
        assert np.allclose(surrogate.predict(middle)[:, :, component], expected, atol=1e-6)


def test_mean_of_members_is_the_answer_and_spread_their_deviation(surrogate, dataset):
    design = dataset.design(dataset.test)
    members = surrogate.regression.by_member(design, surrogate.times)
    assert members.shape == (MEMBERS, 6, 20, 24)
    assert np.allclose(members.mean(axis=0).reshape(6, 20, 3, 8), surrogate.coefficients(design), atol=1e-5)
    fields = [np.einsum("rtk,kn->rtn", member[..., 16:], surrogate.bases[2].modes) for member in members]
    spread = np.sqrt(np.var(fields, axis=0).mean(axis=-1))
    assert np.allclose(surrogate.spread(design)[:, :, 2], spread, rtol=1e-3, atol=1e-7)


def test_start_shape_is_kept(surrogate, dataset):
    start = surrogate.predict(dataset.design(dataset.test))[:, 0]
    assert np.abs(start).max() < 2e-3  # [m]; the bag rises by 0.2 m


def test_times_between_are_interpolated(surrogate, middle):
    trained = surrogate.predict(middle)[:, :, 2]
    between = surrogate.predict(middle, 0.5 * (surrogate.times[10:14] + surrogate.times[11:15]))[:, :, 2]
    neighbours = 0.5 * (trained[10:14] + trained[11:15])
    assert np.sqrt(np.square(between - neighbours).mean()) < 0.005  # [m]
    assert np.allclose(surrogate.predict(middle, surrogate.times[[3, 9]])[:, :, 2], trained[[3, 9]], atol=1e-6)


def test_output_scaling_is_linear_between_times():
    times = np.array([0.0, 1.0, 3.0])
    mean = np.array([[0.0], [2.0], [8.0]], np.float32)
    scaling = OutputScaling(times, mean, mean + 1)
    assert scaling.at(np.array([0.5, 2.0, 3.0]))[0].ravel() == pytest.approx([1.0, 5.0, 8.0])
    assert scaling.back(np.ones((2, 1, 1), np.float32), np.array([2.0])).ravel() == pytest.approx([11.0, 11.0])


@pytest.mark.parametrize(("low", "name", "factor"), [(False, "radius", 1.001), (True, "temperature", 0.999)])
def test_outside_the_trained_range_is_refused(surrogate, middle, low, name, factor):
    parameter = next(p for p in surrogate.parameters if p.name == name)
    bound = parameter.low if low else parameter.high
    surrogate.predict(middle | {name: bound})  # the bound itself is inside
    outside = middle | {name: bound * factor}
    with pytest.raises(InputError) as refused:
        surrogate.predict(outside)
    assert refused.value.code == "E-ROM-002"
    for told in (name, f"{parameter.low:g} to {parameter.high:g} {parameter.unit}", "extrapolate=True"):
        assert told in str(refused.value)
    assert np.isfinite(surrogate.predict(outside, extrapolate=True)).all()


@pytest.mark.parametrize("time", [0.0401, -1e-4])
def test_times_outside_are_refused(surrogate, middle, time):
    with pytest.raises(InputError, match="E-ROM-003"):
        surrogate.predict(middle, [0.01, time])


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda d: d | {"radios": 0.2}, "unknown radios"),
        (lambda d: {k: v for k, v in d.items() if k != "jet"}, "missing jet"),
        (lambda d: d | {"jet": "wide"}, "wide"),
        (lambda d: d | {"jet": float("nan")}, "finite"),
        (lambda d: list(d.values())[:5], "shape"),
    ],
)
def test_designs_that_do_not_fit_are_refused(surrogate, middle, change, told):
    with pytest.raises(InputError, match=r"E-ROM-001") as refused:
        surrogate.predict(change(middle), extrapolate=True)
    assert told in refused.value.why


def test_paper_recipe_has_one_network_for_each_coefficient(dataset):
    surrogate = train(dataset, Recipe("paper", modes=2, epochs=300), runs=dataset.train[:10])
    assert [w.shape for w in surrogate.regression.weights] == [(6, 7, 25), (6, 25, 45), (6, 45, 15), (6, 15, 1)]
    assert surrogate.training["last_loss"] < 0.5 * surrogate.training["first_loss"]
    truth = dataset.snapshots("displacement", dataset.train[:10])
    error = np.abs(surrogate.predict(dataset.design(dataset.train[:10])) - truth)[..., 2].mean()
    assert error < 0.7 * np.abs(truth - truth.mean(axis=(0, 1)))[..., 2].mean()  # 300 of its 15,000 epochs
    with pytest.raises(InputError, match="E-ROM-011"):
        surrogate.spread(dataset.design(dataset.test))


def test_progress_is_told_every_epoch(dataset):
    told = []
    surrogate = train(
        dataset, Recipe(modes=2, epochs=4), runs=dataset.train[:4], progress=lambda *what: told.append(what)
    )
    assert [(epoch, epochs) for epoch, epochs, _ in told] == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert told[-1][2] == surrogate.training["last_loss"]


def test_what_cannot_be_trained_is_refused(dataset, monkeypatch):
    with pytest.raises(InputError, match="E-ROM-008"):
        train(dataset, Recipe("shard"))
    with pytest.raises(InputError, match="E-ROM-007"):
        train(dataset, runs=())
    monkeypatch.setattr(dataset, "times", dataset.times[:1])
    with pytest.raises(InputError, match=r"E-ROM-010(?s:.*)time"):
        train(dataset)
