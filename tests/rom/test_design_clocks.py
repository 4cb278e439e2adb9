"""Clocks of designs: that they are found, used the right way round, kept, and left out where they would harm."""

from __future__ import annotations

import base64
import gzip
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import qmc
from synthetic import disc

from billow.base.errors import InputError, IntegrityError
from billow.pages.explorer import explorer_page
from billow.results.dataset_files import Parameter
from billow.results.tensor_file import read_tensors, write_tensors
from billow.rom.judge.effects import effects
from billow.rom.learn.clock import clock_helps, learn_clock
from billow.rom.learn.suggest import suggest
from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate.clock import Clock
from billow.rom.surrogate.onnx_export import export_onnx
from billow.rom.surrogate.prediction import describe_surrogate, describe_trust, trust_of
from billow.rom.surrogate.surrogate import Surrogate

TIMES = np.arange(1, 31) * 2e-3
LAST = TIMES[-1]


def rates(centred: np.ndarray) -> np.ndarray:
    """Of the true clocks: up to 30 % fast or slow."""
    return np.exp(0.3 * centred[:, 0] - 0.1 * centred[:, 1] * centred[:, 0])


def motion(common: np.ndarray) -> np.ndarray:
    """A rise, and a bounce of five periods: (..., 2)."""
    return np.stack([1.0 - np.exp(-common / 8e-3), np.sin(2.0 * np.pi * common / 12e-3)], axis=-1)


class Swinging:
    """A disc that rises and bounces, sooner or later by its design, and a little higher by it."""

    title, reference_length, missing, left_out = "Swinging", 0.28, {}, {}
    parameters = tuple(Parameter(name, name.title(), "-", 1.0, 3.0) for name in ("first", "second"))
    times = TIMES

    def __init__(self, train: int = 16, test: int = 4):
        self.reference, self.triangles = disc(60)
        names = tuple(f"{run:04d}" for run in range(train + test))
        self.train, self.test = names[:train], names[train:]
        self.trusted = self.train
        unit = [qmc.LatinHypercube(2, rng=3 + part).random(n) for part, n in enumerate((train, test))]
        self.centred = dict(zip(names, 2.0 * np.vstack(unit) - 1.0, strict=True))

    def design(self, runs):
        return np.array([2.0 + self.centred[run] for run in runs])

    def snapshots(self, field, runs):
        x, y = self.reference[:, :2].T
        shapes = []
        for run in runs:
            centred = self.centred[run]
            moved = motion(rates(centred[None]) * TIMES) * [0.2, 0.05 * (1.0 + 0.2 * centred[1])]
            field = moved[:, :1] * (1.0 - 4.0 * (x**2 + y**2)) + moved[:, 1:] * np.cos(4.0 * x)
            shapes.append(np.stack([0.1 * field * x, 0.1 * field * y, field], axis=-1))
        return np.array(shapes, np.float32)

    def computing_seconds(self, runs):
        return np.ones(len(runs))


@pytest.fixture(scope="module")
def swinging():
    return Swinging()


@pytest.fixture(scope="module")
def clocked(swinging):
    return train(swinging, Recipe(modes=3, epochs=40, calibrate=False))


def coefficients(centred: np.ndarray, common: np.ndarray) -> np.ndarray:
    """Of two modes of one component, as `learn_clock` takes them."""
    return motion(common)[:, :, None]


def test_common_time_is_the_integral_of_the_rate():
    weights = np.zeros((3 + 3, 4))
    weights[0], weights[1] = [0.0, 0.1, -0.3, 0.2], 0.2  # constant, and the first parameter
    clock, times = Clock(weights, 0.04), np.linspace(0.0, 0.05, 26)
    found = clock(np.array([[0.5, -1.0]]), times)[0]
    fine = np.linspace(0.0, 0.05, 50_001)
    rate = np.exp(weights[0][np.minimum((fine / 0.01).astype(int), 3)] + 0.1)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(fine))])
    assert found == pytest.approx(np.interp(times, fine, integral), abs=2e-6)  # a step of the sum, 1e-6 s
    assert clock(np.array([[0.5, -1.0]]), np.array([10.0]))[0, 0] == clock.end


