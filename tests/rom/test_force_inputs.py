"""Contact forces as inputs: each step of the paper's recipe against what it says, and the surrogate around them."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest
from synthetic import SyntheticDataset, deploy

from billow.base.errors import InputError
from billow.rom.judge.errors import snapshot_rmse
from billow.rom.learn.dataset import snapshot_bytes
from billow.rom.learn.force_modes import force_bases, learn_force_inputs, ordinary
from billow.rom.learn.reduction import DEFAULT_MEMORY
from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate.force_inputs import previous
from billow.rom.surrogate.surrogate import Surrogate


class PushedDataset(SyntheticDataset):
    """Fabric is shifted by a load that no design parameter tells; the contact force does, one time before."""

    def snapshots(self, field, runs):
        if field == "contact_force":
            return np.stack([self._load(run)[:, None, None] * self._pattern() for run in runs]).astype(np.float32)
        shapes = []
        for run in runs:
            late = previous(self._load(run)[None])[0]
            shapes.append(deploy(self.reference, self.times, self._design[run]))
            shapes[-1][..., 2] += 2e-3 * late[:, None]
        return np.stack(shapes).astype(np.float32)

    def _load(self, run):
        """[N], (times,): random from run to run and time to time."""
        return np.random.default_rng(int(run) + 100).uniform(0.0, 30.0, len(self.times))

    def _pattern(self):
        inside = np.linalg.norm(self.reference[:, :2], axis=1) < 0.1
        return inside[:, None] * np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def pushed():
    return PushedDataset(train=24, test=3, times=12, nodes=200)


def test_snapshots_whose_norm_is_an_outlier_leave():
    matrix = np.ones((4, 50), np.float32)
    matrix[:, 7] = 100.0
    usual = ordinary(np.linalg.norm(matrix, axis=0))
    assert np.flatnonzero(~usual).tolist() == [7]
    # mean +- 3 deviations of 50 norms 1, ..., 1, 100: one outlier always lies 7 deviations off.


def test_inputs_are_the_normal_cumulative_function_of_projections_of_the_time_before(pushed):
    model, inputs = learn_force_inputs(pushed, pushed.train, 1, "z", 0)
    pattern = pushed._pattern()[:, 2]
    mode = model.modes[0, 0]
    assert np.abs(mode @ pattern) == pytest.approx(np.linalg.norm(pattern), rel=1e-6)  # the one shape there is
    loads = np.array([pushed._load(run) for run in pushed.train])
    projected = loads * (mode @ pattern)
    assert model.mean[0, 0] == pytest.approx(projected.mean(), rel=1e-5)
    assert model.deviation[0, 0] == pytest.approx(projected.std(), rel=1e-5)
    run, step = 3, 5
    standard = (projected[run, step - 1] - projected.mean()) / projected.std()
    assert inputs[run, step, 0] == pytest.approx(0.5 * (1.0 + math.erf(standard / math.sqrt(2.0))), abs=1e-5)
    # Before the first time nothing touches.
    assert inputs[:, 0, 0] == pytest.approx(model.scaled(np.zeros((24, 1, 1)))[:, 0])


class Struck(PushedDataset):
    """Forces of several shapes, none along y, and one blow that is out of the ordinary."""

    def snapshots(self, field, runs):
        if field != "contact_force":
            return super().snapshots(field, runs)
        x, y = self.reference[:, 0], self.reference[:, 1]
        shapes = np.stack([np.ones_like(x), x, y, x * y]).astype(float)
        forces = np.zeros((len(runs), len(self.times), len(x), 3), np.float32)
        for row, run in enumerate(runs):
            weights = np.random.default_rng(int(run)).normal(1.0, 0.3, (2, len(self.times), 4)) * (8.0, 4.0, 2.0, 1.0)
            forces[row, :, :, 0], forces[row, :, :, 2] = weights @ shapes
        if "0004" in runs:
            forces[list(runs).index("0004"), 5] *= 1000.0
        return forces


def test_forces_read_block_by_block_are_those_of_all_in_memory():
    dataset = Struck(train=24, test=2, times=20, nodes=300)
    runs, components = dataset.train, (0, 1, 2)
    memory = snapshot_bytes(dataset, runs)
    whole = force_bases(dataset, runs, 3, components, 0, DEFAULT_MEMORY)
    tracemalloc.start()
    streamed = force_bases(dataset, runs, 3, components, 0, memory)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < memory + 1e6  # sketches of 51 columns, 0.2 MB each; all at once take 1.7 times memory and more
    assert np.array_equal(streamed[2], whole[2])
    assert np.flatnonzero(~whole[2][0]).tolist() == [4 * 20 + 5]
    assert whole[0][1] is streamed[0][1] is None  # along y nothing pushes
    for component in (0, 2):
        one, other = (found[0][component].modes.astype(float) for found in (whole, streamed))
        # Rank four: sketches of 51 columns lose nothing, and modes agree but for float32.
        assert other == pytest.approx(one, abs=1e-4)
        known, again = (found[1][component] for found in (whole, streamed))
        assert again == pytest.approx(known, abs=1e-4 * float(np.abs(known).max()))
    inputs = [learn_force_inputs(dataset, runs, 3, "z", 0, limit)[1] for limit in (DEFAULT_MEMORY, memory // 3)]
    assert inputs[1] == pytest.approx(inputs[0], abs=1e-3)
    with pytest.raises(InputError, match="E-CPL-001"):
        learn_force_inputs(dataset, runs, 3, "y", 0, memory // 3)


def test_inputs_lie_between_0_and_1_whatever_the_force(pushed):
    model, _ = learn_force_inputs(pushed, pushed.train, 1, "z", 0)
    forces = np.zeros((3, 200, 3), np.float32)
    forces[1] = 1e9
    forces[2] = -1e9
    inputs = model(forces)
    assert inputs.shape == (3, 1)
    assert ((inputs >= 0.0) & (inputs <= 1.0)).all()


def test_true_forces_help_where_nothing_else_tells(pushed):
    plain, informed = (
        train(pushed, Recipe(modes=3, epochs=40, force_modes=modes, calibrate=False)) for modes in (0, 1)
    )
    designs, truth = pushed.design(pushed.test), pushed.snapshots("displacement", pushed.test)
    forces = previous(pushed.snapshots("contact_force", pushed.test))
    without = snapshot_rmse(plain.predict(designs), truth)
    true_forces = snapshot_rmse(informed.predict(designs, previous_forces=forces), truth)
    # The load moves z by up to 60 mm, evenly distributed: 60 / sqrt(12) = 17 mm that only the force knows.
    assert without[:, 1:, 2].mean() > 12e-3
    assert true_forces[..., 2].mean() < 0.5 * without[..., 2].mean()


def test_a_surrogate_with_forces_survives_its_file_and_asks_for_them(pushed, tmp_path):
    surrogate = train(pushed, Recipe(modes=3, epochs=2, force_modes=2, force_components="z", seed=1))
    again = Surrogate.load(surrogate.save(tmp_path / "forces.safetensors"))
    run = pushed.test[0]
    design, forces = pushed.design([run])[0], previous(pushed.snapshots("contact_force", [run]))[0]
    answer = surrogate.predict(design, previous_forces=forces)
    assert np.array_equal(again.predict(design, previous_forces=forces), answer)
    several = surrogate.predict(np.stack([design, design]), previous_forces=np.stack([forces, forces]))
    assert several[1] == pytest.approx(answer, abs=1e-6)
    assert surrogate.spread(design, previous_forces=forces).shape == (12, 3)
    for wrong in (None, forces[:3], np.full_like(forces, np.nan)):
        with pytest.raises(InputError, match="E-CPL-002"):
            surrogate.predict(design, previous_forces=wrong)


def test_a_surrogate_without_forces_refuses_them(pushed):
    surrogate = train(pushed, Recipe(modes=2, epochs=1, calibrate=False))
    with pytest.raises(InputError, match="E-CPL-002"):
        surrogate.predict(pushed.design(pushed.test)[0], previous_forces=np.zeros((12, 200, 3)))


@pytest.mark.parametrize("components", ["", "w", "zz", "x"])
def test_components_without_force_are_refused(pushed, components):
    with pytest.raises(InputError, match="E-CPL-001"):
        learn_force_inputs(pushed, pushed.train, 1, components, 0)