def test_true_clocks_are_found():
    """Common times of unseen designs are those of the formula, up to the unit of common time, which is anybody's."""
    random = np.random.default_rng(1)
    known, asked = 2.0 * random.random((24, 2)) - 1.0, 2.0 * random.random((10, 2)) - 1.0
    true = rates(known)[:, None] * TIMES
    clock, scaling = learn_clock(known, TIMES, coefficients(known, true))
    common, expected = clock(asked, TIMES), rates(asked)[:, None] * TIMES
    unit = (common * expected).sum() / np.square(expected).sum()
    assert np.abs(common - unit * expected).max() < 0.02 * LAST
    left = scaling.at(common)[0] - coefficients(asked, expected).reshape(len(asked), len(TIMES), 2)
    assert np.sqrt(np.square(left).mean()) < 0.06  # of a bounce of height 1; the wrong way round: 0.5


def test_a_clock_is_taken_where_it_helps_and_nowhere_else(swinging, dataset, clocked, surrogate):
    assert clocked.regression.clock is not None
    assert surrogate.regression.clock is None  # of a bag whose heights differ, not its times: a clock doubles its error
    centred, designs = np.array([swinging.centred[run] for run in swinging.train]), swinging.design(swinging.train)
    same = np.broadcast_to(TIMES, (len(centred), len(TIMES)))
    height = (1.0 + 0.3 * centred[:, 0])[:, None, None, None]
    assert not clock_helps(designs, swinging.parameters, centred, TIMES, height * coefficients(centred, same))
    assert not learn_clock(centred, TIMES, 0.0 * coefficients(centred, same))[0].weights.any()


def test_unseen_runs_are_nearer_with_a_clock(swinging, clocked):
    without = train(swinging, Recipe(modes=3, epochs=40, calibrate=False, clock=False))
    truth, designs = swinging.snapshots("displacement", swinging.test), swinging.design(swinging.test)
    errors = [np.sqrt(np.square(model.predict(designs) - truth).mean()) for model in (clocked, without)]
    assert errors[0] < 0.5 * errors[1]


def test_the_file_keeps_the_clock(swinging, clocked, tmp_path):
    path = clocked.save(tmp_path / "s.safetensors")
    loaded, designs = Surrogate.load(path), swinging.design(swinging.test)
    times = np.array([0.0, 1e-3, 0.0333, LAST])
    assert (
        loaded.predict(designs, times, extrapolate=True).tobytes()
        == clocked.predict(designs, times, extrapolate=True).tobytes()
    )
    assert loaded.spread(designs).tobytes() == clocked.spread(designs).tobytes()
    for one, many in zip(designs, loaded.predict(designs), strict=True):
        assert loaded.predict(one) == pytest.approx(many, abs=1e-6)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t, r: t.pop("clock.weights"), "format"),
        (lambda t, r: r.update(format=1), "format"),
        (lambda t, r: t.update({"clock.weights": t["clock.weights"][:-1]}), "clock.weights"),
        (lambda t, r: t.update({"outputs.times": t["outputs.times"] ** 2}), "not even"),
    ],
)
def test_a_clock_that_does_not_fit_is_refused(clocked, tmp_path, change, said):
    path = clocked.save(tmp_path / "s.safetensors")
    tensors, record = read_tensors(path, lambda why: ValueError(why))
    change(tensors, record)
    write_tensors(path, tensors, record)
    with pytest.raises(IntegrityError, match=said):
        Surrogate.load(path)


def test_a_clock_far_outside_stays_within_bounds(clocked):
    regression = clocked.regression
    wild = replace(regression.clock, weights=1e9 * regression.clock.weights)
    common = wild(np.array([[50.0, -50.0]]), TIMES)
    assert ((common >= 0.0) & (common <= wild.end)).all()
    assert (np.diff(common) >= 0.0).all()


def test_common_time_goes_as_far_as_the_runs_got(swinging, clocked):
    """Beyond, networks would guess: a fast design, whose bounce no run shows to the end, stands still there."""
    clock, fastest = clocked.regression.clock, np.array([3.0, 1.0])
    farthest = clocked.regression.common(swinging.design(swinging.train), TIMES).max()
    assert farthest <= clock.latest <= farthest + 0.25 * LAST / len(TIMES)
    assert replace(clock, reach=np.inf)(np.array([[1.0, -1.0]]), TIMES)[0, -1] > clock.latest
    assert clocked.regression.common(fastest[None], TIMES)[0, -1] == clock.latest
    later = clocked.predict(fastest, np.array([1.05, 1.1]) * LAST, extrapolate=True)
    np.testing.assert_array_equal(later[0], later[1])
    still = clocked.stands_still(fastest)
    assert still == TIMES[clocked.regression.common(fastest[None], TIMES)[0] == clock.latest][0]
    assert f"from {1e3 * still:g} ms on" in " ".join(describe_trust(trust_of(clocked, fastest, None)))
    assert not any(clocked.stands_still(design) for design in swinging.design(swinging.train))


def test_exported_clocks_answer_as_numpy(swinging, clocked):
    pytest.importorskip("onnx")
    pytest.importorskip("onnxruntime")
    from billow.rom.surrogate.onnx_export import largest_difference, onnx_bytes

    designs = np.vstack([swinging.design(swinging.test), [3.0, 1.0]])  # the last gets as far as its clock reaches
    assert largest_difference(onnx_bytes(clocked), clocked, designs) < 1e-5


LOGARITHMS = np.array([0.0, 0.4, -0.25])
"""Of the rates of three gases, whose numbers say nothing of their order."""
GASES = ("nitrogen", "helium", "argon")


class ByGas(Swinging):
    """The same, sooner or later by a choice of gases and by a parameter."""

    def __init__(self, gases: int):
        super().__init__(train=24)
        gas = Parameter("gas", "Gas", "-", 0.0, gases - 1.0, GASES[:gases])
        self.parameters = (Swinging.parameters[0], gas)
        self.designs = {run: (centred[0], float(k % gases)) for k, (run, centred) in enumerate(self.centred.items())}

    def design(self, runs):
        return np.array([[2.0 + self.designs[run][0], self.designs[run][1]] for run in runs])

    def snapshots(self, field, runs):
        x, y = self.reference[:, :2].T
        shapes = []
        for run in runs:
            centred, gas = self.designs[run]
            moved = motion(np.exp(LOGARITHMS[int(gas)] + 0.3 * centred) * TIMES) * [0.2, 0.05]
            field = moved[:, :1] * (1.0 - 4.0 * (x**2 + y**2)) + moved[:, 1:] * np.cos(4.0 * x)
            shapes.append(np.stack([0.1 * field * x, 0.1 * field * y, field], axis=-1))
        return np.array(shapes, np.float32)


def test_two_levels_of_a_factor_have_clocks_of_their_own():
    dataset = ByGas(2)
    model = train(dataset, Recipe(modes=3, epochs=3, calibrate=False))
    common = model.regression.common(np.array([[2.0, 0.0], [2.0, 1.0]]), TIMES[:20])[:, -1]
    assert common[1] / common[0] == pytest.approx(np.exp(0.4), rel=0.03)
    by_name = model.predict({"first": 2.0, "gas": "helium"})
    np.testing.assert_array_equal(by_name, model.predict({"first": 2.0, "gas": 1}))
    with pytest.raises(InputError, match=r"lies between its levels, nitrogen \(0\), helium \(1\)") as caught:
        model.predict({"first": 2.0, "gas": 0.5})
    assert caught.value.code == "E-ROM-001"
    assert set(suggest(model, 6, dataset.design(dataset.train))[:, 1]) <= {0.0, 1.0}


def test_whatever_asks_a_surrogate_by_itself_asks_at_levels_of_a_factor(tmp_path):
    """Evaluation, the explorer, the export and the command that is suggested asked between two levels, and were
    refused."""
    model = train(ByGas(2), Recipe(modes=3, epochs=3))
    assert {effect.label for effect in effects(model)} == {p.label for p in model.parameters}
    path = model.save(tmp_path / "m.safetensors")
    packed = re.search('id="data">([^<]*)<', explorer_page(model.despite_verdict(), None, path))[1]
    assert b"gas" in gzip.decompress(base64.b64decode(packed))
    assert export_onnx(model.despite_verdict(), tmp_path / "m.onnx") < 1e-4
    values = re.findall(r"--set (\w+)=(\S+)", describe_surrogate(model))
    assert np.isfinite(model.despite_verdict().predict({name: float(value) for name, value in values})).all()


def test_clocks_that_reach_otherwise_are_calibrated_together():
    """Folds leave out the fastest designs in turn, so that their clocks get to different times."""
    model = train(Swinging(train=12), Recipe(modes=3, epochs=2, clock=True))
    assert model.intervals is not None
    assert len(model.regression.outputs.deviation) == len(model.regression.outputs.times)


def test_levels_without_an_order_have_no_clock():
    """The polynomial of a clock would see argon as far beyond helium as helium beyond nitrogen."""
    dataset = ByGas(3)
    made = train(dataset, Recipe(modes=3, epochs=2, calibrate=False))
    assert made.regression.clock is None
    with pytest.raises(InputError) as caught:
        train(dataset, Recipe(modes=3, epochs=2, calibrate=False, clock=True))
    assert caught.value.code == "E-ROM-250"
    assert "gas" in str(caught.value)
